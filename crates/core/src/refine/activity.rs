//! Tracks which vertices of a video's mesh are active. Where the picture does not change, the mesh does not either.

use super::pass::Pass;
use super::share::Share;
use super::surface::{Surface, permute};

/// Frames for which a vertex stays active after the last change of the picture around it. Where vertices take turns,
/// only frames with its turn count. A still picture is then constant from its tenth frame on, also with one step a
/// frame, although changes activate their surroundings one after the other. Measured: with 3, and half of
/// [`ACTIVATION_THRESHOLD`], it changes for up to eleven frames, and no video has less error.
/// Measured by `cargo xtask measure active-frames`.
const ACTIVE_FRAMES: u8 = 2;

/// The most turns for which a vertex is skipped after visits without gain.
const MAX_COOLDOWN: u8 = 2;

/// The change of a painted triangle that activates its corners, as a share of the minimum gain. Noise of two 8-bit
/// steps in every pixel stays far below it, since a triangle's mean averages it out. Measured: with half of it no
/// video has less error or flicker, and stills take a frame or two more to become constant.
/// Measured by `cargo xtask measure activation`.
const ACTIVATION_THRESHOLD: f64 = 1.0;

/// Set in a vertex's count of frames where not all of its triangles are covered by this frame.
const OUTSIDE: u8 = 0x80;

/// The activity of each vertex, from frame to frame.
#[derive(Debug, Default)]
pub(super) struct Activity {
    /// For each vertex, the frames with its turn since the picture last changed around it.
    frames_since_change: Vec<u8>,
    /// For each vertex, such frames for which it is skipped, because the last visit promised nothing.
    cooldown: Vec<u8>,
    /// How many such visits there were in a row, up to [`MAX_COOLDOWN`].
    idle_streak: Vec<u8>,
    /// Whether this is a video's second frame or a later one: before, no vertex is skipped.
    is_stream: bool,
    /// The colours in which the triangles were painted when they last were activated or changed.
    colours: Vec<[f32; 4]>,
    /// Scratch for the same in another order.
    spare: Vec<[f32; 4]>,
    /// Which triangles this frame covers; empty for all.
    covered: Vec<bool>,
}

impl Activity {
    /// Forgets everything: all vertices are active.
    pub(super) fn reset(&mut self, surface: &Surface) {
        self.frames_since_change.clear();
        self.frames_since_change.resize(surface.at.len(), 0);
        self.colours.clear();
        self.colours.resize(surface.triangles(), [0.0; 4]);
        self.cooldown.clear();
        self.cooldown.resize(surface.at.len(), 0);
        self.idle_streak.clone_from(&self.cooldown);
        self.is_stream = false;
    }

    /// The triangles have new numbers; `old` has those that they had.
    pub(super) fn renumber(&mut self, old: &[u32]) {
        permute::<1, _>(&mut self.colours, old, &mut self.spare);
    }

    /// The colour that triangle `t` had when it last was activated or changed.
    #[cfg(test)]
    pub(super) fn colour_of(&self, t: u32) -> [f32; 4] {
        self.colours[t as usize]
    }

    /// Deactivates all vertices, with the colours that their triangles have.
    pub(super) fn deactivate_all(&mut self, surface: &Surface) {
        self.frames_since_change.fill(ACTIVE_FRAMES + 1);
        self.commit(surface, 0);
    }

    /// Whether vertex `v` is to be visited, rather than skipped for a while.
    pub(super) fn is_due(&self, v: u32) -> bool {
        self.cooldown[v as usize] == 0
    }

    /// Records a visit to vertex `v`. After an `idle` one, of which hardly anything came, the vertex is skipped
    /// for a frame, after the next such visit for two: most vertices of a video have nothing to gain most of the
    /// time.
    pub(super) fn record_visit(&mut self, v: u32, idle: bool) {
        if !self.is_stream {
            return;
        }
        let streak = &mut self.idle_streak[v as usize];
        *streak = if idle { (*streak + 1).min(MAX_COOLDOWN) } else { 0 };
        // The next frame begins with counting one off.
        self.cooldown[v as usize] = if idle { *streak + 1 } else { 0 };
    }

    /// Whether vertex `v` may change.
    pub(super) fn is_active(&self, v: u32) -> bool {
        self.frames_since_change[v as usize] <= ACTIVE_FRAMES
    }

    /// Whether triangle `t` may change: it is covered and has an active corner.
    pub(super) fn is_active_triangle(&self, surface: &Surface, t: u32) -> bool {
        let is_active =
            |h: u32| self.frames_since_change[surface.from(h) as usize] & !OUTSIDE <= ACTIVE_FRAMES;
        self.covers(t) && (3 * t..3 * t + 3).any(is_active)
    }

    /// Whether this frame covers triangle `t`.
    pub(super) fn covers(&self, t: u32) -> bool {
        self.covered.is_empty() || self.covered[t as usize]
    }

    /// Begins a frame: activates the corners of the triangles whose mean colour has changed by more than
    /// noise since they were last active; slow changes add up. Counts the frame for the vertices of `share`,
    /// whose turn it is.
    pub(super) fn activate_changed(&mut self, surface: &mut Surface, share: Share, pass: Pass) {
        self.is_stream = true;
        for v in share.of(&surface.order) {
            let v = v as usize;
            self.cooldown[v] = self.cooldown[v].saturating_sub(1);
            self.frames_since_change[v] = (self.frames_since_change[v] + 1).min(ACTIVE_FRAMES + 1);
        }
        for t in 0..surface.triangles() as u32 {
            self.activate_around(surface, t, pass);
        }
    }

    /// Begins a frame that covers only some triangles, until [`Activity::cover_all`]: activates as
    /// [`Activity::activate_changed`] does. A place that has changed is active for this frame only.
    pub(super) fn activate_changed_in(
        &mut self,
        surface: &mut Surface,
        covered: Vec<bool>,
        pass: Pass,
    ) {
        for (t, _) in (0..).zip(&covered).filter(|(_, covered)| !**covered) {
            (3 * t..3 * t + 3)
                .for_each(|h| self.frames_since_change[surface.from(h) as usize] |= OUTSIDE);
        }
        for frames in self.frames_since_change.iter_mut().filter(|frames| **frames & OUTSIDE == 0) {
            *frames = ACTIVE_FRAMES + 1;
        }
        for (t, _) in (0..).zip(&covered).filter(|(_, covered)| **covered) {
            self.activate_around(surface, t, pass);
        }
        self.covered = covered;
    }

    /// Covers all triangles again.
    pub(super) fn cover_all(&mut self) {
        self.covered.clear();
        self.frames_since_change.iter_mut().for_each(|frames| *frames &= !OUTSIDE);
    }

    /// Activates the corners of triangle `t` if its colour has changed by more than noise.
    #[inline]
    fn activate_around(&mut self, surface: &mut Surface, t: u32, pass: Pass) {
        let mean = &surface.mean[t as usize];
        let old = &mut self.colours[t as usize];
        if mean.change_from(old) > ACTIVATION_THRESHOLD * pass.min_gain {
            *old = mean.colour;
            for h in 3 * t..3 * t + 3 {
                let v = surface.from(h) as usize;
                self.frames_since_change[v] &= OUTSIDE;
                surface.active[v] = true;
            }
        }
    }

    /// Ends a frame: takes the colours of the triangles that changed at tick `since` or later.
    pub(super) fn commit(&mut self, surface: &Surface, since: u32) {
        for (t, colour) in self.colours.iter_mut().enumerate() {
            if surface.stamp[t] >= since {
                *colour = surface.mean[t].colour;
            }
        }
    }
}
