//! One picture file to another.
//!
//! ```sh
//! cargo run --release --example still -- samples/lake.jpg lake.png
//! ```

#![allow(
    clippy::field_reassign_with_default,
    reason = "Options is non_exhaustive in other packages"
)]

use std::error::Error;

use polyreel::{Frame, Options, Points, Renderer};

fn main() -> Result<(), Box<dyn Error>> {
    let mut names = std::env::args().skip(1);
    let (Some(input), Some(output)) = (names.next(), names.next()) else {
        return Err("name an input and an output".into());
    };
    let frame = Frame::from_image(image::open(input)?.into_rgba8())?;
    let mut options = Options::default();
    options.points = Points::Count(1500);
    let rendered = Renderer::new(&options)?.render(&frame)?;
    rendered.picture.into_image().save(output)?;
    Ok(())
}
