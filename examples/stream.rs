//! Frames of any origin, one after the other: the mesh lives on between them.
//!
//! ```sh
//! cargo run --release --example stream
//! ```

#![allow(
    clippy::field_reassign_with_default,
    reason = "Options is non_exhaustive in other packages"
)]

use polyreel::{Frame, Options, Points, Renderer, Result, Size};

const SIZE: Size = Size::new(320, 200);

/// A disc that moves to the right.
fn frame(t: u32) -> Result<Frame> {
    let pixels = (0..SIZE.pixels() as u32).map(|i| {
        let (x, y) = (i % SIZE.width, i / SIZE.width);
        let is_disc = x.abs_diff(60 + 8 * t).pow(2) + y.abs_diff(100).pow(2) < 1600;
        if is_disc { [230, 180, 40, 255] } else { [20, (y / 2) as u8, 90, 255] }
    });
    Ok(Frame::new(SIZE, pixels.collect())?)
}

fn main() -> Result<()> {
    let mut options = Options::default();
    options.points = Points::Count(400);
    let mut renderer = Renderer::new(&options)?;
    for t in 0..10 {
        let rendered = renderer.render(&frame(t)?)?;
        let life = rendered.life;
        println!("frame {t}: {} seeds kept, {} moved, {} born", life.kept, life.moved, life.born);
    }
    Ok(())
}
