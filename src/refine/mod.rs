//! Level three: vertices descend the squared error between picture and mesh.

mod colouring;
mod descend;
mod flip;
mod force;
mod patch;
mod replace;
mod ring;
mod shape;
mod sums;
mod surface;

use crate::frame::Frame;
use crate::mesh::Mesh;
use colouring::Colouring;
use descend::{FIRST_REACH, Field, Visits, WAKING_REACH, descend};
use flip::flip;
use replace::{Worth, replace};
use sums::RowSums;
use surface::Surface;

/// How to refine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefineOptions {
    /// Steps at most.
    pub steps: u32,
    /// 0..1
    pub regularity: f64,
    /// share
    pub replace: f64,
    /// tick
    pub least_gain: f64,
}

/// What a refinement did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Refined {
    /// Steps done.
    pub steps: u32,
    /// Squared error before.
    pub error_before: f64,
    /// And after.
    pub error_after: f64,
    /// Moves of vertices.
    pub moved: usize,
    /// Turned edges.
    pub flipped: usize,
    /// Re-placed
    pub replaced: usize,
}

/// Vertices that take their turns together, so that what surrounds them stays in the cache.
const BLOCK: usize = 768;

/// Refines.
#[derive(Debug, Default)]
pub struct Refiner {
    rows: RowSums,
    surface: Surface,
    colouring: Colouring,
    reach: Vec<i32>,
    visits: Vec<Visits>,
    edges: Vec<Vec<u32>>,
    worth: Worth,
}

impl Refiner {
    /// Refines.
    pub fn refine(&mut self, mesh: &mut Mesh, frame: &Frame, options: &RefineOptions) -> Refined {
        let tm = std::time::Instant::now();
        let lap = |w: &str| {
            if std::env::var_os("LAP").is_some() {
                eprintln!("{w} {:.2}", tm.elapsed().as_secs_f64() * 1e3)
            }
        };
        self.rows.load(frame);
        lap("load");
        self.surface.link(mesh);
        lap("link");
        self.surface.measure(&self.rows);
        lap("measure");
        self.reach.clear();
        self.reach.resize(mesh.vertices.len(), FIRST_REACH);
        let before = self.surface.error(&self.rows);
        let mean = before / self.surface.triangles() as f64;
        let field = Field {
            rows: &self.rows,
            weight: options.regularity * mean,
            least_gain: mean * options.least_gain,
        };
        let mut refined = Refined { error_before: before, ..Refined::default() };
        self.worth.reset(mesh.vertices.len(), mesh.triangles.len());
        let mut start = self.surface.clock;
        for _ in 0..options.steps {
            let most = (options.replace * mesh.vertices.len() as f64).ceil() as usize;
            lap("-");
            let replaced = if options.replace > 0. {
                replace(&mut self.surface, &mut self.worth, most, field)
            } else {
                vec![]
            };
            for &v in &replaced {
                self.reach[v as usize] = FIRST_REACH;
            }
            lap("replace");
            refined.replaced += replaced.len();
            self.surface.clock += 1;
            let mut moved = 0;
            for block in 0..self.surface.order.len().div_ceil(BLOCK) {
                let s = &self.surface;
                let end = ((block + 1) * BLOCK).min(s.order.len());
                self.colouring.colour(s, &s.order[block * BLOCK..end], |v| s.awake[v as usize]);
                for class in &self.colouring.classes {
                    for &v in class {
                        let reach = &mut self.reach[v as usize];
                        if *reach == 0 {
                            *reach = WAKING_REACH;
                        }
                    }
                    moved +=
                        descend(&mut self.surface, &mut self.reach, class, field, &mut self.visits);
                }
            }
            lap("moves");
            self.surface.clock += 1;
            let flipped = flip(&mut self.surface, start, field, &mut self.edges);
            start = self.surface.clock;
            lap("flip");
            refined.steps += 1;
            refined.moved += moved;
            refined.flipped += flipped;
            if moved + flipped + replaced.len() == 0 && !self.surface.awake.contains(&true) {
                break;
            }
        }
        refined.error_after = self.surface.error(&self.rows);
        lap("end");
        self.surface.store(mesh);
        lap("store");
        refined
    }
}
