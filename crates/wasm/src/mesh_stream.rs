//! Mesh streams, which the program turns into pictures and video of any size.

use polyreel_core::mesh_stream::{Grid, Header, MeshWriter, Time};
use polyreel_core::unstable::frame::Rational;
use polyreel_core::{Options, Renderer, Size};
use wasm_bindgen::prelude::*;

use crate::error::{Error, Result};
use crate::frame;
use crate::look::Look;
use crate::still::{colours, plain};

/// Times of the page: whole microseconds, as WebCodecs has them.
const SECOND: i64 = 1_000_000;

/// A mesh stream being written.
#[wasm_bindgen]
#[derive(Debug)]
pub struct MeshStream {
    renderer: Renderer,
    writer: MeshWriter,
    size: Size,
    header: Header,
    /// The packets of all frames.
    packets: Vec<u8>,
    frames: u64,
    end: i64,
}

#[wasm_bindgen]
impl MeshStream {
    /// A stream of frames of this size; `plays` is how often it is shown, 0 for ever.
    ///
    /// # Errors
    /// When the look has gradients.
    #[wasm_bindgen(constructor)]
    pub fn new(
        look: &Look,
        width: u32,
        height: u32,
        plays: u32,
        alpha: bool,
    ) -> std::result::Result<Self, JsError> {
        Ok(Self::of(&look.options, Size::new(width, height), plays, alpha)?)
    }

    /// Adds a frame that is shown from `start` on for `length`, both in microseconds.
    ///
    /// # Errors
    /// When it cannot be rendered.
    pub fn push(
        &mut self,
        rgba: &[u8],
        width: u32,
        height: u32,
        start: f64,
        length: f64,
    ) -> std::result::Result<(), JsError> {
        Ok(self.add(rgba, Size::new(width, height), start as i64, length as i64)?)
    }

    /// The whole file.
    pub fn finish(self) -> Vec<u8> {
        let mut header = self.header;
        header.put("frames", self.frames);
        header.put("duration", Rational::new(self.end, SECOND));
        let (_, mut bytes) = MeshWriter::new(self.size, Grid::default(), &header);
        bytes.extend(self.packets);
        bytes.append(&mut self.writer.finish());
        bytes
    }
}

impl MeshStream {
    fn of(look: &Options, size: Size, plays: u32, alpha: bool) -> Result<Self> {
        let renderer = Renderer::new(&plain(look)?)?;
        let header = header(look, plays, alpha);
        // What it begins with is written at the end, when the number of frames is known.
        let (writer, _) = MeshWriter::new(size, Grid::default(), &header);
        Ok(Self { renderer, writer, size, header, packets: Vec::new(), frames: 0, end: 0 })
    }

    fn add(&mut self, rgba: &[u8], size: Size, start: i64, length: i64) -> Result<()> {
        let mesh = self.renderer.render(&frame::frame(rgba, size.width, size.height)?)?.mesh;
        self.frames += 1;
        self.end = start + length.max(0);
        let start = Rational::new(start, SECOND);
        let length = (length > 0).then(|| Rational::new(length, SECOND));
        let packet = self.writer.frame(&mesh, &colours(&mesh), Time { start, length });
        self.packets.append(&mut packet.map_err(Error::file)?);
        Ok(())
    }
}

/// What a reader needs to paint the meshes: see `docs/mesh-stream.md`.
fn header(look: &Options, plays: u32, alpha: bool) -> Header {
    let mut header = Header::default();
    header.put("writer", concat!("polyreel ", env!("CARGO_PKG_VERSION")));
    header.put("plays", plays);
    header.put("alpha", u8::from(alpha));
    header.put("still", 0);
    header.put_look(look);
    if let Ok(options) = serde_json::to_string(look) {
        header.put("options", options);
    }
    header
}

#[cfg(test)]
mod tests {
    use super::*;
    use polyreel_core::mesh_stream::MeshReader;

    #[test]
    fn a_stream_tells_its_frames_and_is_read_again() {
        let look = Look::of(r#"{"points": "20", "saturation": 1.5}"#).expect("sound").options;
        let size = Size::new(40, 30);
        let mut stream = MeshStream::of(&look, size, 0, false).expect("no gradients");
        let picture: Vec<u8> = (0..40 * 30 * 4).map(|i| (i * 11 % 253) as u8 | 1).collect();
        for i in 0..3 {
            stream.add(&picture, size, i * 40_000, 40_000).expect("a frame");
        }
        let bytes = stream.finish();
        let mut reader = MeshReader::new(&bytes[..]).expect("a stream");
        assert_eq!(reader.header().get("frames"), Some("3"));
        assert_eq!(reader.header().get("saturation"), Some("1.5"));
        let mut frames = 0;
        while reader.next_frame().expect("sound packets").is_some() {
            frames += 1;
        }
        assert_eq!(frames, 3);
        let gradients = Look::of(r#"{"fill": "linear"}"#).expect("sound").options;
        assert!(MeshStream::of(&gradients, size, 0, false).is_err());
    }
}
