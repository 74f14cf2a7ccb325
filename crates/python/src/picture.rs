//! numpy arrays as frames, and back.

use numpy::ndarray::{Array3, ArrayView3};
use numpy::{Element, PyArray3, PyReadonlyArray3};
use polyreel::{Frame, Rgba, Size};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::away::away;
use crate::error::raise;

/// What a picture's numbers are: what comes in goes out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kind {
    depth: Depth,
    /// 3 (red, green, blue) or 4 (and alpha).
    channels: usize,
}

impl Kind {
    /// Bytes of red, green and blue.
    pub(crate) const RGB: Self = Self { depth: Depth::U8, channels: 3 };
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Depth {
    /// 0 to 255.
    U8,
    /// 0 to 1, single precision.
    F32,
    /// 0 to 1, double precision.
    F64,
}

/// A channel's value and the 8 bits that stand for it.
trait Channel: Element + Copy + Sync {
    fn to_byte(self) -> u8;
    /// Whether it is a number near the range. Far above 1 are floats of 0 to 255, which are a mistake.
    fn is_sound(self) -> bool;
}

impl Channel for u8 {
    #[inline]
    fn to_byte(self) -> u8 {
        self
    }
    #[inline]
    fn is_sound(self) -> bool {
        true
    }
}

/// The largest float that is taken for one of 0 to 1: filters overshoot.
const MOST: f32 = 2.0;

impl Channel for f32 {
    #[inline]
    fn to_byte(self) -> u8 {
        (self.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
    }
    #[inline]
    fn is_sound(self) -> bool {
        self <= MOST
    }
}

impl Channel for f64 {
    #[inline]
    fn to_byte(self) -> u8 {
        (self.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
    }
    #[inline]
    fn is_sound(self) -> bool {
        self <= f64::from(MOST)
    }
}

/// The frame in `array`, of shape height x width x 3 or 4: uint8, or float32 or float64 of 0 to 1 (what lies
/// a little outside is moved to the nearest end). `room` is memory to put it in.
///
/// # Errors
/// `TypeError` for another kind of array, `ValueError` for another shape, for NaN, and for floats far above 1.
pub(crate) fn frame(array: &Bound<'_, PyAny>, room: Vec<Rgba>) -> PyResult<(Frame, Kind)> {
    let py = array.py();
    if let Ok(array) = array.extract::<PyReadonlyArray3<'_, u8>>() {
        return convert(py, array.as_array(), Depth::U8, room);
    }
    if let Ok(array) = array.extract::<PyReadonlyArray3<'_, f32>>() {
        return convert(py, array.as_array(), Depth::F32, room);
    }
    if let Ok(array) = array.extract::<PyReadonlyArray3<'_, f64>>() {
        return convert(py, array.as_array(), Depth::F64, room);
    }
    let shape = array.getattr("shape").and_then(|shape| shape.extract::<Vec<usize>>());
    let dtype = array.getattr("dtype").and_then(|dtype| dtype.str()?.extract::<String>());
    match (shape, dtype) {
        (Ok(shape), Ok(dtype)) if shape.len() == 3 => Err(PyTypeError::new_err(format!(
            "a picture of {dtype} is not supported: convert it to uint8 (0..255) or float32 (0..1)"
        ))),
        (Ok(shape), Ok(_)) => Err(wrong_shape(&shape)),
        _ => Err(PyTypeError::new_err("a picture is a numpy array of height x width x 3 or 4")),
    }
}

fn wrong_shape(shape: &[usize]) -> PyErr {
    PyValueError::new_err(format!(
        "a picture has the shape (height, width, 3) or (height, width, 4), not {shape:?}"
    ))
}

fn convert<T: Channel>(
    py: Python<'_>,
    array: ArrayView3<'_, T>,
    depth: Depth,
    room: Vec<Rgba>,
) -> PyResult<(Frame, Kind)> {
    let (height, width, channels) = array.dim();
    let (Ok(w), Ok(h), 3 | 4) = (u32::try_from(width), u32::try_from(height), channels) else {
        return Err(wrong_shape(array.shape()));
    };
    let (pixels, sound) = away(py, || pixels(array, room));
    if !sound {
        return Err(PyValueError::new_err(
            "the picture holds NaN or floats far above 1: floats are 0 to 1; divide by 255, or convert to uint8",
        ));
    }
    let frame = Frame::known(Size::new(w, h), pixels, channels == 3).map_err(raise)?;
    Ok((frame, Kind { depth, channels }))
}

/// The pixels of `array`, and whether all values are sound.
fn pixels<T: Channel>(array: ArrayView3<'_, T>, mut pixels: Vec<Rgba>) -> (Vec<Rgba>, bool) {
    let channels = array.dim().2;
    let mut sound = true;
    pixels.clear();
    match (array.as_slice(), channels) {
        (Some(all), 3) => pixels.extend(all.as_chunks().0.iter().map(|&[r, g, b]| {
            sound &= r.is_sound() & g.is_sound() & b.is_sound();
            [r.to_byte(), g.to_byte(), b.to_byte(), 255]
        })),
        (Some(all), _) => pixels.extend(all.as_chunks().0.iter().map(|values: &[T; 4]| {
            sound &= values.iter().fold(true, |sound, value| sound & value.is_sound());
            values.map(T::to_byte)
        })),
        _ => pixels.extend(array.rows().into_iter().map(|pixel| {
            let mut rgba = [255; 4];
            for (byte, value) in rgba.iter_mut().zip(pixel) {
                sound &= value.is_sound();
                *byte = value.to_byte();
            }
            rgba
        })),
    }
    (pixels, sound)
}

/// A picture's values as numpy will have them.
pub(crate) enum Packed {
    U8(Array3<u8>),
    F32(Array3<f32>),
    F64(Array3<f64>),
}

impl Packed {
    /// The picture `frame` as values of `kind`.
    pub(crate) fn of(frame: &Frame, kind: Kind) -> Self {
        let channels = kind.channels;
        match kind.depth {
            Depth::U8 => Self::U8(values(frame, channels, |byte| byte)),
            Depth::F32 => Self::F32(values(frame, channels, |byte| f32::from(byte) / 255.0)),
            Depth::F64 => Self::F64(values(frame, channels, |byte| f64::from(byte) / 255.0)),
        }
    }

    /// The array that Python gets, without another copy.
    pub(crate) fn array(self, py: Python<'_>) -> Bound<'_, PyAny> {
        match self {
            Self::U8(values) => PyArray3::from_owned_array(py, values).into_any(),
            Self::F32(values) => PyArray3::from_owned_array(py, values).into_any(),
            Self::F64(values) => PyArray3::from_owned_array(py, values).into_any(),
        }
    }
}

fn values<T: Copy + Default>(frame: &Frame, channels: usize, value: impl Fn(u8) -> T) -> Array3<T> {
    let Size { width, height } = frame.size();
    let shape = (height as usize, width as usize, channels);
    let mut values = Array3::from_elem(shape, T::default());
    // It was made in one piece just now.
    let all = values.as_slice_mut().unwrap_or_default();
    if channels == 3 {
        for (out, &[r, g, b, _]) in all.as_chunks_mut().0.iter_mut().zip(frame.pixels()) {
            *out = [value(r), value(g), value(b)];
        }
    } else {
        for (out, &byte) in all.iter_mut().zip(frame.pixels().as_flattened()) {
            *out = value(byte);
        }
    }
    values
}
