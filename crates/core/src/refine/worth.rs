//! What it costs to take vertices out of the mesh.

use crate::parallel::prelude::*;

use super::cost::Cost;
use super::pass::Pass;
use super::patch::{Closing, Plan};
use super::rest::Rest;
use super::ring::Ring;
use super::share::Turn;
use super::surface::{Fan, Surface, around_each};
use crate::mesh::Place;

/// Vertices that one piece of work looks at.
const PACK: usize = 64;

/// What it costs to take each vertex out, as far as it is known.
#[derive(Debug, Default)]
pub(super) struct Worth {
    /// Cost of the surroundings without the vertex, less their cost with it; infinite for vertices
    /// that have to stay.
    loss: Vec<Cost>,
    /// When that was found, in ticks of the surface's clock.
    asked: Vec<u32>,
    /// By how much the squared error rises at most without each vertex, in the surface's order; infinite for those
    /// that are not asked for.
    rise: Vec<f32>,
    /// Vertices that may be taken out in this pass.
    pub(super) candidates: Vec<Candidate>,
    /// Memory for the triangles of the largest errors, and for those that a pass has touched.
    pub(super) worst: Vec<(f64, u32)>,
    pub(super) taken: Vec<bool>,
    /// Passes over this mesh so far.
    passes: u32,
}

/// A pass that may re-place few vertices looks at this many for each of them, in turns. Measured: 8
/// gain more in the same time than 32 or all; but see [`Mode::Stream`](super::options::Mode::Stream).
const LOOKED_AT: usize = 8;

/// Passes until every vertex has had its turn, when each may re-place `most`.
pub(super) fn turns(vertices: usize, most: usize) -> u32 {
    if most == 0 { 1 } else { (vertices / (most * LOOKED_AT)).max(1) as u32 }
}

/// A vertex that may be taken out.
#[derive(Clone, Debug, Default)]
pub(super) struct Candidate {
    pub(super) vertex: u32,
    /// What that costs; `None` where it is known already.
    loss: Option<Cost>,
    /// How, where it was found just now.
    pub(super) plan: Option<Plan>,
}

impl Worth {
    /// The turn of the next pass, which looks at one of `slices` parts of the mesh.
    pub(super) fn turn(&mut self, slices: u32) -> Turn {
        let turn = Turn::new(slices, self.passes);
        self.passes = self.passes.wrapping_add(1);
        turn
    }

    /// Begins again with the first turn, for a mesh of which nothing is known.
    pub(super) fn start_anew(&mut self) {
        self.passes = 0;
    }

    /// Forgets everything but whose turn it is: a video's mesh has it over several frames.
    pub(super) fn reset(&mut self, vertices: usize) {
        self.loss.clear();
        self.loss.resize(vertices, Cost::INFINITE);
        self.asked.clear();
        self.asked.resize(vertices, 0);
    }

    /// Brings up to date what it is the turn of: the losses of the `most` of its vertices that look the
    /// least needed; on a running video, where all are looked at in every pass, of a quarter of them. That is
    /// enough to choose from, and even has a little less error than to take the same ones again and again.
    pub(super) fn update(
        &mut self,
        surface: &Surface,
        rest: &Rest,
        turn: Turn,
        most: usize,
        pass: Pass,
    ) {
        let mut candidates = std::mem::take(&mut self.candidates);
        let is_asked = |v: u32| {
            turn.has(v)
                && (!pass.is_stream() || turn.has_in_quarter(v))
                && rest.allows(v)
                && surface.freedom(v) == Place::Interior
        };
        self.rise_most(surface, is_asked);
        let rises = self.rise.iter().zip(&surface.order);
        let mut least: Vec<(f32, u32)> =
            rises.filter(|(rise, _)| rise.is_finite()).map(|(&rise, &v)| (rise, v)).collect();
        let order = |a: &(f32, u32), b: &(f32, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        if least.len() > most {
            least.select_nth_unstable_by(most, order);
            least.truncate(most);
        }
        let planned: Vec<u32> = least.iter().map(|&(_, v)| v).collect();
        candidates.clear();
        candidates.resize_with(planned.len(), Candidate::default);
        let packs = planned.par_chunks(PACK).zip(candidates.par_chunks_mut(PACK));
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
        for Candidate { vertex, loss, .. } in &candidates {
            if let Some(loss) = loss {
                self.loss[*vertex as usize] = *loss;
                self.asked[*vertex as usize] = surface.clock;
            }
        }
        candidates.retain(|c| self.loss[c.vertex as usize].shape.is_finite());
        self.candidates = candidates;
    }

    /// Brings up to date by how much the squared error rises at most if the vertices that are asked for are taken
    /// out; infinite for all others.
    fn rise_most(&mut self, surface: &Surface, is_asked: impl Fn(u32) -> bool + Sync) {
        self.rise.resize(surface.order.len(), 0.0);
        let packs = surface.order.par_chunks(PACK).zip(self.rise.par_chunks_mut(PACK));
        packs.for_each(|(vertices, rise)| {
            rise.fill(f32::INFINITY);
            let asked = vertices.iter().zip(rise).filter(|(v, _)| is_asked(**v));
            around_each(
                surface,
                asked,
                |(v, _)| **v,
                |(_, rise), leaving| {
                    *rise = most_loss(surface, leaving);
                },
            );
        });
    }

    /// Looks how to take out `v`, which `ring` surrounds, if that is not known already.
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
            return Candidate { vertex: v, loss: None, plan: None };
        }
        ring.sum_up(surface);
        let plan = closing.plan(ring, pass.rows, pass.weight);
        let loss = |plan: &Plan| plan.cost + ring.cost(surface).scaled(-1.0);
        let loss = plan.as_ref().map_or(Cost::INFINITE, loss);
        Candidate { vertex: v, loss: Some(loss), plan }
    }

    /// What it costs to take out each candidate, error or error with shape, whichever is worse, with its
    /// place among them, the cheapest first.
    pub(super) fn prices(&self, weight: f64) -> Vec<(f64, usize)> {
        let price = |c: &Candidate| {
            let loss = self.loss[c.vertex as usize];
            loss.total(weight).max(loss.error)
        };
        let mut prices: Vec<_> = self.candidates.iter().map(price).zip(0..).collect();
        let vertex = |place: usize| self.candidates[place].vertex;
        prices.sort_unstable_by(|a, b| {
            a.0.total_cmp(&b.0).then_with(|| vertex(a.1).cmp(&vertex(b.1)))
        });
        prices
    }
}

/// The most by which the squared error can rise when a vertex that half-edges are `leaving` is taken out: as much
/// as it does when all of its triangles take one colour.
fn most_loss(surface: &Surface, leaving: Fan) -> f32 {
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
