//! One step: vertices are re-placed, vertices move, and edges flip.

use super::activity::Activity;
use super::border::replace_on_border;
use super::descend::Descent;
use super::errors::Errors;
use super::flip::{Diagonal, flip};
use super::pass::Pass;
use super::removal::RemovalCosts;
use super::replace::replace;
use super::share::{Share, Turn};
use super::surface::Surface;

/// Error above which maintenance counts a triangle as bad, in minimum gains: that of a triangle of a plain grid.
const WRONG: f64 = 50.0;

/// The three kinds of change, with their scratch and what is known of each vertex.
#[derive(Debug, Default)]
pub(super) struct Stepper {
    descent: Descent,
    removals: RemovalCosts,
    errors: Errors,
    /// The active parts of the mesh.
    pub(super) activity: Activity,
    diagonals: Vec<Vec<Diagonal>>,
    /// The tick of the surface's clock at which the last step ended, or the frame began.
    since: u32,
}

/// The changes of a step.
#[derive(Debug)]
pub(super) struct Changes {
    /// Moves of vertices.
    pub(super) moved: usize,
    /// Flips of edges.
    pub(super) flipped: usize,
    /// The vertices that were re-placed.
    pub(super) replaced: Vec<u32>,
}

impl Changes {
    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.moved + self.flipped + self.replaced.len() == 0
    }
}

impl Stepper {
    /// Forgets all vertices, for a new mesh with this number of `vertices`.
    pub(super) fn forget(&mut self, vertices: usize) {
        self.descent.reset(vertices);
        self.removals.restart();
    }

    /// Begins a frame. `carried` says that triangles and half-edges are those of the last frame; then the vertices of
    /// `share` age by a frame.
    pub(super) fn begin(&mut self, surface: &mut Surface, carried: bool, share: Share, pass: Pass) {
        if carried {
            self.activity.activate_changed(surface, share, pass);
        } else {
            self.activity.reset(surface);
        }
        self.start(surface, pass);
    }

    fn start(&mut self, surface: &Surface, pass: Pass) {
        self.removals.reset(surface.at.len());
        self.errors.begin(surface, pass);
        self.since = surface.clock;
    }

    /// As [`Stepper::begin`], for a frame that covers only the triangles `here`.
    pub(super) fn begin_in(
        &mut self,
        surface: &mut Surface,
        carried: bool,
        here: Vec<bool>,
        pass: Pass,
    ) {
        if !carried {
            self.activity.reset(surface);
        }
        self.activity.activate_changed_in(surface, here, pass);
        self.start(surface, pass);
    }

    /// Re-places up to `limit` vertices, at most one for each bad triangle, and flips edges; no vertex moves.
    pub(super) fn maintain(&mut self, surface: &mut Surface, limit: usize, pass: Pass) -> Changes {
        let Self { descent, removals, errors, activity, diagonals, since } = self;
        surface.clock += 1;
        errors.update(surface, activity, Turn::ALL, pass);
        let is_wrong = |&t: &u32| {
            activity.is_active_triangle(surface, t) && errors.of(t) > WRONG * pass.min_gain
        };
        let wrong = (0..surface.triangles() as u32).filter(is_wrong).count();
        let limit = limit.min(wrong);
        let replaced = replace(surface, removals, errors, activity, limit, Turn::ALL, pass);
        descent.restart(&replaced);
        let flipped = flip(surface, errors, activity, *since, pass, diagonals);
        Changes { moved: 0, flipped, replaced }
    }

    /// Re-places up to `limit` vertices of one of `turns` shares of the mesh, moves the vertices of `share`, and
    /// flips edges.
    pub(super) fn step(
        &mut self,
        surface: &mut Surface,
        share: Share,
        limit: usize,
        turns: u32,
        pass: Pass,
    ) -> Changes {
        let Self { descent, removals, errors, activity, diagonals, since } = self;
        surface.clock += 1;
        let looks_at_border = limit > 0 && !pass.is_stream() && removals.is_border_due();
        let turn = removals.turn(turns);
        let mut replaced = replace(surface, removals, errors, activity, limit, turn, pass);
        if looks_at_border {
            replaced.extend(replace_on_border(surface, errors, activity, turn, pass));
        }
        descent.restart(&replaced);
        let moved = descent.step(surface, share, activity, errors, pass);
        let flipped = flip(surface, errors, activity, *since, pass, diagonals);
        *since = surface.clock;
        Changes { moved, flipped, replaced }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;
    use crate::refine::options::RefineOptions;
    use crate::refine::rows::RowSums;
    use crate::refine::target::Target;
    use crate::refine::tests::{picture, scattered};

    /// After vertices have left, come in and moved, and edges have turned.
    #[test]
    fn guesses_at_errors_add_up_to_the_error_that_there_is() {
        for seed in 0..8 {
            let frame = picture(Size::new(160, 120), seed, 60, true);
            let (mut rows, mut surface) = (RowSums::default(), Surface::default());
            rows.load(&Target::Frame(&frame), true);
            surface.link(&scattered(frame.size(), 300));
            surface.measure(&rows);
            let options = RefineOptions::live();
            let target = Target::Frame(&frame);
            let pass = Pass::new(&rows, &target, surface.triangles(), &options);
            let pass = Pass { has_next: true, ..pass };
            let mut stepper = Stepper::default();
            stepper.forget(surface.at.len());
            stepper.begin(&mut surface, false, Share::ALL, pass);
            for _ in 0..3 {
                let Changes { moved, flipped, replaced } =
                    stepper.step(&mut surface, Share::ALL, 12, 1, pass);
                assert!(moved.min(flipped).min(replaced.len()) > 4, "nothing to tell");
                let (mut reported, mut guessed, mut exact) = (0, 0.0, 0.0);
                for t in 0..surface.triangles() as u32 {
                    let error = stepper.errors.of(t);
                    if error.is_finite() {
                        reported += 1;
                        guessed += error;
                        let squares = rows.squares_of(&target, surface.corners(t));
                        exact += squares + surface.cost[t as usize].error;
                    }
                }
                assert!(
                    reported * 10 >= surface.triangles() * 9,
                    "{reported} of {}",
                    surface.triangles()
                );
                assert!((guessed / exact - 1.0).abs() < 0.15, "{guessed} for {exact}");
            }
        }
    }
}
