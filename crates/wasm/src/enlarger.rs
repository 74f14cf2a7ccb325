//! Pictures larger than their source, drawn from the mesh.

use polyreel_core::unstable::rasterise::{Painter, stretch};
use polyreel_core::{Renderer, Size};
use wasm_bindgen::prelude::*;

use crate::error::{Error, Result};
use crate::frame;
use crate::look::Look;
use crate::still::{colours, plain};

/// The same longest side as the program's.
const MOST: u32 = polyreel_core::MAX_SIDE;

/// Renders one frame after another at a multiple of its size: crisp, with the bytes of the program's `--scale`.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Enlarger {
    renderer: Renderer,
    painter: Painter,
    times: u32,
}

#[wasm_bindgen]
impl Enlarger {
    /// For pictures `times` as wide and as high, 1 or more.
    ///
    /// # Errors
    /// When the look has gradients.
    #[wasm_bindgen(constructor)]
    pub fn new(look: &Look, times: u32) -> std::result::Result<Self, JsError> {
        Ok(Self::of(look, times)?)
    }

    /// The next frame as low-poly art, `times` as large.
    ///
    /// # Errors
    /// When a size is wrong, or the frame cannot be rendered.
    pub fn render(
        &mut self,
        rgba: &[u8],
        width: u32,
        height: u32,
    ) -> std::result::Result<Vec<u8>, JsError> {
        Ok(self.next(rgba, width, height)?)
    }
}

impl Enlarger {
    fn of(look: &Look, times: u32) -> Result<Self> {
        let renderer = Renderer::new(&plain(&look.options)?)?;
        let painter = Painter::new(&look.options.enlarged(f64::from(times)));
        Ok(Self { renderer, painter, times })
    }

    fn next(&mut self, rgba: &[u8], width: u32, height: u32) -> Result<Vec<u8>> {
        let [wide, high] = [width, height].map(|side| side.saturating_mul(self.times));
        if wide > MOST || high > MOST {
            return Err(Error::file(format!(
                "{wide} × {high} is larger than {MOST} pixels a side. Choose a smaller size."
            )));
        }
        let mut mesh = self.renderer.render(&frame::frame(rgba, width, height)?)?.mesh;
        let mut colours = colours(&mesh);
        stretch(&mut mesh, &mut colours, Size::new(wide, high));
        Ok(frame::bytes(self.painter.paint_known(&mesh, &colours).frame))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_larger_and_of_the_same_colours() {
        let look = Look::of(r#"{"points": "40", "edges": "hard"}"#).expect("sound");
        let mut enlarger = Enlarger::of(&look, 3).expect("sound");
        let picture: Vec<u8> = (0..64 * 48 * 4).map(|i| (i * 7 % 251) as u8 | 3).collect();
        let large = enlarger.next(&picture, 64, 48).expect("renders");
        assert_eq!(large.len(), 9 * picture.len());
        let colours = |bytes: &[u8]| {
            let mut all = bytes.as_chunks::<4>().0.to_vec();
            all.sort_unstable();
            all.dedup();
            all
        };
        let small = Enlarger::of(&look, 1).expect("sound").next(&picture, 64, 48).expect("renders");
        // Small facets may have no pixel of the small one.
        let (small, large) = (colours(&small), colours(&large));
        assert!(small.iter().all(|colour| large.binary_search(colour).is_ok()));
        assert!(Enlarger::of(&look, 1000).expect("sound").next(&picture, 64, 48).is_err());
    }
}
