//! The cost of removing each vertex from the mesh.

use crate::parallel::prelude::*;

use super::activity::Activity;
use super::border;
use super::cost::Cost;
use super::pass::Pass;
use super::patch::{Closing, Plan};
use super::planes;
use super::ring::Ring;
use super::share::Turn;
use super::surface::{Fan, Surface, around_each};
use crate::mesh::Place;

/// Vertices in one parallel piece of work.
const CHUNK: usize = 64;

/// The removal costs of the vertices, if known.
#[derive(Debug, Default)]
pub(super) struct RemovalCosts {
    /// Removal cost: cost of the surroundings without the vertex, less their cost with it; infinite for vertices that
    /// must stay.
    cost: Vec<Cost>,
    /// When it was found, in ticks of the surface's clock.
    asked: Vec<u32>,
    /// Upper bounds of the rise in squared error without each vertex, in the surface's order; infinite if the vertex
    /// is not a candidate.
    bounds: Vec<f32>,
    /// The candidates of this pass.
    pub(super) candidates: Vec<Candidate>,
    /// Scratch for the triangles of the largest errors, and for those that a pass has touched.
    pub(super) worst: Vec<(f64, u32)>,
    pub(super) taken: Vec<bool>,
    /// Passes over this mesh so far.
    passes: u32,
}

/// If a pass may re-place few vertices, it evaluates this many for each of them, in turns. Measured: 8 gain more in
/// the same time than 32 or all; but see [`Mode::Stream`](super::options::Mode::Stream).
/// Measured by `cargo xtask measure looked-at`.
const LOOKED_AT: usize = 8;

/// Number of passes in which every vertex is evaluated once, if each may re-place `limit`.
pub(super) fn turns(vertices: usize, limit: usize) -> u32 {
    if limit == 0 { 1 } else { (vertices / (limit * LOOKED_AT)).max(1) as u32 }
}

/// A vertex that may be removed.
#[derive(Clone, Debug, Default)]
pub(super) struct Candidate {
    pub(super) vertex: u32,
    /// Its cost; `None` if it was known before.
    cost: Option<Cost>,
    /// The plan, if it was found just now.
    pub(super) plan: Option<Plan>,
}

impl RemovalCosts {
    /// The turn of the next pass, which evaluates one of `slices` parts of the mesh.
    pub(super) fn turn(&mut self, slices: u32) -> Turn {
        let turn = Turn::new(slices, self.passes);
        self.passes = self.passes.wrapping_add(1);
        turn
    }

    /// Whether the next pass looks at the border, too.
    pub(super) fn is_border_due(&self) -> bool {
        border::is_due(self.passes)
    }

    /// Restarts with the first turn, for a new mesh.
    pub(super) fn restart(&mut self) {
        self.passes = 0;
    }

    /// Forgets all costs, but not the turn: turns continue over the frames of a video.
    pub(super) fn reset(&mut self, vertices: usize) {
        self.cost.clear();
        self.cost.resize(vertices, Cost::INFINITE);
        self.asked.clear();
        self.asked.resize(vertices, 0);
    }

    /// Updates the removal costs of the `limit` vertices of this turn with the lowest bounds. In streams, where every
    /// pass covers all vertices, only a quarter of them are candidates: that is a large enough choice, and has
    /// slightly less error than the same candidates in every pass.
    pub(super) fn update(
        &mut self,
        surface: &Surface,
        activity: &Activity,
        turn: Turn,
        limit: usize,
        pass: Pass,
    ) {
        let mut candidates = std::mem::take(&mut self.candidates);
        let is_asked = |v: u32| {
            turn.has(v)
                && (!pass.is_stream() || turn.has_in_quarter(v))
                && activity.is_active(v)
                && surface.freedom(v) == Place::Interior
        };
        self.update_bounds(surface, is_asked, pass);
        let bounds = self.bounds.iter().zip(&surface.order);
        let mut least: Vec<(f32, u32)> = bounds
            .filter(|(bounds, _)| bounds.is_finite())
            .map(|(&bounds, &v)| (bounds, v))
            .collect();
        let order = |a: &(f32, u32), b: &(f32, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        if least.len() > limit {
            least.select_nth_unstable_by(limit, order);
            least.truncate(limit);
        }
        let planned: Vec<u32> = least.iter().map(|&(_, v)| v).collect();
        candidates.clear();
        candidates.resize_with(planned.len(), Candidate::default);
        let packs = planned.par_chunks(CHUNK).zip(candidates.par_chunks_mut(CHUNK));
        packs.for_each_init(
            <(Ring, Closing)>::default,
            |(ring, closing), (vertices, candidates)| {
                let asked = vertices.iter().zip(candidates);
                around_each(
                    surface,
                    asked,
                    |(v, _)| **v,
                    |(&v, candidate), leaving| {
                        ring.surround(surface, v, leaving);
                        *candidate = self.candidate(surface, v, ring, closing, pass);
                    },
                );
            },
        );
        for Candidate { vertex, cost, .. } in &candidates {
            if let Some(cost) = cost {
                self.cost[*vertex as usize] = *cost;
                self.asked[*vertex as usize] = surface.clock;
            }
        }
        candidates.retain(|c| self.cost[c.vertex as usize].shape.is_finite());
        self.candidates = candidates;
    }

    /// Updates the upper bounds of the rise in squared error without each of the requested vertices; infinite for all
    /// others.
    fn update_bounds(
        &mut self,
        surface: &Surface,
        is_asked: impl Fn(u32) -> bool + Sync,
        pass: Pass,
    ) {
        let planes = planes::of(&pass);
        self.bounds.resize(surface.order.len(), 0.0);
        let packs = surface.order.par_chunks(CHUNK).zip(self.bounds.par_chunks_mut(CHUNK));
        packs.for_each(|(vertices, bounds)| {
            bounds.fill(f32::INFINITY);
            let asked = vertices.iter().zip(bounds).filter(|(v, _)| is_asked(**v));
            around_each(
                surface,
                asked,
                |(v, _)| **v,
                |(v, bounds), leaving| {
                    *bounds = match planes {
                        Some(planes) => planes::cost_bound(surface, planes, leaving),
                        None => cost_bound(surface, leaving),
                    };
                    if pass.focus.is_some() {
                        *bounds *= pass.focus_at(surface.at[*v as usize]) as f32;
                    }
                },
            );
        });
    }

    /// Plans the removal of `v`, which is surrounded by `ring`, unless its cost is known.
    fn candidate(
        &self,
        surface: &Surface,
        v: u32,
        ring: &mut Ring,
        closing: &mut Closing,
        pass: Pass,
    ) -> Candidate {
        let newest = ring.links.iter().map(|&h| surface.stamp[h as usize / 3]).max();
        if newest < Some(self.asked[v as usize]) {
            return Candidate { vertex: v, cost: None, plan: None };
        }
        ring.sum_up(surface);
        let plan = closing.plan(ring, pass.rows, pass.weight);
        let cost = |plan: &Plan| plan.cost + ring.cost(surface).scaled(-1.0);
        let cost = plan.as_ref().map_or(Cost::INFINITE, cost);
        Candidate { vertex: v, cost: Some(cost), plan }
    }

    /// The removal cost of each candidate (of error, or of error with shape, whichever is larger) with its index, the
    /// cheapest first.
    pub(super) fn costs(&self, surface: &Surface, pass: Pass) -> Vec<(f64, usize)> {
        let cost_of = |c: &Candidate| {
            let cost = self.cost[c.vertex as usize];
            let cost = cost.total(pass.weight).max(cost.error);
            cost * pass.focus_at(surface.at[c.vertex as usize])
        };
        let mut costs: Vec<_> = self.candidates.iter().map(cost_of).zip(0..).collect();
        let vertex = |place: usize| self.candidates[place].vertex;
        costs.sort_unstable_by(|a, b| {
            a.0.total_cmp(&b.0).then_with(|| vertex(a.1).cmp(&vertex(b.1)))
        });
        costs
    }
}

/// An upper bound of the rise in squared error when the vertex with the half-edges `leaving` is removed: the rise if
/// all of its triangles had one colour.
fn cost_bound(surface: &Surface, leaving: Fan) -> f32 {
    let (mut explained, mut count, mut sum) = (0.0, 0.0, [0.0; 4]);
    leaving.for_each(|h| {
        let mean = &surface.mean[h as usize / 3];
        count += mean.count;
        for (sum, channel) in sum.iter_mut().zip(mean.colour) {
            explained += mean.count * channel * channel;
            *sum += mean.count * channel;
        }
    });
    let together: f32 = sum.iter().map(|s| s * s).sum();
    if count > 0.0 { explained - together / count } else { 0.0 }
}
