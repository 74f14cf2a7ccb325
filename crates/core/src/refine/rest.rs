//! Which parts of a video's mesh rest: where the picture stands still, so does the mesh.

use super::pass::Pass;
use super::share::Share;
use super::surface::{Surface, permute};

/// Frames with a turn of its own during which a vertex may still change after the picture around it has
/// come to rest. A still picture is then the same for good before its tenth frame, with one step a frame too: changes
/// wake their surroundings in turn. Measured: with three, and half of [`WAKING`], it changes for up to eleven, and no
/// video has less error.
const CALM: u8 = 2;

/// The most turns that a vertex is left alone for.
const LONGEST_NAP: u8 = 2;

/// What has to change in the painted triangle to wake its corners, as a share of the least gain.
/// Noise of two 8-bit steps in every pixel stays far below: the mean of a triangle evens it out. Measured: with a half
/// of it no video has less error or flicker, and stills take a frame or two more to come to rest.
const WAKING: f64 = 1.0;

/// Set in a vertex's count of calm frames where not all of its triangles are looked at in this frame.
const OUTSIDE: u8 = 0x80;

/// What is remembered from frame to frame of where the picture moves.
#[derive(Debug, Default)]
pub(super) struct Rest {
    /// Frames in which it had its turn since the picture last changed around each vertex.
    calm: Vec<u8>,
    /// Such frames for which each vertex takes a rest, because the last look at it promised nothing.
    nap: Vec<u8>,
    /// How many such looks there were in a row, up to [`LONGEST_NAP`].
    tired: Vec<u8>,
    /// Whether this is a video's second frame or a later one: before, nobody takes a rest.
    live: bool,
    /// The colours in which the triangles were painted when they last woke or were changed.
    colours: Vec<[f32; 4]>,
    /// Memory for the same in another order.
    spare: Vec<[f32; 4]>,
    /// Which triangles are looked at in this frame; empty for all.
    here: Vec<bool>,
}

impl Rest {
    /// Forgets everything: all vertices may change.
    pub(super) fn reset(&mut self, surface: &Surface) {
        self.calm.clear();
        self.calm.resize(surface.at.len(), 0);
        self.colours.clear();
        self.colours.resize(surface.triangles(), [0.0; 4]);
        self.nap.clear();
        self.nap.resize(surface.at.len(), 0);
        self.tired.clone_from(&self.nap);
        self.live = false;
    }

    /// The triangles have new numbers; `old` has those that they had.
    pub(super) fn renumber(&mut self, old: &[u32]) {
        permute::<1, _>(&mut self.colours, old, &mut self.spare);
    }

    /// The colour that triangle `t` had when it last woke or was changed.
    #[cfg(test)]
    pub(super) fn colour_of(&self, t: u32) -> [f32; 4] {
        self.colours[t as usize]
    }

    /// All vertices come to rest, with the colours that their triangles have.
    pub(super) fn lie_down(&mut self, surface: &Surface) {
        self.calm.fill(CALM + 1);
        self.settle(surface, 0);
    }

    /// Whether it is worth to look at what a step of vertex `v` gains.
    pub(super) fn is_rested(&self, v: u32) -> bool {
        self.nap[v as usize] == 0
    }

    /// Takes up that vertex `v` was looked at. If hardly anything came of it, it is left alone for a
    /// frame, after the next such look for two: most vertices of a video have nothing to gain most of
    /// the time.
    pub(super) fn looked_at(&mut self, v: u32, idle: bool) {
        if !self.live {
            return;
        }
        let tired = &mut self.tired[v as usize];
        *tired = if idle { (*tired + 1).min(LONGEST_NAP) } else { 0 };
        // The next frame begins with counting one off.
        self.nap[v as usize] = if idle { *tired + 1 } else { 0 };
    }

    /// Whether vertex `v` may change.
    pub(super) fn allows(&self, v: u32) -> bool {
        self.calm[v as usize] <= CALM
    }

    /// Whether triangle `t` may change: one of its corners may.
    pub(super) fn allows_triangle(&self, surface: &Surface, t: u32) -> bool {
        let is_awake = |h: u32| self.calm[surface.from(h) as usize] & !OUTSIDE <= CALM;
        self.looks_at(t) && (3 * t..3 * t + 3).any(is_awake)
    }

    /// Whether triangle `t` is looked at in this frame.
    pub(super) fn looks_at(&self, t: u32) -> bool {
        self.here.is_empty() || self.here[t as usize]
    }

    /// A new frame: wakes the corners of the triangles whose mean colour has changed by more than
    /// noise since they were last awake; slow changes add up. Time passes for the vertices of `share`,
    /// whose turn it is.
    pub(super) fn wake(&mut self, surface: &mut Surface, share: Share, pass: Pass) {
        self.live = true;
        for v in share.of(&surface.order) {
            let (nap, calm) = (&mut self.nap[v as usize], &mut self.calm[v as usize]);
            *nap = nap.saturating_sub(1);
            *calm = (*calm + 1).min(CALM + 1);
        }
        for t in 0..surface.triangles() as u32 {
            self.wake_around(surface, t, pass);
        }
    }

    /// A new frame in which only the triangles `here` are looked at, until [`Rest::open`]: wakes as
    /// [`Rest::wake`] does. A turn is all that a place gets when it has changed.
    pub(super) fn wake_some(&mut self, surface: &mut Surface, here: Vec<bool>, pass: Pass) {
        for (t, _) in (0..).zip(&here).filter(|(_, here)| !**here) {
            (3 * t..3 * t + 3).for_each(|h| self.calm[surface.from(h) as usize] |= OUTSIDE);
        }
        for calm in self.calm.iter_mut().filter(|calm| **calm & OUTSIDE == 0) {
            *calm = CALM + 1;
        }
        for (t, _) in (0..).zip(&here).filter(|(_, here)| **here) {
            self.wake_around(surface, t, pass);
        }
        self.here = here;
    }

    /// All triangles are looked at again.
    pub(super) fn open(&mut self) {
        self.here.clear();
        self.calm.iter_mut().for_each(|calm| *calm &= !OUTSIDE);
    }

    /// Wakes the corners of triangle `t` if its colour has changed by more than noise.
    #[inline]
    fn wake_around(&mut self, surface: &mut Surface, t: u32, pass: Pass) {
        let mean = &surface.mean[t as usize];
        let old = &mut self.colours[t as usize];
        if mean.change_from(old) > WAKING * pass.min_gain {
            *old = mean.colour;
            for h in 3 * t..3 * t + 3 {
                let v = surface.from(h) as usize;
                self.calm[v] &= OUTSIDE;
                surface.awake[v] = true;
            }
        }
    }

    /// The end of a frame: takes the colours of the triangles that changed at tick `since` or later.
    pub(super) fn settle(&mut self, surface: &Surface, since: u32) {
        for (t, colour) in self.colours.iter_mut().enumerate() {
            if surface.stamp[t] >= since {
                *colour = surface.mean[t].colour;
            }
        }
    }
}
