//! Writing a stream, packet by packet.

use std::collections::HashMap;

use super::frame::State;
use super::{
    DELTA, END, FIELDS, Fault, Grid, Header, KEY, MAGIC, MOST_BYTES, MOST_VERTICES, NONE, Time,
    VERSION, checksum,
};
use crate::frame::{Rational, Rgba};
use crate::geom::{Point, Size};
use crate::mesh::{CORNERS, Mesh};

/// Frames from one key frame to the next, where no cut comes between: a reader can begin there.
const INTERVAL: u32 = 250;
/// Writes a stream: each call gives the bytes of one packet, to be written one after another.
#[derive(Debug)]
pub struct MeshWriter {
    size: Size,
    state: State,
    /// The vertices of the last frame, their lasting ids, and their numbers in the stream.
    last: Vec<Point>,
    ids: Vec<u64>,
    numbers: Vec<u32>,
    since_key: u32,
    frames: u64,
}

impl MeshWriter {
    /// A stream of meshes of `size` whose vertices are moved to `grid`, and its first bytes.
    pub fn new(size: Size, grid: Grid, header: &Header) -> (Self, Vec<u8>) {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend([grid.power() as u8, 0]);
        bytes.extend(size.width.to_le_bytes());
        bytes.extend(size.height.to_le_bytes());
        let fields = header.fields.iter().map(|(name, value)| format!("{name}={value}\n"));
        bytes.append(&mut packet(FIELDS, fields.collect::<String>().as_bytes()));
        let state = State::new(size, grid);
        let (last, ids, numbers) = (Vec::new(), Vec::new(), Vec::new());
        (Self { size, state, last, ids, numbers, since_key: 0, frames: 0 }, bytes)
    }

    /// The same, whose colours may be off by `tolerance` a channel: that takes fewer bytes.
    #[must_use]
    pub fn with_colour_error(mut self, tolerance: u8) -> Self {
        self.state.tolerance = tolerance;
        self
    }

    /// The packet of the next frame: `mesh` with its triangles in `colours`, one each and in their order.
    ///
    /// # Errors
    /// When the mesh is of another size, has too many vertices, or does not cover its frame.
    pub fn frame(&mut self, mesh: &Mesh, colours: &[Rgba], time: Time) -> Result<Vec<u8>, Fault> {
        if mesh.size != self.size || mesh.vertices.len() < CORNERS {
            return Err(Fault::Border);
        }
        if mesh.vertices.len() > MOST_VERTICES as usize {
            return Err(Fault::Vertices(mesh.vertices.len() as u32));
        }
        let mut numbers = self.lived(mesh);
        let living = numbers.iter().filter(|&&number| number != NONE).count();
        // Where little lives on, as after a cut, a key frame takes no more bytes.
        let is_key = 2 * living < numbers.len() || self.since_key >= INTERVAL || self.frames == 0;
        let mut payload = Vec::new();
        put_time(&mut payload, time);
        let write = if is_key { State::write_key } else { State::write_delta };
        let payload = write(&mut self.state, payload, mesh, colours, &mut numbers)?;
        let kind = if is_key { KEY } else { DELTA };
        self.numbers = numbers;
        self.since_key = if is_key { 1 } else { self.since_key + 1 };
        self.last.clone_from(&mesh.vertices);
        self.ids.clone_from(&mesh.ids);
        self.frames += 1;
        if payload.len() > MOST_BYTES as usize {
            return Err(Fault::Vertices(mesh.vertices.len() as u32));
        }
        Ok(packet(kind, &payload))
    }

    /// The last packet.
    pub fn finish(self) -> Vec<u8> {
        packet(END, &self.frames.to_le_bytes())
    }

    /// For each vertex of `mesh` the number that it had in the stream, by its lasting id; [`NONE`] where it is new.
    fn lived(&self, mesh: &Mesh) -> Vec<u32> {
        let places = self.ids.iter().copied().zip(0usize..);
        // Most stand where they stood.
        let mut others: Option<HashMap<u64, usize>> = None;
        let mut taken = vec![false; self.last.len()];
        let mut number = |v: usize, point: Point| {
            let id = *mesh.ids.get(v)?;
            let place = if self.ids.get(v) == Some(&id) {
                v
            } else {
                *others.get_or_insert_with(|| places.clone().collect()).get(&id)?
            };
            let lives = self.same_border(*self.last.get(place)?, point);
            (lives && !std::mem::replace(&mut taken[place], true)).then(|| self.numbers[place])
        };
        let seeds = mesh.vertices.iter().enumerate().skip(CORNERS);
        let seeds = seeds.map(|(v, &point)| number(v, point).unwrap_or(NONE));
        // The corners stay as long as there is a frame.
        let corners = (0..CORNERS as u32).map(|v| if self.frames == 0 { NONE } else { v });
        corners.chain(seeds).collect()
    }

    /// Whether a vertex that lay on a border still does: others are coded as new ones.
    fn same_border(&self, a: Point, b: Point) -> bool {
        use crate::mesh::Place;
        let far = self.size.far();
        match Place::of(a, self.size) {
            Place::Corner => a == b,
            Place::SideBorder => a.x == b.x && b.y != 0 && b.y != far.y,
            Place::LevelBorder => a.y == b.y && b.x != 0 && b.x != far.x,
            Place::Interior => true,
        }
    }
}

/// A single mesh, its vertices moved to `grid`, in as few bytes as a key frame takes, without a header.
///
/// # Errors
/// When it does not cover its frame.
pub fn pack(mesh: &Mesh, colours: &[Rgba], grid: Grid) -> Result<Vec<u8>, Fault> {
    let mut numbers = vec![NONE; mesh.vertices.len()];
    State::new(mesh.size, grid).write_key(Vec::new(), mesh, colours, &mut numbers)
}

fn packet(kind: u8, payload: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(payload.len() + 9);
    bytes.push(kind);
    bytes.extend((payload.len() as u32).to_le_bytes());
    bytes.extend(checksum(kind, payload).to_le_bytes());
    bytes.extend(payload);
    bytes
}

fn put_time(bytes: &mut Vec<u8>, time: Time) {
    // 0/0 stands for no length.
    let (num, den) = time.length.map_or((0, 0), |Rational { num, den }| (num, den));
    for value in [time.start.num, time.start.den, num, den] {
        bytes.extend(value.to_le_bytes());
    }
}
