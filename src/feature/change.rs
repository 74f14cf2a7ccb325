//! What changed since the frame before: cuts, motion, and where the picture stirs at all.

use crate::flow::motion::{Motion, Small, block_correlations, block_differences, blocks};
use crate::frame::Frame;

/// Mean difference of luma in a block of a small picture, 0..255, above which the block has changed.
/// Grain of standard deviation 4 leaves about 1 there (16 pixels' mean, mean absolute value); the
/// quantisation noise of usual encoders lies below that.
const STIR: f32 = 1.5;

/// Frames for which a block is worked on after it changed: time for the mesh to settle on it, and short
/// enough that a picture at rest is at rest after ten frames.
const WAKE_FRAMES: u8 = 7;

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
    /// It goes on from the frame before.
    Goes {
        /// Where the picture went since the frame before.
        motion: Motion,
        /// Where it stirs.
        stir: Stir,
    },
}

/// Which blocks of the frame have changed lately.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stir {
    /// Where the columns and rows of blocks end, in pixels of the frame.
    column_ends: Vec<u32>,
    row_ends: Vec<u32>,
    awake: Vec<bool>,
}

impl Stir {
    /// Whether the block of pixel `(x, y)` has changed lately.
    pub fn at(&self, x: u32, y: u32) -> bool {
        let place =
            |ends: &[u32], at: u32| ends.partition_point(|&end| end <= at).min(ends.len() - 1);
        let (column, row) = (place(&self.column_ends, x), place(&self.row_ends, y));
        self.awake[row * self.column_ends.len() + column]
    }

    /// Whether nothing has changed lately.
    pub fn is_rest(&self) -> bool {
        !self.awake.contains(&true)
    }
}

/// Watches a stream, one frame after the other.
#[derive(Debug, Default)]
pub struct Watcher {
    seen: Option<Seen>,
}

#[derive(Debug)]
struct Seen {
    previous: Small,
    /// What each block looked like when it last counted as changed; slow drift adds up against it.
    reference: Small,
    /// Frames that each block still stays awake.
    waking: Vec<u8>,
    /// The last frame with texture before one without, and how long ago that was.
    before_flash: Option<(Small, u32)>,
}

impl Watcher {
    /// How `frame` continues the frames watched before.
    pub fn watch(&mut self, frame: &Frame) -> Change {
        let small = Small::new(frame);
        match self.seen.take().filter(|seen| seen.previous.size == small.size) {
            Some(seen) => self.compare(seen, small),
            None => self.begin(small),
        }
    }

    fn begin(&mut self, small: Small) -> Change {
        let (columns, rows) = blocks(&small);
        self.seen = Some(Seen {
            previous: small.clone(),
            reference: small,
            waking: vec![WAKE_FRAMES; columns.len() * rows.len()],
            before_flash: None,
        });
        Change::Shot
    }

    fn compare(&mut self, mut seen: Seen, small: Small) -> Change {
        let moved = block_differences(&seen.previous, &small);
        let changed: Vec<bool> = moved.iter().map(|&d| d > STIR).collect();
        let motion = Motion::between(&seen.previous, &small, &changed);
        let share = changed.iter().filter(|&&c| c).count() as f32 / changed.len() as f32;
        if share > CUT_CHANGED {
            let likeness = Likeness::of(&seen.previous, &small, &motion);
            if likeness.now_empty {
                return self.wait(seen, small);
            }
            let new_scene = share > CUT_WIDE || likeness.shift > CUT_SHIFT;
            if new_scene && likeness.correlation < CUT_CORRELATION && !seen.comes_back(&small) {
                return self.begin(small);
            }
        }
        seen.before_flash = seen
            .before_flash
            .map(|(last, age)| (last, age + 1))
            .filter(|&(_, age)| age <= FLASH_FRAMES);
        self.go_on(seen, small, motion)
    }

    /// Passes a frame without texture, a flash perhaps, without stirring anything.
    fn wait(&mut self, seen: Seen, small: Small) -> Change {
        let motion = Motion::between(&small, &small, &[]);
        let stir = stir(&small, &vec![0; seen.waking.len()]);
        let (last, age) = seen.before_flash.unwrap_or((seen.previous, 0));
        let before_flash = Some((last, age + 1)).filter(|&(_, age)| age <= FLASH_FRAMES);
        let Seen { reference, waking, .. } = seen;
        self.seen = Some(Seen { previous: small, reference, waking, before_flash });
        Change::Goes { motion, stir }
    }

    fn go_on(&mut self, mut seen: Seen, small: Small, motion: Motion) -> Change {
        let drifted = block_differences(&seen.reference, &small);
        for (waking, &drift) in seen.waking.iter_mut().zip(&drifted) {
            *waking = if drift > STIR { WAKE_FRAMES } else { waking.saturating_sub(1) };
        }
        seen.reference.take_blocks(&small, |block| drifted[block] > STIR);
        let stir = stir(&small, &seen.waking);
        self.seen = Some(Seen { previous: small, ..seen });
        Change::Goes { motion, stir }
    }
}

impl Seen {
    /// Whether `small` goes on from the last frame before a flash.
    fn comes_back(&self, small: &Small) -> bool {
        self.before_flash.as_ref().is_some_and(|(last, _)| {
            let motion = Motion::between(last, small, &vec![true; self.waking.len()]);
            Likeness::of(last, small, &motion).correlation >= CUT_CORRELATION
        })
    }
}

/// The blocks that are awake, and those beside them, since an edge on a block's border is seen in both.
fn stir(small: &Small, waking: &[u8]) -> Stir {
    let (columns, rows) = blocks(small);
    let width = columns.len();
    let awake = (0..waking.len()).map(|i| {
        let (x, y) = (i % width, i / width);
        (y.saturating_sub(1)..(y + 2).min(rows.len()))
            .any(|v| (x.saturating_sub(1)..(x + 2).min(width)).any(|u| waking[v * width + u] > 0))
    });
    let ends = |starts: &[usize]| {
        let next = starts.iter().skip(1).map(|&start| start as u32 * small.factor);
        next.chain([u32::MAX]).collect()
    };
    Stir { column_ends: ends(&columns), row_ends: ends(&rows), awake: awake.collect() }
}

/// How much a frame is like one before.
#[derive(Clone, Copy, Debug)]
struct Likeness {
    /// The mean of the textured blocks' correlations, each block where it went.
    correlation: f32,
    /// Total variation distance of their histograms of luma, 0..1.
    shift: f32,
    /// Whether the newer frame has hardly any texture.
    now_empty: bool,
}

impl Likeness {
    fn of(from: &Small, to: &Small, motion: &Motion) -> Self {
        let correlations = block_correlations(from, to, motion);
        let known: Vec<f32> = correlations.iter().copied().flatten().collect();
        let mean = known.iter().sum::<f32>() / known.len().max(1) as f32;
        let rest = Motion::between(to, to, &[]);
        let textured = block_correlations(to, to, &rest).iter().flatten().count();
        Self {
            shift: histogram_distance(from, to),
            correlation: if known.is_empty() { 1.0 } else { mean },
            now_empty: (textured as f32) < EMPTY * correlations.len() as f32,
        }
    }
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
