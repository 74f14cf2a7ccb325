//! The mesh stream, `.polyreel`, and the page that plays one, `.html`.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::facets::Facets;
use super::html::Page;
use super::place::Place;
use super::still::nothing;
use super::{Needs, Origin, Picture, Sink, SinkOptions};
use crate::error::{Error, Result};
use crate::frame::Buffers;
use crate::mesh_stream::{Header, MeshWriter, Time};
use crate::rasterise::Grade;
use crate::stream::StreamInfo;

/// What a stream is written to.
pub(super) trait Body: Write {
    /// Writes what comes after the stream, and all that waits.
    ///
    /// # Errors
    /// When it cannot be written.
    fn end(self) -> io::Result<()>;
}

impl Body for BufWriter<File> {
    fn end(mut self) -> io::Result<()> {
        self.flush()
    }
}

/// A mesh stream being written to a file.
pub(crate) struct MeshSink<B> {
    place: Place,
    body: B,
    writer: MeshWriter,
    written: u64,
    /// Grades colours before they are written, for readers that do not.
    grade: Option<Grade>,
}

impl MeshSink<BufWriter<File>> {
    /// A stream at `output`, made from the stream `info`.
    ///
    /// # Errors
    /// As [`Place::reserve`], and when its first bytes cannot be written.
    pub(crate) fn create(output: &Path, info: &StreamInfo, options: &SinkOptions) -> Result<Self> {
        Self::begin(output, info, options, |file| Ok(BufWriter::new(file)))
    }
}

impl MeshSink<Page> {
    /// A page at `output`, made from the stream `info`.
    ///
    /// # Errors
    /// As [`MeshSink::create`].
    pub(crate) fn page(output: &Path, info: &StreamInfo, options: &SinkOptions) -> Result<Self> {
        let look = &options.look;
        let grade = Grade::of(look);
        let ungraded = SinkOptions { look: look.ungraded(), ..options.clone() };
        let sink = Self::begin(output, info, &ungraded, |file| Page::begin(file, info, options))?;
        Ok(Self { grade: Some(grade), ..sink })
    }
}

impl<B: Body> MeshSink<B> {
    fn begin(
        output: &Path,
        info: &StreamInfo,
        options: &SinkOptions,
        body: impl FnOnce(File) -> io::Result<B>,
    ) -> Result<Self> {
        let place = Place::reserve(output, options)?;
        let body = place.file().try_clone().and_then(body).map_err(|error| place.failed(&error))?;
        let (writer, bytes) = MeshWriter::new(info.size, options.grid, &header(info, options));
        let writer = writer.with_colour_error(options.colour_error);
        let mut sink = Self { place, body, writer, written: 0, grade: None };
        sink.put(&bytes)?;
        Ok(sink)
    }

    fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.body.write_all(bytes).map_err(|error| self.place.failed(&error))
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
    header.put("plays", options.loops.unwrap_or(info.loops).plays());
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
    header.put_look(&options.look);
    let options = serde_json::to_string(&options.look).expect("options are plain data");
    header.put("options", options);
    header
}

impl<B: Body + Send> Sink for MeshSink<B> {
    fn needs(&self) -> Needs {
        Needs { origin: true, plain: true, ..Needs::default() }
    }

    fn write(&mut self, picture: Picture, origin: Option<Origin>) -> Result<Buffers> {
        let facets = Facets::of(picture, origin)?;
        let colours = match &mut self.grade {
            Some(grade) => facets.graded(grade),
            None => facets.colours,
        };
        let (mesh, span) = (facets.mesh, facets.span);
        let time = Time { start: span.start, length: span.length };
        let frame = self.writer.frame(&mesh, &colours, time);
        let bytes = frame.map_err(|fault| Error::output(self.place.named(), fault.to_string()))?;
        self.put(&bytes)?;
        self.written += 1;
        Ok(Buffers::default())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        let Self { place, mut body, writer, written, .. } = *self;
        if written == 0 {
            return Err(nothing(place.named()));
        }
        let done = body.write_all(&writer.finish()).and_then(|()| body.end());
        done.map_err(|error| place.failed(&error))?;
        place.commit()
    }
}
