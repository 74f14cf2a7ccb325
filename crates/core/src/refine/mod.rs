//! Level three: vertices descend the squared error between picture and mesh.
//!
//! The paper places seeds once and stops. Here the mesh learns: with every triangle painted in its mean
//! colour, the squared error E is the sum over triangles of |I - mean|^2 over their pixels, and three
//! kinds of change lower it. Vertices **move** against the force that the picture exerts on their edges
//! (Lawonn and Guenther, "Stylized Image Triangulation", 2019); diagonals **flip** where the other one
//! fits better (data-dependent triangulation, Dyn, Levin and Rippa 1990); and vertices that matter
//! least are **re-placed** where the error is largest, their number staying the same.
//!
//! Every change is tried first, on exact sums over the very pixels that the rasteriser will give to
//! each triangle, and made only if it pays: E never rises, a picture that stands still
//! settles, and the outcome does not depend on the number of threads. The mesh that comes out is not
//! Delaunay: where the picture asks for it a diagonal turns the other way, and a penalty on flat
//! triangles, [`RefineOptions::regularity`], keeps the rest well-shaped.

mod activity;
mod cell;
mod colouring;
mod cost;
mod descend;
mod errors;
mod flip;
mod force;
mod maintain;
mod mean;
mod morton;
mod options;
mod pass;
mod patch;
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

/// What a refinement did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refined {
    /// Steps that were done, the last perhaps in part.
    pub steps: u32,
    /// Squared error before: the sum over pixels and channels of (picture - mesh)^2, 0..255 each,
    /// colours premultiplied by alpha, and alpha itself where the frame is not opaque.
    pub error_before: f64,
    /// The same afterwards; never more. With a residual both are against the corrected target.
    pub error_after: f64,
    /// Moves of vertices, summed over the steps.
    pub moved: usize,
    /// Flips of edges, summed over the steps.
    pub flipped: usize,
    /// The vertices that were taken from one place and put in at another, ascending.
    pub replaced: Vec<u32>,
    /// The mean colour and the area of each triangle, in the mesh's order, as
    /// [`crate::rasterise::means`] finds them, save the colours of those without a pixel; with a residual
    /// nearly so, a share of what they were off in the frame before. Empty where they are not known: of
    /// frames that are not opaque, and where no step was asked for.
    pub fills: Vec<Fill>,
    /// The likeness that was measured last, where [`crate::options::Options::error`] asked for one.
    pub likeness: Option<f64>,
}

impl Refined {
    /// One step more.
    fn add(&mut self, mut changes: Changes) {
        self.steps += 1;
        self.moved += changes.moved;
        self.flipped += changes.flipped;
        self.replaced.append(&mut changes.replaced);
    }
}

/// Is shown a mesh and its squared error before the first step and after each; returns whether to go on.
pub type Watch<'a> = &'a mut (dyn FnMut(&Mesh, f64) -> bool + Send);

/// Refines meshes. Keeps scratch buffers and, for video, what vertices have learnt.
#[derive(Debug, Default)]
pub struct Refiner {
    rows: RowSums,
    surface: Surface,
    stepper: Stepper,
    /// Of pictures that are no longer needed.
    buffers: Buffers,
    /// The stripe of vertices that comes next where a step is done in part.
    stripe: u32,
    /// Where the picture is [maintained](Refiner::frame) next.
    strips: StripScheduler,
    /// Vertices that were re-placed since triangles were numbered so that neighbours are close together.
    replaced_since_renumber: usize,
}

/// Triangles are renumbered after one vertex in this many was re-placed. Measured at 1080p, one step: 4 % less time
/// than with numbers as old as the shot.
/// Measured by `cargo xtask measure renumber-after`.
const RENUMBER_AFTER: usize = 64;

/// Refines `mesh` against `frame`, which must have its size. See [`Refiner::still`].
pub fn refine(mesh: &mut Mesh, frame: &Frame, options: &RefineOptions) -> Refined {
    Refiner::default().still(mesh, frame, options, None)
}

/// Does `job` inside rayon's pool. A thread outside it would hand each of a frame's many parallel loops over
/// to the pool and sleep until it is done; this way it does so once.
fn in_pool<T: Send>(job: impl FnOnce() -> T + Send) -> T {
    crate::parallel::scope(|_| job())
}

impl Refiner {
    /// Refines a fresh `mesh`, of a still or the first frame of a shot, against `frame`. The mesh must be
    /// sound and of the frame's size. Afterwards it is sound and in canonical order, with as many vertices
    /// and triangles; corners are where they were and vertices on the border still on their side of it. Goes
    /// on as long as `watch` returns true. Where the options ask for no step, [`RefineOptions::unrefined`]
    /// says what is kept for the next frame.
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

    /// Refines `mesh` as it came out of the frame before, its vertices perhaps carried along with the
    /// picture, against the next frame of a stream. Vertices keep what they have learnt of how far to
    /// step; those around which the picture has not changed for some frames stay, so that a picture
    /// that stands still settles for good, and noise does not move the mesh.
    ///
    /// With the `residual` of the frame before, what is lowered is the squared error plus squared flicker,
    /// |change of the mesh's picture - change of the source|^2, m / (1 - m) times, m the residual's share:
    /// where the source stands still a change must gain more, and where it moves edges follow it rather than
    /// jump.
    ///
    /// Where the options ask for no step, the mesh is only kept fit for the frame: in a strip of the picture,
    /// which sweeps over it from frame to frame, vertices that matter least are re-placed where the picture
    /// has changed and the error is large, and edges flip next to them. All others stay where they are. Of
    /// `options`, regularity and threshold count then.
    ///
    /// A mesh with other numbers of vertices or triangles than the one before is refined as a fresh one.
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

    /// Buffers that are free, perhaps empty: for the residual of the frame that was refined last.
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
            self.rows.load(&target, options.mode == Mode::Stream);
            self.surface.link(mesh);
            self.surface.measure(&self.rows);
            self.begin();
            self.run(mesh, &target, options, false, watch)
        })
    }

    /// Links a fresh `mesh` that is not refined before the next frame, which then has less to do.
    fn prepare(&mut self, mesh: &Mesh) {
        self.surface.link(mesh);
        self.surface.stored.clone_from(&mesh.triangles);
        // All triangles count as changed in the next frame.
        self.surface.clock = 0;
        self.stepper.activity.reset(&self.surface);
        self.begin();
    }

    /// Nothing is known of the mesh yet.
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
            let ((), carried) = crate::parallel::join(|| rows.load(&target, subsample), carry);
            self.surface.measure(&self.rows);
            let refined = self.run(mesh, &target, options, carried, None);
            target.recycle(&mut self.buffers);
            refined
        })
    }

    /// The steps; `carried` says that triangles and half-edges are those of the frame before.
    fn run(
        &mut self,
        mesh: &mut Mesh,
        target: &Target<'_>,
        options: &RefineOptions,
        carried: bool,
        mut watch: Option<Watch<'_>>,
    ) -> Refined {
        let Self { rows, surface, stepper, stripe, replaced_since_renumber, .. } = self;
        let pass = Pass::new(rows, target, surface.triangles(), options);
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
        // Both are sums of rounded numbers: a mesh that stayed as it was has not got worse.
        refined.error_after = surface.error(rows).min(refined.error_before);
        surface.store(mesh);
        let fills = || if target.is_opaque() { surface.stored_fills(rows) } else { Vec::new() };
        (refined.fills, ()) =
            crate::parallel::join(fills, || stepper.activity.commit(surface, begin));
        refined
    }
}

/// Numbers the triangles anew where many vertices were re-placed, `replaced_since_renumber`, since that was done last. What
/// has settled with the old numbers might not have with the new ones: those decide between changes that exclude
/// each other.
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
