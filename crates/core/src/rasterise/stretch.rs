//! Meshes at another size.

use crate::frame::Rgba;
use crate::geom::{Point, Size, orient};
use crate::mesh::Mesh;

/// Stretches `mesh` to `size`. Triangles that lose their area are removed, with their colours.
pub fn stretch(mesh: &mut Mesh, colours: &mut Vec<Rgba>, size: Size) {
    if mesh.size == size {
        return;
    }
    let (from, to) = (mesh.size.far(), size.far());
    let stretched = |v: i32, from: i32, to: i32| {
        ((2 * i64::from(v) * i64::from(to) + i64::from(from)) / (2 * i64::from(from))) as i32
    };
    for p in &mut mesh.vertices {
        *p = Point::new(stretched(p.x, from.x, to.x), stretched(p.y, from.y, to.y));
    }
    mesh.size = size;
    let kept = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
        orient(a, b, c) > 0
    };
    let keep: Vec<bool> = mesh.triangles.iter().map(kept).collect();
    let mut flags = keep.iter();
    colours.retain(|_| flags.next().is_some_and(|&keep| keep));
    let mut flags = keep.iter();
    mesh.triangles.retain(|_| flags.next().is_some_and(|&keep| keep));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Options;
    use crate::rasterise::Painter;
    use crate::triangulate::triangulate;

    #[test]
    fn a_stretched_mesh_covers_its_frame() {
        let seeds = [Point::new(700, 900), Point::new(0, 500), Point::new(701, 901)];
        for (width, height) in [(40, 30), (17, 13), (5, 3), (10, 7)] {
            let mut mesh = triangulate(Size::new(10, 7), &seeds).expect("three seeds");
            let mut colours = vec![[9, 9, 9, 255]; mesh.triangles.len()];
            stretch(&mut mesh, &mut colours, Size::new(width, height));
            assert_eq!(colours.len(), mesh.triangles.len());
            let painted = Painter::new(&Options::default()).paint_known(&mesh, &colours).frame;
            assert_eq!(painted.size(), Size::new(width, height));
            assert!(painted.pixels().iter().all(|&pixel| pixel == [9, 9, 9, 255]));
        }
    }
}
