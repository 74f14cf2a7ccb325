//! A mesh with its colours as few bytes: the size in Table 3.
//!
//! The layout: width, height, number of seeds, whether colours have alpha, whether triangles are
//! listed; the seeds, row by row, as steps from one pixel to the next and the place inside the pixel in
//! 1/256; the colours of the triangles in their canonical order, each as its difference from the mean
//! of the neighbours told before it. All of it passes through an adaptive range coder. The triangles
//! themselves are **not** stored where the Delaunay triangulation of the seeds, taken in their stored
//! order, gives them back, which it nearly always does; else they are listed. Nothing is lost: the
//! picture that a decoder paints is the rendering, pixel by pixel (without outlines).

use super::range_coder::{Bits, Byte, Encoder, Number};
use polyreel::error::Result;
use polyreel::frame::{Fill, Rgba};
use polyreel::geom::{Point, SUBPIXEL};
use polyreel::mesh::{CORNERS, Mesh};
use polyreel::triangulate::triangulate;

/// The bytes that stand for `mesh`, its triangles filled with `fills`, one each and in their order.
///
/// # Errors
/// When two vertices are equal.
pub(crate) fn pack(mesh: &Mesh, fills: &[Fill]) -> Result<Vec<u8>> {
    let (seeds, triangles) = ordered(mesh);
    let by_delaunay = triangulate(mesh.size, &seeds)?;
    let mut sorted: Vec<_> =
        triangles.iter().copied().zip(fills.iter().map(|fill| fill.colour)).collect();
    sorted.sort_unstable_by_key(|(triangle, _)| *triangle);
    let listed: Vec<[u32; 3]> = sorted.iter().map(|(triangle, _)| *triangle).collect();
    let mut colours: Vec<Rgba> = sorted.iter().map(|(_, colour)| *colour).collect();

    let mut bits = Encoder::new();
    let mut number = Number::default();
    let alpha = colours.iter().any(|colour| colour[3] < 255);
    let told = by_delaunay.triangles != listed;
    let head = [
        mesh.size.width,
        mesh.size.height,
        seeds.len() as u32,
        u32::from(alpha),
        u32::from(told),
        listed.len() as u32,
    ];
    for value in head {
        number.pass(&mut bits, value);
    }
    let mut seeds = seeds;
    pass_seeds(&mut bits, &mut seeds);
    let mut listed = listed;
    if told {
        pass_triangles(&mut bits, &mut listed);
    }
    pass_colours(&mut bits, &listed, &mut colours, alpha);
    Ok(bits.finish())
}

/// The seeds in the order in which they are stored, and the triangles in its numbers, each turned so
/// that its smallest number comes first.
fn ordered(mesh: &Mesh) -> (Vec<Point>, Vec<[u32; 3]>) {
    let mut order: Vec<usize> = (CORNERS..mesh.vertices.len()).collect();
    let row = |p: Point| (p.y.div_euclid(SUBPIXEL), p.x.div_euclid(SUBPIXEL), p.y, p.x);
    order.sort_unstable_by_key(|&v| row(mesh.vertices[v]));
    let mut number: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for (place, &v) in order.iter().enumerate() {
        number[v] = (CORNERS + place) as u32;
    }
    let triangles = mesh.triangles.iter().map(|triangle| {
        let mut t = triangle.map(|v| number[v as usize]);
        let first = (0..3).min_by_key(|&i| t[i]).unwrap_or(0);
        t.rotate_left(first);
        t
    });
    (order.iter().map(|&v| mesh.vertices[v]).collect(), triangles.collect())
}

// Encoder and decoder share what follows: an encoder passes values that are there, a decoder ones that
// are overwritten with what comes out.

fn pass_seeds(bits: &mut impl Bits, seeds: &mut [Point]) {
    let (mut down, mut along, mut across) =
        (Number::default(), Number::default(), Number::default());
    let mut fractions = [(); 2].map(|()| Byte::default());
    let (mut last_x, mut last_y) = (0i32, 0i32);
    for seed in seeds {
        let pixel = |v: i32| v.div_euclid(SUBPIXEL);
        let step = down.pass(bits, (pixel(seed.y) - last_y) as u32) as i32;
        let y = last_y + step;
        let x = if step == 0 {
            last_x + along.pass(bits, (pixel(seed.x) - last_x) as u32) as i32
        } else {
            across.pass(bits, pixel(seed.x) as u32) as i32
        };
        let [fx, fy] = [seed.x, seed.y].map(|v| v.rem_euclid(SUBPIXEL) as u8);
        let fx = fractions[0].pass(bits, fx);
        let fy = fractions[1].pass(bits, fy);
        *seed = Point::new(x * SUBPIXEL + i32::from(fx), y * SUBPIXEL + i32::from(fy));
        (last_x, last_y) = (x, y);
    }
}

fn pass_triangles(bits: &mut impl Bits, triangles: &mut [[u32; 3]]) {
    let (mut first, mut second, mut third) =
        (Number::default(), Number::default(), Number::default());
    let mut last = 0;
    for [a, b, c] in triangles {
        *a = last + first.pass(bits, a.wrapping_sub(last));
        // The first is the smallest; wrapping serves a decoder, whose values are not there yet.
        *b = *a + second.pass(bits, b.wrapping_sub(*a));
        let gap = c.wrapping_sub(*b) as i32;
        let zigzag = third.pass(bits, ((gap << 1) ^ (gap >> 31)) as u32);
        *c = b.wrapping_add((zigzag >> 1) ^ (zigzag & 1).wrapping_neg());
        last = *a;
    }
}

fn pass_colours(bits: &mut impl Bits, triangles: &[[u32; 3]], colours: &mut [Rgba], alpha: bool) {
    let mut channels = [(); 4].map(|()| Byte::default());
    let neighbours = neighbours(triangles);
    for t in 0..triangles.len() {
        let told: Vec<Rgba> = neighbours[t].iter().map(|&n| colours[n as usize]).collect();
        let predicted = match (&told[..], t) {
            ([], 0) => [128; 4],
            ([], t) => colours[t - 1],
            (told, _) => [0, 1, 2, 3].map(|c| {
                let sum: usize = told.iter().map(|colour| usize::from(colour[c])).sum();
                ((sum + told.len() / 2) / told.len()) as u8
            }),
        };
        let difference = |c: usize| colours[t][c].wrapping_sub(predicted[c]);
        // Red and blue change with green: only what they change beyond it is written.
        let green = channels[1].pass(bits, difference(1));
        let red = channels[0].pass(bits, difference(0).wrapping_sub(green)).wrapping_add(green);
        let blue = channels[2].pass(bits, difference(2).wrapping_sub(green)).wrapping_add(green);
        let glass = if alpha { channels[3].pass(bits, difference(3)) } else { 0 };
        let whole = if alpha { predicted[3].wrapping_add(glass) } else { 255 };
        colours[t] = [
            predicted[0].wrapping_add(red),
            predicted[1].wrapping_add(green),
            predicted[2].wrapping_add(blue),
            whole,
        ];
    }
}

/// For each triangle those before it that share an edge with it, in rising order.
fn neighbours(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut edges = Vec::with_capacity(3 * triangles.len());
    for (&[a, b, c], t) in triangles.iter().zip(0u32..) {
        edges.extend([(a, b), (b, c), (c, a)].map(|(a, b)| (a.min(b), a.max(b), t)));
    }
    edges.sort_unstable();
    let mut found = vec![Vec::new(); triangles.len()];
    for pair in edges.windows(2) {
        if (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1) {
            found[pair[1].2 as usize].push(pair[0].2);
        }
    }
    found.iter_mut().for_each(|list| list.sort_unstable());
    found
}

/// What a decoder needs to know first; only tests read it back.
#[cfg(test)]
fn unpack(bytes: &[u8]) -> (Mesh, Vec<Rgba>) {
    let mut bits = super::range_coder::tests::Decoder::new(bytes);
    let mut number = Number::default();
    let [width, height, seeds, alpha, told, triangles] =
        [0; 6].map(|_: u32| number.pass(&mut bits, 0));
    let size = polyreel::geom::Size::new(width, height);
    let mut points = vec![Point::new(0, 0); seeds as usize];
    pass_seeds(&mut bits, &mut points);
    let mut mesh = triangulate(size, &points).expect("distinct seeds");
    if told == 1 {
        mesh.triangles = vec![[0; 3]; triangles as usize];
        pass_triangles(&mut bits, &mut mesh.triangles);
    }
    let mut colours = vec![[0; 4]; triangles as usize];
    pass_colours(&mut bits, &mesh.triangles, &mut colours, alpha == 1);
    (mesh, colours)
}

#[cfg(test)]
mod tests {
    use super::*;
    use polyreel::chance::{Purpose, rank};
    use polyreel::frame::Frame;
    use polyreel::geom::Size;
    use polyreel::options::{Method, Options, Points};
    use polyreel::rasterise::{means, rasterise};
    use polyreel::render::Renderer;

    fn picture(alpha: bool) -> Frame {
        let size = Size::new(160, 120);
        let pixel = |i: u32| {
            let (x, y) = (i % 160, i / 160);
            let grain = (rank(4, Purpose::Noise, x, y) % 40) as u8;
            let a = if alpha { (x as u8).saturating_mul(2) } else { 255 };
            [(x as u8) ^ grain, (y as u8).wrapping_add(grain), 90, a]
        };
        Frame::new(size, (0..size.pixels() as u32).map(pixel).collect()).expect("a picture")
    }

    #[test]
    fn the_decoded_mesh_paints_the_same_picture() {
        for (alpha, points) in [(false, 300), (true, 300), (false, 0), (false, 1)] {
            for method in [Method::Hrlp, Method::Entropy] {
                let frame = picture(alpha);
                let points = Points::Count(points.max(1));
                let options = Options { method, points, ..Options::default() };
                let rendered =
                    Renderer::new(&options).expect("sound").render(&frame).expect("renders");
                let bytes = pack(&rendered.mesh, &rendered.mesh.fills).expect("a sound mesh");
                let (mesh, colours) = unpack(&bytes);
                assert_eq!(mesh.check(), Ok(()));
                let painted = rasterise(&mesh, &frame, options.edges, None);
                assert_eq!(painted.frame, rendered.picture);
                let expected: Vec<_> = means(&mesh, &frame).iter().map(|f| f.colour).collect();
                assert_eq!(colours, expected);
            }
        }
    }

    #[test]
    fn triangles_that_are_not_delaunay_are_listed() {
        let size = Size::new(40, 40);
        let seeds = [Point::from_pixels(10.0, 19.0), Point::from_pixels(30.0, 21.0)];
        let mut mesh = triangulate(size, &seeds).expect("two seeds");
        let fills = vec![Fill { colour: [9, 8, 7, 255], area: 1 }; mesh.triangles.len()];
        let by_rule = pack(&mesh, &fills).expect("a sound mesh").len();
        let pairs = (0..mesh.triangles.len())
            .flat_map(|t| (0..mesh.triangles.len()).map(move |u| (t, u)))
            .filter(|(t, u)| t != u);
        // The first edge that can be turned: its two triangles make a convex quadrilateral.
        let turned = pairs.filter_map(|(t, u)| {
            let (a, b) = (mesh.triangles[t], mesh.triangles[u]);
            let i = (0..3).find(|&i| !b.contains(&a[i]))?;
            let (apex, p, q) = (a[i], a[(i + 1) % 3], a[(i + 2) % 3]);
            let far = *b.iter().find(|v| !a.contains(v))?;
            let new = [[apex, p, far], [apex, far, q]];
            let area = |t: [u32; 3]| {
                let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
                polyreel::geom::orient(a, b, c)
            };
            let shared = b.contains(&p) && b.contains(&q);
            (shared && new.into_iter().all(|t| area(t) > 0)).then_some((t, u, new))
        });
        let (t, u, [first, second]) = { turned }.next().expect("an edge that can be turned");
        (mesh.triangles[t], mesh.triangles[u]) = (first, second);
        Mesh::canonicalise(&mut mesh.triangles);
        let bytes = pack(&mesh, &fills).expect("a sound mesh");
        assert!(bytes.len() > by_rule);
        let (found, _) = unpack(&bytes);
        let (_, mut expected) = ordered(&mesh);
        expected.sort_unstable();
        assert_eq!(found.triangles, expected);
    }
}
