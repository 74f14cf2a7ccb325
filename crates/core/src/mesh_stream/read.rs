//! Reading a stream.

use std::io::{self, Read};

use super::frame::State;
use super::{
    DELTA, END, FIELDS, Fault, Grid, Header, KEY, MAGIC, MOST_BYTES, Time, VERSION, checksum,
};
use crate::frame::{Rational, Rgba};
use crate::geom::{MAX_SIDE, Size};
use crate::mesh::{Mesh, MeshFault};

/// Why a stream cannot be read (any further).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// It cannot be read at all.
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    /// It is no mesh stream.
    #[error("is no mesh stream: it does not begin with \"polyreel\"")]
    Magic,
    /// It is of a later version.
    #[error("is a mesh stream of version {0}, and this program reads version {VERSION}")]
    Version(u16),
    /// The header makes no sense.
    #[error("its header is damaged: {0}")]
    Header(&'static str),
    /// It ends in the middle.
    #[error("the stream is cut short")]
    Truncated,
    /// Bytes are not those that were written.
    #[error("a packet is damaged: its checksum does not fit")]
    Checksum,
    /// A packet is of an unknown kind or too long, or out of place.
    #[error("a packet of a kind, length or place that there is not")]
    Packet,
    /// A frame's bytes make no sense.
    #[error("the frame is damaged: {0}")]
    Frame(#[from] Fault),
    /// A frame's mesh is not sound.
    #[error("the frame's mesh is damaged: {0}")]
    Mesh(#[from] MeshFault),
}

/// A frame of a stream.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFrame {
    /// The mesh.
    pub mesh: Mesh,
    /// The colours of its triangles, in their order, before they are graded.
    pub colours: Vec<Rgba>,
    /// For each vertex a number that stays the same as long as it lives.
    pub ids: Vec<u64>,
    /// When it is shown.
    pub time: Time,
    /// Whether nothing before it is needed to read it.
    pub is_key: bool,
}

/// Reads a stream from its beginning to its end; never goes back, so that a pipe will do.
#[derive(Debug)]
pub struct MeshReader<R> {
    input: R,
    size: Size,
    grid: Grid,
    header: Header,
    state: Option<State>,
    frames: u64,
    /// The last packet.
    bytes: Vec<u8>,
}

impl<R: Read> MeshReader<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// When it is not a mesh stream, or of a later version.
    pub fn new(mut input: R) -> Result<Self, ReadError> {
        let mut start = [0; 20];
        input.read_exact(&mut start).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => ReadError::Magic,
            _ => ReadError::Io(error),
        })?;
        if !start.starts_with(MAGIC) {
            return Err(ReadError::Magic);
        }
        let version = u16::from_le_bytes([start[8], start[9]]);
        if version != VERSION {
            return Err(ReadError::Version(version));
        }
        let side = |at: usize| {
            u32::from_le_bytes([start[at], start[at + 1], start[at + 2], start[at + 3]])
        };
        let size = Size::new(side(12), side(16));
        let grid = Grid::of_power(start[10]).filter(|_| start[11] == 0);
        let grid = grid.ok_or(ReadError::Header("there is no such grid"))?;
        let sound = |side: u32| (1..=MAX_SIDE).contains(&side);
        if !sound(size.width) || !sound(size.height) {
            return Err(ReadError::Header("the size is out of range"));
        }
        let (header, frames, bytes) = (Header::default(), 0, Vec::new());
        let mut reader = Self { input, size, grid, header, state: None, frames, bytes };
        if reader.packet()? != FIELDS {
            return Err(ReadError::Header("its fields are missing"));
        }
        let text = std::str::from_utf8(&reader.bytes).map_err(|_| ReadError::Header("no text"))?;
        let fields = text.lines().filter_map(|line| line.split_once('='));
        let fields = fields.map(|(name, value)| (name.to_owned(), value.to_owned())).collect();
        reader.header = Header { fields };
        Ok(reader)
    }

    /// The size of its frames.
    pub fn size(&self) -> Size {
        self.size
    }

    /// What it says of itself.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The next frame; `None` at the end of a complete stream.
    ///
    /// # Errors
    /// When the stream is cut short or damaged; frames before have been delivered.
    pub fn next_frame(&mut self) -> Result<Option<MeshFrame>, ReadError> {
        let kind = self.packet()?;
        if kind == END {
            let frames = self.bytes.as_slice().try_into().map(u64::from_le_bytes);
            let is_whole = matches!(frames, Ok(count) if count == self.frames);
            return if is_whole { Ok(None) } else { Err(ReadError::Packet) };
        }
        let (time, rest) = time(&self.bytes)?;
        let is_key = kind == KEY;
        match (kind, &mut self.state) {
            (KEY, state) => {
                state.get_or_insert_with(|| State::new(self.size, self.grid)).read_key(rest)?
            }
            (DELTA, Some(state)) => state.read_delta(rest)?,
            _ => return Err(ReadError::Packet),
        }
        self.frames += 1;
        let Some(state) = &self.state else { return Err(ReadError::Packet) };
        let (mesh, colours) = state.mesh();
        mesh.check()?;
        Ok(Some(MeshFrame { mesh, colours, ids: state.ids.clone(), time, is_key }))
    }

    /// Reads a packet into `bytes`; returns its kind.
    fn packet(&mut self) -> Result<u8, ReadError> {
        let mut head = [0; 9];
        self.input.read_exact(&mut head).map_err(cut)?;
        let word =
            |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let (kind, length, sum) = (head[0], word(1), word(5));
        if length > MOST_BYTES {
            return Err(ReadError::Packet);
        }
        self.bytes.clear();
        // Memory is taken as bytes come, not as many as are announced.
        let read = (&mut self.input).take(length.into()).read_to_end(&mut self.bytes)?;
        if read < length as usize {
            return Err(ReadError::Truncated);
        }
        if checksum(kind, &self.bytes) != sum {
            return Err(ReadError::Checksum);
        }
        Ok(kind)
    }
}

fn cut(error: io::Error) -> ReadError {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => ReadError::Truncated,
        _ => ReadError::Io(error),
    }
}

/// The time that a frame's packet begins with, and the rest of it.
fn time(bytes: &[u8]) -> Result<(Time, &[u8]), ReadError> {
    let Some((times, rest)) = bytes.split_at_checked(32) else { return Err(ReadError::Packet) };
    let (words, _) = times.as_chunks::<8>();
    let [start, den, num, length_den] = [0, 1, 2, 3].map(|i| i64::from_le_bytes(words[i]));
    // Times of more than some thousand years stand for damage.
    let sound = |num: i64, den: i64| den > 0 && num.unsigned_abs() / den.unsigned_abs() < 1 << 37;
    if !sound(start, den) || (length_den != 0 && !(sound(num, length_den) && num >= 0)) {
        return Err(ReadError::Packet);
    }
    let length = (length_den != 0).then(|| Rational::new(num, length_den));
    Ok((Time { start: Rational::new(start, den), length }, rest))
}
