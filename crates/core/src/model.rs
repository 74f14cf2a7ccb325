//! A mesh as a 3-D model of one file: OBJ or PLY, as Blender, MeshLab and others read them.
//!
//! One unit is a pixel; y points up, the frame's lower left corner is the origin, faces look towards z. Both formats
//! have colours of vertices, not of faces, that all programs read: each triangle has three vertices of its own.

use std::fmt::Write as _;

use crate::frame::Rgba;
use crate::mesh::Mesh;

/// `mesh` as OBJ, its triangles in `colours`, one each and in their order: vertices with sRGB colours from 0 to 1. What
/// has alpha 0 is left out; other alpha is not written.
///
/// # Panics
/// When there are not as many colours as triangles.
pub fn to_obj(mesh: &Mesh, colours: &[Rgba]) -> String {
    let mut text = "# low-poly by polyreel; a unit is a pixel\no LowPoly\n".to_owned();
    let faces = faces(mesh, colours);
    for (corners, [r, g, b, _]) in &faces {
        let [r, g, b] = [r, g, b].map(|c| f64::from(*c) / 255.0);
        for (x, y) in corners {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "v {x} {y} 0 {r:.4} {g:.4} {b:.4}");
        }
    }
    for face in 0..faces.len() {
        let first = 3 * face + 1;
        let _ = writeln!(text, "f {first} {} {}", first + 1, first + 2);
    }
    text
}

/// `mesh` as binary PLY, its triangles in `colours`, one each and in their order: vertices with sRGB colours and alpha
/// of 8 bits. What has alpha 0 is left out.
///
/// # Panics
/// When there are not as many colours as triangles.
pub fn to_ply(mesh: &Mesh, colours: &[Rgba]) -> Vec<u8> {
    let faces = faces(mesh, colours);
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment low-poly by polyreel; a unit is a pixel\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        3 * faces.len(),
        faces.len()
    )
    .into_bytes();
    for (corners, colour) in &faces {
        for (x, y) in corners {
            [*x as f32, *y as f32, 0.0].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
            bytes.extend(colour);
        }
    }
    for first in (0..3 * faces.len() as u32).step_by(3) {
        bytes.push(3);
        (first..first + 3).for_each(|v| bytes.extend(v.to_le_bytes()));
    }
    bytes
}

/// The triangles that are seen, anticlockwise with y up, in pixels, with their colours.
fn faces(mesh: &Mesh, colours: &[Rgba]) -> Vec<([(f64, f64); 3], Rgba)> {
    assert_eq!(colours.len(), mesh.triangles.len(), "a colour a triangle");
    let height = f64::from(mesh.size.height);
    let seen = colours.iter().enumerate().filter(|(_, colour)| colour[3] > 0);
    seen.map(|(t, &colour)| {
        // On a screen y points down: with y up the turn is the other one.
        let [a, b, c] = mesh.triangle(t).map(|p| {
            let (x, y) = p.to_pixels();
            (x, height - y)
        });
        ([a, c, b], colour)
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;
    use crate::triangulate::triangulate;

    #[test]
    fn what_is_seen_has_its_colour_and_faces_the_viewer() {
        let mesh = triangulate(Size::new(4, 2), &[]).expect("corners");
        let colours = [[255, 0, 51, 255], [0, 128, 0, 0]];
        let obj = to_obj(&mesh, &colours);
        assert_eq!(obj.lines().filter(|line| line.starts_with("v ")).count(), 3);
        assert!(obj.contains(" 0 1.0000 0.0000 0.2000\n") && obj.ends_with("f 1 2 3\n"), "{obj}");
        for ([(ax, ay), (bx, by), (cx, cy)], _) in faces(&mesh, &[[9; 4]; 2]) {
            assert!((bx - ax) * (cy - ay) - (by - ay) * (cx - ax) > 0.0);
        }
        let ply = to_ply(&mesh, &colours);
        let body = ply.windows(11).position(|w| w == b"end_header\n").expect("a header") + 11;
        assert_eq!(ply.len() - body, 3 * 16 + 13);
        assert_eq!(ply[body + 12..body + 16], [255, 0, 51, 255]);
    }
}
