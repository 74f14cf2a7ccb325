//! Level three: lowers the squared error between picture and mesh.
//!
//! The paper ends with the choice of seeds. Here the mesh is optimised: with every triangle painted in its mean
//! colour, the squared error E is the sum over triangles of |I - mean|^2 over their pixels, and three kinds of change
//! lower it. Vertices **move** against the gradient of the error (Lawonn and Guenther, "Stylized Image
//! Triangulation", 2019); edges **flip** if the other diagonal fits better (data-dependent triangulation, Dyn, Levin
//! and Rippa 1990); and the vertices that lower the error least are **re-placed** where it is largest, so that their
//! number stays the same.
//!
//! Every change is evaluated first, on exact sums over the pixels that the rasteriser will give to each triangle, and
//! made only if it gains enough: E never rises, the mesh of a constant picture becomes constant, and the result does
//! not depend on the number of threads. The resulting mesh is not Delaunay: edges follow the picture, and a penalty
//! on flat triangles, [`RefineOptions::regularity`], keeps the others well-shaped.

mod activity;
mod border;
mod cell;
mod colouring;
mod cost;
mod descend;
mod errors;
mod flip;
mod force;
mod limits;
mod line;
mod maintain;
mod mean;
mod morton;
mod options;
mod pass;
mod patch;
mod planes;
mod removal;
mod replace;
mod ring;
mod rows;
mod shape;
mod share;
mod step;
mod subsampled;
mod sums;
mod surface;
mod target;
#[cfg(test)]
mod tests;
pub(crate) mod thinning;

use crate::focus::FocusMap;
use crate::frame::{Buffers, Fill, Frame};
use crate::mesh::Mesh;
use crate::residual::Residual;
use activity::Activity;
use maintain::StripScheduler;
pub use options::{Mode, REGULARITY, RefineOptions, Unrefined};
use pass::Pass;
use removal::turns;
use rows::RowSums;
use share::Share;
use step::{Changes, Stepper};
use surface::Surface;
use target::Target;

/// The result of a refinement.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refined {
    /// Number of steps, the last perhaps in part.
    pub steps: u32,
    /// Squared error before: the sum over pixels and channels of (picture - mesh)^2, 0..255 each,
    /// colours premultiplied by alpha, and alpha itself where the frame is not opaque.
    pub error_before: f64,
    /// The squared error afterwards; never larger. With a residual both are against the corrected target.
    pub error_after: f64,
    /// Number of moves of vertices in all steps.
    pub moved: usize,
    /// Number of flips of edges in all steps.
    pub flipped: usize,
    /// The vertices that were re-placed, ascending.
    pub replaced: Vec<u32>,
    /// The mean colour and the area of each triangle, in the mesh's order, as [`crate::rasterise::means`] finds them,
    /// except the colours of triangles without pixels. With a residual the colours differ by a share of the last
    /// frame's error. Empty if unknown: for frames that are not opaque, and without steps.
    pub fills: Vec<Fill>,
    /// The last measured likeness, where [`crate::options::Options::error`] requests one.
    pub likeness: Option<f64>,
}

impl Refined {
    /// Adds the changes of a step.
    fn add(&mut self, mut changes: Changes) {
        self.steps += 1;
        self.moved += changes.moved;
        self.flipped += changes.flipped;
        self.replaced.append(&mut changes.replaced);
    }
}

/// Gets the mesh and its squared error before the first step and after each one; returns whether to go on.
pub type Watch<'a> = &'a mut (dyn FnMut(&Mesh, f64) -> bool + Send);

/// Refines meshes. It keeps scratch buffers and, for video, what is known of each vertex.
#[derive(Debug, Default)]
pub struct Refiner {
    /// How much places matter; `None` for all the same.
    pub(crate) focus: Option<FocusMap>,
    rows: RowSums,
    surface: Surface,
    stepper: Stepper,
    /// Of pictures that are no longer needed.
    buffers: Buffers,
    /// The next stripe of vertices, for steps in part.
    stripe: u32,
    /// The next strips to be [maintained](Refiner::frame).
    strips: StripScheduler,
    /// Number of vertices re-placed since the triangles were last renumbered.
    replaced_since_renumber: usize,
}

/// Triangles are renumbered, so that neighbours are close in memory, after one vertex in this many was re-placed.
/// Measured at 1080p, one step: 4 % less time than with the numbers of the shot's first frame.
/// Measured by `cargo xtask measure renumber-after`.
const RENUMBER_AFTER: usize = 64;

/// Refines `mesh` against `frame`, which must have its size. See [`Refiner::still`].
pub fn refine(mesh: &mut Mesh, frame: &Frame, options: &RefineOptions) -> Refined {
    Refiner::default().still(mesh, frame, options, None)
}

/// Runs `job` inside rayon's pool. A thread outside it would hand each of a frame's many parallel loops to the pool
/// and sleep until it is done; this way it does so once.
fn in_pool<T: Send>(job: impl FnOnce() -> T + Send) -> T {
    crate::parallel::scope(|_| job())
}

impl Refiner {
    /// Refines a fresh `mesh`, of a still or the first frame of a shot, against `frame`. The mesh must be sound and
    /// of the frame's size. Afterwards it is sound and in canonical order, with the same numbers of vertices and
    /// triangles; corners have not moved, and border vertices are on the border, though perhaps elsewhere. Goes on as long as `watch`
    /// returns true. If the options request no step, [`RefineOptions::unrefined`] says what is prepared for the next
    /// frame.
    pub fn still(
        &mut self,
        mesh: &mut Mesh,
        frame: &Frame,
        options: &RefineOptions,
        watch: Option<Watch<'_>>,
    ) -> Refined {
        if options.passes() > 0 {
            return self.refine_fresh(mesh, frame, options, watch);
        }
        match options.unrefined {
            Unrefined::Forget => {}
            Unrefined::Prepare => self.prepare(mesh),
            Unrefined::Adopt => self.adopt(mesh, frame),
        }
        Refined::default()
    }

    /// Refines the `mesh` of the last frame, which may have been moved with the picture, against the next `frame` of
    /// a stream. Each vertex keeps its step length; a vertex around which the picture has not changed for some frames
    /// stays, so that the mesh of a constant picture becomes constant, and noise does not move it.
    ///
    /// With the `residual` of the last frame, the objective is the squared error plus m / (1 - m) times the squared
    /// flicker, |change of the mesh's picture - change of the source|^2, where m is the residual's share: where the
    /// source is constant a change must gain more, and where it moves edges follow it rather than jump.
    ///
    /// If the options request no step, the mesh is only maintained: in a strip of the picture, which moves down from
    /// frame to frame, the vertices that lower the error least are re-placed where the picture has changed and the
    /// error is large, and edges flip next to them. All others stay. Of the `options`, only regularity and threshold
    /// count then.
    ///
    /// A mesh with other numbers of vertices or triangles than the last one is refined as a fresh one.
    pub fn frame(
        &mut self,
        mesh: &mut Mesh,
        frame: &Frame,
        options: &RefineOptions,
        residual: Option<Residual>,
    ) -> Refined {
        if options.passes() > 0 {
            return self.refine_next(mesh, frame, options, residual);
        }
        if let Some(residual) = residual {
            self.recycle(residual.into_buffers());
        }
        self.maintain(mesh, frame, options)
    }

    /// Takes back buffers that are no longer needed.
    pub fn recycle(&mut self, buffers: Buffers) {
        self.buffers = buffers;
    }

    /// Free buffers, perhaps empty, for the residual of the last frame.
    pub fn take_buffers(&mut self) -> Buffers {
        std::mem::take(&mut self.buffers)
    }

    fn refine_fresh(
        &mut self,
        mesh: &mut Mesh,
        frame: &Frame,
        options: &RefineOptions,
        watch: Option<Watch<'_>>,
    ) -> Refined {
        if mesh.size != frame.size() {
            return Refined::default();
        }
        in_pool(|| {
            let target = Target::Frame(frame);
            self.rows.load_for(&target, options);
            self.surface.link(mesh);
            self.surface.measure(&self.rows);
            self.begin();
            self.run(mesh, &target, options, false, watch)
        })
    }

    /// Links a fresh `mesh` that is not refined before the next frame, to save time there.
    fn prepare(&mut self, mesh: &Mesh) {
        self.surface.link(mesh);
        self.surface.stored.clone_from(&mesh.triangles);
        // All triangles count as changed in the next frame.
        self.surface.clock = 0;
        self.stepper.activity.reset(&self.surface);
        self.begin();
    }

    /// Forgets the last mesh.
    fn begin(&mut self) {
        self.stepper.forget(self.surface.at.len());
        self.stripe = 0;
        self.replaced_since_renumber = 0;
        self.strips = StripScheduler::default();
    }

    fn refine_next(
        &mut self,
        mesh: &mut Mesh,
        frame: &Frame,
        options: &RefineOptions,
        residual: Option<Residual>,
    ) -> Refined {
        let same = mesh.size == self.surface.size
            && mesh.vertices.len() == self.surface.at.len()
            && mesh.triangles.len() == self.surface.triangles();
        if !same || mesh.size != frame.size() {
            return self.refine_fresh(mesh, frame, options, None);
        }
        in_pool(|| {
            let target = Target::with_residual(frame, residual);
            let Self { rows, surface, stepper, replaced_since_renumber, .. } = self;
            let subsample = options.mode == Mode::Stream;
            let carry = || {
                let carried = surface.relink(mesh);
                if carried && subsample {
                    renumber_if_stale(surface, &mut stepper.activity, replaced_since_renumber);
                }
                carried
            };
            let load = || rows.load_for(&target, options);
            let ((), carried) = crate::parallel::join(load, carry);
            self.surface.measure(&self.rows);
            let refined = self.run(mesh, &target, options, carried, None);
            target.recycle(&mut self.buffers);
            refined
        })
    }

    /// Runs the steps; `carried` says that triangles and half-edges are those of the last frame.
    fn run(
        &mut self,
        mesh: &mut Mesh,
        target: &Target<'_>,
        options: &RefineOptions,
        carried: bool,
        mut watch: Option<Watch<'_>>,
    ) -> Refined {
        let Self { focus, rows, surface, stepper, stripe, replaced_since_renumber, .. } = self;
        let pass = Pass::new(rows, target, surface.triangles(), options);
        let pass = Pass { focus: focus.as_ref(), ..pass };
        let part = Share::new(*stripe, options.part);
        *stripe = part.next();
        stepper.begin(surface, carried, if options.steps > 0 { Share::ALL } else { part }, pass);
        let (begin, vertices) = (surface.clock, surface.at.len());
        let limit = (options.replace.clamp(0.0, 1.0) * vertices as f64).ceil() as usize;
        let mut refined = Refined { error_before: surface.error(rows), ..Refined::default() };
        let mut still = 0;
        for number in 0..options.passes() {
            if let Some(watch) = &mut watch {
                surface.store(mesh);
                if !watch(mesh, surface.error(rows)) {
                    break;
                }
            }
            let share = if number < options.steps { Share::ALL } else { part };
            let limit = share.count(limit);
            let turns =
                if options.mode == Mode::Stream { share.turns() } else { turns(vertices, limit) };
            let pass = Pass { has_next: number + 1 < options.passes(), ..pass };
            let changes = stepper.step(surface, share, limit, turns, pass);
            still = if changes.is_empty() { still + 1 } else { 0 };
            refined.add(changes);
            if still >= turns && !surface.active.contains(&true) {
                break;
            }
        }
        refined.replaced.sort_unstable();
        refined.replaced.dedup();
        *replaced_since_renumber += refined.replaced.len();
        // Both are sums of rounded numbers: an unchanged mesh must not get worse by rounding.
        refined.error_after = surface.error(rows).min(refined.error_before);
        surface.store(mesh);
        let fills = || if target.is_opaque() { surface.stored_fills(rows) } else { Vec::new() };
        (refined.fills, ()) =
            crate::parallel::join(fills, || stepper.activity.commit(surface, begin));
        refined
    }
}

/// Renumbers the triangles if many vertices were re-placed since the last time. It is rare, because numbers decide
/// between changes that exclude each other: a mesh that is constant with the old numbers might change with new ones.
fn renumber_if_stale(
    surface: &mut Surface,
    activity: &mut Activity,
    replaced_since_renumber: &mut usize,
) {
    if *replaced_since_renumber * RENUMBER_AFTER >= surface.at.len() {
        *replaced_since_renumber = 0;
        activity.renumber(surface.renumber());
    }
}
