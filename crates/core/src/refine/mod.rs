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

mod cell;
mod colouring;
mod cost;
mod descend;
mod errors;
mod flip;
mod force;
mod mean;
mod nearby;
mod patch;
mod plan;
mod replace;
mod rest;
mod ring;
mod rows;
mod shape;
mod share;
mod step;
mod sums;
mod surface;
mod tend;
#[cfg(test)]
mod tests;
mod thin;
mod worth;

use crate::echo::{Call, Echo};
use crate::frame::{Buffers, Fill, Frame};
use crate::mesh::Mesh;
use cell::cell_error;
use rest::Rest;
use rows::RowSums;
use share::Share;
use step::{Changes, Stepper};
use surface::Surface;
use tend::Sweep;
use worth::turns;

/// How to refine a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefineOptions {
    /// Steps at most; fewer are done where nothing is left to gain.
    pub steps: u32,
    /// Eighths of one step more: it visits that share of the vertices, which take turns over the frames
    /// of a video. 0..=7.
    pub part: u32,
    /// How much well-shaped triangles count against the error, 0 (not at all: any sliver that fits)
    /// to 1 (no change makes triangles flatter on the whole).
    pub regularity: f64,
    /// The share of the vertices that a step may re-place, 0 (none) to 1.
    pub replace: f64,
    /// What a change has to gain to be made, as a share of the error that a triangle of a plain grid
    /// with as many triangles has on this picture. 0 and up.
    pub threshold: f64,
    /// Whether to look closely: more points along an edge, more vertices and places to choose from where
    /// some are re-placed. 3 % less error, for a fifth more time.
    pub closely: bool,
    /// Whether the picture goes on changing, and a place that changes must not wait for its turn: a step
    /// looks at the whole mesh for vertices to re-place, not at a share in turn, and instead passes by
    /// vertices around which there is hardly any error. On a still, more steps gain more in the same time.
    pub running: bool,
}

/// The default of [`RefineOptions::regularity`]: about 0.3 % of the triangles have an angle below 5
/// degrees then.
pub const REGULARITY: f64 = 0.5;

impl RefineOptions {
    /// No refinement at all.
    pub const fn draft() -> Self {
        Self {
            steps: 0,
            part: 0,
            regularity: REGULARITY,
            replace: 0.0,
            threshold: 0.01,
            closely: false,
            running: false,
        }
    }

    /// Most of the gain for a third of the time of [`RefineOptions::best`].
    pub const fn normal() -> Self {
        Self { steps: 5, replace: 0.05, ..Self::draft() }
    }

    /// Until nothing is left to gain.
    pub const fn best() -> Self {
        Self { steps: 60, replace: 0.05, threshold: 0.001, closely: true, ..Self::draft() }
    }

    /// A frame of a video whose mesh comes from the frame before.
    pub const fn live() -> Self {
        Self { steps: 3, replace: 0.03, threshold: 0.02, running: true, ..Self::draft() }
    }

    /// Steps, one in part among them.
    pub(crate) fn passes(&self) -> u32 {
        self.steps + u32::from(self.part > 0)
    }
}

/// What a refinement did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refined {
    /// Steps that were done, the last perhaps in part.
    pub steps: u32,
    /// Squared error before: the sum over pixels and channels of (picture - mesh)^2, 0..255 each,
    /// colours premultiplied by alpha, and alpha itself where the frame is not opaque.
    pub error_before: f64,
    /// The same afterwards; never more. With an echo both are against what was asked for.
    pub error_after: f64,
    /// Moves of vertices, summed over the steps.
    pub moved: usize,
    /// Flips of edges, summed over the steps.
    pub flipped: usize,
    /// The vertices that were taken from one place and put in at another, ascending.
    pub replaced: Vec<u32>,
    /// The mean colour and the area of each triangle, in the mesh's order, as
    /// [`crate::rasterise::means`] finds them, save the colours of those without a pixel; with an echo
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

/// Looks at a mesh and its squared error, before the first step and after each; whether to go on.
pub type Watch<'a> = &'a mut (dyn FnMut(&Mesh, f64) -> bool + Send);

/// Refines meshes: memory that is used again and, for video, what vertices have learnt.
#[derive(Debug, Default)]
pub struct Refiner {
    rows: RowSums,
    surface: Surface,
    stepper: Stepper,
    /// Of frames that nobody needs any more.
    spent: Buffers,
    /// The stripe of vertices that comes next where a step is done in part.
    stripe: u32,
    /// Where the picture is [tended](Refiner::tend) next.
    sweep: Sweep,
    /// Vertices that were re-placed since triangles were numbered so that neighbours are close together.
    scattered: usize,
}

/// Triangles are numbered anew after one vertex in so many was re-placed. Measured at 1080p, one step: 4 %
/// less time than with numbers as old as the shot.
const GATHERED: usize = 64;

/// Refines `mesh` against `frame`, which must have its size. See [`Refiner::refine`].
pub fn refine(mesh: &mut Mesh, frame: &Frame, options: &RefineOptions) -> Refined {
    Refiner::default().refine(mesh, frame, options)
}

impl Refiner {
    /// Refines `mesh`, a sound one of `frame`'s size, against `frame`, knowing nothing of it yet.
    /// Afterwards it is sound and in canonical order, with as many vertices and triangles; corners are
    /// where they were and vertices on the border still on their side of it.
    pub fn refine(&mut self, mesh: &mut Mesh, frame: &Frame, options: &RefineOptions) -> Refined {
        self.anew(mesh, frame, options, None)
    }

    /// As [`Refiner::refine`], as long as `watch` wants to go on.
    pub fn refine_while(
        &mut self,
        mesh: &mut Mesh,
        frame: &Frame,
        options: &RefineOptions,
        watch: Watch<'_>,
    ) -> Refined {
        self.anew(mesh, frame, options, Some(watch))
    }

    fn anew(
        &mut self,
        mesh: &mut Mesh,
        frame: &Frame,
        options: &RefineOptions,
        watch: Option<Watch<'_>>,
    ) -> Refined {
        if mesh.size != frame.size() || options.passes() == 0 {
            return Refined::default();
        }
        crate::parallel::scope(|_| {
            self.rows.load(frame, options.running);
            self.surface.link(mesh);
            self.surface.measure(&self.rows);
            self.begin();
            self.run(mesh, frame, options, false, watch)
        })
    }

    /// Takes up a new `mesh` that is not to be refined before the next frame, for which
    /// [`Refiner::resume`] then has less to do.
    pub fn prepare(&mut self, mesh: &Mesh) {
        self.surface.link(mesh);
        self.surface.stored.clone_from(&mesh.triangles);
        // All triangles count as changed in the next frame.
        self.surface.clock = 0;
        self.stepper.rest.reset(&self.surface);
        self.begin();
    }

    /// Nothing is known of the mesh yet.
    fn begin(&mut self) {
        self.stepper.forget(self.surface.at.len());
        self.stripe = 0;
        self.scattered = 0;
        self.sweep = Sweep::default();
    }

    /// Refines `mesh` as it came out of the frame before, its vertices perhaps carried along with the
    /// picture, against the next frame of a video. Vertices keep what they have learnt of how far to
    /// step; those around which the picture has not changed for some frames stay, so that a picture
    /// that stands still settles for good, and noise does not move the mesh.
    ///
    /// With an `echo` of the frame before, what is lowered is the squared error plus squared flicker,
    /// |change of the mesh's picture - change of the source|^2, m / (1 - m) times, m the echo's share: where
    /// the source stands still a change must gain more, and where it moves edges follow it rather than jump.
    ///
    /// A mesh with other numbers of vertices or triangles is refined as by [`Refiner::refine`].
    pub fn resume(
        &mut self,
        mesh: &mut Mesh,
        frame: &Frame,
        options: &RefineOptions,
        echo: Option<Echo>,
    ) -> Refined {
        let same = mesh.size == self.surface.size
            && mesh.vertices.len() == self.surface.at.len()
            && mesh.triangles.len() == self.surface.triangles();
        if !same || mesh.size != frame.size() || options.passes() == 0 {
            return self.refine(mesh, frame, options);
        }
        crate::parallel::scope(|_| {
            let wanted = echo.and_then(|echo| echo.on(frame));
            let frame = wanted.as_ref().unwrap_or(frame);
            let Self { rows, surface, stepper, scattered, .. } = self;
            let carry = || {
                let carried = surface.relink(mesh);
                if carried && options.running {
                    gather(surface, &mut stepper.rest, scattered);
                }
                carried
            };
            let ((), carried) = crate::parallel::join(|| rows.load(frame, options.running), carry);
            self.surface.measure(&self.rows);
            let refined = self.run(mesh, frame, options, carried, None);
            if let Some(wanted) = wanted {
                self.spent = wanted.into_buffers();
            }
            refined
        })
    }

    /// Asks for the echo of a frame that was refined, for the next one to [resume](Refiner::resume) with.
    pub fn call(&mut self, coherence: f64) -> Option<Call> {
        Call::new(coherence, std::mem::take(&mut self.spent))
    }

    /// Takes up the memory of an `echo` that is not needed.
    pub fn pass_over(&mut self, echo: Echo) {
        self.spent = echo.into_buffers();
    }

    /// The steps; `carried` says that triangles and half-edges are those of the frame before.
    fn run(
        &mut self,
        mesh: &mut Mesh,
        frame: &Frame,
        options: &RefineOptions,
        carried: bool,
        mut watch: Option<Watch<'_>>,
    ) -> Refined {
        let Self { rows, surface, stepper, stripe, scattered, .. } = self;
        let field = Field::new(rows, frame, surface.triangles(), options);
        let part = Share::new(*stripe, options.part);
        *stripe = part.next();
        stepper.begin(surface, carried, if options.steps > 0 { Share::ALL } else { part }, field);
        let (begin, vertices) = (surface.clock, surface.at.len());
        let most = (options.replace.clamp(0.0, 1.0) * vertices as f64).ceil() as usize;
        let mut refined = Refined { error_before: surface.error(rows), ..Refined::default() };
        let mut still = 0;
        for pass in 0..options.passes() {
            if let Some(watch) = &mut watch {
                surface.store(mesh);
                if !watch(mesh, surface.error(rows)) {
                    break;
                }
            }
            let share = if pass < options.steps { Share::ALL } else { part };
            let most = share.count(most);
            let turns = if options.running { share.turns() } else { turns(vertices, most) };
            let field = Field { follows: pass + 1 < options.passes(), ..field };
            let changes = stepper.step(surface, share, most, turns, field);
            still = if changes.is_empty() { still + 1 } else { 0 };
            refined.add(changes);
            if still >= turns && !surface.awake.contains(&true) {
                break;
            }
        }
        refined.replaced.sort_unstable();
        refined.replaced.dedup();
        *scattered += refined.replaced.len();
        // Both are sums of rounded numbers: a mesh that stayed as it was has not got worse.
        refined.error_after = surface.error(rows).min(refined.error_before);
        surface.store(mesh);
        let fills = || if frame.is_opaque() { surface.stored_fills(rows) } else { Vec::new() };
        (refined.fills, ()) = crate::parallel::join(fills, || stepper.rest.settle(surface, begin));
        refined
    }
}

/// Numbers the triangles anew where many vertices were re-placed, `scattered`, since that was done last. What
/// has settled with the old numbers might not have with the new ones: those decide between changes that exclude
/// each other.
fn gather(surface: &mut Surface, rest: &mut Rest, scattered: &mut usize) {
    if *scattered * GATHERED >= surface.at.len() {
        *scattered = 0;
        rest.renumber(surface.renumber());
    }
}

/// What a pass over the mesh works with.
#[derive(Clone, Copy, Debug)]
struct Field<'a> {
    rows: &'a RowSums,
    frame: &'a Frame,
    /// Squared 8-bit steps for a unit of flatness.
    weight: f64,
    /// What a change must gain to be made, in squared 8-bit steps.
    least_gain: f64,
    /// [`RefineOptions::closely`].
    closely: bool,
    /// [`RefineOptions::running`].
    running: bool,
    /// Whether another pass over the same picture follows.
    follows: bool,
}

/// Squared 8-bit steps for a unit of flatness at the default regularity, as a share of a cell's error.
/// Measured on 16 stills: 0.25 % of the triangles have an angle below 5 degrees in the mean, where those of
/// the plain Delaunay mesh of the same seeds are 2 %.
const SHAPE: f64 = 0.003;

/// The same at regularity 1, where it would be infinite.
const MOST_SHAPE: f64 = 1e4;

/// Nothing below it can be seen: a pixel that is better by one 8-bit step in one channel.
const LEAST_GAIN: f64 = 1.0;

impl<'a> Field<'a> {
    fn new(rows: &'a RowSums, frame: &'a Frame, triangles: usize, options: &RefineOptions) -> Self {
        // Against the picture, not the mesh: the measure must not change as the mesh learns.
        let cell = cell_error(rows, frame, triangles);
        let r = options.regularity.clamp(0.0, 1.0);
        Self {
            rows,
            frame,
            weight: cell * (SHAPE * (r / (1.0 - r)).powi(2)).min(MOST_SHAPE),
            least_gain: (cell * options.threshold.max(0.0)).max(LEAST_GAIN),
            closely: options.closely,
            running: options.running,
            follows: false,
        }
    }
}
