//! What changed since the frame before: cuts and motion.

use crate::flow::motion::{Motion, block_correlations, block_differences, blocks, textured};
use crate::flow::small::Small;
use crate::frame::Frame;
use crate::geom::Size;

/// Mean difference of luma in a block of a small picture, 0..255, above which the block has changed.
/// Grain of standard deviation 4 leaves about 1 there (16 pixels' mean, mean absolute value); the
/// quantisation noise of usual encoders lies below that.
const STIR: f32 = 2.5;

/// Share of changed blocks below which no cut is looked for.
const CUT_CHANGED: f32 = 0.35;

/// Correlation of a frame with the one before, blocks moved to where they went, below which it begins a
/// new shot. Measured on a dozen clips: at most 0.23 at cuts, at least 0.60 inside shots, fast ground
/// and zooms among them.
const CUT_CORRELATION: f32 = 0.45;

/// A cut changes this share of the blocks, or shifts the histogram by [`CUT_SHIFT`]; a cut-out figure
/// that leaps on an empty ground does neither.
const CUT_WIDE: f32 = 0.6;
const CUT_SHIFT: f32 = 0.1;

/// Share of textured blocks below which a frame is too empty to judge: a flash, or black between shots.
const EMPTY: f32 = 0.08;

/// Frames for which the last full frame before a flash is remembered.
const FLASH_FRAMES: u32 = 12;

/// How a frame continues its stream.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// It begins a new shot: the first frame, or the one after a cut.
    Shot,
    /// It goes on from the frame before, moved so.
    Goes(Motion),
}

/// Watches a stream, one frame after the other.
#[derive(Debug, Default)]
pub struct Watcher {
    seen: Option<Seen>,
    /// Memory for the next small picture.
    spent: Option<Small>,
}

#[derive(Debug)]
struct Seen {
    previous: Small,
    /// The last frame with texture before one without, and how long ago that was.
    before_flash: Option<(Small, u32)>,
}

impl Watcher {
    /// How `frame` continues the frames watched before.
    pub fn watch(&mut self, frame: &Frame) -> Change {
        let small = Small::in_memory(frame, self.spent.take());
        match self.seen.take().filter(|seen| seen.previous.size == small.size) {
            Some(seen) => self.compare(seen, small),
            None => self.begin(small),
        }
    }

    /// Passes a frame of `size` without looking at it, as one at rest; the next one is compared with
    /// the last one seen. `None` where none of that size was.
    pub fn pause(&self, size: Size) -> Option<Motion> {
        let seen = self.seen.as_ref().filter(|seen| seen.previous.size == size)?;
        Some(Motion::rest(&seen.previous))
    }

    fn begin(&mut self, small: Small) -> Change {
        self.seen = Some(Seen { previous: small, before_flash: None });
        Change::Shot
    }

    fn compare(&mut self, mut seen: Seen, small: Small) -> Change {
        let moved = block_differences(&seen.previous, &small);
        let changed: Vec<bool> = moved.iter().map(|&d| d > STIR).collect();
        let motion = Motion::between(&seen.previous, &small, &changed);
        let share = changed.iter().filter(|&&c| c).count() as f32 / changed.len() as f32;
        if share > CUT_CHANGED {
            if is_empty(&small) {
                return self.wait(seen, small);
            }
            let last = &seen.previous;
            let new_scene = share > CUT_WIDE || histogram_distance(last, &small) > CUT_SHIFT;
            if new_scene
                && correlation(last, &small, &motion) < CUT_CORRELATION
                && !seen.comes_back(&small)
            {
                return self.begin(small);
            }
        }
        seen.before_flash = seen
            .before_flash
            .map(|(last, age)| (last, age + 1))
            .filter(|&(_, age)| age <= FLASH_FRAMES);
        self.spent = Some(std::mem::replace(&mut seen.previous, small));
        self.seen = Some(seen);
        Change::Goes(motion)
    }

    /// Passes a frame without texture, a flash perhaps: nothing can be learnt from it.
    fn wait(&mut self, seen: Seen, small: Small) -> Change {
        let motion = Motion::rest(&small);
        let (last, age) = seen.before_flash.unwrap_or((seen.previous, 0));
        let before_flash = Some((last, age + 1)).filter(|&(_, age)| age <= FLASH_FRAMES);
        self.seen = Some(Seen { previous: small, before_flash });
        Change::Goes(motion)
    }
}

impl Seen {
    /// Whether `small` goes on from the last frame before a flash.
    fn comes_back(&self, small: &Small) -> bool {
        self.before_flash.as_ref().is_some_and(|(last, _)| {
            let motion = Motion::between(last, small, &vec![true; block_count(small)]);
            correlation(last, small, &motion) >= CUT_CORRELATION
        })
    }
}

fn block_count(small: &Small) -> usize {
    let (columns, rows) = blocks(small);
    columns.len() * rows.len()
}

/// Whether a frame has hardly any texture.
fn is_empty(small: &Small) -> bool {
    (textured(small) as f32) < EMPTY * block_count(small) as f32
}

/// The mean of the textured blocks' correlations, each block where it went; 1 where there are none.
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
        let begins = frames.into_iter().map(|frame| watcher.watch(&frame) == Change::Shot);
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
        assert_eq!(cuts((1..20).map(|t| scene(1, 0.0, f64::from(t) * 0.05))), [0], "fade in");
        assert_eq!(cuts((0..8).map(|t| scene(1, f64::from(t) * 15.0, 1.0))), [0], "pan");
    }

    #[test]
    fn a_frame_of_another_size_begins_anew() {
        let small = Frame::filled(Size::new(9, 9), [7; 4]).expect("small");
        assert_eq!(cuts([scene(1, 0.0, 1.0), small.clone(), small]), [0, 1]);
    }
}
