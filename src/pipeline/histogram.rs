//! Percentiles of times, in constant memory.

use std::time::Duration;

use crate::stage::{Percentiles, Stage, Timing};

/// Buckets for each doubling of the time: neighbours differ by at most 1/64, so that the middle of a bucket is within
/// 0.8 % of every time in it.
const STEPS: u64 = 64;
/// Number of buckets up to the longest time in 64 bits of nanoseconds (584 years).
const BUCKETS: usize = (STEPS as usize) * (64 - STEPS.trailing_zeros() as usize + 1);

/// A histogram with logarithmic buckets, exact below 64 ns (the layout of Tene's HdrHistogram).
#[derive(Clone, Debug)]
pub(super) struct Histogram {
    counts: Vec<u64>,
}

impl Histogram {
    pub(super) fn new() -> Self {
        Self { counts: vec![0; BUCKETS] }
    }

    pub(super) fn add(&mut self, time: Duration) {
        let nanos = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        self.counts[bucket_of(nanos)] += 1;
    }

    /// Median and tails.
    pub(super) fn percentiles(&self) -> Percentiles {
        Percentiles {
            p50_ms: self.percentile(0.50),
            p95_ms: self.percentile(0.95),
            p99_ms: self.percentile(0.99),
        }
    }

    /// The nearest-rank percentile `share` in milliseconds, 0 when nothing was added.
    fn percentile(&self, share: f64) -> f64 {
        let total: u64 = self.counts.iter().sum();
        let rank = ((share * total as f64).ceil() as u64).max(1);
        let mut seen = 0;
        for (bucket, &count) in self.counts.iter().enumerate() {
            seen += count;
            if seen >= rank {
                return middle_of(bucket) / 1e6;
            }
        }
        0.0
    }
}

/// The bucket of `nanos`.
fn bucket_of(nanos: u64) -> usize {
    if nanos < STEPS {
        return nanos as usize;
    }
    // Numbers from STEPS * 2^shift up to twice that keep their leading bits.
    let shift = u64::from(STEPS.leading_zeros() - nanos.leading_zeros());
    (STEPS * shift + (nanos >> shift)) as usize
}

/// The middle of `bucket`, in nanoseconds.
fn middle_of(bucket: usize) -> f64 {
    let bucket = bucket as u64;
    if bucket < STEPS {
        return bucket as f64;
    }
    let shift = bucket / STEPS - 1;
    let low = (bucket - STEPS * shift) as f64;
    let width = (shift as f64).exp2();
    low * width + (width - 1.0) / 2.0
}

/// The times of every stage over a run: 26 KiB for each stage, whatever the number of frames.
#[derive(Clone, Debug)]
pub(super) struct StageHistograms([Histogram; Stage::ALL.len()]);

impl StageHistograms {
    pub(super) fn new() -> Self {
        Self(Stage::ALL.map(|_| Histogram::new()))
    }

    /// Adds one frame's times.
    pub(super) fn add(&mut self, timing: &Timing) {
        for stage in Stage::ALL {
            self.0[stage as usize].add(timing.get(stage));
        }
    }

    /// Median and tails of every stage.
    pub(super) fn percentiles(&self) -> [Percentiles; Stage::ALL.len()] {
        Stage::ALL.map(|stage| self.0[stage as usize].percentiles())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_are_in_order_and_their_middles_are_near() {
        let mut last = 0;
        for exponent in 0..64 {
            for extra in [0u64, 1, 3] {
                let nanos = (1u64 << exponent) + (extra << exponent) / 4;
                let bucket = bucket_of(nanos);
                assert!(bucket >= last && bucket < BUCKETS, "{nanos}: {bucket} after {last}");
                last = bucket;
                let off = (middle_of(bucket) - nanos as f64).abs() / nanos as f64;
                assert!(off <= 1.0 / 128.0, "{nanos} is reported as {}", middle_of(bucket));
            }
        }
        assert_eq!(bucket_of(u64::MAX), BUCKETS - 1);
    }

    #[test]
    fn percentiles_agree_with_sorting() {
        let mut times: Vec<_> =
            (0..1000u64).map(|i| Duration::from_micros(i * i * 7919 % 100_003)).collect();
        let mut histogram = Histogram::new();
        times.iter().for_each(|&time| histogram.add(time));
        let exact = Percentiles::of(&mut times);
        for (share, expected) in [(0.50, exact.p50_ms), (0.95, exact.p95_ms), (0.99, exact.p99_ms)]
        {
            let found = histogram.percentile(share);
            assert!((found - expected).abs() <= expected * 0.008, "{found} for {expected}");
        }
        assert_eq!(Histogram::new().percentile(0.5), 0.0);
    }
}
