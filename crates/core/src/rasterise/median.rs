//! The median colour of a triangle: where a contour runs through it, that of the larger side.

use super::each_triangle_with;
use crate::frame::{Fill, Frame, Rgba};
use crate::geom::Point;
use crate::mesh::Mesh;
use crate::scan;

/// As many pixels of the colour that a triangle had are added to its own at coherence 1, as a share of its area: where
/// two sides are about equal it does not go back and forth between them.
const INERTIA: f64 = 0.25;

/// Pixels that less than half can be seen of do not count.
const SEEN: u8 = 128;

/// `fills` with the median colours of the triangles, channel by channel, in place of their means; alpha stays.
/// `before` are the colours of the frame before, by triangle.
pub(super) fn medians(
    mesh: &Mesh,
    frame: &Frame,
    fills: &mut [Fill],
    before: &[Option<Rgba>],
    coherence: f64,
) {
    // Planes become pixels once, not on whichever thread comes first.
    let _ = frame.pixels();
    let means = &*fills;
    let found = each_triangle_with(mesh, Fill { colour: [0; 4], area: 0 }, |t, triangle| {
        let fill = means[t];
        if fill.colour[3] == 0 || fill.area == 0 {
            return fill;
        }
        let last = before.get(t).copied().flatten().map(|colour| {
            let votes = (INERTIA * coherence * f64::from(fill.area)) as u32;
            (colour, votes)
        });
        Fill {
            colour: median(frame, triangle, last)
                .map_or(fill.colour, |[r, g, b]| [r, g, b, fill.colour[3]]),
            ..fill
        }
    });
    fills.copy_from_slice(&found);
}

/// The lower median of each channel of the pixels that are seen. The colour of `last` counts as its number of pixels.
fn median(frame: &Frame, triangle: [Point; 3], last: Option<(Rgba, u32)>) -> Option<[u8; 3]> {
    let mut counts = [[0u32; 256]; 3];
    let mut all = 0u32;
    scan::spans(triangle, 0..frame.size().height, |y, columns| {
        for pixel in &frame.row(y)[columns] {
            let seen = u32::from(pixel[3] >= SEEN);
            all += seen;
            (0..3).for_each(|c| {
                counts[c][pixel[c] as usize] += seen;
            });
        }
    });
    if all == 0 {
        return None;
    }
    if let Some((colour, votes)) = last {
        all += votes;
        (0..3).for_each(|c| counts[c][colour[c] as usize] += votes);
    }
    let half = all.div_ceil(2);
    Some([0, 1, 2].map(|c| {
        let mut below = 0;
        let reaches = |&count: &u32| {
            below += count;
            below >= half
        };
        counts[c].iter().position(reaches).unwrap_or(255) as u8
    }))
}

#[cfg(test)]
mod tests {
    use super::super::means;
    use super::*;
    use crate::chance::{Purpose, rank};
    use crate::geom::Size;
    use crate::triangulate::triangulate;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn half_of_the_pixels_are_not_above_and_half_not_below(seed: u64) {
            let size = Size::new(40, 30);
            let pixel = |i: usize| {
                let [r, g, b, ..] = rank(seed, Purpose::Noise, i as u32, 0).to_le_bytes();
                [r, g, b, 255]
            };
            let frame = Frame::new(size, (0..size.pixels()).map(pixel).collect()).expect("small");
            let mesh = triangulate(size, &[Point::pixel_centre(9, 5), Point::pixel_centre(25, 20)]);
            let mesh = mesh.expect("two seeds");
            let mut fills = means(&mesh, &frame);
            medians(&mesh, &frame, &mut fills, &[], 0.0);
            for (t, fill) in fills.iter().enumerate() {
                for c in 0..3 {
                    let (mut below, mut above) = (0, 0);
                    scan::spans(mesh.triangle(t), 0..30, |y, columns| for x in columns {
                        let value = frame.at(x as u32, y)[c];
                        below += u32::from(value < fill.colour[c]);
                        above += u32::from(value > fill.colour[c]);
                    });
                    prop_assert!(2 * below <= fill.area && 2 * above <= fill.area);
                }
            }
        }
    }

    /// A silhouette through a square, and how far the larger side goes.
    #[test]
    fn the_larger_side_wins_and_keeps_on_winning_for_a_while() {
        let size = Size::new(40, 40);
        let colour = |to: usize, last: Option<(Rgba, u32)>| {
            let pixel =
                |i: usize| if i / 40 + 1 < to { [250, 250, 250, 255] } else { [9, 9, 9, 255] };
            let frame = Frame::new(size, (0..size.pixels()).map(pixel).collect()).expect("small");
            let p = |x: i32, y: i32| Point::new(x * 256, y * 256);
            median(&frame, [p(0, 0), p(40, 0), p(0, 40)], last).expect("pixels")[0]
        };
        assert_eq!((colour(20, None), colour(5, None)), (250, 9));
        // 40 + 39 + ... = 820 pixels, of which 12 rows hold 414.
        assert_eq!((colour(13, None), colour(12, None)), (250, 9));
        assert_eq!(colour(12, Some(([250; 4], 80))), 250);
        assert_eq!(colour(8, Some(([250; 4], 80))), 9);
    }
}
