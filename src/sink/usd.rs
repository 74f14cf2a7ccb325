//! USD text, `.usda`: samples wait in a file for each attribute until all are known.

use std::fs::File;
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

use super::facets::Facets;
use super::place::Place;
use super::still::nothing;
use super::{Needs, Origin, Picture, Sink, SinkOptions};
use crate::error::Result;
use crate::frame::Buffers;
use crate::rasterise::Grade;
use crate::stream::StreamInfo;
use crate::usd;

/// A mesh sequence being written.
#[derive(Debug)]
pub(crate) struct UsdSink {
    place: Place,
    grade: Grade,
    parts: Vec<BufWriter<File>>,
    rate: f64,
    /// Times of the first and the last frame.
    codes: Option<(f64, f64)>,
}

impl UsdSink {
    /// A sequence at `output`, made from the stream `info`.
    ///
    /// # Errors
    /// As [`Place::reserve`], and when no temporary file can be made.
    pub(crate) fn create(output: &Path, info: &StreamInfo, options: &SinkOptions) -> Result<Self> {
        let place = Place::reserve(output, options)?;
        let parts = usd::ATTRIBUTES.iter().map(|_| tempfile::tempfile().map(BufWriter::new));
        let parts = parts.collect::<std::io::Result<_>>().map_err(|error| place.failed(&error))?;
        let rate = info.rate.map_or(25.0, |rate| rate.to_f64());
        Ok(Self { place, grade: Grade::of(&options.look), parts, rate, codes: None })
    }

    fn complete(parts: Vec<BufWriter<File>>, head: &str, mut out: &File) -> std::io::Result<()> {
        out.write_all(head.as_bytes())?;
        for (attribute, part) in parts.into_iter().enumerate() {
            let mut part = part.into_inner().map_err(std::io::IntoInnerError::into_error)?;
            part.seek(SeekFrom::Start(0))?;
            out.write_all(usd::before(attribute).as_bytes())?;
            std::io::copy(&mut part, &mut out)?;
            out.write_all(usd::after(attribute).as_bytes())?;
        }
        out.write_all(usd::END.as_bytes())
    }
}

impl Sink for UsdSink {
    fn needs(&self) -> Needs {
        Needs { origin: true, plain: true, ..Needs::default() }
    }

    fn write(&mut self, picture: Picture, origin: Option<Origin>) -> Result<Buffers> {
        let facets = Facets::of(picture, origin)?;
        // Hundredths of a frame are fine enough, and hide that fractions are no floats.
        let code = (facets.span.start.to_f64() * self.rate * 100.0).round() / 100.0;
        let colours = facets.graded(&mut self.grade);
        for (part, sample) in self.parts.iter_mut().zip(usd::samples(&facets.mesh, &colours, code))
        {
            part.write_all(sample.as_bytes()).map_err(|error| self.place.failed(&error))?;
        }
        self.codes = Some((self.codes.map_or(code, |codes| codes.0), code));
        Ok(Buffers::default())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        let Self { place, parts, rate, codes, .. } = *self;
        let Some((first, last)) = codes else { return Err(nothing(place.named())) };
        let done = Self::complete(parts, &usd::head(rate, first, last), place.file());
        done.map_err(|error| place.failed(&error))?;
        place.commit()
    }
}
