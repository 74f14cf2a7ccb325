//! One frame's mesh and colours in as few bits as the frame before allows.

use super::colours;
use super::connectivity::{self, Before, Grown};
use super::half_edges::HalfEdges;
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

impl State {
    pub(super) fn new(size: Size) -> Self {
        Self {
            size,
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

    /// Writes a key frame behind `bytes`; returns for each vertex of `mesh` its number in the stream.
    pub(super) fn write_key(
        &mut self,
        bytes: Vec<u8>,
        mesh: &Mesh,
        colours: &[Rgba],
    ) -> Result<(Vec<u8>, Vec<u32>), Fault> {
        let mut order: Vec<u32> = (CORNERS as u32..mesh.vertices.len() as u32).collect();
        order.sort_unstable_by_key(|&v| by_rows(mesh.vertices[v as usize]));
        let mut points: Vec<_> = order.iter().map(|&v| mesh.vertices[v as usize]).collect();
        let mut numbers: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
        for (&v, number) in order.iter().zip(CORNERS as u32..) {
            numbers[v as usize] = number;
        }
        let known = Known::of(mesh, colours, &numbers);
        let mut bits = Encoder::new(bytes);
        self.key(&mut bits, &mut points, Some(known))?;
        Ok((bits.finish(), numbers))
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
        let mut fates = vec![Fate::Dies; self.points.len()];
        for (&number, &point) in numbers.iter().zip(&mesh.vertices) {
            if number != NONE {
                let still = self.points[number as usize] == point;
                fates[number as usize] = if still { Fate::Stays } else { Fate::Moves(point) };
            }
        }
        let new = |v: &usize| numbers[*v] == NONE;
        let mut born: Vec<usize> = (0..numbers.len()).filter(new).collect();
        born.sort_unstable_by_key(|&v| by_rows(mesh.vertices[v]));
        let mut points: Vec<_> = born.iter().map(|&v| mesh.vertices[v]).collect();
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
        self.key(&mut Decoder::new(bytes), &mut Vec::new(), None)
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
        known: Option<Known>,
    ) -> Result<(), Fault> {
        self.models = Models::default();
        let count = self.models.number.pass(bits, seeds.len() as u32);
        if count > MOST_VERTICES {
            return Err(Fault::Vertices(count));
        }
        fill(bits, &mut self.models.rows, self.size, seeds, count)?;
        self.points = Mesh::corners(self.size).to_vec();
        self.points.append(seeds);
        // The corners are always the same.
        let corners = CORNERS as u64;
        let seeds = self.points.len() as u64 - corners;
        self.ids = (0..corners).chain(self.next_id..self.next_id + seeds).collect();
        self.next_id += seeds;
        let (models, area) = (&mut self.models, (self.size, &self.points[..]));
        let edges = known.as_ref().map(|known| &known.edges);
        let grown = connectivity::pass(bits, &mut models.connectivity, area, None, edges)?;
        self.colours.clear();
        self.paint(bits, grown, &[], known)
    }

    fn delta(
        &mut self,
        bits: &mut impl Bits,
        fates: &mut [Fate],
        born: &mut Vec<Point>,
        known: Option<Known>,
    ) -> Result<(), Fault> {
        let models = &mut self.models;
        let area = (self.size, &self.points[..]);
        pass_fates(bits, &mut models.moves, area, &self.edges, fates)?;
        let count = models.number.pass(bits, born.len() as u32);
        if count > MOST_VERTICES {
            return Err(Fault::Vertices(count));
        }
        fill(bits, &mut models.births, self.size, born, count)?;
        let (numbers, births) = positions::renumbered(fates, born.len());
        let vertices = numbers.iter().filter(|&&number| number != NONE).count() + births.len();
        let mut points = vec![Point::default(); vertices];
        let mut ids = vec![0; vertices];
        let mut moved = vec![true; vertices];
        for (v, &number) in numbers.iter().enumerate().filter(|(_, number)| **number != NONE) {
            let number = number as usize;
            moved[number] = fates[v] != Fate::Stays;
            points[number] = if let Fate::Moves(to) = fates[v] { to } else { self.points[v] };
            ids[number] = self.ids[v];
        }
        for (&number, &point) in births.iter().zip(&*born) {
            points[number as usize] = point;
            ids[number as usize] = self.next_id;
            self.next_id += 1;
        }
        self.renumber_edges(&numbers, vertices);
        (self.points, self.ids) = (points, ids);
        let models = &mut self.models;
        let area = (self.size, &self.points[..]);
        let before = Some(Before { edges: &self.edges, moved: &moved });
        let edges = known.as_ref().map(|known| &known.edges);
        let grown = connectivity::pass(bits, &mut models.connectivity, area, before, edges)?;
        self.paint(bits, grown, &moved, known)
    }

    /// Gives the edges of the frame before the numbers that its vertices have now.
    fn renumber_edges(&mut self, numbers: &[u32], vertices: usize) {
        if numbers.iter().zip(0..).all(|(&number, v)| number == v) && numbers.len() == vertices {
            return;
        }
        // A triangle that lost a vertex stands for none; its place stays, because colours go by it.
        let nowhere = vertices as u32;
        let triangles: Vec<[u32; 3]> = self
            .grown
            .triangles
            .iter()
            .map(|t| {
                let t = t.map(|v| numbers[v as usize]);
                if t.contains(&NONE) { [nowhere; 3] } else { t }
            })
            .collect();
        self.edges = HalfEdges::of(vertices + 1, &triangles);
    }

    /// Passes colours, and takes the frame up.
    fn paint(
        &mut self,
        bits: &mut impl Bits,
        grown: Grown,
        moved: &[bool],
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
        let before = colours::Before { colours: &self.colours, wrong: &self.wrong, moved };
        self.wrong = colours::pass(bits, models, &grown, before, alpha, &mut colours)?;
        self.edges = HalfEdges::of(self.points.len(), &grown.triangles);
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
    size: Size,
    points: &mut Vec<Point>,
    count: u32,
) -> Result<(), Fault> {
    points.resize(count as usize, Point::default());
    pass_rows(bits, models, size, points)
}
