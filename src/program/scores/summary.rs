//! The short tables: a row for each method, study or preset, with means over all inputs.

use super::clip::{ClipMethodScores, ClipScores};
use super::plan::{Kind, name};
use super::still::{MethodScores, StillScores};
use super::tables::{NONE, cells, figure, mean, pictures};
use super::{Evaluation, Table};

/// The short tables for which there are figures.
pub(crate) fn summaries(evaluation: &Evaluation) -> Vec<Table> {
    let mut tables = Vec::new();
    if !evaluation.stills.is_empty() {
        tables.push(stills(evaluation));
    }
    if !evaluation.clips.is_empty() {
        tables.push(clips(evaluation));
    }
    tables
}

const STILLS: [&str; 9] =
    ["level 1", "seeds", "triangles", "bytes", "SSIM", "MSE", "PSNR dB", "s", "refined: SSIM"];

fn stills(evaluation: &Evaluation) -> Table {
    let refines = evaluation.plan.refines();
    let mut head = vec![evaluation.plan.kind.noun().to_owned()];
    head.extend(cells(STILLS).into_iter().take(if refines { 9 } else { 8 }));
    if refines {
        head.extend(cells(["MSE", "PSNR dB", "s"]));
    }
    let row = |(i, subject): (usize, &str)| {
        let scores = |refined: bool| {
            let of = move |still: &'_ StillScores| still.of(refined).get(i).cloned();
            evaluation.stills.iter().filter_map(of).collect::<Vec<_>>()
        };
        let plain = scores(false);
        let whole = |value: fn(&MethodScores) -> usize| {
            figure(mean(plain.iter().map(|s| Some(value(s) as f64))), 0)
        };
        let mut line = vec![subject.to_owned()];
        line.extend([
            whole(|s| s.candidates),
            whole(|s| s.seeds),
            whole(|s| s.triangles),
            whole(|s| s.mesh_bytes),
        ]);
        line.extend(likeness(&plain));
        if refines {
            line.extend(likeness(&scores(true)));
        }
        line
    };
    let about = match evaluation.plan.kind {
        Kind::Methods => "all at the same number of points, without refinement and with it",
        Kind::Studies => {
            "all at the same number of points, as published and refined; colours are not graded"
        }
        Kind::Presets => "each with its own number of points; colours and lines count as error",
    };
    Table {
        title: "Table 1: means over all pictures".into(),
        note: format!(
            "{}; {about}. Level 1: feature points. Bytes: the mesh packed. Time is from pixels to pixels.",
            pictures(evaluation)
        ),
        head,
        rows: evaluation.plan.names().enumerate().map(row).collect(),
    }
}

/// SSIM, MSE, PSNR and seconds.
fn likeness(scores: &[MethodScores]) -> [String; 4] {
    let average = |value: fn(&MethodScores) -> Option<f64>, digits| {
        figure(mean(scores.iter().map(value)), digits)
    };
    [
        average(|s| s.likeness.ssim, 3),
        average(|s| Some(s.likeness.mse), 1),
        average(|s| s.likeness.psnr, 2),
        average(|s| Some(s.ms / 1e3), 2),
    ]
}

fn clips(evaluation: &Evaluation) -> Table {
    let row = |(i, subject): (usize, &str), refined: bool| {
        let of = |clip: &ClipScores| clip.of(refined).get(i).cloned();
        let scores: Vec<ClipMethodScores> = evaluation.clips.iter().filter_map(of).collect();
        let average = |value: fn(&ClipMethodScores) -> Option<f64>, digits| {
            figure(mean(scores.iter().map(value)), digits)
        };
        vec![
            name(subject, refined),
            average(|s| Some(s.fps), 1),
            average(|s| s.ssim, 3),
            average(|s| Some(s.mse), 1),
            average(|s| s.fdb, 3),
            average(|s| s.warp_error, 6),
            average(|s| Some(s.seeds), 0),
            average(|s| Some(s.seeds_kept), 1),
        ]
    };
    let own = mean(evaluation.clips.iter().map(|clip| clip.source_warp_error));
    let mut rows = vec![cells(["(source)", NONE, NONE, NONE, NONE, "", NONE, NONE])];
    rows[0][5] = figure(own, 6);
    for refined in [false, true] {
        if !refined || evaluation.plan.refines() {
            rows.extend(evaluation.plan.names().enumerate().map(|subject| row(subject, refined)));
        }
    }
    Table {
        title: "Clips: means over all of them".into(),
        note: "Frames per second of the work inside frames; FDB and E_warp as in the long table."
            .into(),
        head: cells([
            evaluation.plan.kind.noun(),
            "fps",
            "SSIM",
            "MSE",
            "FDB",
            "E_warp",
            "seeds",
            "kept",
        ]),
        rows,
    }
}
