//! Meshes as USD text (`.usda`): one mesh whose points, faces and colours change from sample to sample, as Blender,
//! Houdini and usdview read them.
//!
//! One unit is a pixel, and [`METRES_PER_UNIT`] says how large that is; y points up, the frame's lower left corner is
//! the origin, faces look towards z. Colours are linear, as `displayColor` has to be.

use std::fmt::Write as _;

use crate::frame::Rgba;
use crate::geom::Point;
use crate::mesh::Mesh;

/// Metres of a unit, which is a pixel.
pub const METRES_PER_UNIT: f64 = 0.01;

/// The attributes that change, in the order in which they are written.
pub const ATTRIBUTES: [&str; 5] = [
    "point3f[] points",
    "int[] faceVertexCounts",
    "int[] faceVertexIndices",
    "color3f[] primvars:displayColor",
    "float[] primvars:displayOpacity",
];

/// A frame's sample of each of [`ATTRIBUTES`] at the time `code`; `mesh` has its triangles in `colours`, one each and
/// in their order.
pub fn samples(mesh: &Mesh, colours: &[Rgba], code: f64) -> [String; 5] {
    let height = f64::from(mesh.size.height);
    let point = |text: &mut String, p: &Point| {
        let (x, y) = p.to_pixels();
        let _ = write!(text, "({x}, {}, 0)", height - y);
    };
    let index = |text: &mut String, [a, b, c]: &[u32; 3]| {
        // On a screen y points down: with y up the turn is the other one.
        let _ = write!(text, "{a}, {c}, {b}");
    };
    let colour = |text: &mut String, c: &Rgba| {
        let [r, g, b] = [c[0], c[1], c[2]].map(linear);
        let _ = write!(text, "({r:.5}, {g:.5}, {b:.5})");
    };
    let opacity = |text: &mut String, c: &Rgba| {
        let _ = write!(text, "{:.4}", f64::from(c[3]) / 255.0);
    };
    [
        sample(code, &mesh.vertices, point),
        sample(code, &mesh.triangles, |text, _| text.push('3')),
        sample(code, &mesh.triangles, index),
        sample(code, colours, colour),
        sample(code, colours, opacity),
    ]
}

fn sample<T>(code: f64, items: &[T], write: impl Fn(&mut String, &T)) -> String {
    let mut text = format!("        {code}: [");
    for (i, item) in items.iter().enumerate() {
        if i > 0 {
            text.push_str(", ");
        }
        write(&mut text, item);
    }
    text.push_str("],\n");
    text
}

/// sRGB to linear, 0 to 1 (IEC 61966-2-1).
fn linear(code: u8) -> f64 {
    let v = f64::from(code) / 255.0;
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// What a file says before its samples: frames a second, and the times of its first and its last frame.
pub fn head(rate: f64, first: f64, last: f64) -> String {
    format!(
        "#usda 1.0\n(\n    defaultPrim = \"LowPoly\"\n    doc = \"low-poly by polyreel; a unit is a pixel\"\n    \
         startTimeCode = {first}\n    endTimeCode = {last}\n    timeCodesPerSecond = {rate}\n    \
         framesPerSecond = {rate}\n    metersPerUnit = {METRES_PER_UNIT}\n    upAxis = \"Y\"\n)\n\n\
         def Mesh \"LowPoly\"\n{{\n    uniform token subdivisionScheme = \"none\"\n    \
         uniform bool doubleSided = 1\n"
    )
}

/// What stands before the samples of [`ATTRIBUTES`]`[attribute]`.
pub fn before(attribute: usize) -> String {
    format!("    {}.timeSamples = {{\n", ATTRIBUTES[attribute])
}

/// What stands after them.
pub fn after(attribute: usize) -> String {
    let name = ATTRIBUTES[attribute];
    // Colours are those of faces, not of points.
    if name.contains("primvars:") {
        format!("    }}\n    {name} (\n        interpolation = \"uniform\"\n    )\n")
    } else {
        "    }\n".to_owned()
    }
}

/// What stands at the end.
pub const END: &str = "}\n";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;
    use crate::triangulate::triangulate;

    #[test]
    fn y_points_up_and_faces_look_towards_z() {
        let mesh = triangulate(Size::new(4, 2), &[]).expect("corners");
        let [points, counts, indices, colours, _] =
            samples(&mesh, &[[255, 0, 0, 255], [0, 128, 0, 255]], 3.0);
        assert_eq!(points.trim(), "3: [(0, 2, 0), (4, 2, 0), (0, 0, 0), (4, 0, 0)],");
        assert_eq!(counts.trim(), "3: [3, 3],");
        assert!(colours.contains("(1.00000, 0.00000, 0.00000), (0.00000, 0.21586, 0.00000)"));
        let at = [(0, 2), (4, 2), (0, 0), (4, 0)];
        let list = indices.trim().trim_start_matches("3: [").trim_end_matches("],");
        let ids: Vec<usize> = list.split(", ").map(|n| n.parse().expect("a number")).collect();
        for face in ids.chunks(3) {
            let [(ax, ay), (bx, by), (cx, cy)] = [face[0], face[1], face[2]].map(|v| at[v]);
            let turn = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
            assert!(turn > 0, "anticlockwise as seen from z");
        }
    }
}
