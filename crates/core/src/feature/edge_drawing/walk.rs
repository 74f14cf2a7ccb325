//! Joins anchors: walks along edges.

use super::chains::Branches;
use super::{Course, EdgeDrawing, Slope};
use crate::feature::mask::Mask;
use crate::plane::Plane;

/// What is known of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Plain,
    Anchor,
    Edge,
}

/// Where a walk goes on: from a pixel along its course, towards rising coordinates or falling ones.
#[derive(Clone, Copy, Debug)]
struct Head {
    at: (u32, u32),
    course: Course,
    rises: bool,
    parent: usize,
}

/// Walks along the edges of a picture, and keeps what it has walked on.
pub(super) struct Walker<'a> {
    detector: &'a EdgeDrawing,
    slopes: &'a Plane<Slope>,
    states: Plane<State>,
    branches: Branches,
    heads: Vec<Head>,
    /// Pixels of the walk from one anchor.
    trail: Vec<(u32, u32)>,
}

impl<'a> Walker<'a> {
    pub(super) fn new(
        detector: &'a EdgeDrawing,
        slopes: &'a Plane<Slope>,
        anchors: &[(u32, u32)],
    ) -> Self {
        let mut states = Plane::filled(slopes.size(), State::Plain);
        for &(x, y) in anchors {
            states.set(x, y, State::Anchor);
        }
        Self {
            detector,
            slopes,
            states,
            branches: Branches::default(),
            heads: Vec::new(),
            trail: Vec::new(),
        }
    }

    /// All pixels of edges.
    pub(super) fn edges(&self) -> Mask {
        let mut edges = Mask::new(self.slopes.size());
        let width = self.slopes.size().width;
        for (i, _) in (0u32..).zip(self.states.values()).filter(|(_, s)| **s == State::Edge) {
            edges.insert(i % width, i / width);
        }
        edges
    }

    /// The chains of the edge through the anchor `at`; none if it is too short, or an earlier walk has passed there.
    pub(super) fn from(&mut self, at: (u32, u32)) -> Vec<Vec<(u32, u32)>> {
        if self.state(at) != State::Anchor {
            return Vec::new();
        }
        self.trail.clear();
        self.branches.restart();
        self.turn(at, 0);
        let mut shared = 0;
        while let Some(head) = self.heads.pop() {
            // The first head of a pixel has it in common with the second.
            shared += usize::from(self.state(head.at) != State::Edge);
            self.walk(head);
        }
        if self.trail.len() - shared < self.detector.shortest {
            for &(x, y) in &self.trail {
                self.states.set(x, y, State::Plain);
            }
            return Vec::new();
        }
        self.branches.chains(self.detector.shortest)
    }

    /// Goes both ways from `at`.
    fn turn(&mut self, at: (u32, u32), parent: usize) {
        let (_, course) = self.slopes.at(at.0, at.1);
        self.heads.push(Head { at, course, rises: true, parent });
        self.heads.push(Head { at, course, rises: false, parent });
    }

    /// Follows the edge until it ends, meets another one, or turns.
    fn walk(&mut self, Head { at, course, rises, parent }: Head) {
        let branch = self.branches.begin(parent, rises);
        let mut at = at;
        self.trail.push(at);
        self.branches.extend(branch, at);
        while self.slopes.at(at.0, at.1).1 == course {
            self.pass(at, course);
            at = self.ahead(at, course, rises);
            let (gradient, _) = self.slopes.at(at.0, at.1);
            if self.state(at) == State::Edge || gradient < self.detector.gradient_threshold {
                return;
            }
            self.trail.push(at);
            self.branches.extend(branch, at);
        }
        // The pixel of the turn belongs to the branches that begin there.
        self.trail.pop();
        self.branches.shorten(branch);
        self.turn(at, branch);
    }

    /// Makes `at` an edge pixel; anchors on either side of it are none any more.
    fn pass(&mut self, (x, y): (u32, u32), course: Course) {
        self.set((x, y), State::Edge);
        let sides = match course {
            Course::Across => [(x, y - 1), (x, y + 1)],
            Course::Down => [(x - 1, y), (x + 1, y)],
        };
        for side in sides {
            if self.state(side) == State::Anchor {
                self.set(side, State::Plain);
            }
        }
    }

    /// The next pixel: an anchor or an edge if there is one ahead, else that with the largest gradient.
    fn ahead(&self, (x, y): (u32, u32), course: Course, rises: bool) -> (u32, u32) {
        let onward = |v: u32| if rises { v + 1 } else { v - 1 };
        let neighbour = |shift: i32| match course {
            Course::Across => (onward(x), y.wrapping_add_signed(shift)),
            Course::Down => (x.wrapping_add_signed(shift), onward(y)),
        };
        let first = if rises { 1 } else { -1 };
        let taken = [0, first, -first].map(neighbour);
        if let Some(&next) = taken.iter().find(|&&next| self.state(next) != State::Plain) {
            return next;
        }
        let gradient = |shift: i32| {
            let (x, y) = neighbour(shift);
            self.slopes.at(x, y).0
        };
        let (before, straight, after) = (gradient(-1), gradient(0), gradient(1));
        if before > straight && before > after {
            neighbour(-1)
        } else if before > straight || after > straight {
            neighbour(1)
        } else {
            neighbour(0)
        }
    }

    fn state(&self, (x, y): (u32, u32)) -> State {
        self.states.at(x, y)
    }

    fn set(&mut self, (x, y): (u32, u32), state: State) {
        self.states.set(x, y, state);
    }
}
