//! One stream of frames.

use polyreel_core::unstable::options::{Detail, Steps};
use polyreel_core::{Mesh, Renderer};
use wasm_bindgen::prelude::*;

use crate::error::Result;
use crate::frame;
use crate::look::Look;

/// Renders a stream of frames, each of which goes on from the one before.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Engine {
    renderer: Renderer,
    mesh: Option<Mesh>,
    cut: bool,
}

#[wasm_bindgen]
impl Engine {
    /// An engine for one stream.
    ///
    /// # Errors
    /// When options do not fit together.
    #[wasm_bindgen(constructor)]
    pub fn new(look: &Look) -> std::result::Result<Self, JsError> {
        Ok(Self::of(look)?)
    }

    /// Changes the look from the next frame on.
    ///
    /// # Errors
    /// When options do not fit together; nothing is changed then.
    pub fn retune(&mut self, look: &Look) -> std::result::Result<(), JsError> {
        Ok(self.renderer.retune(&look.options).map_err(crate::error::Error::from)?)
    }

    /// Forgets all frames.
    pub fn reset(&mut self) {
        self.renderer.reset();
        self.mesh = None;
    }

    /// The next frame as low-poly art, of the same size.
    ///
    /// # Errors
    /// When the frame's size is wrong, or it cannot be rendered.
    pub fn render(
        &mut self,
        rgba: &[u8],
        width: u32,
        height: u32,
    ) -> std::result::Result<Vec<u8>, JsError> {
        Ok(self.next(rgba, width, height, &Detail::FULL)?)
    }

    /// The same for a frame that is only looked at: with `eighths` of a step of refinement, where time is short.
    ///
    /// # Errors
    /// As [`Engine::render`].
    #[wasm_bindgen(js_name = renderBriefly)]
    pub fn render_briefly(
        &mut self,
        rgba: &[u8],
        width: u32,
        height: u32,
        eighths: u32,
    ) -> std::result::Result<Vec<u8>, JsError> {
        let steps = Some(Steps::from_eighths(eighths));
        Ok(self.next(rgba, width, height, &Detail { steps, ..Detail::FULL })?)
    }

    /// Points of the last frame; of a Voronoi diagram its cells.
    #[wasm_bindgen(getter)]
    pub fn points(&self) -> usize {
        self.mesh.as_ref().map_or(0, |mesh| mesh.seed_ids().count())
    }

    /// Triangles of the last frame.
    #[wasm_bindgen(getter)]
    pub fn triangles(&self) -> usize {
        self.mesh.as_ref().map_or(0, |mesh| mesh.triangles.len())
    }

    /// Whether the last frame began afresh.
    #[wasm_bindgen(getter)]
    pub fn cut(&self) -> bool {
        self.cut
    }
}

impl Engine {
    pub(crate) fn of(look: &Look) -> Result<Self> {
        Ok(Self { renderer: Renderer::new(&look.options)?, mesh: None, cut: true })
    }

    fn next(&mut self, rgba: &[u8], width: u32, height: u32, detail: &Detail) -> Result<Vec<u8>> {
        let rendered = self.renderer.render_in(&frame::frame(rgba, width, height)?, detail)?;
        self.cut = rendered.life.cut;
        self.mesh = Some(rendered.mesh);
        Ok(frame::bytes(rendered.picture))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_go_in_and_pictures_come_out() {
        let mut engine =
            Engine::of(&Look::of(r#"{"points": "40"}"#).expect("sound")).expect("sound");
        let picture: Vec<u8> = (0..64 * 48 * 4).map(|i| (i * 7 % 251) as u8 | 3).collect();
        let first = engine.next(&picture, 64, 48, &Detail::FULL).expect("renders");
        assert_eq!(first.len(), picture.len());
        assert_eq!(engine.points(), 40);
        engine.reset();
        assert_eq!(engine.next(&picture, 64, 48, &Detail::FULL).expect("renders"), first);
        let steps = Some(Steps::from_eighths(2));
        let brief = Detail { steps, ..Detail::FULL };
        assert_eq!(engine.next(&picture, 64, 48, &brief).expect("renders").len(), first.len());
        assert!(engine.next(&picture, 64, 47, &Detail::FULL).is_err());
        assert!(engine.next(&picture[1..], 64, 48, &Detail::FULL).is_err());
    }
}
