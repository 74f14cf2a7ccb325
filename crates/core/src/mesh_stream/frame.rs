//! One frame's mesh and colours in as few bits as the frame before allows.

use super::colours;
use super::connectivity::{self, Before, Grown};
use super::grid::{Grid, rounded};
use super::half_edges::HalfEdges;
use super::places::Places;
use super::positions::{self, Fate, MoveModels, RowModels, by_rows, pass_fates, pass_rows};
use super::range_coder::{Bits, Decoder, Encoder, Model, Number};
use super::{Fault, MOST_VERTICES, NONE};
use crate::frame::Rgba;
use crate::geom::{Point, Size};
use crate::mesh::{CORNERS, Mesh};

/// What both sides have learnt since the last key frame, and the frame before.
#[derive(Debug)]
pub(super) struct State {
    size: Size,
    grid: Grid,
    /// By how much an encoder's colours may be off.
    pub(super) tolerance: u8,
    /// Vertices by their numbers in the stream.
    points: Vec<Point>,
    /// A number for each that stays the same as long as it lives.
    pub(super) ids: Vec<u64>,
    next_id: u64,
    grown: Grown,
    edges: HalfEdges,
    colours: Vec<Rgba>,
    wrong: Vec<u16>,
    models: Models,
}

#[derive(Debug, Default)]
struct Models {
    number: Number,
    /// Whether a vertex of a key frame was there before.
    lives: Model,
    alpha: Model,
    rows: RowModels,
    births: RowModels,
    moves: MoveModels,
    connectivity: connectivity::Models,
    colours: colours::Models,
}

/// A frame in the numbers of the stream, for an encoder.
#[derive(Debug)]
struct Known {
    edges: HalfEdges,
    colours: Vec<Rgba>,
}

/// The mesh of the frame before.
#[derive(Debug)]
struct Old {
    points: Vec<Point>,
    triangles: Vec<[u32; 3]>,
    edges: HalfEdges,
    /// The number that each vertex had there.
    back: Vec<u32>,
}

impl Old {
    fn places<'a>(&'a self, now: &'a [Point]) -> Places<'a> {
        let Self { points, triangles, edges, back } = self;
        Places { points, triangles, edges, back, now }
    }
}

impl State {
    pub(super) fn new(size: Size, grid: Grid) -> Self {
        Self {
            size,
            grid,
            tolerance: 0,
            points: Vec::new(),
            ids: Vec::new(),
            next_id: CORNERS as u64,
            grown: Grown::default(),
            edges: HalfEdges::default(),
            colours: Vec::new(),
            wrong: Vec::new(),
            models: Models::default(),
        }
    }

    /// The mesh of the frame that was passed last, and its colours.
    pub(super) fn mesh(&self) -> (Mesh, Vec<Rgba>) {
        let mut all: Vec<_> = self
            .grown
            .triangles
            .iter()
            .zip(&self.colours)
            .map(|(&t, &colour)| (Mesh::smallest_first(t), colour))
            .collect();
        all.sort_unstable_by_key(|(t, _)| *t);
        let (triangles, colours) = all.into_iter().unzip();
        let (vertices, ids) = (self.points.clone(), self.ids.clone());
        (Mesh { size: self.size, vertices, ids, triangles, fills: Vec::new() }, colours)
    }

    /// Writes a key frame behind `bytes`. `numbers` are those that the vertices of `mesh` had in the frame before,
    /// [`NONE`] for those that are new; they become those that they have now.
    pub(super) fn write_key(
        &mut self,
        bytes: Vec<u8>,
        mesh: &Mesh,
        colours: &[Rgba],
        numbers: &mut [u32],
    ) -> Result<Vec<u8>, Fault> {
        let places = rounded(mesh, self.grid);
        let mut order: Vec<u32> = (CORNERS as u32..mesh.vertices.len() as u32).collect();
        order.sort_unstable_by_key(|&v| by_rows(places[v as usize]));
        let mut points: Vec<_> = order.iter().map(|&v| places[v as usize]).collect();
        let id = |&v: &u32| self.ids.get(numbers[v as usize] as usize).copied();
        let ids: Vec<_> = order.iter().map(id).collect();
        (0..CORNERS).for_each(|v| numbers[v] = v as u32);
        for (&v, number) in order.iter().zip(CORNERS as u32..) {
            numbers[v as usize] = number;
        }
        let known = Known::of(mesh, colours, numbers);
        let mut bits = Encoder::new(bytes);
        self.key(&mut bits, &mut points, &ids, Some(known))?;
        Ok(bits.finish())
    }

    /// Writes a frame behind `bytes` that goes on from the one before. `numbers` are those that the vertices of
    /// `mesh` had there, [`NONE`] for those that are new; they become those that they have now.
    pub(super) fn write_delta(
        &mut self,
        bytes: Vec<u8>,
        mesh: &Mesh,
        colours: &[Rgba],
        numbers: &mut [u32],
    ) -> Result<Vec<u8>, Fault> {
        let places = rounded(mesh, self.grid);
        let mut fates = vec![Fate::Dies; self.points.len()];
        for (&number, &point) in numbers.iter().zip(&places) {
            if number != NONE {
                let still = self.points[number as usize] == point;
                fates[number as usize] = if still { Fate::Stays } else { Fate::Moves(point) };
            }
        }
        let new = |v: &usize| numbers[*v] == NONE;
        let mut born: Vec<usize> = (0..numbers.len()).filter(new).collect();
        born.sort_unstable_by_key(|&v| by_rows(places[v]));
        let mut points: Vec<_> = born.iter().map(|&v| places[v]).collect();
        let (renumbered, births) = positions::renumbered(&fates, born.len());
        for number in numbers.iter_mut().filter(|number| **number != NONE) {
            *number = renumbered[*number as usize];
        }
        for (&v, &number) in born.iter().zip(&births) {
            numbers[v] = number;
        }
        let known = Known::of(mesh, colours, numbers);
        let mut bits = Encoder::new(bytes);
        self.delta(&mut bits, &mut fates, &mut points, Some(known))?;
        Ok(bits.finish())
    }

    /// Reads a key frame.
    pub(super) fn read_key(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        self.key(&mut Decoder::new(bytes), &mut Vec::new(), &[], None)
    }

    /// Reads a frame that goes on from the one before.
    pub(super) fn read_delta(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        let mut fates = vec![Fate::Stays; self.points.len()];
        self.delta(&mut Decoder::new(bytes), &mut fates, &mut Vec::new(), None)
    }

    fn key(
        &mut self,
        bits: &mut impl Bits,
        seeds: &mut Vec<Point>,
        ids: &[Option<u64>],
        known: Option<Known>,
    ) -> Result<(), Fault> {
        self.models = Models::default();
        let count = self.models.number.pass(bits, seeds.len() as u32);
        if count > MOST_VERTICES {
            return Err(Fault::Vertices(count));
        }
        fill(bits, &mut self.models.rows, (self.size, self.grid), seeds, count)?;
        self.pass_ids(bits, ids, count)?;
        self.points = Mesh::corners(self.size).to_vec();
        self.points.append(seeds);
        let (models, area) = (&mut self.models, (self.size, &self.points[..]));
        let edges = known.as_ref().map(|known| &known.edges);
        let grown = connectivity::pass(bits, &mut models.connectivity, area, None, edges)?;
        self.colours.clear();
        self.paint(bits, grown, &[], None, known)
    }

    /// Passes the lasting numbers of `count` seeds; an encoder has in `ids` those that were there before. New ones get
    /// the next that none had.
    fn pass_ids(
        &mut self,
        bits: &mut impl Bits,
        ids: &[Option<u64>],
        count: u32,
    ) -> Result<(), Fault> {
        let halves = [self.next_id >> 32, self.next_id].map(|half| bits.plain(half as u32, 32));
        let first = u64::from(halves[0]) << 32 | u64::from(halves[1]);
        if !(CORNERS as u64..1 << 48).contains(&first) {
            return Err(Fault::Ids);
        }
        let digits = (u64::BITS - (first - 1).leading_zeros()).min(32);
        let mut passed: Vec<u64> = (0..CORNERS as u64).collect();
        let mut next = first;
        for i in 0..count as usize {
            let id = ids.get(i).copied().flatten().filter(|id| first - 1 - id < 1 << 32);
            passed.push(if bits.bit(&mut self.models.lives, id.is_some()) {
                // Counted back from the first new one.
                let back = id.map_or(0, |id| (first - 1 - id) as u32);
                first.checked_sub(1 + u64::from(bits.plain(back, digits))).ok_or(Fault::Ids)?
            } else {
                next += 1;
                next - 1
            });
            if bits.is_beyond_end() {
                return Err(Fault::Ids);
            }
        }
        let mut sorted = passed.clone();
        sorted.sort_unstable();
        if sorted.windows(2).any(|pair| pair[0] == pair[1]) {
            return Err(Fault::Ids);
        }
        (self.ids, self.next_id) = (passed, next);
        Ok(())
    }

    fn delta(
        &mut self,
        bits: &mut impl Bits,
        fates: &mut [Fate],
        born: &mut Vec<Point>,
        known: Option<Known>,
    ) -> Result<(), Fault> {
        let models = &mut self.models;
        let area = (self.size, self.grid, &self.points[..]);
        pass_fates(bits, &mut models.moves, area, &self.edges, fates)?;
        let count = models.number.pass(bits, born.len() as u32);
        if count > MOST_VERTICES {
            return Err(Fault::Vertices(count));
        }
        fill(bits, &mut models.births, (self.size, self.grid), born, count)?;
        let (numbers, births) = positions::renumbered(fates, born.len());
        let vertices = numbers.iter().filter(|&&number| number != NONE).count() + births.len();
        let mut points = vec![Point::default(); vertices];
        let mut ids = vec![0; vertices];
        let mut moved = vec![true; vertices];
        let mut back = vec![NONE; vertices];
        for (v, &number) in numbers.iter().enumerate().filter(|(_, number)| **number != NONE) {
            let number = number as usize;
            moved[number] = fates[v] != Fate::Stays;
            back[number] = v as u32;
            points[number] = if let Fate::Moves(to) = fates[v] { to } else { self.points[v] };
            ids[number] = self.ids[v];
        }
        for (&number, &point) in births.iter().zip(&*born) {
            points[number as usize] = point;
            ids[number as usize] = self.next_id;
            self.next_id += 1;
        }
        let renumbered = self.renumbered_edges(&numbers, vertices);
        let (old_points, old_edges) =
            (std::mem::take(&mut self.points), std::mem::take(&mut self.edges));
        let old_triangles = std::mem::take(&mut self.grown.triangles);
        (self.points, self.ids) = (points, ids);
        let models = &mut self.models;
        let area = (self.size, &self.points[..]);
        let edges = renumbered.as_ref().unwrap_or(&old_edges);
        let before = Some(Before { edges, moved: &moved });
        let edges = known.as_ref().map(|known| &known.edges);
        let grown = connectivity::pass(bits, &mut models.connectivity, area, before, edges)?;
        let old = Old { points: old_points, triangles: old_triangles, edges: old_edges, back };
        self.paint(bits, grown, &moved, Some(&old), known)
    }

    /// The edges of the frame before in the numbers that its vertices have now; `None` where these are the same.
    fn renumbered_edges(&self, numbers: &[u32], vertices: usize) -> Option<HalfEdges> {
        if numbers.iter().zip(0..).all(|(&number, v)| number == v) && numbers.len() == vertices {
            return None;
        }
        // A triangle that lost a vertex stands for none; its place stays, because colours go by it.
        let nowhere = vertices as u32;
        let renumber = |t: &[u32; 3]| {
            let t = t.map(|v| numbers[v as usize]);
            if t.contains(&NONE) { [nowhere; 3] } else { t }
        };
        let triangles: Vec<[u32; 3]> = self.grown.triangles.iter().map(renumber).collect();
        Some(HalfEdges::of(vertices + 1, &triangles))
    }

    /// Passes colours, and takes the frame up.
    fn paint(
        &mut self,
        bits: &mut impl Bits,
        grown: Grown,
        moved: &[bool],
        old: Option<&Old>,
        known: Option<Known>,
    ) -> Result<(), Fault> {
        let mut colours = match &known {
            Some(known) => {
                let number = |&[a, b, _]: &[u32; 3]| known.edges.left_of(a, b).map(|(_, t)| t);
                let numbers = grown.triangles.iter().map(number);
                numbers.map(|t| t.map_or([0; 4], |t| known.colours[t as usize])).collect()
            }
            None => vec![[0; 4]; grown.triangles.len()],
        };
        let alpha = colours.iter().any(|colour: &Rgba| colour[3] < 255);
        let alpha = bits.bit(&mut self.models.alpha, alpha);
        let models = &mut self.models.colours;
        let edges = HalfEdges::of(self.points.len(), &grown.triangles);
        let now = &self.points;
        let before = colours::Before {
            edges: &edges,
            points: now,
            colours: &self.colours,
            wrong: &self.wrong,
            moved,
            places: old.map(|old| old.places(now)),
            tolerance: self.tolerance,
        };
        self.wrong = colours::pass(bits, models, &grown, before, alpha, &mut colours)?;
        self.edges = edges;
        (self.grown, self.colours) = (grown, colours);
        Ok(())
    }
}

impl Known {
    /// `mesh` with its vertices renumbered. Colours stay in the order of its triangles.
    fn of(mesh: &Mesh, colours: &[Rgba], numbers: &[u32]) -> Self {
        let triangles: Vec<_> =
            mesh.triangles.iter().map(|t| t.map(|v| numbers[v as usize])).collect();
        Self { edges: HalfEdges::of(numbers.len(), &triangles), colours: colours.to_vec() }
    }
}

/// Passes `count` points in order. Memory is taken as they come, not as many as are announced.
fn fill(
    bits: &mut impl Bits,
    models: &mut RowModels,
    area: (Size, Grid),
    points: &mut Vec<Point>,
    count: u32,
) -> Result<(), Fault> {
    points.resize(count as usize, Point::default());
    pass_rows(bits, models, area, points)
}
