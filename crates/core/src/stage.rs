//! The stages of the chain and the times that they take.

use std::time::Duration;

/// A stage of the chain. Variants are in the order of the work on a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Stage {
    /// Reading a frame from the source.
    Decode,
    /// Level one: feature points or a score for every pixel.
    Features,
    /// Level two: choice of seeds on the hexagonal grid, or carrying them from the last frame.
    Sample,
    /// Delaunay triangulation.
    Triangulate,
    /// Level three: refinement against the squared error.
    Refine,
    /// Mean colours and fill.
    Rasterise,
    /// Writing a frame to the sink.
    Encode,
}

impl Stage {
    /// All stages in order.
    pub const ALL: [Stage; 7] = [
        Stage::Decode,
        Stage::Features,
        Stage::Sample,
        Stage::Triangulate,
        Stage::Refine,
        Stage::Rasterise,
        Stage::Encode,
    ];

    /// The stage's name as reports write it.
    pub const fn name(self) -> &'static str {
        match self {
            Stage::Decode => "decode",
            Stage::Features => "features",
            Stage::Sample => "sample",
            Stage::Triangulate => "triangulate",
            Stage::Refine => "refine",
            Stage::Rasterise => "rasterise",
            Stage::Encode => "encode",
        }
    }
}

impl std::fmt::Display for Stage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Time that one frame spent at work in each stage (waiting for a neighbour does not count).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Timing([Duration; Stage::ALL.len()]);

impl Timing {
    /// Time in `stage`.
    pub fn get(&self, stage: Stage) -> Duration {
        self.0[stage as usize]
    }

    /// Adds `time` to `stage`.
    pub fn add(&mut self, stage: Stage, time: Duration) {
        self.0[stage as usize] += time;
    }
}

/// Median and tails of a stage's times over a run, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Percentiles {
    /// Half of the frames took at most this.
    pub p50_ms: f64,
    /// 95 of 100 frames took at most this.
    pub p95_ms: f64,
    /// 99 of 100 frames took at most this.
    pub p99_ms: f64,
}

impl Percentiles {
    /// Nearest-rank percentiles of `times`; zero for no times. Reorders `times`.
    pub fn of(times: &mut [Duration]) -> Self {
        times.sort_unstable();
        let at = |share: f64| {
            let rank = (share * times.len() as f64).ceil() as usize;
            times.get(rank.max(1) - 1).map_or(0.0, |t| t.as_secs_f64() * 1e3)
        };
        Self { p50_ms: at(0.50), p95_ms: at(0.95), p99_ms: at(0.99) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_nearest_rank() {
        let mut times: Vec<_> = (1..=100).rev().map(Duration::from_millis).collect();
        let p = Percentiles::of(&mut times);
        assert_eq!((p.p50_ms, p.p95_ms, p.p99_ms), (50.0, 95.0, 99.0));
        assert_eq!(Percentiles::of(&mut []), Percentiles::default());
    }
}
