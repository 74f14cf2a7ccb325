//! Adaptive thinning (Demaret, Dyn and Iske, "Image compression by linear splines over adaptive triangulations", Signal
//! Processing 86(7), 2006): of many points the one goes without which the error rises least, again and again.
//!
//! The error is that of triangles in their mean colours. The hole of a point is closed by the triangles of the best
//! shape: those are nearly the Delaunay triangles that the points get in the end.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::parallel::prelude::*;

use super::errors::Errors;
use super::options::RefineOptions;
use super::pass::Pass;
use super::patch::{Closing, Plan, take_out};
use super::ring::Ring;
use super::rows::RowSums;
use super::surface::Surface;
use super::target::Target;
use crate::focus::FocusMap;
use crate::frame::Frame;
use crate::geom::Point;
use crate::mesh::{CORNERS, Place};
use crate::triangulate::triangulate;

/// Squared 8-bit steps for a unit of flatness: shape decides, and error does where shapes are equal.
const SHAPE: f64 = 1e12;

/// Vertices in one parallel piece of work.
const CHUNK: usize = 64;

/// The `target` of `points`, distinct pixels of `frame`, that are left by adaptive thinning, in the order in which they
/// were given. The seeds of the `border` stay. By `focus` the error counts more in some places.
pub(crate) fn thin(
    frame: &Frame,
    border: &[Point],
    points: Vec<(u32, u32)>,
    target: usize,
    focus: Option<&FocusMap>,
) -> Vec<(u32, u32)> {
    let seeds = || points.iter().map(|&(x, y)| Point::pixel_centre(x, y));
    let seeds: Vec<Point> = border.iter().copied().chain(seeds()).collect();
    let first = CORNERS + border.len();
    // Pixel centres do not lie on the border, and pixels are distinct.
    let Ok(mesh) = triangulate(frame.size(), &seeds) else { return points };
    let (mut rows, mut surface) = (RowSums::default(), Surface::default());
    let source = Target::Frame(frame);
    rows.load(&source, false);
    surface.link(&mesh);
    surface.measure(&rows);
    let options = RefineOptions::draft();
    let pass = Pass::new(&rows, &source, mesh.triangles.len(), &options);
    let pass = Pass { focus, weight: SHAPE, ..pass };
    let mut thinning = Thinning::new(surface, pass);
    let gone = points.len().saturating_sub(target);
    let removed = (0..gone).map_while(|_| thinning.remove()).collect::<Vec<_>>();
    let mut stays = vec![true; points.len()];
    for v in removed {
        stays[v as usize - first] = false;
    }
    points.into_iter().zip(stays).filter_map(|(point, stays)| stays.then_some(point)).collect()
}

/// The cost of a vertex, which is valid if it is the last that was found.
type Entry = Reverse<(Key, u32, u32)>;

/// A cost, never negative or not a number, by its bits: they are in its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Key(u64);

impl Key {
    fn of(cost: f64) -> Self {
        Self(cost.max(0.0).to_bits())
    }
}

/// A mesh whose vertices go one by one.
struct Thinning<'a> {
    surface: Surface,
    pass: Pass<'a>,
    queue: BinaryHeap<Entry>,
    /// How often the cost of each vertex was found.
    versions: Vec<u32>,
    ring: Ring,
    closing: Closing,
    errors: Errors,
}

impl<'a> Thinning<'a> {
    fn new(surface: Surface, pass: Pass<'a>) -> Self {
        let inner: Vec<u32> = (0..surface.at.len() as u32)
            .filter(|&v| surface.freedom(v) == Place::Interior)
            .collect();
        let cost = |(ring, closing): &mut (Ring, Closing), &v: &u32| {
            let plan = planned(&surface, pass, v, ring, closing)?;
            Some(Reverse((Key::of(plan.1), v, 0)))
        };
        let packs = inner.par_chunks(CHUNK).map(|pack| {
            let mut scratch = <(Ring, Closing)>::default();
            pack.iter().filter_map(|v| cost(&mut scratch, v)).collect::<Vec<_>>()
        });
        let queue = packs.collect::<Vec<_>>().concat().into();
        let versions = vec![0; surface.at.len()];
        let (ring, closing, errors) = Default::default();
        Self { surface, pass, queue, versions, ring, closing, errors }
    }

    /// Takes the cheapest vertex out, and returns it; `None` if none can be taken out.
    fn remove(&mut self) -> Option<u32> {
        loop {
            let Reverse((_, v, version)) = self.queue.pop()?;
            if version != self.versions[v as usize] {
                continue;
            }
            let Self { surface, pass, ring, closing, errors, .. } = self;
            let Some((plan, _)) = planned(surface, *pass, v, ring, closing) else { continue };
            let neighbours: Vec<u32> = ring.links.iter().map(|&h| surface.from(h)).collect();
            take_out(surface, errors, pass.rows, ring, &plan);
            self.versions[v as usize] += 1;
            neighbours.into_iter().for_each(|v| self.ask(v));
            return Some(v);
        }
    }

    /// Finds the cost of `v` anew.
    fn ask(&mut self, v: u32) {
        let Self { surface, pass, queue, versions, ring, closing, .. } = self;
        if surface.freedom(v) != Place::Interior {
            return;
        }
        versions[v as usize] += 1;
        if let Some((_, cost)) = planned(surface, *pass, v, ring, closing) {
            queue.push(Reverse((Key::of(cost), v, versions[v as usize])));
        }
    }
}

/// The best way to close the hole of `v`, and by how much the error rises; the ring around `v` is left in `ring`.
/// `None` if there is no way.
fn planned(
    surface: &Surface,
    pass: Pass,
    v: u32,
    ring: &mut Ring,
    closing: &mut Closing,
) -> Option<(Plan, f64)> {
    ring.surround(surface, v, surface.around(v));
    ring.sum_up(surface);
    let plan = closing.plan(ring, pass.rows, pass.weight)?;
    let rise = plan.cost.error - ring.cost(surface).error;
    Some((plan, rise * pass.focus_at(surface.at[v as usize])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;

    /// Grey with a bright square.
    fn square(size: Size) -> Frame {
        let pixel = |i: u32| {
            let (x, y) = (i % size.width, i / size.width);
            let inside = (20..60).contains(&x) && (16..44).contains(&y);
            if inside { [230, 210, 40, 255] } else { [60, 70, 90, 255] }
        };
        Frame::new(size, (0..size.pixels() as u32).map(pixel).collect()).expect("small")
    }

    fn lattice(size: Size, step: usize) -> Vec<(u32, u32)> {
        let rows = (1..size.height - 1).step_by(step);
        rows.flat_map(|y| (1..size.width - 1).step_by(step).map(move |x| (x, y))).collect()
    }

    #[test]
    fn points_stay_where_the_picture_changes() {
        let size = Size::new(80, 60);
        let points = lattice(size, 3);
        let kept = thin(&square(size), &[], points.clone(), 60, None);
        assert_eq!(kept.len(), 60);
        assert!(kept.iter().all(|p| points.contains(p)));
        let near = |&&(x, y): &&(u32, u32)| {
            let off = |v: u32, low: u32, high: u32| v.abs_diff(low).min(v.abs_diff(high));
            (off(x, 20, 60) <= 4 && (12..48).contains(&y))
                || (off(y, 16, 44) <= 4 && (16..64).contains(&x))
        };
        let outline = kept.iter().filter(near).count();
        assert!(outline >= 30, "{outline} of 60 lie along the square");
    }

    #[test]
    fn any_number_of_points_can_be_kept() {
        let size = Size::new(40, 30);
        let points = lattice(size, 4);
        let border = [Point::new(20 * 256, 0)];
        for target in [0, 1, 5, points.len(), 500] {
            let kept = thin(&square(size), &border, points.clone(), target, None);
            assert!(kept.len() <= points.len() && kept.len() >= target.min(points.len()));
            assert!(kept.len() <= target + 4, "{} for {target}", kept.len());
        }
    }

    #[test]
    fn one_thread_and_many_keep_the_same() {
        let size = Size::new(80, 60);
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let thin = || thin(&square(size), &[], lattice(size, 2), 90, None);
            pool.expect("a pool").install(thin)
        };
        assert_eq!(run(1), run(3));
    }
}
