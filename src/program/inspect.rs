//! `polyreel inspect`: the results of each stage, as pictures of the frame's size (the paper's Figure 2).

use std::path::Path;

use polyreel::chain::{MeshStage, Meshed};
use polyreel::draw;
use polyreel::error::{Error, Result};
use polyreel::feature::maps;
use polyreel::feature::mask::Mask;
use polyreel::feature::region::{Regions, TRANSPARENT};
use polyreel::feature::saliency::saliency;
use polyreel::feature::{Extractor, Features};
use polyreel::ffmpeg::Ffmpeg;
use polyreel::frame::{Fill, Frame, Rational, Rgba};
use polyreel::geom::{Point, Size};
use polyreel::hex::HexGrid;
use polyreel::mesh::Mesh;
use polyreel::options::{Look, Options, Points};
use polyreel::pipeline::Stop;
use polyreel::plane::Plane;
use polyreel::rasterise::rasterise;
use polyreel::sample::Sampler;
use polyreel::sink::{self, Picture, SinkOptions};
use polyreel::source::{self, SourceOptions};
use polyreel::stream::{Span, StreamInfo};

use crate::program::cli::InspectArgs;
use crate::program::convergence::Convergence;
use crate::program::interrupt::Interrupt;
use crate::program::progress::spinner;
use crate::program::render::fell_short;
use crate::program::{Outcome, npy, record};

const WHITE: Rgba = [255, 255, 255, 255];
const INK: Rgba = [24, 24, 32, 255];
const GRID: Rgba = [120, 150, 215, 255];
const SEED: Rgba = [210, 30, 40, 255];

/// Writes one PNG for each stage, the exact maps, and the convergence of refinement.
pub(crate) fn inspect(args: &InspectArgs) -> Result<Outcome> {
    // Programs that read for us must not outlive us.
    let interrupt = Interrupt::listen(&Stop::default());
    let mut options = args.look.options()?;
    let wanted = SourceOptions {
        frames: Some(1),
        max_size: args.max_size,
        ffmpeg: Ffmpeg { program: args.ffmpeg.clone(), processes: interrupt.processes() },
        max_memory: args.max_memory,
        ..SourceOptions::default()
    };
    let input = source::open(std::slice::from_ref(&args.image), &wanted)?;
    if input.info().still {
        // No frame follows: --refine STEPS is exactly this number.
        options.coherence = 0.0;
    }
    let info = StreamInfo { still: true, frames: Some(1), ..input.info().clone() };
    let inputs = input.paths().to_vec();
    let Some(decoded) = input.start()?.next()? else {
        return Err(Error::input(&args.image, "has no frame to look at"));
    };
    let frame = decoded.frame;

    let bar = spinner();
    bar.set_message("finding feature points");
    let mut extractor = Extractor::new(&options);
    let regions = extractor.regions(&frame);
    let features = extractor.extract(&frame, Look::Full);
    bar.set_message("refining the mesh");
    let course = course(&options, &features, &frame);
    bar.set_message("drawing the stages");
    let Course { grid, before, after, convergence } = course?;
    let with_edges = |mesh: &Mesh| {
        let mut pixels = faded(&frame);
        draw::edges(&mut pixels, mesh, INK, 1);
        pixels
    };
    let outline = options.outline.map(|colour| colour.0);
    let painted = |mesh: &Mesh| rasterise(mesh, &frame, options.edges, outline).frame.into_pixels();
    let stages = [
        ("regions", region_colours(&regions)),
        ("candidates", dots(&features.candidates)),
        ("grid", with_grid(faded(&frame), &grid)),
        ("seeds", with_seeds(faded(&frame), frame.size(), before.seeds())),
        ("mesh-before", with_edges(&before)),
        ("lowpoly-before", painted(&before)),
        ("mesh", with_edges(&after)),
        ("lowpoly", painted(&after)),
    ];

    std::fs::create_dir_all(&args.output)
        .map_err(|error| Error::output(&args.output, format!("cannot be made: {error}")))?;
    let to = SinkOptions {
        overwrite: args.overwrite,
        inputs,
        unfinished: interrupt.unfinished(),
        ..SinkOptions::default()
    };
    for (name, map) in maps_of(&frame, &options) {
        let shown = grey(&map.shown());
        let png = args.output.join(name).with_extension("png");
        write(&png, frame.size(), shown, &info, &to)?;
        npy::write(&png.with_extension("npy"), &map.exact, args.overwrite)?;
    }
    for (name, pixels) in stages {
        write(&args.output.join(name).with_extension("png"), frame.size(), pixels, &info, &to)?;
    }
    let plot = args.output.join("convergence.svg");
    record::put(&plot, convergence.svg().as_bytes(), args.overwrite)?;
    let figures = plot.with_extension("csv");
    record::put(&figures, convergence.csv().as_bytes(), args.overwrite)?;
    bar.finish_and_clear();
    Ok(Outcome::Done)
}

/// The results from feature points to the mesh.
struct Course {
    grid: HexGrid,
    /// The mesh of the seeds.
    before: Mesh,
    /// The same refined.
    after: Mesh,
    convergence: Convergence,
}

fn course(options: &Options, features: &Features, frame: &Frame) -> Result<Course> {
    let mut before = None;
    let mut errors = Vec::new();
    let mut observer = |mesh: &Mesh, error: f64| {
        before.get_or_insert_with(|| mesh.clone());
        errors.push(error);
    };
    let Meshed { mesh: after, refined, .. } =
        MeshStage::new(options).run_observed(features, frame, &mut observer)?;
    let before = before.unwrap_or_else(|| after.clone());
    if let (Some(target), Some(likeness)) = (options.error, refined.likeness)
        && let Some(warning) = fell_short(target, u64::from(likeness < target.value()), likeness)
    {
        crate::program::terminal::warn(warning);
    }
    let points = Points::Count(u32::try_from(before.seeds().len()).unwrap_or(u32::MAX));
    let grid = match options.points {
        // The number that was found for auto.
        Points::Auto => Sampler::new(&Options { points, ..options.clone() }).grid(frame.size()),
        _ => Sampler::new(options).grid(frame.size()),
    };
    Ok(Course { grid, before, after, convergence: Convergence::new(frame, errors, &refined) })
}

/// A map, and the value that is shown as white.
struct Map {
    exact: Plane<f32>,
    white: f32,
}

impl Map {
    fn shown(&self) -> Plane<u8> {
        let scale = 255.0 / self.white;
        // A plane of bytes is shown without scaling.
        if self.white == 255.0 {
            self.exact.to_bytes()
        } else {
            self.exact.map(|v| v * scale).to_bytes()
        }
    }
}

/// The maps of all methods, whichever is chosen.
fn maps_of(frame: &Frame, options: &Options) -> [(&'static str, Map); 4] {
    let luma = maps::visible_luma(frame);
    let diffused = maps::diffused(&luma, options);
    let entropy = maps::entropy_of(&diffused, options);
    let edges = maps::edges(&luma).to_plane();
    [
        ("saliency", Map { exact: saliency(&luma), white: 1.0 }),
        // 256 levels have at most eight bits.
        ("entropy", Map { exact: entropy, white: 8.0 }),
        ("diffused", Map { exact: diffused, white: 255.0 }),
        ("edges", Map { exact: edges, white: 1.0 }),
    ]
}

fn grey(plane: &Plane<u8>) -> Vec<Rgba> {
    plane.values().iter().map(|&v| [v, v, v, 255]).collect()
}

fn write(
    path: &Path,
    size: Size,
    pixels: Vec<Rgba>,
    info: &StreamInfo,
    options: &SinkOptions,
) -> Result<()> {
    let name = path.to_str().ok_or_else(|| Error::output(path, "is not a name in UTF-8"))?;
    let mut sink = sink::create(name, info, options)?;
    let fills = fills_of(&pixels);
    let span = Span { start: Rational::ZERO, length: None };
    sink.write(Picture { frame: Frame::new(size, pixels)?, fills, span }, None)?;
    sink.finish()
}

/// The colours of `pixels` with their areas.
fn fills_of(pixels: &[Rgba]) -> Vec<Fill> {
    let mut sorted = pixels.to_vec();
    sorted.sort_unstable();
    let same = sorted.chunk_by(|a, b| a == b);
    same.map(|run| Fill { colour: run[0], area: run.len() as u32 }).collect()
}

/// Every pixel in the colour of its cluster.
fn region_colours(regions: &Regions) -> Vec<Rgba> {
    let colour = |&label: &u8| match label {
        TRANSPARENT => [0; 4],
        label => {
            let [r, g, b] = regions.palette[usize::from(label)].map(|v| v.round() as u8);
            [r, g, b, 255]
        }
    };
    regions.labels.iter().map(colour).collect()
}

/// The pixels of `mask` on white.
fn dots(mask: &Mask) -> Vec<Rgba> {
    let size = mask.size();
    let mut pixels = vec![WHITE; size.pixels()];
    for (x, y) in mask.iter() {
        pixels[place(size, x, y)] = INK;
    }
    pixels
}

/// The frame at a third of its strength on white, to draw on.
fn faded(frame: &Frame) -> Vec<Rgba> {
    let fade = |&[r, g, b, a]: &Rgba| {
        let weight = u32::from(a) / 3;
        let mix = |v: u8| ((u32::from(v) * weight + 255 * (255 - weight)) / 255) as u8;
        [mix(r), mix(g), mix(b), 255]
    };
    frame.pixels().iter().map(fade).collect()
}

/// `pixels` with each seed as a dot of three by three.
fn with_seeds(mut pixels: Vec<Rgba>, size: Size, seeds: &[Point]) -> Vec<Rgba> {
    for seed in seeds {
        let (x, y) = seed.pixel(size);
        for y in y.saturating_sub(1)..(y + 2).min(size.height) {
            for x in x.saturating_sub(1)..(x + 2).min(size.width) {
                pixels[place(size, x, y)] = SEED;
            }
        }
    }
    pixels
}

/// `pixels` with the cells of `grid`.
fn with_grid(mut pixels: Vec<Rgba>, grid: &HexGrid) -> Vec<Rgba> {
    let size = grid.size();
    for cell in 0..grid.cells() {
        // The other three sides are drawn by the neighbours to the left and above.
        for pair in grid.lower_right(cell).windows(2) {
            if let Some([a, b]) = clip(size, pair[0], pair[1]) {
                draw::line(size, a, b, |x, y| pixels[place(size, x, y)] = GRID);
            }
        }
    }
    pixels
}

/// The part of the line from `a` to `b` (in pixels) that lies in the frame (Liang and Barsky 1984).
fn clip(size: Size, a: (f64, f64), b: (f64, f64)) -> Option<[Point; 2]> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let sides = [
        (-dx, a.0),
        (dx, f64::from(size.width) - a.0),
        (-dy, a.1),
        (dy, f64::from(size.height) - a.1),
    ];
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for (outwards, room) in sides {
        if outwards == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if outwards < 0.0 {
            from = from.max(room / outwards);
        } else {
            to = to.min(room / outwards);
        }
    }
    let at = |t: f64| Point::from_pixels(a.0 + t * dx, a.1 + t * dy);
    (from <= to).then(|| [at(from), at(to)])
}

fn place(size: Size, x: u32, y: u32) -> usize {
    y as usize * size.width as usize + x as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_cut_at_the_frame() {
        let size = Size::new(10, 8);
        let px = Point::from_pixels;
        assert_eq!(clip(size, (-5.0, 4.0), (15.0, 4.0)), Some([px(0.0, 4.0), px(10.0, 4.0)]));
        assert_eq!(clip(size, (-2.0, 0.0), (0.0, -2.0)), None);
        assert_eq!(clip(size, (2.0, 9.0), (8.0, 9.0)), None);
        let inside = ((1.0, 2.0), (3.0, 4.0));
        assert_eq!(clip(size, inside.0, inside.1), Some([px(1.0, 2.0), px(3.0, 4.0)]));
    }

    #[test]
    fn fills_add_up_to_the_picture() {
        let fills = fills_of(&[WHITE, INK, WHITE]);
        assert_eq!(fills.len(), 2);
        assert!(fills.contains(&Fill { colour: WHITE, area: 2 }));
        assert!(fills.contains(&Fill { colour: INK, area: 1 }));
    }

    #[test]
    fn grid_lines_run_between_cells() {
        let size = Size::new(60, 40);
        let grid = HexGrid::new(size, 12.0);
        let pixels = with_grid(vec![WHITE; size.pixels()], &grid);
        // The middle of a cell is free, and every cell border that the frame shows is drawn.
        let (x, y) = grid.centre(grid.cell_at(30.0, 20.0));
        assert_eq!(pixels[place(size, x as u32, y as u32)], WHITE);
        for y in 0..size.height {
            for x in 1..size.width {
                if grid.cell_of_pixel(x - 1, y) != grid.cell_of_pixel(x, y) {
                    let near = (x.saturating_sub(2)..(x + 2).min(size.width))
                        .any(|x| pixels[place(size, x, y)] == GRID);
                    assert!(near, "no line near ({x}, {y})");
                }
            }
        }
    }
}
