//! Sums, costs and errors of a mesh over a new frame.

use crate::parallel::prelude::*;

use super::{Surface, next};
use crate::geom::{Point, orient};
use crate::refine::cost::Cost;
use crate::refine::mean::Mean;
use crate::refine::rows::RowSums;
use crate::refine::subsampled;
use crate::refine::sums::Sums;

/// Triangles in one parallel piece of work.
const CHUNK: usize = 256;

impl Surface {
    /// Computes the sums of all edges and the costs of all triangles over a new frame, and estimates of their errors
    /// if `rows` has the squares.
    pub(in crate::refine) fn measure(&mut self, rows: &RowSums) {
        let (subsample, sloped) = (rows.has_subsampled(), rows.planes().is_some());
        let Self { at, origin, twin, sums, cost, mean, estimate, .. } = self;
        let triangles = origin.len() / 3;
        sums.resize(origin.len(), Sums::default());
        cost.resize(triangles, Cost::default());
        mean.resize(triangles, Mean::default());
        estimate.resize(triangles, f32::INFINITY);
        let packs = sums.par_chunks_mut(3 * CHUNK).zip(cost.par_chunks_mut(CHUNK));
        let packs = packs.zip(mean.par_chunks_mut(CHUNK).zip(estimate.par_chunks_mut(CHUNK)));
        let place = |h: u32| at[origin[h as usize] as usize];
        packs.enumerate().for_each(|(pack, ((sums, costs), (means, estimate)))| {
            let first = (pack * 3 * CHUNK) as u32;
            let subsampled_sums = sum_up(rows, subsample, first, twin, place, sums);
            let (sums, _) = sums.as_chunks::<3>();
            let triangles = costs.iter_mut().zip(&mut *means).zip(sums);
            for (t, ((cost, mean), &[a, b, c])) in (first / 3..).zip(triangles) {
                let triangle = [3 * t, 3 * t + 1, 3 * t + 2].map(place);
                let doubled = orient(triangle[0], triangle[1], triangle[2]);
                let total = rows.total(&(a + b + c), doubled, triangle);
                *cost = if sloped {
                    Cost::special(rows, doubled, triangle)
                } else {
                    Cost::with(&total, doubled, triangle)
                }
                .limited(rows, doubled);
                *mean = Mean::of(&total);
            }
            if subsample {
                for ((estimate, mean), subsampled) in
                    estimate.iter_mut().zip(means).zip(subsampled_sums)
                {
                    *estimate = subsampled::error(subsampled, mean.count);
                }
            }
        });
    }

    /// The same for the triangles `here`; the others keep their values.
    pub(in crate::refine) fn measure_in(&mut self, rows: &RowSums, here: &[bool]) {
        self.sums.resize(self.origin.len(), Sums::default());
        self.cost.resize(here.len(), Cost::default());
        self.mean.resize(here.len(), Mean::default());
        let triangles = || (0..).zip(here).filter(|(_, here)| **here).map(|(t, _)| t);
        for h in triangles().flat_map(|t| 3 * t..3 * t + 3) {
            let twin = self.twin[h as usize];
            // The half-edge with the lower number does the work, or the only one; NONE is the highest.
            if h < twin || !here[twin as usize / 3] {
                self.set_sums(h, rows.edge(self.place(h), self.place(next(h))));
            }
        }
        for t in triangles() {
            let triangle = self.corners(t);
            let [a, b, c] = triangle;
            let total = self.total(rows, t);
            let doubled = orient(a, b, c);
            self.cost[t as usize] = Cost::with(&total, doubled, triangle).limited(rows, doubled);
            self.mean[t as usize] = Mean::of(&total);
        }
    }
}

/// Writes the `sums` of a pack's half-edges from the `first` on, with their `twin`s; `place` has the origin of each.
/// Returns the [subsampled] sums of its triangles on request.
#[inline(always)]
fn sum_up(
    rows: &RowSums,
    subsample: bool,
    first: u32,
    twin: &[u32],
    place: impl Fn(u32) -> Point,
    sums: &mut [Sums],
) -> [Sums; CHUNK] {
    let mut subsampled_sums = [Sums::default(); CHUNK];
    for i in 0..sums.len() {
        let h = first + i as u32;
        // Neighbours are close in memory: few twins are in another pack, and are summed twice.
        let other = twin[h as usize].wrapping_sub(first) as usize;
        if other < i {
            continue;
        }
        let (from, to) = (place(h), place(next(h)));
        if subsample {
            let subsampled;
            [sums[i], subsampled] = rows.edges(from, to);
            subsampled_sums[i / 3] = subsampled_sums[i / 3] + subsampled;
            if other < sums.len() {
                subsampled_sums[other / 3] = subsampled_sums[other / 3] - subsampled;
            }
        } else {
            sums[i] = rows.edge(from, to);
        }
        if other < sums.len() {
            sums[other] = -sums[i];
        }
    }
    subsampled_sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;
    use crate::refine::target::Target;
    use crate::refine::tests::{picture, scattered};

    /// Of a mesh of several packs, against each half-edge and triangle by itself.
    #[test]
    fn what_is_measured_together_is_what_each_has_alone() {
        for (opaque, subsample) in [(true, true), (true, false), (false, true)] {
            let frame = picture(Size::new(201, 150), 5, 60, opaque);
            let mut rows = RowSums::default();
            rows.load(&Target::Frame(&frame), subsample);
            let mut surface = Surface::default();
            surface.link(&scattered(frame.size(), 500));
            assert!(surface.triangles() > 3 * CHUNK);
            surface.measure(&rows);
            let mut reported = 0;
            for t in 0..surface.triangles() as u32 {
                for h in 3 * t..3 * t + 3 {
                    let alone = rows.edge(surface.place(h), surface.place(next(h)));
                    assert_eq!(surface.sums[h as usize], alone);
                }
                let corners = surface.corners(t);
                let mean = Mean::of(&rows.wide(corners));
                assert_eq!(surface.mean[t as usize], mean);
                let estimate = if subsample && opaque {
                    subsampled::error(rows.subsampled(corners), mean.count)
                } else {
                    f32::INFINITY
                };
                assert_eq!(surface.estimate[t as usize], estimate);
                reported += usize::from(estimate.is_finite());
            }
            assert_eq!(reported > surface.triangles() / 2, subsample && opaque, "{reported}");
        }
    }
}
