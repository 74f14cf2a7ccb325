//! The mesh stream (`.polyreel`): the meshes of a clip, one after another, with the colours of their triangles.
//!
//! Nothing is lost: what is read is the mesh that was written, up to the numbers of its vertices. Frames that go on
//! from the one before hold only what has changed. The page `docs/mesh-stream.md` specifies every bit.

mod apexes;
mod colours;
mod connectivity;
mod frame;
mod grid;
mod half_edges;
mod look;
mod places;
mod positions;
mod range_coder;
mod read;
mod write;

use crate::frame::Rational;

pub use grid::Grid;
pub use read::{MeshFrame, MeshReader, ReadError};
pub use write::{MeshWriter, pack};

/// No vertex, no triangle.
const NONE: u32 = u32::MAX;

/// The most seeds of a frame.
pub const MOST_VERTICES: u32 = 1 << 19;

/// What is wrong with a frame's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// Too many vertices.
    #[error("{0} vertices, more than {MOST_VERTICES}")]
    Vertices(u32),
    /// A vertex lies outside the frame.
    #[error("a vertex lies outside the frame")]
    Vertex,
    /// The border of the frame is not closed.
    #[error("the frame's border is not whole")]
    Border,
    /// The triangles do not cover the frame.
    #[error("the triangles do not cover the frame")]
    Triangles,
    /// A colour is out of range.
    #[error("a colour is out of range")]
    Colours,
    /// Two vertices have one number, or a number lies ahead.
    #[error("the lasting numbers of the vertices make no sense")]
    Ids,
}

/// What a stream begins with.
pub const MAGIC: &[u8; 8] = b"polyreel";
/// The version of the format.
pub const VERSION: u16 = 2;
/// The most bytes of a packet.
const MOST_BYTES: u32 = 1 << 26;

/// Kinds of packets.
const FIELDS: u8 = b'H';
const KEY: u8 = b'K';
const DELTA: u8 = b'D';
const END: u8 = b'E';

/// What a stream says of itself before its frames.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// Names and values, as text: see the specification. Neither holds a line break, names no `=`.
    pub fields: Vec<(String, String)>,
}

impl Header {
    /// The value of `name`.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.fields.iter().find(|field| field.0 == name).map(|field| field.1.as_str())
    }

    /// Adds a value.
    pub fn put(&mut self, name: &str, value: impl std::fmt::Display) {
        let value = value.to_string().replace(['\n', '\r'], " ");
        self.fields.push((name.to_owned(), value));
    }
}

/// When a frame is shown, in seconds from the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Time {
    /// First moment.
    pub start: Rational,
    /// How long, where it is known.
    pub length: Option<Rational>,
}

/// The sum that guards a packet: CRC-32 over its kind and its payload.
fn checksum(kind: u8, payload: &[u8]) -> u32 {
    let mut sum = crc32fast::Hasher::new();
    sum.update(&[kind]);
    sum.update(payload);
    sum.finalize()
}

#[cfg(test)]
mod tests;
