//! Files of one picture.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use polyreel_core::svg::{Lines, SvgOptions, to_svg};
use polyreel_core::unstable::rasterise::{Grade, outlined};
use polyreel_core::{Frame, Mesh, Options, Renderer, Rgba};
use wasm_bindgen::prelude::*;

use crate::error::{Error, Result};
use crate::frame;
use crate::look::Look;

/// A picture as PNG, with the bytes that the program writes.
///
/// # Errors
/// When the size is wrong.
#[wasm_bindgen(js_name = pngFile)]
pub fn png_file(rgba: &[u8], width: u32, height: u32) -> std::result::Result<Vec<u8>, JsError> {
    Ok(png(&frame::frame(rgba, width, height)?)?)
}

/// A frame drawn as SVG.
///
/// # Errors
/// When the look has gradients, or the frame cannot be rendered.
#[wasm_bindgen(js_name = svgFile)]
pub fn svg_file(
    look: &Look,
    rgba: &[u8],
    width: u32,
    height: u32,
    title: &str,
) -> std::result::Result<String, JsError> {
    Ok(svg(&look.options, &frame::frame(rgba, width, height)?, title)?)
}

fn png(frame: &Frame) -> Result<Vec<u8>> {
    let mut file = Vec::new();
    let (width, height) = (frame.size().width, frame.size().height);
    let encoder = PngEncoder::new_with_quality(&mut file, CompressionType::Fast, FilterType::Paeth);
    let written = if frame.is_opaque() {
        let rgb: Vec<[u8; 3]> = frame.pixels().iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        encoder.write_image(rgb.as_flattened(), width, height, ExtendedColorType::Rgb8)
    } else {
        let rgba = frame.pixels().as_flattened();
        encoder.write_image(rgba, width, height, ExtendedColorType::Rgba8)
    };
    written.map_err(Error::file)?;
    Ok(file)
}

/// The options for a mesh whose colours are graded later, and that has lines of its own.
///
/// # Errors
/// When triangles are to have more than one colour.
pub(crate) fn plain(look: &Options) -> Result<Options> {
    if look.fill.is_gradient() {
        return Err(Error::file(format!(
            "Fill “{}” gives a triangle more than one colour, which this kind of file cannot hold. Choose another fill, \
             or save a picture.",
            look.fill.name()
        )));
    }
    Ok(look.plain())
}

/// The colours of a mesh's triangles before grading.
pub(crate) fn colours(mesh: &Mesh) -> Vec<Rgba> {
    mesh.fills.iter().map(|fill| fill.colour).collect()
}

fn svg(look: &Options, frame: &Frame, title: &str) -> Result<String> {
    let mesh = Renderer::new(&plain(look)?)?.render(frame)?.mesh;
    let plain = colours(&mesh);
    let outlined = outlined(&mesh, &plain, look);
    let lines = Lines::of(&outlined, look, mesh.size);
    let graded = Grade::of(look).graded(&mesh, &plain);
    Ok(to_svg(&mesh, &graded, &SvgOptions { title, lines: &lines, ..SvgOptions::default() }))
}
