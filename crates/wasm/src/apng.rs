//! Animated PNGs: of each frame only the rectangle that changed.

use std::cell::RefCell;
use std::io::{self, Write};
use std::rc::Rc;

use png::{BitDepth, BlendOp, ColorType, Compression, DisposeOp, Encoder, Filter, Writer};
use wasm_bindgen::prelude::*;

use crate::area::Area;
use crate::error::{Error, Result};

/// More frames than there will be: the number is put in at the end.
const MANY: u32 = i32::MAX as u32;

/// Bytes that the encoder writes, and that are read when it is done.
#[derive(Clone, Debug, Default)]
struct Shared(Rc<RefCell<Vec<u8>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// An animated PNG being written.
#[wasm_bindgen]
pub struct Apng {
    bytes: Shared,
    writer: Writer<Shared>,
    width: usize,
    height: usize,
    last: Vec<[u8; 4]>,
    frames: u32,
}

#[wasm_bindgen]
impl Apng {
    /// An animation of this size; `plays` is how often it is shown, 0 for ever.
    ///
    /// # Errors
    /// When a side is 0.
    #[wasm_bindgen(constructor)]
    pub fn new(width: u32, height: u32, plays: u32) -> std::result::Result<Self, JsError> {
        Ok(Self::of(width, height, plays)?)
    }

    /// Adds a frame that is shown for `milliseconds`.
    ///
    /// # Errors
    /// When its size is wrong.
    pub fn push(&mut self, rgba: &[u8], milliseconds: u16) -> std::result::Result<(), JsError> {
        Ok(self.add(rgba, milliseconds)?)
    }

    /// The whole file.
    ///
    /// # Errors
    /// When there is no frame.
    pub fn finish(self) -> std::result::Result<Vec<u8>, JsError> {
        Ok(self.end()?)
    }
}

impl Apng {
    fn of(width: u32, height: u32, plays: u32) -> Result<Self> {
        let bytes = Shared::default();
        let mut encoder = Encoder::new(bytes.clone(), width, height);
        encoder.set_color(ColorType::Rgba);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::Fast);
        encoder.set_filter(Filter::Paeth);
        encoder.set_animated(MANY, plays).map_err(Error::file)?;
        encoder.set_blend_op(BlendOp::Source).map_err(Error::file)?;
        encoder.set_dispose_op(DisposeOp::None).map_err(Error::file)?;
        let writer = encoder.write_header().map_err(Error::file)?;
        let (width, height) = (width as usize, height as usize);
        Ok(Self { bytes, writer, width, height, last: Vec::new(), frames: 0 })
    }

    fn add(&mut self, rgba: &[u8], milliseconds: u16) -> Result<()> {
        let (pixels, _) = rgba.as_chunks::<4>();
        if pixels.len() != self.width * self.height {
            return Err(Error::file("a frame has another size than the first one"));
        }
        self.writer.set_frame_delay(milliseconds, 1000).map_err(Error::file)?;
        if self.frames == 0 {
            self.writer.write_image_data(rgba).map_err(Error::file)?;
        } else {
            let area = Area::changed(self.width, self.height, |i| pixels[i] == self.last[i]);
            let part = area.of(pixels, self.width);
            let side = |side: usize| side as u32;
            // The order keeps each rectangle inside the frame.
            self.writer.reset_frame_position().map_err(Error::file)?;
            let size = (side(area.width), side(area.height));
            self.writer.set_frame_dimension(size.0, size.1).map_err(Error::file)?;
            let place = (side(area.x), side(area.y));
            self.writer.set_frame_position(place.0, place.1).map_err(Error::file)?;
            self.writer.write_image_data(part.as_flattened()).map_err(Error::file)?;
        }
        self.last.clear();
        self.last.extend_from_slice(pixels);
        self.frames += 1;
        Ok(())
    }

    fn end(self) -> Result<Vec<u8>> {
        if self.frames == 0 {
            return Err(Error::file("an animation needs a frame"));
        }
        let Self { bytes, writer, frames, .. } = self;
        writer.finish().map_err(Error::file)?;
        let mut file = bytes.0.take();
        put_frames(&mut file, frames)?;
        Ok(file)
    }
}

/// Writes the number of frames where the file tells it.
fn put_frames(file: &mut [u8], frames: u32) -> Result<()> {
    let at = file.windows(4).position(|name| name == b"acTL");
    let at = at.ok_or_else(|| Error::file("the file has no place for the number of frames"))?;
    file[at + 4..at + 8].copy_from_slice(&frames.to_be_bytes());
    let sum = crc32fast::hash(&file[at..at + 12]);
    file[at + 12..at + 16].copy_from_slice(&sum.to_be_bytes());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_back_as_they_were() {
        let mut frames = vec![[9, 90, 200, 255]; 30];
        let mut apng = Apng::of(6, 5, 0).expect("a size");
        let mut wanted = Vec::new();
        for (i, place) in [(0, 0), (1, 8), (2, 29), (3, 3)] {
            frames[place] = [i, 3, 7, 255];
            apng.add(frames.as_flattened(), 40).expect("a frame");
            wanted.push(frames.clone());
        }
        let file = apng.end().expect("frames");
        let mut reader = png::Decoder::new(io::Cursor::new(&file)).read_info().expect("a PNG");
        assert_eq!(reader.info().animation_control().expect("moves").num_frames, 4);
        let mut canvas = vec![[0; 4]; 30];
        for wanted in wanted {
            let mut part = vec![0; reader.output_buffer_size().expect("small")];
            reader.next_frame(&mut part).expect("a frame");
            let control = *reader.info().frame_control().expect("its place");
            assert_eq!((control.delay_num, control.delay_den), (40, 1000));
            let (rows, _) = part.as_chunks::<4>();
            for (i, pixel) in
                rows.iter().take((control.width * control.height) as usize).enumerate()
            {
                let x = control.x_offset as usize + i % control.width as usize;
                let y = control.y_offset as usize + i / control.width as usize;
                canvas[y * 6 + x] = *pixel;
            }
            assert_eq!(canvas, wanted);
        }
        assert!(Apng::of(6, 5, 0).expect("a size").end().is_err());
    }
}
