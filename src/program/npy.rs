//! Exact floats for other programs: numpy's `.npy`, version 1.0 (numpy, "NPY format", NEP 1).

use std::path::Path;

use polyreel::error::Result;
use polyreel::plane::Plane;

use crate::program::record;

/// Writes `plane` as an array of shape (height, width) of little-endian 32-bit floats.
pub(crate) fn write(path: &Path, plane: &Plane<f32>, overwrite: bool) -> Result<()> {
    record::put(path, &encoded(plane), overwrite)
}

fn encoded(plane: &Plane<f32>) -> Vec<u8> {
    let size = plane.size();
    let mut header = format!(
        "{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}), }}",
        size.height, size.width
    );
    // Magic, version and length take 10 bytes; the data begins at a multiple of 64, after a line's end.
    let blank = 63 - (10 + header.len()) % 64;
    header.extend(std::iter::repeat_n(' ', blank));
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(plane.values().iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use polyreel::geom::Size;

    #[test]
    fn the_header_is_as_numpy_has_it() {
        let plane = Plane::new(Size::new(3, 2), vec![0.0, 1.5, -2.0, 3.0, 4.0, 5.0]);
        let bytes = encoded(&plane.expect("six values"));
        assert_eq!(bytes.len(), 128 + 24);
        assert_eq!(&bytes[..10], b"\x93NUMPY\x01\x00\x76\x00");
        assert_eq!(bytes[127], b'\n');
        let text = String::from_utf8_lossy(&bytes[10..127]);
        assert!(text.contains("'shape': (2, 3)"), "{text}");
        assert_eq!(&bytes[132..136], 1.5f32.to_le_bytes());
    }
}
