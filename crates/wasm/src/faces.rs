//! Where faces are.

use polyreel_faces::Detector;
use wasm_bindgen::prelude::*;

use crate::error::Result;
use crate::frame;

/// The least certainty of a face.
const CERTAIN: f32 = 0.6;

/// The faces in a picture, the most certain first: of each its left side, top, width and height, in pixels.
///
/// # Errors
/// When the size is wrong.
#[wasm_bindgen(js_name = findFaces)]
pub fn find_faces(rgba: &[u8], width: u32, height: u32) -> std::result::Result<Vec<f32>, JsError> {
    Ok(found(rgba, width, height)?)
}

fn found(rgba: &[u8], width: u32, height: u32) -> Result<Vec<f32>> {
    let frame = frame::frame(rgba, width, height)?;
    let faces = Detector::new().find(frame.pixels(), width as usize, height as usize, CERTAIN);
    Ok(faces.iter().flat_map(|face| [face.left, face.top, face.width, face.height]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grey_picture_has_no_faces_and_a_wrong_size_is_refused() {
        assert!(found(&[128; 64 * 48 * 4], 64, 48).expect("a sound size").is_empty());
        assert!(found(&[128; 64], 64, 48).is_err());
    }
}
