//! The Voronoi diagram of the triangles' centres as a mesh: each cell a fan of triangles around its centre.
//!
//! The centres of triangles, not the seeds: a contour runs along edges, so that a triangle lies on one side of it, where
//! seeds lie on it. There are as many cells as triangles.

use std::collections::HashMap;

use crate::geom::{Point, SUBPIXEL, Size, orient};
use crate::mesh::{CORNERS, DERIVED, Mesh};
use crate::triangulate::delaunay;

/// Centres that are closer together than this, in 1/256 pixel, share a cell.
const CLOSEST: i32 = 2 * SUBPIXEL;

/// How far the points that close the outermost cells lie from the frame, in longer sides of it.
const FAR: f64 = 8.0;

/// Times that centres are left out whose cells have no room on the grid of 1/256 pixel.
const TRIES: usize = 8;

/// A triangle at a centre: from which neighbour to which it goes, and the middle of its circle.
type Wedge = (u32, u32, (f64, f64));

/// A centre: its place and what it is known by.
type Site = (Point, u64);

/// The cells of the centres of the triangles of `mesh`. Vertices that are corners of cells have ids from [`DERIVED`] on;
/// those of the centres follow from the triangles', below that. `mesh` itself where its triangles have no room for cells.
pub(crate) fn cells(mesh: &Mesh) -> Mesh {
    let mut sites = sites(mesh);
    for _ in 0..TRIES {
        match diagram(mesh.size, &sites) {
            Ok(cells) => return cells,
            Err(wrong) => {
                let mut wrong = wrong.into_iter().peekable();
                let mut number = 0;
                sites.retain(|_| {
                    number += 1;
                    wrong.next_if(|&w| w + 1 == number).is_none()
                });
            }
        }
    }
    mesh.clone()
}

/// The centres of the triangles, without those too close to one before.
fn sites(mesh: &Mesh) -> Vec<Site> {
    let mut taken: HashMap<(i32, i32), Vec<Point>> = HashMap::new();
    let mut sites = Vec::with_capacity(mesh.triangles.len());
    for (t, ids) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.triangle(t);
        let centre = Point::new((a.x + b.x + c.x) / 3, (a.y + b.y + c.y) / 3);
        let far = mesh.size.far();
        let inside = |v: i32, far: i32| (CLOSEST / 2..=far - CLOSEST / 2).contains(&v);
        let (i, j) = (centre.x / CLOSEST, centre.y / CLOSEST);
        let near = |p: &Point| {
            let (dx, dy) = (i64::from(p.x - centre.x), i64::from(p.y - centre.y));
            dx * dx + dy * dy < i64::from(CLOSEST).pow(2)
        };
        let mut around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (i + dx, j + dy)));
        let crowded = around.any(|cell| taken.get(&cell).is_some_and(|p| p.iter().any(near)));
        if !crowded && inside(centre.x, far.x) && inside(centre.y, far.y) {
            taken.entry((i, j)).or_default().push(centre);
            sites.push((centre, name(ids.map(|v| mesh.ids[v as usize]))));
        }
    }
    sites
}

/// A number for what belongs to three vertices with lasting numbers, below [`DERIVED`].
fn name(mut ids: [u64; 3]) -> u64 {
    ids.sort_unstable();
    ids.iter().fold(0, |sum, &id| crate::chance::mix(sum ^ id)) & (DERIVED - 1)
}

/// The diagram of `sites`, or the numbers, ascending, of those whose cells are none.
fn diagram(size: Size, sites: &[Site]) -> Result<Mesh, Vec<usize>> {
    let cells = polygons(size, sites);
    let mut vertices = Mesh::corners(size).to_vec();
    let mut ids: Vec<u64> = (0..CORNERS as u64).collect();
    vertices.extend(sites.iter().map(|site| site.0));
    ids.extend(sites.iter().map(|site| site.1));
    let corners = Mesh::corners(size).into_iter().zip(0..);
    let mut numbers: HashMap<Point, u32> = corners.collect();
    let (mut triangles, mut wrong) = (Vec::new(), Vec::new());
    for (site, polygon) in cells.iter().enumerate() {
        let centre = (CORNERS + site) as u32;
        let mut ring: Vec<u32> = Vec::with_capacity(polygon.len());
        for &point in polygon {
            let number = *numbers.entry(point).or_insert_with(|| {
                vertices.push(point);
                let place = (u64::from(point.x as u32) << 31) | u64::from(point.y as u32);
                ids.push(DERIVED | place);
                vertices.len() as u32 - 1
            });
            if ring.last() != Some(&number) {
                ring.push(number);
            }
        }
        if ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        let place = |v: u32| vertices[v as usize];
        let turn = |i: usize| (ring[i], ring[(i + 1) % ring.len()]);
        let sound = ring.len() > 2
            && (0..ring.len()).all(|i| {
                let (from, to) = turn(i);
                orient(place(centre), place(from), place(to)) > 0
            });
        if !sound {
            wrong.push(site);
            continue;
        }
        triangles.extend((0..ring.len()).map(|i| [centre, turn(i).0, turn(i).1]));
    }
    if !wrong.is_empty() || sites.is_empty() {
        return Err(wrong);
    }
    Mesh::canonicalise(&mut triangles);
    let mut mesh = Mesh::new(size, vertices, triangles);
    mesh.ids = ids;
    Ok(mesh)
}

/// The cell of each site within the frame, its corners in their turn. Cells that share an edge have the same points
/// for it: both are computed from the same numbers in the same order.
fn polygons(size: Size, sites: &[Site]) -> Vec<Vec<Point>> {
    let far = size.far();
    let (width, height) = (f64::from(far.x), f64::from(far.y));
    let reach = FAR * width.max(height);
    // A diamond: no four of its corners and the frame's lie on a line.
    let ghosts = [
        (-reach, height / 2.0),
        (width + reach, height / 2.0),
        (width / 2.0, -reach),
        (width / 2.0, height + reach),
    ];
    let centres = sites.iter().map(|(p, _)| (f64::from(p.x), f64::from(p.y)));
    let places: Vec<(f64, f64)> = centres.chain(ghosts).collect();
    let (_, triangles) = delaunay(places.iter().copied());
    // For each site the triangles around it: from which neighbour to which, and the middle of the circle.
    let mut around: Vec<Vec<Wedge>> = vec![Vec::new(); sites.len()];
    for &[a, b, c] in &triangles {
        let middle = circumcentre([a, b, c].map(|v| places[v as usize]));
        for (site, from, to) in [(a, b, c), (b, c, a), (c, a, b)] {
            if let Some(around) = around.get_mut(site as usize) {
                around.push((from, to, middle));
            }
        }
    }
    around.iter().map(|wedges| snapped(&clipped(ring(wedges), (width, height)))).collect()
}

/// The middles in the order of their triangles.
fn ring(wedges: &[Wedge]) -> Vec<(f64, f64)> {
    let Some(&(first, mut next, middle)) = wedges.first() else { return Vec::new() };
    let mut ring = vec![middle];
    while next != first && ring.len() <= wedges.len() {
        let Some(&(_, to, middle)) = wedges.iter().find(|wedge| wedge.0 == next) else { break };
        ring.push(middle);
        next = to;
    }
    ring
}

fn circumcentre([a, b, c]: [(f64, f64); 3]) -> (f64, f64) {
    let (bx, by) = (b.0 - a.0, b.1 - a.1);
    let (cx, cy) = (c.0 - a.0, c.1 - a.1);
    let doubled = 2.0 * (bx * cy - by * cx);
    let (b2, c2) = (bx * bx + by * by, cx * cx + cy * cy);
    (a.0 + (cy * b2 - by * c2) / doubled, a.1 + (bx * c2 - cx * b2) / doubled)
}

/// The polygon's part inside the frame (Sutherland and Hodgman, 1974).
fn clipped(mut polygon: Vec<(f64, f64)>, (width, height): (f64, f64)) -> Vec<(f64, f64)> {
    // Of each side: which coordinate, where, and whether the inside lies above it.
    for (axis, bound, above) in
        [(0, 0.0, true), (0, width, false), (1, 0.0, true), (1, height, false)]
    {
        let coordinate = |p: (f64, f64)| if axis == 0 { p.0 } else { p.1 };
        let inside = |p: (f64, f64)| {
            if above { coordinate(p) >= bound } else { coordinate(p) <= bound }
        };
        let mut out = Vec::with_capacity(polygon.len() + 2);
        for (i, &to) in polygon.iter().enumerate() {
            let from = polygon[(i + polygon.len() - 1) % polygon.len()];
            if inside(from) != inside(to) {
                out.push(crossing(from, to, axis, bound));
            }
            if inside(to) {
                out.push(to);
            }
        }
        polygon = out;
    }
    polygon
}

/// Where the line between two points meets a side; the same for either order of them.
fn crossing(p: (f64, f64), q: (f64, f64), axis: usize, bound: f64) -> (f64, f64) {
    let (p, q) = if p < q { (p, q) } else { (q, p) };
    if axis == 0 {
        (bound, p.1 + (bound - p.0) / (q.0 - p.0) * (q.1 - p.1))
    } else {
        (p.0 + (bound - p.1) / (q.1 - p.1) * (q.0 - p.0), bound)
    }
}

fn snapped(polygon: &[(f64, f64)]) -> Vec<Point> {
    polygon.iter().map(|&(x, y)| Point::new(x.round() as i32, y.round() as i32)).collect()
}

/// For each triangle of a mesh of cells the number of its cell's centre.
pub(crate) fn centres(mesh: &Mesh) -> Vec<u32> {
    let is_centre = |v: u32| v as usize >= CORNERS && mesh.ids[v as usize] < DERIVED;
    let centre = |ids: &[u32; 3]| ids.iter().copied().find(|&v| is_centre(v)).unwrap_or(ids[0]);
    mesh.triangles.iter().map(centre).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan;
    use crate::triangulate::tests::mesh_of;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn cells_cover_the_frame_and_each_has_the_pixels_nearest_to_its_centre(
            (width, height) in (1u32..90, 1u32..70),
            seeds in proptest::collection::vec((0.0..=1.0, 0.0..=1.0), 0..60),
            snap in prop_oneof![Just(1), Just(SUBPIXEL / 2), Just(4 * SUBPIXEL)],
        ) {
            let mesh = mesh_of(Size::new(width, height), &seeds, snap);
            let cells = cells(&mesh);
            prop_assert_eq!(cells.check(), Ok(()));
            if cells == mesh {
                return Ok(());
            }
            let centres = centres(&cells);
            let mut sites = centres.clone();
            sites.sort_unstable();
            sites.dedup();
            for (t, &centre) in centres.iter().enumerate() {
                scan::spans(cells.triangle(t), 0..height, |y, columns| for x in columns {
                    let distance = |v: u32| {
                        let (p, q) = (cells.vertices[v as usize], Point::pixel_centre(x as u32, y));
                        f64::from(p.x - q.x).hypot(f64::from(p.y - q.y))
                    };
                    let least = sites.iter().map(|&v| distance(v)).fold(f64::INFINITY, f64::min);
                    // Corners of cells lie on the grid.
                    assert!(distance(centre) <= least + 3.0, "({x}, {y})");
                });
            }
        }
    }
}
