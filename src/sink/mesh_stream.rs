//! The mesh stream, `.polyreel`.

use std::io::{BufWriter, Write};
use std::path::Path;

use super::facets::Facets;
use super::place::Place;
use super::still::nothing;
use super::{Needs, Origin, Picture, Sink, SinkOptions};
use crate::error::{Error, Result};
use crate::frame::Buffers;
use crate::look;
use crate::mesh_stream::{Header, MeshWriter, Time};
use crate::stream::{Loops, StreamInfo};

/// A mesh stream being written to a file.
#[derive(Debug)]
pub(crate) struct MeshSink {
    place: Place,
    file: BufWriter<std::fs::File>,
    writer: MeshWriter,
    written: u64,
}

impl MeshSink {
    /// A stream at `output`, made from the stream `info`.
    ///
    /// # Errors
    /// As [`Place::reserve`], and when its first bytes cannot be written.
    pub(crate) fn create(output: &Path, info: &StreamInfo, options: &SinkOptions) -> Result<Self> {
        let place = Place::reserve(output, options)?;
        let file = place.file().try_clone().map_err(|error| place.failed(&error))?;
        let (writer, bytes) = MeshWriter::new(info.size, &header(info, options));
        let mut sink = Self { place, file: BufWriter::new(file), writer, written: 0 };
        sink.put(&bytes)?;
        Ok(sink)
    }

    fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.file.write_all(bytes).map_err(|error| self.place.failed(&error))
    }
}

fn header(info: &StreamInfo, options: &SinkOptions) -> Header {
    let mut header = Header::default();
    header.put("writer", concat!("polyreel ", env!("CARGO_PKG_VERSION")));
    if let Some(rate) = info.rate {
        header.put("rate", rate);
    }
    if let Some(frames) = info.frames {
        header.put("frames", frames);
    }
    if let Some(duration) = info.duration {
        header.put("duration", duration);
    }
    let plays = match options.loops.unwrap_or(info.loops) {
        Loops::Once => 1,
        Loops::Times(n) => n,
        Loops::Forever => 0,
    };
    header.put("plays", plays);
    header.put("alpha", u8::from(info.alpha));
    header.put("still", u8::from(info.still));
    if let Some(colour) = &info.colour {
        let tags = [
            ("matrix", &colour.matrix),
            ("range", &colour.range),
            ("primaries", &colour.primaries),
            ("transfer", &colour.transfer),
        ];
        header.put("tagged", 1);
        for (name, tag) in tags {
            if let Some(tag) = tag {
                header.put(name, tag);
            }
        }
    }
    look::put(&options.look, &mut header);
    let options = serde_json::to_string(&options.look).expect("options are plain data");
    header.put("options", options);
    header
}

impl Sink for MeshSink {
    fn needs(&self) -> Needs {
        Needs { origin: true, plain: true, ..Needs::default() }
    }

    fn write(&mut self, picture: Picture, origin: Option<Origin>) -> Result<Buffers> {
        let Facets { mesh, colours, span } = Facets::of(picture, origin)?;
        let time = Time { start: span.start, length: span.length };
        let frame = self.writer.frame(&mesh, &colours, time);
        let bytes = frame.map_err(|fault| Error::output(self.place.named(), fault.to_string()))?;
        self.put(&bytes)?;
        self.written += 1;
        Ok(Buffers::default())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        let Self { place, mut file, writer, written } = *self;
        if written == 0 {
            return Err(nothing(place.named()));
        }
        let done = file.write_all(&writer.finish()).and_then(|()| file.flush());
        done.map_err(|error| place.failed(&error))?;
        place.commit()
    }
}
