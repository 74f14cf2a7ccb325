//! Random numbers as hashes of a seed and a position, not as a sequence: a pixel has the same number in every frame,
//! on any number of threads.

/// The use of a random number; numbers for different purposes are independent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Purpose {
    /// The choice of candidates inside colour regions.
    Interior = 1,
    /// The choice of candidates of a cell.
    Keep = 2,
    /// The order in which seeds are removed.
    Trim = 3,
    /// Offsets of the grid and of border points.
    Phase = 4,
    /// Noise that `evaluate` adds to a picture.
    Noise = 5,
}

/// A uniform 64-bit number decided by `seed`, `purpose` and the pixel `(x, y)` alone.
///
/// The finaliser is `SplitMix64`'s (Steele, Lea, Flood: "Fast splittable pseudorandom number
/// generators", 2014).
#[inline(always)]
pub const fn rank(seed: u64, purpose: Purpose, x: u32, y: u32) -> u64 {
    let place = ((y as u64) << 32) | x as u64;
    mix(mix(seed ^ (purpose as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)) ^ place)
}

/// [`rank`] as a number in `[0, 1)`.
pub fn unit(seed: u64, purpose: Purpose, x: u32, y: u32) -> f64 {
    (rank(seed, purpose, x, y) >> 11) as f64 / (1u64 << 53) as f64
}

#[inline(always)]
pub(crate) const fn mix(z: u64) -> u64 {
    let z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_uniform_and_independent_between_purposes() {
        let n = 64u32;
        let (mut sum, mut cross) = (0.0, 0.0);
        for y in 0..n {
            for x in 0..n {
                let a = unit(7, Purpose::Keep, x, y) - 0.5;
                let b = unit(7, Purpose::Trim, x, y) - 0.5;
                sum += a;
                cross += a * b;
            }
        }
        let count = f64::from(n * n);
        // Standard errors: 1/sqrt(12 n^2) = 0.0045 and 1/(12 n) = 0.0013; four of each allowed.
        assert!((sum / count).abs() < 0.018, "mean {}", sum / count);
        assert!((cross / count).abs() < 0.0052, "correlation {}", cross / count);
    }
}
