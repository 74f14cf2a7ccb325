//! The mesh behind a picture.

use std::path::PathBuf;

use numpy::ndarray::{Array2, ArrayView1};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use polyreel::rasterise::{Grade, outlined};
use polyreel::sink::Needs;
use polyreel::sink::repainted::Repainted;
use polyreel::svg::{Lines, Seams, SvgOptions, to_svg};
use polyreel::{
    Fill, Frame, Options, Origin, Picture, Point, Rational, Rgba, SUBPIXEL, Sink, SinkOptions,
    Size, Span, StreamInfo,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::away::away;
use crate::error::{UsageError, raise};
use crate::picture;
use crate::work::work;

/// Vertices, triangles and their colours. The arrays cannot be written to.
#[pyclass(frozen, module = "polyreel")]
pub(crate) struct Mesh {
    /// Width and height of the picture in pixels.
    #[pyo3(get)]
    size: (u32, u32),
    /// float64, vertices x 2: x and y in pixels from the top left corner of the picture.
    #[pyo3(get)]
    vertices: Py<PyArray2<f64>>,
    /// uint64, vertices: a number for each vertex that lasts from frame to frame.
    #[pyo3(get)]
    ids: Py<PyArray1<u64>>,
    /// uint32, triangles x 3: rows of `vertices`.
    #[pyo3(get)]
    triangles: Py<PyArray2<u32>>,
    /// uint8, triangles x 4: red, green, blue, alpha.
    #[pyo3(get)]
    colors: Py<PyArray2<u8>>,
    /// Colours before they are graded.
    plain: Vec<Rgba>,
    /// How they are graded, and what lines there are.
    look: Options,
}

fn table<'py, T: numpy::Element, const N: usize>(
    py: Python<'py>,
    rows: Vec<[T; N]>,
) -> PyResult<Py<PyArray2<T>>> {
    let table = Array2::from_shape_vec((rows.len(), N), rows.into_flattened())
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    let array: Bound<'py, PyArray2<T>> = PyArray2::from_owned_array(py, table);
    array.readwrite().make_nonwriteable();
    Ok(array.unbind())
}

/// A mesh as it came from the engine, with its plain colours, and how it looks.
type Made = (polyreel::Mesh, Options);

impl Mesh {
    fn new(py: Python<'_>, (mesh, look): Made) -> PyResult<Self> {
        let plain: Vec<Rgba> = mesh.fills.iter().map(|fill| fill.colour).collect();
        let graded = Grade::of(&look).graded(&mesh, &plain);
        let pixels = |value: i32| f64::from(value) / f64::from(SUBPIXEL);
        let vertices = mesh.vertices.iter().map(|p| [pixels(p.x), pixels(p.y)]).collect();
        let ids = PyArray1::from_vec(py, mesh.ids);
        ids.readwrite().make_nonwriteable();
        Ok(Self {
            size: (mesh.size.width, mesh.size.height),
            vertices: table(py, vertices)?,
            ids: ids.unbind(),
            triangles: table(py, mesh.triangles)?,
            colors: table(py, graded)?,
            plain,
            look,
        })
    }

    /// The engine's mesh again: all numbers are exact.
    fn mesh(&self, py: Python<'_>) -> polyreel::Mesh {
        let (width, height) = self.size;
        let units = |value: f64| (value * f64::from(SUBPIXEL)) as i32;
        let (vertices, triangles) =
            (self.vertices.bind(py).readonly(), self.triangles.bind(py).readonly());
        let (vertices, triangles) = (vertices.as_array(), triangles.as_array());
        let point = |p: ArrayView1<'_, f64>| Point::new(units(p[0]), units(p[1]));
        let vertices = vertices.rows().into_iter().map(point).collect();
        let triangles = triangles.rows().into_iter().map(|t| [t[0], t[1], t[2]]).collect();
        let mut mesh = polyreel::Mesh::new(Size::new(width, height), vertices, triangles);
        mesh.ids = self.ids.bind(py).readonly().as_array().to_vec();
        mesh.fills = self.plain.iter().map(|&colour| Fill { colour, area: 0 }).collect();
        mesh
    }
}

#[pymethods]
impl Mesh {
    fn __repr__(&self, py: Python<'_>) -> String {
        let (width, height) = self.size;
        let (vertices, triangles) =
            (self.vertices.bind(py).shape()[0], self.triangles.bind(py).shape()[0]);
        format!("<polyreel.Mesh of {width}x{height}: {vertices} vertices, {triangles} triangles>")
    }

    /// The mesh as an SVG document, which begins with `<svg`.
    #[pyo3(signature = (title="", *, seams="underlap"))]
    fn svg(&self, py: Python<'_>, title: &str, seams: &str) -> PyResult<String> {
        let seams =
            Seams::ALL.into_iter().find(|known| known.name() == seams).ok_or_else(|| {
                let names = Seams::ALL.map(Seams::name).join(", ");
                UsageError::new_err(format!("seams is '{seams}'; it can be {names}"))
            })?;
        let mesh = self.mesh(py);
        Ok(away(py, || {
            let outlined = outlined(&mesh, &self.plain, &self.look);
            let lines = Lines::of(&outlined, &self.look, mesh.size);
            let graded = Grade::of(&self.look).graded(&mesh, &self.plain);
            to_svg(&mesh, &graded, &SvgOptions { title, seams, lines: &lines })
        }))
    }

    /// Writes the mesh to a file, in the format that its name ends in; see `polyreel.Mesh.save`.
    #[pyo3(signature = (destination, *, scale=1.0, overwrite=false))]
    fn save(
        &self,
        py: Python<'_>,
        destination: PathBuf,
        scale: f64,
        overwrite: bool,
    ) -> PyResult<()> {
        if !(0.05..=64.0).contains(&scale) {
            return Err(UsageError::new_err(format!("scale is {scale}; it can be 0.05 to 64")));
        }
        let mesh = self.mesh(py);
        away(py, || save(mesh, &self.look, &destination, scale, overwrite)).map_err(raise)
    }
}

/// A frame in the place of one that nobody looks at.
fn nothing() -> polyreel::Result<Frame> {
    Ok(Frame::filled(Size::new(1, 1), [0; 4])?)
}

fn save(
    mesh: polyreel::Mesh,
    look: &Options,
    destination: &std::path::Path,
    scale: f64,
    overwrite: bool,
) -> polyreel::Result<()> {
    let side = |side: u32| (f64::from(side) * scale).round().max(1.0) as u32;
    let size = Size::new(side(mesh.size.width), side(mesh.size.height));
    polyreel::frame::check_size(size)?;
    let look = look.enlarged(scale);
    let info = StreamInfo { still: true, frames: Some(1), alpha: true, ..StreamInfo::of(size) };
    let options = SinkOptions { overwrite, look: look.clone(), ..SinkOptions::default() };
    let mut sink = Repainted::new(polyreel::create(destination, &info, &options)?, &look, size);
    let picture = Picture {
        frame: nothing()?,
        fills: mesh.fills.clone(),
        span: Span { start: Rational::ZERO, length: None },
    };
    sink.write(picture, Some(Origin { frame: nothing()?, mesh }))?;
    Box::new(sink).finish()
}

/// The mesh of `picture`, drawn by itself.
#[pyfunction]
#[pyo3(signature = (picture, **options))]
pub(crate) fn triangulate(
    picture: &Bound<'_, PyAny>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Mesh> {
    let mut look = crate::options::look(options)?;
    // Nothing comes after it.
    look.coherence = 0.0;
    let py = picture.py();
    let (frame, _) = picture::frame(picture, Vec::new())?;
    let made: polyreel::Result<_> = work(py, move || {
        // Colours as they were found: how they are shown is the mesh's to say.
        let mut plain = look.clone();
        let needs = Needs { plain: true, ..Needs::default() };
        needs.check(&plain)?;
        needs.adapt(&mut plain);
        let rendered = polyreel::Renderer::new(&plain)?.render(&frame)?;
        Ok((rendered.mesh, look))
    })?;
    Mesh::new(py, made.map_err(raise)?)
}
