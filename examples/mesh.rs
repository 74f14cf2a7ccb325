//! The mesh of a picture as a Wavefront OBJ file with a colour for each vertex of each triangle.
//!
//! ```sh
//! cargo run --release --example mesh -- samples/lake.jpg > lake.obj
//! ```

#![allow(
    clippy::field_reassign_with_default,
    reason = "Options is non_exhaustive in other packages"
)]

use std::error::Error;
use std::io::Write;

use polyreel::{Frame, Options, Points, Renderer};

fn main() -> Result<(), Box<dyn Error>> {
    let input = std::env::args().nth(1).ok_or("name a picture")?;
    let frame = Frame::from_image(image::open(input)?.into_rgba8())?;
    let mut options = Options::default();
    options.points = Points::Count(500);
    let mesh = Renderer::new(&options)?.render(&frame)?.mesh;

    let mut out = std::io::stdout().lock();
    for (triangle, fill) in mesh.triangles.iter().zip(&mesh.fills) {
        let [r, g, b, _] = fill.colour.map(|channel| f32::from(channel) / 255.0);
        for v in triangle {
            let (x, y) = mesh.vertices[*v as usize].to_pixels();
            writeln!(out, "v {x} {} 0 {r} {g} {b}", f64::from(mesh.size.height) - y)?;
        }
    }
    for first in (1..).step_by(3).take(mesh.triangles.len()) {
        // Upwards y turns the triangles over.
        writeln!(out, "f {first} {} {}", first + 2, first + 1)?;
    }
    Ok(())
}
