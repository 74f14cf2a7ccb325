//! Maintains a mesh without refinement steps: vertices are re-placed strip by strip.

use super::cell::cell_rows;
use super::options::{Mode, RefineOptions};
use super::pass::Pass;
use super::step::Changes;
use super::surface::Surface;
use super::target::Target;
use super::{Refined, Refiner, in_pool};
use crate::frame::Frame;
use crate::geom::{SUBPIXEL, Size};
use crate::mesh::Mesh;

/// The height of a strip, as a share of the picture's.
const STRIP: f64 = 1.0 / 8.0;

/// The share of the picture that becomes due with every frame; a strip is maintained when enough is due. The cube of
/// the share of moved vertices is added: motion distorts the mesh, most where everything moves, and calm clips cost
/// little. Measured on nine clips: with the square a tenth less error, for 8 % of the time from MP4 to MP4.
/// Measured by `cargo xtask measure effort`.
const EFFORT: f64 = 1.0 / 64.0;

/// The largest strip, as a share of the picture.
const MAX_SHARE: f64 = 1.0 / 4.0;

/// The share of the vertices that may be re-placed in a strip.
const REPLACED: f64 = 0.02;

/// Schedules the strips from frame to frame.
#[derive(Debug, Default)]
pub(super) struct StripScheduler {
    /// The share of the picture that is due.
    due: f64,
    /// The top of the next strip, as a share of the height.
    top: f64,
}

impl StripScheduler {
    /// The top and bottom of the next strip, if one is due, when a share `moved` of the vertices has moved since the
    /// last frame.
    fn next(&mut self, moved: f64) -> Option<(f64, f64)> {
        self.due += EFFORT + moved.powi(3);
        if self.due < STRIP {
            return None;
        }
        let (top, bottom) = (self.top, (self.top + self.due.min(MAX_SHARE)).min(1.0));
        *self = Self { due: 0.0, top: if bottom < 1.0 { bottom } else { 0.0 } };
        Some((top, bottom))
    }
}

impl Refiner {
    /// Adopts a fresh `mesh` of `frame` that later frames only maintain.
    pub(super) fn adopt(&mut self, mesh: &Mesh, frame: &Frame) {
        self.prepare(mesh);
        if mesh.size == frame.size() {
            self.rows.load(&Target::Frame(frame), false);
            self.surface.measure(&self.rows);
            self.stepper.activity.deactivate_all(&self.surface);
        }
    }

    /// Maintains `mesh` for `frame` without steps: see [`Refiner::frame`].
    pub(super) fn maintain(
        &mut self,
        mesh: &mut Mesh,
        frame: &Frame,
        options: &RefineOptions,
    ) -> Refined {
        if mesh.size != frame.size() {
            return Refined::default();
        }
        let Self { focus, rows, surface, stepper, strips, buffers, .. } = self;
        let strip = strips.next(moved(surface, mesh));
        let Some(strip) = strip else {
            if surface.at.len() == mesh.vertices.len() {
                surface.at.clone_from(&mesh.vertices);
            }
            return Refined::default();
        };
        in_pool(|| {
            let carried = surface.relink(mesh);
            if !carried {
                stepper.forget(surface.at.len());
            }
            let here = overlapping(surface, strip);
            let wanted = rows_of(surface, &here);
            let read = cell_rows(frame.size(), surface.triangles()).chain([wanted.clone()]);
            let target = Target::with_rows(frame, read, buffers);
            rows.load_rows(&target, wanted, false);
            surface.measure_in(rows, &here);
            let still = RefineOptions { mode: Mode::Quick, ..*options };
            let pass = Pass::new(rows, &target, surface.triangles(), &still);
            let pass = Pass { focus: focus.as_ref(), ..pass };
            stepper.begin_in(surface, carried, here, pass);
            let begin = surface.clock;
            let limit = (REPLACED * surface.at.len() as f64).ceil() as usize;
            let changes = stepper.maintain(surface, limit, pass);
            stepper.activity.commit(surface, begin);
            stepper.activity.cover_all();
            if !changes.is_empty() {
                surface.store(mesh);
            }
            target.recycle(buffers);
            let Changes { flipped, mut replaced, .. } = changes;
            replaced.sort_unstable();
            Refined { flipped, replaced, ..Refined::default() }
        })
    }
}

/// The share of the vertices of `mesh` that have moved from their positions in `surface`.
fn moved(surface: &Surface, mesh: &Mesh) -> f64 {
    let moved = surface.at.iter().zip(&mesh.vertices).filter(|(then, now)| then != now).count();
    moved as f64 / mesh.vertices.len().max(1) as f64
}

/// Which triangles overlap the strip from `top` to `bottom`.
fn overlapping(surface: &Surface, (top, bottom): (f64, f64)) -> Vec<bool> {
    let far = f64::from(surface.size.far().y);
    let (top, bottom) = ((top * far) as i32, (bottom * far) as i32);
    let overlaps = |t: u32| {
        let [a, b, c] = surface.corners(t).map(|p| p.y);
        a.min(b).min(c) <= bottom && a.max(b).max(c) >= top
    };
    (0..surface.triangles() as u32).map(overlaps).collect()
}

/// The rows that the triangles `here` cover.
fn rows_of(surface: &Surface, here: &[bool]) -> std::ops::Range<u32> {
    let Size { height, .. } = surface.size;
    let triangles = (0..).zip(here).filter(|(_, here)| **here).map(|(t, _)| surface.corners(t));
    let (top, bottom) =
        triangles.flatten().fold((i32::MAX, 0), |(top, bottom), p| (top.min(p.y), bottom.max(p.y)));
    // The row of the lowest corner is included, because gradients read it.
    (top / SUBPIXEL) as u32..((bottom / SUBPIXEL) as u32 + 1).min(height)
}
