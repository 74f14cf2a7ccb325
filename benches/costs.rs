//! What each stage costs, in CPU milliseconds for a frame on one thread, as tables in Markdown for
//! `benches/README.md`: `cargo bench -p polyreel-bench --bench costs`.

mod chain;
mod film;

use std::hint::black_box;
use std::time::{Duration, Instant};

use chain::{Chain, STAGES};
use polyreel::frame::Frame;
use polyreel::geom::Size;
use polyreel::options::{FillMode, Options, Points, Shape};
use polyreel::render::Renderer;

/// Different frames, shown over and over.
const DIFFERENT: u64 = 8;

/// Frames before the clock starts.
const BEFORE: usize = 8;

fn main() {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    one.install(stages);
    one.install(looks);
    scaling(&one);
}

/// Options with `steps` of refinement for each frame.
fn with_steps(steps: u32) -> Options {
    Options { refine: Some(steps), ..Options::default() }
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// The median, which a busy neighbour does not move.
fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    milliseconds(times[times.len() / 2])
}

fn stages() {
    println!(
        "\n| size | frames | steps | features | sample | triangulate | refine | rasterise | all |"
    );
    println!("|---|---|--:|--:|--:|--:|--:|--:|--:|");
    for size in [Size::new(1280, 720), Size::new(1920, 1080)] {
        let film = film::shot(size, DIFFERENT);
        for (name, coherence) in [("carried", 0.5), ("fresh", 0.0)] {
            for steps in [0, 1] {
                let options = Options { coherence, ..with_steps(steps) };
                let times = time_stages(&film, &options, 16);
                print!("| {size} | {name} | {steps} |");
                times.iter().for_each(|ms| print!(" {ms:.2} |"));
                println!(" {:.2} |", times.iter().sum::<f64>());
            }
        }
    }
}

/// Fills, shapes and the like, each next to the default: carried frames at 1080p with one step, and 2,000 seeds.
fn looks() {
    println!("\n| look | features | sample | triangulate | refine | rasterise | all |");
    println!("|---|--:|--:|--:|--:|--:|--:|");
    let film = film::shot(Size::new(1920, 1080), DIFFERENT);
    let plain = Options { points: Points::Count(2_000), ..with_steps(1) };
    let mut rows = vec![("default".to_owned(), plain.clone())];
    for fill in FillMode::ALL.into_iter().filter(|&fill| fill != FillMode::Mean) {
        rows.push((format!("fill {}", fill.name()), Options { fill, ..plain.clone() }));
    }
    for shape in [Shape::Polygons, Shape::Voronoi] {
        rows.push((format!("shape {}", shape.name()), Options { shape, ..plain.clone() }));
    }
    let palette = Some("12".parse().expect("a number of colours"));
    rows.push(("palette 12".to_owned(), Options { palette, ..plain.clone() }));
    let focus = Some("saliency".parse().expect("a focus"));
    rows.push(("focus saliency".to_owned(), Options { focus, ..plain }));
    for (name, options) in rows {
        let times = time_stages(&film, &options, 16);
        print!("| {name} |");
        times.iter().for_each(|ms| print!(" {ms:.2} |"));
        println!(" {:.2} |", times.iter().sum::<f64>());
    }
}

/// Medians of the stages' times over `frames`.
fn time_stages(film: &[Frame], options: &Options, frames: usize) -> Vec<f64> {
    let mut chain = Chain::new(options, Some(film::form(film[0].size())));
    let mut times = vec![Vec::new(); STAGES.len()];
    for number in 0..BEFORE + frames {
        let (mut before, mut stage) = (Instant::now(), 0);
        let picture = chain.render(&film[number % film.len()], |_| {
            if number >= BEFORE {
                times[stage].push(before.elapsed());
            }
            stage += 1;
            before = Instant::now();
        });
        chain.recycle(black_box(picture));
    }
    times.into_iter().map(median).collect()
}

/// Pixels at 0.8 % seeds, and seeds at 2.1 megapixels: a carried frame, on one thread and on all.
fn scaling(one: &rayon::ThreadPool) {
    println!(
        "\n| MP | seeds | 0 steps, 1 thread | 1 step, 1 thread | 0 steps | 1 step | ns/pixel, 0 steps |"
    );
    println!("|--:|--:|--:|--:|--:|--:|--:|");
    let sizes = [(640, 400), (1280, 800), (2560, 1600), (4960, 3232)];
    let by_pixels = sizes.map(|(w, h)| (Size::new(w, h), Points::Share(0.008)));
    for (size, points) in by_pixels {
        scaled(one, &film::shot(size, 4), points);
    }
    let film = film::shot(Size::new(1920, 1080), 4);
    for seeds in [1_000, 3_162, 10_000, 31_623, 100_000] {
        scaled(one, &film, Points::Count(seeds));
    }
}

fn scaled(one: &rayon::ThreadPool, film: &[Frame], points: Points) {
    let options = |steps| Options { points, ..with_steps(steps) };
    let [unrefined, one_step] = [0, 1].map(options);
    let (unrefined_one, step_one) =
        one.install(|| (time_frame(film, &unrefined), time_frame(film, &one_step)));
    let (unrefined_all, step_all) = (time_frame(film, &unrefined), time_frame(film, &one_step));
    let size = film[0].size();
    let pixels = size.pixels() as f64;
    let (megapixels, seeds) = (pixels / 1e6, points.target(size));
    let each = unrefined_one * 1e6 / pixels;
    println!(
        "| {megapixels:.2} | {seeds} | {unrefined_one:.2} | {step_one:.2} | {unrefined_all:.2} | {step_all:.2} | {each:.2} |"
    );
}

/// Median milliseconds for a carried frame, one frame at a time.
fn time_frame(film: &[Frame], options: &Options) -> f64 {
    let mut renderer = Renderer::new(options).expect("sound options");
    let mut times = Vec::new();
    for frame in film.iter().cycle().take(3 * film.len()) {
        let began = Instant::now();
        black_box(renderer.render(frame).expect("rendered"));
        times.push(began.elapsed());
    }
    // The first round is fresh, and finds the buffers' sizes.
    median(times.split_off(film.len()))
}
