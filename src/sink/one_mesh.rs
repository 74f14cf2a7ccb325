//! Files of one mesh: SVG, OBJ and PLY, one or a numbered series; and animated SVG.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use super::facets::Facets;
use super::place::{Place, Series};
use super::still::nothing;
use super::{Needs, Origin, Picture, Sink, SinkOptions};
use crate::error::{Error, Result};
use crate::frame::{Buffers, Rational};
use crate::model::{to_obj, to_ply};
use crate::options::Options;
use crate::rasterise::Grade;
use crate::stream::{Loops, StreamInfo};
use crate::svg::{AnimatedSvg, Lines, Seams, SvgOptions, to_svg};

/// The format of a file of one mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Svg,
    Obj,
    Ply,
}

impl Format {
    /// The format that files with this extension have.
    pub(crate) fn of_extension(extension: &str) -> Option<Self> {
        Some(match extension {
            "svg" => Self::Svg,
            "obj" => Self::Obj,
            "ply" => Self::Ply,
            _ => return None,
        })
    }
}

/// What all of them have: how facets become bytes.
#[derive(Debug)]
struct Writer {
    format: Format,
    look: Options,
    grade: Grade,
    seams: Seams,
    title: String,
}

/// What these sinks need.
const NEEDS: Needs = Needs { form: None, edges: None, origin: true, plain: true, live: false };

impl Writer {
    fn new(format: Format, options: &SinkOptions) -> Self {
        let stem = options.inputs.first().and_then(|input| input.file_stem());
        let title = stem.map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let grade = Grade::of(&options.look);
        Self { format, look: options.look.clone(), grade, seams: options.seams, title }
    }

    /// Calls `write` with the graded colours and everything else that there is to say of `facets`.
    fn with<T>(
        &mut self,
        facets: &Facets,
        write: impl FnOnce(&[crate::frame::Rgba], &SvgOptions<'_>) -> T,
    ) -> T {
        let outlined = facets.outlined(&self.look);
        let lines = Lines::of(&outlined, &self.look, facets.mesh.size);
        let options = SvgOptions { title: &self.title, seams: self.seams, lines: &lines };
        write(&facets.graded(&mut self.grade), &options)
    }

    fn bytes(&mut self, facets: &Facets) -> Vec<u8> {
        let mesh = &facets.mesh;
        match self.format {
            Format::Svg => {
                self.with(facets, |colours, options| to_svg(mesh, colours, options)).into_bytes()
            }
            Format::Obj => to_obj(mesh, &facets.graded(&mut self.grade)).into_bytes(),
            Format::Ply => to_ply(mesh, &facets.graded(&mut self.grade)),
        }
    }
}

fn write_all(bytes: &[u8], mut file: &File, named: &Path) -> Result<()> {
    file.write_all(bytes)
        .map_err(|error| Error::output(named, format!("cannot be written: {error}")))
}

/// One picture in one file.
#[derive(Debug)]
pub(crate) struct MeshStill {
    writer: Writer,
    place: Place,
    written: bool,
}

impl MeshStill {
    /// A picture at `output`.
    ///
    /// # Errors
    /// As [`Place::reserve`].
    pub(crate) fn create(output: &Path, format: Format, options: &SinkOptions) -> Result<Self> {
        let place = Place::reserve(output, options)?;
        Ok(Self { writer: Writer::new(format, options), place, written: false })
    }
}

impl Sink for MeshStill {
    fn needs(&self) -> Needs {
        NEEDS
    }

    fn write(&mut self, picture: Picture, origin: Option<Origin>) -> Result<Buffers> {
        let named = self.place.named();
        if std::mem::replace(&mut self.written, true) {
            return Err(Error::output(named, "one picture cannot hold a second frame"));
        }
        let facets = Facets::of(picture, origin)?;
        write_all(&self.writer.bytes(&facets), self.place.file(), named)?;
        Ok(Buffers::default())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        if !self.written {
            return Err(nothing(self.place.named()));
        }
        self.place.commit()
    }
}

/// Numbered pictures.
#[derive(Debug)]
pub(crate) struct MeshSeries {
    writer: Writer,
    series: Series,
}

impl MeshSeries {
    /// Pictures that go to the places of `series`.
    pub(crate) fn create(series: Series, format: Format, options: &SinkOptions) -> Self {
        Self { writer: Writer::new(format, options), series }
    }
}

impl Sink for MeshSeries {
    fn needs(&self) -> Needs {
        NEEDS
    }

    fn write(&mut self, picture: Picture, origin: Option<Origin>) -> Result<Buffers> {
        let facets = Facets::of(picture, origin)?;
        let (file, named) = self.series.file()?;
        write_all(&self.writer.bytes(&facets), &file, &named)?;
        Ok(Buffers::default())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        if self.series.is_empty() {
            return Err(nothing(&self.series.first()));
        }
        self.series.commit()
    }
}

/// One file that moves.
#[derive(Debug)]
pub(crate) struct SvgAnimation {
    writer: Writer,
    place: Place,
    svg: AnimatedSvg,
    loops: Loops,
    /// When the last frame ends.
    end: Rational,
    /// How long a frame is shown of which nothing else is known.
    usual: Rational,
}

impl SvgAnimation {
    /// An animation at `output`, made from the stream `info`.
    ///
    /// # Errors
    /// As [`Place::reserve`].
    pub(crate) fn create(output: &Path, info: &StreamInfo, options: &SinkOptions) -> Result<Self> {
        let place = Place::reserve(output, options)?;
        let usual = info.rate.and_then(Rational::recip).unwrap_or(Rational { num: 1, den: 25 });
        let (loops, end) = (options.loops.unwrap_or(info.loops), Rational::ZERO);
        Ok(Self {
            writer: Writer::new(Format::Svg, options),
            place,
            svg: AnimatedSvg::default(),
            loops,
            end,
            usual,
        })
    }
}

impl Sink for SvgAnimation {
    fn needs(&self) -> Needs {
        NEEDS
    }

    fn write(&mut self, picture: Picture, origin: Option<Origin>) -> Result<Buffers> {
        let facets = Facets::of(picture, origin)?;
        let span = facets.span;
        let Self { writer, svg, .. } = self;
        let pushed = writer.with(&facets, |colours, options| {
            svg.push(&facets.mesh, colours, span.start.to_f64(), options)
        });
        pushed.map_err(|error| too_large(self.place.named(), &error.to_string()))?;
        self.end = span.start + span.length.unwrap_or(self.usual);
        Ok(Buffers::default())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        let plays = match self.loops {
            Loops::Once => Some(1),
            Loops::Times(n) => Some(n),
            Loops::Forever => None,
        };
        let text = self.svg.finish(self.end.to_f64(), plays);
        if text.is_empty() {
            return Err(nothing(self.place.named()));
        }
        write_all(text.as_bytes(), self.place.file(), self.place.named())?;
        self.place.commit()
    }
}

fn too_large(named: &Path, what: &str) -> Error {
    let stem = named.file_stem().unwrap_or_default().to_string_lossy();
    Error::output(
        named,
        format!(
            "{what}: write numbered files ({stem}_%04d.svg), a mesh stream ({stem}.polyreel), a page \
             ({stem}.html) or a video ({stem}.mp4), or ask for fewer --points or --frames"
        ),
    )
}
