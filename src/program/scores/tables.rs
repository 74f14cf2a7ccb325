//! The tables of the paper from the figures of an [`Evaluation`].

use std::path::Path;

use super::disturb::Disturbance;
use super::plan::name;
use super::still::{MethodScores, StillScores};
use super::{Evaluation, Table};

/// A dash where there is no figure.
pub(super) const NONE: &str = "-";

/// All tables for which there are figures, in the order of the paper.
pub(crate) fn tables(evaluation: &Evaluation) -> Vec<Table> {
    let mut tables = Vec::new();
    if !evaluation.stills.is_empty() {
        tables.extend([points(evaluation), sizes(evaluation), likeness(evaluation)]);
        if evaluation.plan.robustness {
            tables.push(robustness(evaluation));
        }
        tables.push(means(evaluation));
        if evaluation.plan.refines() {
            tables.extend([refinement(evaluation), mean_refinement(evaluation)]);
        }
    }
    if !evaluation.clips.is_empty() {
        tables.push(clips(evaluation));
    }
    tables
}

/// The file's name without its folder, as rows are called.
pub(crate) fn short_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

pub(super) fn cells<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.iter().map(|&cell| cell.to_owned()).collect()
}

pub(super) fn figure(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| NONE.to_owned(), |v| format!("{v:.digits$}"))
}

pub(super) fn mean(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0);
    for value in values.flatten() {
        sum += value;
        count += 1;
    }
    (count > 0).then(|| sum / f64::from(count))
}

/// All scores of one method.
pub(super) fn of_method<'a>(
    evaluation: &'a Evaluation,
    method: &'a str,
) -> impl Iterator<Item = &'a MethodScores> {
    let all = evaluation.stills.iter().flat_map(|still| &still.methods);
    all.filter(move |scores| scores.method == method)
}

/// One row a still and method, and the means of each method.
fn per_still(
    evaluation: &Evaluation,
    row: impl Fn(&StillScores, &MethodScores) -> Vec<String>,
    mean_row: impl Fn(&str) -> Vec<String>,
) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for still in &evaluation.stills {
        for scores in &still.methods {
            let mut line = vec![short_name(&still.path), scores.method.clone()];
            line.extend(row(still, scores));
            rows.push(line);
        }
    }
    for method in evaluation.plan.names() {
        let mut line = vec!["mean".to_owned(), method.to_owned()];
        line.extend(mean_row(method));
        rows.push(line);
    }
    rows
}

fn points(evaluation: &Evaluation) -> Table {
    let rows = per_still(
        evaluation,
        |still, s| {
            vec![
                still.size.to_string(),
                still.size.pixels().to_string(),
                s.candidates.to_string(),
                format!("{:.2}", s.candidates_rate),
                s.seeds.to_string(),
                format!("{:.2}", s.seeds_rate),
            ]
        },
        |method| {
            let average = |value: fn(&MethodScores) -> f64, digits| {
                figure(mean(of_method(evaluation, method).map(|s| Some(value(s)))), digits)
            };
            let pixels = evaluation.stills.iter().map(|still| Some(still.size.pixels() as f64));
            vec![
                NONE.to_owned(),
                figure(mean(pixels), 0),
                average(|s| s.candidates as f64, 0),
                average(|s| s.candidates_rate, 2),
                average(|s| s.seeds as f64, 0),
                average(|s| s.seeds_rate, 2),
            ]
        },
    );
    Table {
        title: "Table 2: points of both levels".into(),
        note: "Rates are 100 - 100 x points / pixels, as the paper prints them.".into(),
        head: cells([
            "picture", "method", "size", "pixels", "level 1", "rate %", "seeds", "rate %",
        ]),
        rows,
    }
}

fn sizes(evaluation: &Evaluation) -> Table {
    let file = |still: &StillScores| still.file_bytes.map(|bytes| bytes as f64);
    let mut rows = per_still(
        evaluation,
        |still, s| vec![figure(file(still), 0), s.mesh_bytes.to_string(), figure(s.reduction, 2)],
        |method| {
            let scores = || of_method(evaluation, method);
            vec![
                figure(mean(evaluation.stills.iter().map(file)), 0),
                figure(mean(scores().map(|s| Some(s.mesh_bytes as f64))), 0),
                figure(mean(scores().map(|s| s.reduction)), 2),
            ]
        },
    );
    for (name, pick) in [("min", f64::min as fn(f64, f64) -> f64), ("max", f64::max)] {
        for method in evaluation.plan.names() {
            let most = |values: &mut dyn Iterator<Item = f64>| values.reduce(pick);
            let scores = || of_method(evaluation, method);
            rows.push(vec![
                name.to_owned(),
                method.to_owned(),
                figure(most(&mut evaluation.stills.iter().filter_map(file)), 0),
                figure(most(&mut scores().map(|s| s.mesh_bytes as f64)), 0),
                figure(most(&mut scores().filter_map(|s| s.reduction)), 2),
            ]);
        }
    }
    Table {
        title: "Table 3: size of the mesh".into(),
        note: "Bytes of the file and of the mesh really encoded: seeds as steps in 1/256 pixel, one \
               colour a triangle as its difference from its neighbours, both through an adaptive range \
               coder; triangles are not stored where the Delaunay triangulation gives them back. \
               Reduction is 100 - 100 x mesh / file; none where the file was not read whole at its \
               own size."
            .into(),
        head: cells(["picture", "method", "file", "mesh", "reduction %"]),
        rows,
    }
}

fn likeness(evaluation: &Evaluation) -> Table {
    let mean_row = |method: &str| mean_likeness(|| of_method(evaluation, method));
    let rows = per_still(evaluation, |_, s| mean_likeness(|| std::iter::once(s)), mean_row);
    Table {
        title: "Table 4: likeness and time".into(),
        note: LIKENESS_NOTE.into(),
        head: cells(["picture", "method", "SSIM", "SSIM gauss", "MSE", "PSNR dB", "ms"]),
        rows,
    }
}

const LIKENESS_NOTE: &str = "SSIM of the luma rounded to 8 bits, by a uniform window of 7x7 and by a \
    Gaussian one of 11x11; MSE and PSNR over RGB; transparency is laid over white. Time is from pixels \
    to pixels, without reading and writing.";

/// Cells with the means of `scores`; of one they are its own figures.
fn mean_likeness<'a, I>(scores: impl Fn() -> I) -> Vec<String>
where
    I: Iterator<Item = &'a MethodScores>,
{
    let average =
        |value: fn(&MethodScores) -> Option<f64>, digits| figure(mean(scores().map(value)), digits);
    vec![
        average(|s| s.likeness.ssim, 4),
        average(|s| s.likeness.ssim_gaussian, 4),
        average(|s| Some(s.likeness.mse), 1),
        average(|s| s.likeness.psnr, 2),
        average(|s| Some(s.ms), 1),
    ]
}

pub(super) fn pictures(evaluation: &Evaluation) -> String {
    match evaluation.stills.len() {
        1 => "1 picture".to_owned(),
        n => format!("{n} pictures"),
    }
}

fn means(evaluation: &Evaluation) -> Table {
    let row = |method: &str| {
        let mut line = vec![method.to_owned()];
        line.extend(mean_likeness(|| of_method(evaluation, method)));
        line
    };
    Table {
        title: "Table 4, means: methods over all pictures".into(),
        note: format!("{}. {LIKENESS_NOTE}", pictures(evaluation)),
        head: cells(["method", "SSIM", "SSIM gauss", "MSE", "PSNR dB", "ms"]),
        rows: evaluation.plan.names().map(row).collect(),
    }
}

/// The same method's scores on one still, without and with refinement.
pub(super) type Pair<'a> = (&'a MethodScores, &'a MethodScores);

pub(super) fn pairs(still: &StillScores) -> impl Iterator<Item = Pair<'_>> {
    still.methods.iter().zip(&still.refined)
}

const REFINEMENT: [&str; 9] =
    ["method", "steps", "SSIM", "SSIM gauss", "MSE", "PSNR dB", "ms", "MSE x", "1 - SSIM x"];

const REFINEMENT_NOTE: &str = "Every method as in Table 4, and its mesh refined. The last columns are \
    what refinement leaves of MSE and of the distance 1 - SSIM: below 1 is better.";

/// With a digit behind the point, if it is not 0.
fn rounded(value: f64) -> String {
    format!("{}", (value * 10.0).round() / 10.0)
}

/// Two rows with the means of `pairs`: without refinement, and with it.
fn refinement_rows<'a, I>(method: &str, pairs: impl Fn() -> I) -> [Vec<String>; 2]
where
    I: Iterator<Item = Pair<'a>>,
{
    let before = mean(pairs().map(|(s, _)| Some(f64::from(s.refine_steps)))).unwrap_or_default();
    let mut plain = vec![name(method, false), rounded(before)];
    plain.extend(mean_likeness(|| pairs().map(|(plain, _)| plain)));
    plain.extend(cells([NONE, NONE]));
    let steps = mean(pairs().map(|(_, s)| Some(f64::from(s.refine_steps)))).unwrap_or_default();
    let mut refined = vec![name(method, true), rounded(steps)];
    refined.extend(mean_likeness(|| pairs().map(|(_, refined)| refined)));
    let share = |before: f64, after: f64| (before > 0.0).then(|| after / before);
    let left = |value: fn(&MethodScores) -> Option<f64>| {
        let left = pairs().map(|(before, after)| share(value(before)?, value(after)?));
        figure(mean(left), 3)
    };
    refined.push(left(|s| Some(s.likeness.mse)));
    refined.push(left(|s| s.likeness.ssim.map(|ssim| 1.0 - ssim)));
    [plain, refined]
}

fn refinement(evaluation: &Evaluation) -> Table {
    let mut rows = Vec::new();
    for still in &evaluation.stills {
        for pair in pairs(still) {
            for cells in refinement_rows(&pair.0.method, || std::iter::once(pair)) {
                rows.push([vec![short_name(&still.path)], cells].concat());
            }
        }
    }
    Table {
        title: "Refinement: likeness and time without and with level three".into(),
        note: REFINEMENT_NOTE.into(),
        head: [cells(["picture"]), cells(REFINEMENT)].concat(),
        rows,
    }
}

fn mean_refinement(evaluation: &Evaluation) -> Table {
    let rows = |method: &str| {
        let all = || evaluation.stills.iter().flat_map(pairs);
        refinement_rows(method, || all().filter(move |(plain, _)| plain.method == method))
    };
    Table {
        title: "Refinement, means: methods over all pictures".into(),
        note: format!("{}. {REFINEMENT_NOTE}", pictures(evaluation)),
        head: cells(REFINEMENT),
        rows: evaluation.plan.names().flat_map(rows).collect(),
    }
}

fn robustness(evaluation: &Evaluation) -> Table {
    let row = |method: &str| {
        let mut line = vec![method.to_owned()];
        let scores = || of_method(evaluation, method);
        line.push(figure(mean(scores().map(|s| s.likeness.ssim)), 4));
        line.push(figure(mean(scores().map(|s| Some(s.likeness.mse))), 1));
        for disturbance in Disturbance::ALL {
            let found = |s: &MethodScores| {
                s.robustness.iter().find(|(d, _)| *d == disturbance).map(|(_, likeness)| *likeness)
            };
            line.push(figure(mean(scores().map(|s| found(s).and_then(|l| l.ssim))), 4));
            line.push(figure(mean(scores().map(|s| found(s).map(|l| l.mse))), 1));
        }
        line
    };
    Table {
        title: "Robustness: renderings of disturbed pictures".into(),
        note: "Means over all pictures. The rendering of the disturbed picture is compared with the \
               undisturbed one: Gaussian noise of standard deviation 0.5 of 255 (the paper's) and of 25.5, a \
               black rectangle over 2 % of the frame, JPEG of quality 10."
            .into(),
        head: cells([
            "method", "SSIM", "MSE", "faint SSIM", "faint MSE", "noise SSIM", "noise MSE",
            "occlusion SSIM", "occlusion MSE", "jpeg SSIM", "jpeg MSE",
        ]),
        rows: evaluation.plan.names().map(row).collect(),
    }
}

fn clips(evaluation: &Evaluation) -> Table {
    let mut rows = Vec::new();
    for clip in &evaluation.clips {
        let mut own = vec![short_name(&clip.path), "(source)".to_owned()];
        own.extend([clip.size.to_string(), clip.frames.to_string()]);
        own.extend(cells([NONE, NONE, NONE, NONE]));
        own.push(figure(clip.source_warp_error, 6));
        own.extend(cells([NONE, NONE]));
        rows.push(own);
        let plain = clip.methods.iter().map(|s| (s, false));
        for (s, refined) in plain.chain(clip.refined.iter().map(|s| (s, true))) {
            rows.push(vec![
                short_name(&clip.path),
                name(&s.method, refined),
                clip.size.to_string(),
                clip.frames.to_string(),
                format!("{:.1}", s.fps),
                figure(s.ssim, 4),
                format!("{:.1}", s.mse),
                figure(s.fdb, 3),
                figure(s.warp_error, 6),
                format!("{:.0}", s.seeds),
                format!("{:.1}", s.seeds_kept),
            ]);
        }
    }
    Table {
        title: "Clips: speed, flicker and seeds".into(),
        note: "Frames per second of the work inside frames, one after the other. FDB: mean |(O_t - \
               O_t-1) - (I_t - I_t-1)|, 0..510. E_warp: mean squared difference along the source's \
               motion, RGB of 0..1, unoccluded pixels. Kept: seeds of the frame before that live on."
            .into(),
        head: cells([
            "clip", "method", "size", "frames", "fps", "SSIM", "MSE", "FDB", "E_warp", "seeds", "kept",
        ]),
        rows,
    }
}
