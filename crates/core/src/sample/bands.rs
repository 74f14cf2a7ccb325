//! Level two of the baseline Pic2PolyArt: an equal share of the seeds for each of four bands of
//! saliency, 0-63, 64-127, 128-191 and 192-255, chosen among edges and salient points.
//!
//! The original also puts points on faces: here `--focus faces` gives them more.

use super::thin;
use crate::feature::mask::Mask;
use crate::focus::FocusMap;
use crate::plane::Plane;

const BANDS: usize = 4;

/// `target` of the `candidates`, a quarter from each band of `score`, whose largest value counts as 255; random
/// within a band. Bands with too few candidates leave their share to the others, in equal parts. Fewer than `target`
/// if there are fewer candidates.
pub(crate) fn share_bands(
    candidates: &Mask,
    score: &Plane<f32>,
    target: usize,
    focus: Option<&FocusMap>,
    seed: u64,
) -> Vec<(u32, u32)> {
    let most = score.values().iter().copied().fold(0.0, f32::max);
    let mut bands = [const { Vec::new() }; BANDS];
    for (x, y) in candidates.iter() {
        let level = if most > 0.0 { score.at(x, y) / most * 255.0 } else { 0.0 };
        bands[usize::from(level as u8) * BANDS / 256].push((x, y));
    }
    let shares = equal_shares(bands.each_ref().map(Vec::len), target);
    let chosen = bands.into_iter().zip(shares);
    chosen.flat_map(|(band, share)| thin::keep(band, share, focus, seed)).collect()
}

/// Equal shares of `target`, none larger than the number of candidates `held`. The remainder of a division goes to
/// the first bands.
fn equal_shares(held: [usize; BANDS], target: usize) -> [usize; BANDS] {
    let mut shares = [0; BANDS];
    loop {
        let left = target - shares.iter().sum::<usize>();
        let open = (0..BANDS).filter(|&b| shares[b] < held[b]).count();
        if left == 0 || open == 0 {
            return shares;
        }
        // At least one, so that each round makes progress.
        let each = (left / open).max(1);
        let mut left = left;
        for band in 0..BANDS {
            let more = each.min(held[band] - shares[band]).min(left);
            shares[band] += more;
            left -= more;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;

    #[test]
    fn bands_share_equally_and_lend_what_they_lack() {
        assert_eq!(equal_shares([100; 4], 40), [10; 4]);
        assert_eq!(equal_shares([100; 4], 42), [11, 11, 10, 10]);
        assert_eq!(equal_shares([100, 2, 100, 4], 46), [20, 2, 20, 4]);
        assert_eq!(equal_shares([3, 0, 1, 2], 99), [3, 0, 1, 2]);
        assert_eq!(equal_shares([3, 0, 1, 2], 0), [0; 4]);
    }

    #[test]
    fn every_band_has_its_quarter() {
        let size = Size::new(256, 40);
        let mut mask = Mask::new(size);
        (0..40).for_each(|y| (0..256).for_each(|x| mask.insert(x, y)));
        let score = (0..size.pixels()).map(|i| (i % 256) as f32 / 510.0).collect();
        let score = Plane::new(size, score).expect("as many as pixels");
        let mut points = share_bands(&mask, &score, 400, None, 5);
        for band in 0..4 {
            assert_eq!(points.iter().filter(|p| p.0 / 64 == band).count(), 100);
        }
        points.sort_unstable();
        points.dedup();
        assert_eq!(points.len(), 400);
        let flat = share_bands(&mask, &Plane::filled(size, 0.0), 400, None, 5);
        assert_eq!(flat.len(), 400, "a band alone takes all");
    }
}
