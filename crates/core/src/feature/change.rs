//! Detects cuts, and motion since the last frame.

use crate::flow::motion::{
    Motion, block_correlations, block_differences, block_means, blocks, has_textured,
};
use crate::flow::small::Small;
use crate::frame::Frame;
use crate::geom::Size;

/// Mean difference of luma in a block of a small picture, 0..255, above which the block has changed.
/// Grain of standard deviation 4 leaves about 1 there (16 pixels' mean, mean absolute value); the
/// quantisation noise of usual encoders lies below that.
const BLOCK_CHANGE_THRESHOLD: f32 = 2.5;

/// Share of changed blocks below which no cut is looked for.
const CUT_CHANGED: f32 = 0.35;

/// Correlation of a frame with the motion-compensated one before, below which it begins a new shot. Measured on a
/// dozen clips: at most 0.23 at cuts, at least 0.60 inside shots, also with fast motion and zooms.
/// Measured by `cargo xtask measure cut-correlation`.
const CUT_CORRELATION: f32 = 0.45;

/// The sum of that correlation and the [correlation ratio](correlation_ratio) below which a frame begins a new shot.
/// Grain, falling snow and flashes leave hardly any correlation, but brightness still depends on the frame before.
/// Measured: 1371 pairs of scenes have at most 0.54, half of them 0.1; 202 frames with grain, snow, confetti,
/// flashes and strobes that correlate as cuts do have at least 0.67, except 17 after one without texture.
/// Measured by `cargo xtask measure cut-likeness`.
const CUT_LIKENESS: f32 = 0.6;

/// Bins of luma for the correlation ratio.
const BINS: usize = 16;

/// The variance of block means, in squared 8-bit steps, below which a correlation ratio has no meaning.
const FLAT: f64 = 4.0;

/// A cut changes at least this share of the blocks, or shifts the histogram by [`CUT_SHIFT`]; a cut-out figure that
/// jumps on an empty ground does neither. If the last frame also began something new, the histogram has to change:
/// snow and static differ from frame to frame.
const CUT_WIDE: f32 = 0.6;
const CUT_SHIFT: f32 = 0.1;

/// Share of textured blocks below which a frame is too empty to compare: a flash, or black between shots.
const EMPTY: f32 = 0.08;

/// Frames for which the last frame with texture before a flash is kept.
const FLASH_FRAMES: u32 = 12;

/// How a frame continues its stream.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// It begins a new shot: the first frame, or the one after a cut.
    Cut,
    /// It starts afresh within a shot that fades in: the first frame with any texture.
    FadeIn,
    /// It continues the frame before, with this motion.
    Continues(Motion),
}

impl Change {
    /// Whether the mesh has to be made afresh, since the frame does not continue the one before it.
    pub fn is_fresh(&self) -> bool {
        !matches!(self, Self::Continues(_))
    }
}

/// Watches a stream, one frame after the other.
#[derive(Debug, Default)]
pub struct Watcher {
    seen: Option<Seen>,
    /// Buffers for the next small picture.
    spent: Option<Small>,
}

#[derive(Debug)]
struct Seen {
    previous: Small,
    /// Whether it differed from the frame before as after a cut.
    other: bool,
    /// Whether the shot began without texture and has had none so far.
    blank: bool,
    /// The last frame with texture before one without, and its age in frames.
    before_flash: Option<(Small, u32)>,
}

impl Watcher {
    /// Compares `frame` with the last frames.
    pub fn watch(&mut self, frame: &Frame) -> Change {
        let small = Small::in_memory(frame, self.spent.take());
        match self.seen.take().filter(|seen| seen.previous.size == small.size) {
            Some(seen) => self.compare(seen, small),
            None => {
                let blank = is_empty(&small);
                self.begin(small, blank);
                Change::Cut
            }
        }
    }

    /// Skips a frame of `size`, as one without motion; the next one is compared with the last frame that was not
    /// skipped. `None` if there was none of this size.
    pub fn pause(&self, size: Size) -> Option<Motion> {
        let seen = self.seen.as_ref().filter(|seen| seen.previous.size == size)?;
        Some(Motion::zero(&seen.previous))
    }

    fn begin(&mut self, small: Small, blank: bool) {
        self.seen = Some(Seen { previous: small, other: true, blank, before_flash: None });
    }

    fn compare(&mut self, mut seen: Seen, small: Small) -> Change {
        let moved = block_differences(&seen.previous, &small);
        let changed: Vec<bool> = moved.iter().map(|&d| d > BLOCK_CHANGE_THRESHOLD).collect();
        let motion = Motion::between(&seen.previous, &small, &changed);
        let share = changed.iter().filter(|&&c| c).count() as f32 / changed.len() as f32;
        seen.other = if share > CUT_CHANGED {
            if is_empty(&small) {
                return self.wait(seen, small);
            }
            // Histograms only for frames that differ: they take longer than the comparison.
            let is_shifted = || histogram_distance(&seen.previous, &small) > CUT_SHIFT;
            let other = seen.is_left(&small, &motion) && (share > CUT_WIDE || is_shifted());
            if other && (!seen.other || is_shifted()) {
                let fades_in =
                    seen.blank && seen.before_flash.is_none() && is_empty(&seen.previous);
                self.begin(small, false);
                return if fades_in { Change::FadeIn } else { Change::Cut };
            }
            seen.blank = false;
            other
        } else {
            false
        };
        seen.before_flash = seen.before_flash.and_then(older);
        self.spent = Some(std::mem::replace(&mut seen.previous, small));
        self.seen = Some(seen);
        Change::Continues(motion)
    }

    /// Skips a frame without texture, for instance a flash: it cannot be compared.
    fn wait(&mut self, seen: Seen, small: Small) -> Change {
        let motion = Motion::zero(&small);
        let full = || (!is_empty(&seen.previous)).then_some((seen.previous, 0));
        let before_flash = seen.before_flash.or_else(full).and_then(older);
        self.seen = Some(Seen { previous: small, other: false, before_flash, ..seen });
        Change::Continues(motion)
    }
}

impl Seen {
    /// Whether `small`, with this motion, differs from the last frame, and from the last one before a flash.
    fn is_left(&self, small: &Small, motion: &Motion) -> bool {
        let flashed = self.before_flash.as_ref();
        // A frame without texture cannot be compared with.
        let was_empty = flashed.is_some() && is_empty(&self.previous);
        let is_back = |(before, _): &(Small, u32)| {
            let motion = Motion::between(before, small, &vec![true; block_count(small)]);
            !is_other(before, small, &motion)
        };
        (was_empty || is_other(&self.previous, small, motion)) && !flashed.is_some_and(is_back)
    }
}

/// The frame before a flash, with its age, as long as it is kept.
fn older((before, age): (Small, u32)) -> Option<(Small, u32)> {
    (age < FLASH_FRAMES).then_some((before, age + 1))
}

fn block_count(small: &Small) -> usize {
    let (columns, rows) = blocks(small);
    columns.len() * rows.len()
}

/// Whether a frame has almost no texture.
fn is_empty(small: &Small) -> bool {
    !has_textured(small, (EMPTY * block_count(small) as f32).ceil() as usize)
}

/// Whether `to` differs from `from`, moved by the motion.
fn is_other(from: &Small, to: &Small, motion: &Motion) -> bool {
    let correlation = correlation(from, to, motion);
    correlation < CUT_CORRELATION && {
        let [from, to] = [from, to].map(block_means);
        let ratio = correlation_ratio(&from, &to).max(correlation_ratio(&to, &from));
        correlation + ratio < CUT_LIKENESS
    }
}

/// The correlation ratio: the share, 0 to 1, of the variance of the block means `to` that is explained by the means
/// `from` of another picture. It is 1 if a change of light, with any curve, leads from one to the other. With as many
/// bins as blocks any two pictures would have 1; the bias is removed (Kelley's epsilon squared). 0 for flat pictures.
///
/// R. A. Fisher, "Statistical Methods for Research Workers", 1925; A. Roche et al., "The Correlation Ratio as a New
/// Similarity Measure for Multimodal Image Registration", 1998.
fn correlation_ratio(from: &[f32], to: &[f32]) -> f32 {
    let bin = |&luma: &f32| (luma as usize * BINS / 256).min(BINS - 1);
    let mut bins = [(0.0f64, 0.0f64); BINS];
    for (from, &to) in from.iter().zip(to) {
        let (count, sum) = &mut bins[bin(from)];
        (*count, *sum) = (*count + 1.0, *sum + f64::from(to));
    }
    let count = to.len() as f64;
    let mean = bins.iter().map(|(_, sum)| sum).sum::<f64>() / count;
    let square = |value: &f32, mean: f64| (f64::from(*value) - mean).powi(2);
    let all: f64 = to.iter().map(|to| square(to, mean)).sum();
    let within = |(from, to): (&f32, &f32)| {
        let (count, sum) = bins[bin(from)];
        square(to, sum / count)
    };
    let within: f64 = from.iter().zip(to).map(within).sum();
    let groups = bins.iter().filter(|(count, _)| *count > 0.0).count() as f64;
    if all <= FLAT * count || count <= groups {
        return 0.0;
    }
    (1.0 - within / (count - groups) * (count - 1.0) / all).max(0.0) as f32
}

/// The mean of the correlations of textured blocks, moved by the motion; 1 without any.
fn correlation(from: &Small, to: &Small, motion: &Motion) -> f32 {
    let (mut sum, mut count) = (0.0, 0);
    for known in block_correlations(from, to, motion).into_iter().flatten() {
        sum += known;
        count += 1;
    }
    if count == 0 { 1.0 } else { sum / count as f32 }
}

/// Total variation distance of two pictures' luma histograms, 32 bins each: 0 for equal ones, 1 for
/// disjoint ones.
fn histogram_distance(a: &Small, b: &Small) -> f32 {
    let mut bins = [0i64; 32];
    for (&a, &b) in a.plane().values().iter().zip(b.plane().values()) {
        bins[(a / 8.0) as usize % 32] += 1;
        bins[(b / 8.0) as usize % 32] -= 1;
    }
    let moved: u64 = bins.iter().map(|n| n.unsigned_abs()).sum();
    moved as f32 / (2 * a.plane().values().len().max(1)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, unit};

    const SIZE: Size = Size::new(320, 200);

    /// Smooth noise of `pitch` pixels a knot.
    fn blobs(seed: u64, x: f64, y: f64, pitch: f64) -> f64 {
        let knot = |x: f64, y: f64| unit(seed, Purpose::Noise, x as u32 + 50, y as u32 + 50);
        let (u, v) = (x / pitch + 99.0, y / pitch);
        let (fu, fv) = (u.fract(), v.fract());
        let row = |v: f64| knot(u.floor(), v) * (1.0 - fu) + knot(u.floor() + 1.0, v) * fu;
        row(v.floor()) * (1.0 - fv) + row(v.floor() + 1.0) * fv
    }

    /// A scene by chance, coarse and fine, moved to the right, its brightness scaled.
    fn scene(seed: u64, moved: f64, light: f64) -> Frame {
        let value = |x: u32, y: u32| {
            let (x, y) = (f64::from(x) - moved, f64::from(y));
            let level = 0.6 * blobs(seed, x, y, 29.0) + 0.4 * blobs(seed + 90, x, y, 7.0);
            let g = (255.0 * light * level).min(255.0) as u8;
            [g, g, g / 2, 255]
        };
        let pixels = (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)));
        Frame::new(SIZE, pixels.map(|(x, y)| value(x, y)).collect()).expect("a small frame")
    }

    fn cuts(frames: impl IntoIterator<Item = Frame>) -> Vec<usize> {
        let mut watcher = Watcher::default();
        let begins = frames.into_iter().map(|frame| watcher.watch(&frame) == Change::Cut);
        begins.enumerate().filter(|(_, begins)| *begins).map(|(i, _)| i).collect()
    }

    #[test]
    fn cuts_are_found_in_the_frame_itself() {
        let shot = |seed: u64| (0..5).map(move |t| scene(seed, f64::from(t) * 4.0, 1.0));
        assert_eq!(cuts(shot(1).chain(shot(2)).chain(shot(3))), [0, 5, 10]);
    }

    #[test]
    fn flashes_fades_and_pans_are_no_cuts() {
        let white = Frame::filled(SIZE, [255; 4]).expect("white");
        let flash =
            (0..8).map(|t| if t == 4 { white.clone() } else { scene(1, f64::from(t), 1.0) });
        assert_eq!(cuts(flash), [0], "to white");
        let bright = (0..8).map(|t| scene(1, f64::from(t), if t == 4 { 1.6 } else { 0.6 }));
        assert_eq!(cuts(bright), [0], "of light");
        assert_eq!(
            cuts((0..20).map(|t| scene(1, 0.0, 1.0 - f64::from(t) * 0.05))),
            [0],
            "fade out"
        );
        for frames in [4, 8, 20] {
            let light = |t: u32| f64::from(t) / f64::from(frames);
            assert_eq!(cuts((1..frames).map(|t| scene(1, 0.0, light(t)))), [0], "fade in");
            assert_eq!(cuts((0..frames).map(|t| scene(1, 0.0, light(t)))), [0], "from black");
        }
        assert_eq!(cuts((0..8).map(|t| scene(1, f64::from(t) * 15.0, 1.0))), [0], "pan");
    }

    /// `frame`, each of its pixels made another by chance.
    fn changed(frame: &Frame, t: u64, change: impl Fn(u8, f64) -> f64) -> Frame {
        let pixel = |(i, &[r, g, b, a]): (usize, &[u8; 4])| {
            let chance = unit(t, Purpose::Noise, i as u32, 7);
            let [r, g, b] = [r, g, b].map(|value| change(value, chance).clamp(0.0, 255.0) as u8);
            [r, g, b, a]
        };
        let pixels = frame.pixels().iter().enumerate().map(pixel);
        Frame::new(frame.size(), pixels.collect()).expect("as many pixels")
    }

    /// A dark figure on a light ground, not much to see.
    fn figure() -> Frame {
        let value = |i: u32| {
            let (x, y) = (i % SIZE.width, i / SIZE.width);
            let dark = x.abs_diff(90).pow(2) + y.abs_diff(110).pow(2) < 60 * 60;
            if dark { [70, 60, 50, 255] } else { [200, 210, 190, 255] }
        };
        Frame::new(SIZE, (0..SIZE.pixels() as u32).map(value).collect()).expect("a small frame")
    }

    #[test]
    fn grain_and_falling_snow_are_no_cuts_and_hide_none() {
        let grain = |value: u8, chance: f64| f64::from(value) + 200.0 * (chance - 0.5);
        let snow = |value: u8, chance: f64| if chance < 0.2 { 255.0 } else { value.into() };
        let black = Frame::filled(SIZE, [0, 0, 0, 255]).expect("black");
        let shots = |first: &Frame, second: &Frame, change: &dyn Fn(u8, f64) -> f64| {
            let shot = (0..6).map(|t| changed(first, t, change));
            cuts(shot.chain((6..12).map(|t| changed(second, t, change))))
        };
        let (left, scene) = (figure(), scene(3, 0.0, 1.0));
        assert_eq!(shots(&left, &left, &grain), [0]);
        assert_eq!(shots(&left, &left, &snow), [0]);
        assert_eq!(shots(&black, &black, &snow), [0], "nothing but snow");
        assert_eq!(shots(&black, &black, &grain), [0], "nothing but static");
        assert_eq!(shots(&left, &scene, &grain), [0, 6]);
        assert_eq!(shots(&scene, &left, &snow), [0, 6]);
    }

    #[test]
    fn light_that_burns_out_dims_or_turns_over_is_no_cut() {
        let lights: [fn(f64) -> f64; 4] = [|v| v + 150.0, |v| 3.0 * v, |v| 0.1 * v, |v| 255.0 - v];
        for light in lights {
            for first in [scene(1, 0.0, 1.0), figure()] {
                let lit = changed(&first, 0, |value, _| light(value.into()));
                let frame = |t: u32| if t == 4 || t == 5 { lit.clone() } else { first.clone() };
                assert_eq!(cuts((0..9).map(frame)), [0]);
            }
        }
    }

    #[test]
    fn a_cut_under_a_flash_is_found_after_it() {
        let white = || std::iter::once(Frame::filled(SIZE, [255; 4]).expect("white"));
        let shot = |seed: u64| (0..5).map(move |t| scene(seed, f64::from(t) * 4.0, 1.0));
        assert_eq!(cuts(shot(1).chain(white()).chain(shot(2))), [0, 6]);
        assert_eq!(cuts(shot(1).chain(white()).chain(shot(1))), [0]);
    }

    #[test]
    fn what_comes_after_an_empty_beginning_emerges_and_is_cut_to_later() {
        let black = Frame::filled(SIZE, [0, 0, 0, 255]).expect("black");
        let mut watcher = Watcher::default();
        let mut is = |frame: &Frame| watcher.watch(frame);
        assert_eq!(is(&black), Change::Cut);
        assert!(matches!(is(&black), Change::Continues(_)));
        assert_eq!(is(&scene(1, 0.0, 0.3)), Change::FadeIn);
        assert!(matches!(is(&scene(1, 0.0, 0.6)), Change::Continues(_)));
        assert_eq!(is(&scene(2, 0.0, 1.0)), Change::Cut);
        for _ in 0..=FLASH_FRAMES {
            assert!(matches!(is(&black), Change::Continues(_)));
        }
        assert_eq!(is(&scene(1, 0.0, 1.0)), Change::Cut, "this one is cut to");
    }

    #[test]
    fn a_correlation_ratio_is_1_of_a_function_and_0_of_chance_and_of_few_blocks() {
        let by_chance = |seed: u64, count: u32| -> Vec<f32> {
            (0..count).map(|i| 255.0 * unit(seed, Purpose::Noise, i, 3) as f32).collect()
        };
        let from = by_chance(1, 2000);
        let turned: Vec<_> = from.iter().map(|v| (v - 128.0).powi(2) / 64.0).collect();
        assert!(correlation_ratio(&from, &turned) > 0.98);
        assert!(correlation_ratio(&turned, &from) < 0.1, "either of two came from it");
        assert!(correlation_ratio(&from, &by_chance(2, 2000)) < 0.02);
        assert_eq!(correlation_ratio(&from[..8], &by_chance(2, 8)), 0.0);
        assert_eq!(correlation_ratio(&from, &vec![200.0; 2000]), 0.0, "a flat one");
    }

    #[test]
    fn a_frame_of_another_size_begins_anew() {
        let small = Frame::filled(Size::new(9, 9), [7; 4]).expect("small");
        assert_eq!(cuts([scene(1, 0.0, 1.0), small.clone(), small]), [0, 1]);
    }
}
