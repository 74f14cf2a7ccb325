//! Weighted random sampling of pixels.
//!
//! Each pixel gets a uniform u in (0, 1] by a hash of its position; its key is u / weight, and the pixels with the
//! smallest keys are taken: priority sampling (Duffield, Lund and Thorup, "Priority sampling for estimation of
//! arbitrary subset sums", J. ACM 54(6), 2007). The probability of a pixel is proportional to its weight, and with a
//! constant score it has the same key in every frame.

use crate::parallel::prelude::*;

use super::mask::Mask;
use crate::chance::{Purpose, rank};
use crate::plane::Plane;

/// Bins of weights, by which the limit of the keys is found.
const BINS: usize = 1 << 12;

/// A weighting of the pixels: a power of their score, 1 for the largest score.
#[derive(Clone, Copy, Debug)]
pub struct PrioritySampler<'a> {
    score: &'a Plane<f32>,
    most: f32,
    power: i32,
    seed: u64,
}

impl<'a> PrioritySampler<'a> {
    /// Weights in proportion to `score` to the power of `power`; scores are finite, and those of at
    /// most 0 are never taken.
    pub fn new(score: &'a Plane<f32>, power: i32, seed: u64) -> Self {
        let most =
            score.values().par_iter().with_min_len(1 << 14).copied().reduce(|| 0.0, f32::max);
        Self { score, most, power, seed }
    }

    fn weight(&self, score: f32) -> f32 {
        // The power of a score that is tiny compared with the largest underflows to 0.
        if score > 0.0 { (score / self.most).powi(self.power) } else { 0.0 }
    }

    /// The key of pixel `(x, y)`, above 0: infinite where the weight is 0.
    pub fn key(&self, x: u32, y: u32) -> f32 {
        uniform(self.seed, x, y) / self.weight(self.score.at(x, y))
    }

    /// About `share` of all pixels: those with keys below a limit. Fewer if fewer have a weight.
    pub fn sample(&self, share: f64) -> Mask {
        let mut mask = Mask::new(self.score.size());
        if self.most <= 0.0 {
            return mask;
        }
        let limit = self.limit(share);
        let stride = mask.stride();
        mask.words_mut().par_chunks_mut(stride).enumerate().for_each(|(y, words)| {
            for (x, &score) in self.score.row(y as u32).iter().enumerate() {
                let chance = limit * self.weight(score);
                // In maps with few high values most pixels have weight 0.
                let is_taken = chance > 0.0 && uniform(self.seed, x as u32, y as u32) <= chance;
                words[x / 64] |= u64::from(is_taken) << (x % 64);
            }
        });
        mask
    }

    /// The limit of the keys at which `share` of the pixels are expected to be taken:
    /// sum of min(1, limit x weight) = share x pixels, over a histogram of the scores.
    fn limit(&self, share: f64) -> f32 {
        let last = (BINS - 1) as f32;
        let scale = last / self.most;
        let count = |values: &[f32]| {
            let mut bins = vec![0u32; BINS];
            // A float cast to an integer saturates, and takes NaN to 0.
            values.iter().for_each(|&v| bins[((v * scale + 0.5) as usize).min(BINS - 1)] += 1);
            bins
        };
        let add = |mut a: Vec<u32>, b: Vec<u32>| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            a
        };
        let chunks = self.score.values().par_chunks(1 << 17).map(count);
        let bins = chunks.reduce(|| vec![0; BINS], add);
        let weights: Vec<(f64, f64)> = (0..BINS)
            .map(|i| (f64::from((i as f32 / last).powi(self.power)), f64::from(bins[i])))
            .filter(|&(weight, count)| weight > 0.0 && count > 0.0)
            .collect();
        let expected =
            |limit: f64| weights.iter().map(|(w, n)| n * (limit * w).min(1.0)).sum::<f64>();
        let wanted = share * self.score.values().len() as f64;
        let (mut low, mut high) = (0.0, 1.0);
        // 1e30 takes all pixels with a weight.
        while expected(high) < wanted && high < 1e30 {
            (low, high) = (high, high * 4.0);
        }
        for _ in 0..40 {
            let middle = (low + high) / 2.0;
            if expected(middle) < wanted { low = middle } else { high = middle }
        }
        high as f32
    }
}

/// A uniform random number of a pixel, in (0, 1], by a hash of its place.
fn uniform(seed: u64, x: u32, y: u32) -> f32 {
    // 24 bits fill a float's mantissa.
    ((rank(seed, Purpose::Keep, x, y) >> 40) + 1) as f32 / (1u32 << 24) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;

    fn ramp(size: Size) -> Plane<f32> {
        let values = (0..size.pixels()).map(|i| (i % size.width as usize) as f32).collect();
        Plane::new(size, values).expect("as many as pixels")
    }

    #[test]
    fn the_share_is_met_and_follows_the_weight() {
        let size = Size::new(300, 400);
        let score = ramp(size);
        for (power, left_share) in [(1, 0.25), (3, 1.0 / 16.0)] {
            let taken = PrioritySampler::new(&score, power, 7).sample(0.05);
            let expected = 0.05 * size.pixels() as f64;
            assert!((taken.len() as f64 / expected - 1.0).abs() < 0.04, "{}", taken.len());
            // The integral of x^p over the left half is 2^-(p + 1) of the whole.
            let left = taken.iter().filter(|p| p.0 < 150).count() as f64;
            assert!((left / taken.len() as f64 - left_share).abs() < 0.02, "{power}: {left}");
        }
    }

    #[test]
    fn winners_are_those_with_the_smallest_keys() {
        let score = ramp(Size::new(60, 50));
        let sampler = PrioritySampler::new(&score, 2, 3);
        let taken = sampler.sample(0.1);
        let key = |&(x, y): &(u32, u32)| sampler.key(x, y);
        let worst = taken.iter().map(|p| key(&p)).fold(0.0, f32::max);
        let pixels = (0..50).flat_map(|y| (0..60).map(move |x| (x, y)));
        let better = pixels.filter(|&(x, y)| !taken.contains(x, y)).map(|p| key(&p));
        assert!(better.fold(f32::INFINITY, f32::min) >= worst * 0.9999);
    }

    #[test]
    fn what_scores_nothing_never_wins() {
        let flat = Plane::filled(Size::new(30, 20), 0.0);
        assert!(PrioritySampler::new(&flat, 1, 0).sample(1.0).is_empty());
        let mut one = flat.clone();
        one.values_mut()[31] = 0.5;
        assert_eq!(
            PrioritySampler::new(&one, 4, 0).sample(0.5).iter().collect::<Vec<_>>(),
            [(1, 1)]
        );
        let all = Plane::filled(Size::new(30, 20), 3.0);
        assert_eq!(PrioritySampler::new(&all, 4, 0).sample(1.0).len(), 600);
    }
}
