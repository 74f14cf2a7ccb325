//! Writing a stream, packet by packet.

use super::frame::State;
use super::{
    DELTA, END, FIELDS, Fault, Header, KEY, MAGIC, MOST_BYTES, MOST_VERTICES, NONE, Time, VERSION,
    checksum,
};
use crate::frame::{Rational, Rgba};
use crate::geom::{Point, SUBPIXEL, Size};
use crate::mesh::{CORNERS, Mesh};

/// Frames from one key frame to the next, where no cut comes between: a reader can begin there.
const INTERVAL: u32 = 250;
/// A vertex that has gone further, in 1/256 pixel, is taken for another one: that takes fewer bits.
const FURTHEST: i32 = 12 * SUBPIXEL;

/// Writes a stream: each call gives the bytes of one packet, to be written one after another.
#[derive(Debug)]
pub struct MeshWriter {
    size: Size,
    state: State,
    /// The vertices of the last frame, and their numbers in the stream.
    last: Vec<Point>,
    numbers: Vec<u32>,
    since_key: u32,
    frames: u64,
}

impl MeshWriter {
    /// A stream of meshes of `size`, and its first bytes.
    pub fn new(size: Size, header: &Header) -> (Self, Vec<u8>) {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend([0; 2]);
        bytes.extend(size.width.to_le_bytes());
        bytes.extend(size.height.to_le_bytes());
        let fields = header.fields.iter().map(|(name, value)| format!("{name}={value}\n"));
        bytes.append(&mut packet(FIELDS, fields.collect::<String>().as_bytes()));
        let state = State::new(size);
        let (last, numbers) = (Vec::new(), Vec::new());
        (Self { size, state, last, numbers, since_key: 0, frames: 0 }, bytes)
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
        let lived = self.lived(mesh);
        let is_key = lived.is_none() || self.since_key >= INTERVAL;
        let mut payload = Vec::new();
        put_time(&mut payload, time);
        let (kind, payload) = match lived.filter(|_| !is_key) {
            Some(mut numbers) => {
                let payload = self.state.write_delta(payload, mesh, colours, &mut numbers)?;
                self.numbers = numbers;
                (DELTA, payload)
            }
            None => {
                let (payload, numbers) = self.state.write_key(payload, mesh, colours)?;
                self.numbers = numbers;
                (KEY, payload)
            }
        };
        self.since_key = if is_key { 1 } else { self.since_key + 1 };
        self.last.clone_from(&mesh.vertices);
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

    /// The numbers of vertices that live on; `None` where fewer than half do.
    fn lived(&self, mesh: &Mesh) -> Option<Vec<u32>> {
        if self.last.len() != mesh.vertices.len() {
            return None;
        }
        let near = |(a, b): (&Point, &Point)| {
            (a.x - b.x).abs() <= FURTHEST
                && (a.y - b.y).abs() <= FURTHEST
                && self.same_border(*a, *b)
        };
        let pairs = self.last.iter().zip(&mesh.vertices).map(near);
        let numbers: Vec<u32> = pairs
            .zip(&self.numbers)
            .map(|(near, &number)| if near { number } else { NONE })
            .collect();
        let living = numbers.iter().filter(|&&number| number != NONE).count();
        (2 * living >= numbers.len() && numbers.iter().zip(0..CORNERS as u32).all(|(a, b)| *a == b))
            .then_some(numbers)
    }

    /// Whether a vertex that lay on a border still does: others are told as new ones.
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

/// A single mesh in as few bytes as a key frame takes, without a header.
///
/// # Errors
/// When it does not cover its frame.
pub fn pack(mesh: &Mesh, colours: &[Rgba]) -> Result<Vec<u8>, Fault> {
    State::new(mesh.size).write_key(Vec::new(), mesh, colours).map(|(bytes, _)| bytes)
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
    // A length of 0/0 is none.
    let (num, den) = time.length.map_or((0, 0), |Rational { num, den }| (num, den));
    for value in [time.start.num, time.start.den, num, den] {
        bytes.extend(value.to_le_bytes());
    }
}
