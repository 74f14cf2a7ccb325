//! Carries a mesh along with the motion of the picture.

use crate::flow::motion::Motion;
use crate::geom::{Point, SUBPIXEL, Size, orient};
use crate::mesh::{CORNERS, Mesh, Place, starts};

/// Shares of its displacement that a vertex tries, the longest first. After the last it stays.
const SHARES: [f64; 3] = [1.0, 0.5, 0.25];

/// Carries meshes. Keeps scratch buffers from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct Carrier {
    /// The position of each vertex before.
    from: Vec<Point>,
    /// The displacement of each vertex.
    displacements: Vec<(f64, f64)>,
    /// The number of [`SHARES`] of it that were too long.
    attempts: Vec<u8>,
    /// The triangles of each vertex, those of vertex v from `ends[v - 1]` to `ends[v]`.
    ends: Vec<u32>,
    triangles_around: Vec<u32>,
    /// Triangles that are still to be checked.
    pending: TriangleSet,
}

impl Carrier {
    /// Moves the vertices of `mesh` by `motion`, as far as no triangle folds or loses its area. Where it would, at
    /// occlusions and where the picture leaves the frame, vertices move by half of the displacement, by a quarter, or
    /// not at all. Border vertices slide along their border; corners stay. A sound mesh stays sound.
    pub fn carry(&mut self, mesh: &mut Mesh, motion: &Motion) {
        if motion.is_zero() {
            return;
        }
        let Self { from, displacements, attempts, ends, triangles_around, pending } = self;
        let size = mesh.size;
        from.clone_from(&mesh.vertices);
        displacements.clear();
        displacements.extend(from.iter().map(|&p| displacement(p, size, motion)));
        attempts.clear();
        attempts.resize(from.len(), 0);
        let position = |v: usize, attempts: u8| {
            let share = SHARES.get(usize::from(attempts)).copied().unwrap_or(0.0);
            moved(from[v], displacements[v], share, size)
        };
        for v in CORNERS..from.len() {
            mesh.vertices[v] = position(v, 0);
        }
        pending.clear(mesh.triangles.len());
        (0..mesh.triangles.len()).filter(|&t| is_folded(mesh, t)).for_each(|t| pending.insert(t));
        let mut next = pending.pop_from(0);
        if next.is_some() {
            index_triangles(mesh, ends, triangles_around);
        }
        // Each round over the triangles shortens the displacement of a vertex of every folded triangle. A triangle is
        // sound at the latest when all three vertices are back.
        while let Some(t) = next {
            if is_folded(mesh, t) {
                for v in mesh.triangles[t].map(|v| v as usize) {
                    if v >= CORNERS && usize::from(attempts[v]) < SHARES.len() {
                        attempts[v] += 1;
                        mesh.vertices[v] = position(v, attempts[v]);
                        let here = &triangles_around[ends[v - 1] as usize..ends[v] as usize];
                        here.iter().for_each(|&t| pending.insert(t as usize));
                    }
                }
            }
            next = pending.pop_from(t + 1).or_else(|| pending.pop_from(0));
        }
    }
}

/// Lists the triangles around each vertex, and the end of each list, which is the start of the next.
fn index_triangles(mesh: &Mesh, ends: &mut Vec<u32>, triangles_around: &mut Vec<u32>) {
    let corners = mesh.triangles.as_flattened().iter().copied();
    starts(ends, mesh.vertices.len(), corners.clone());
    triangles_around.resize(3 * mesh.triangles.len(), 0);
    for (v, corner) in corners.zip(0u32..) {
        // Each start becomes the end of its list.
        let at = &mut ends[v as usize];
        triangles_around[*at as usize] = corner / 3;
        *at += 1;
    }
}

/// A set of triangle numbers, one bit for each.
#[derive(Clone, Debug, Default)]
struct TriangleSet(Vec<u64>);

impl TriangleSet {
    /// Bits of a word.
    const WORD: usize = u64::BITS as usize;

    /// Empties the set, for numbers below `count`.
    fn clear(&mut self, count: usize) {
        self.0.clear();
        self.0.resize(count.div_ceil(Self::WORD), 0);
    }

    fn insert(&mut self, t: usize) {
        self.0[t / Self::WORD] |= 1 << (t % Self::WORD);
    }

    /// Removes and returns the first number that is at least `from`.
    fn pop_from(&mut self, from: usize) -> Option<usize> {
        let mut wanted = !0 << (from % Self::WORD);
        for (i, word) in self.0.iter_mut().enumerate().skip(from / Self::WORD) {
            if *word & wanted != 0 {
                let bit = (*word & wanted).trailing_zeros();
                *word &= !(1 << bit);
                return Some(i * Self::WORD + bit as usize);
            }
            wanted = !0;
        }
        None
    }
}

/// Whether motion has folded triangle `t`: it has less than [`MIN_AREA`].
fn is_folded(mesh: &Mesh, t: usize) -> bool {
    let [a, b, c] = mesh.triangle(t);
    orient(a, b, c) < MIN_AREA
}

/// A triangle whose doubled area, in (1/256 pixel)^2, is smaller than this counts as folded: a quarter of a
/// pixel.
const MIN_AREA: i64 = (SUBPIXEL as i64 * SUBPIXEL as i64) / 2;

/// The displacement of a vertex at `p`, in 1/256 pixel: corners stay, border vertices slide.
fn displacement(p: Point, size: Size, motion: &Motion) -> (f64, f64) {
    let (x, y) = p.to_pixels();
    let [u, v] = motion.at(x as f32, y as f32).map(|d| f64::from(d) * f64::from(SUBPIXEL));
    match Place::of(p, size) {
        Place::Corner => (0.0, 0.0),
        Place::SideBorder => (0.0, v),
        Place::LevelBorder => (u, 0.0),
        Place::Interior => (u, v),
    }
}

/// `p` moved by a share of its displacement. Inner vertices stay inside the frame and off its border.
fn moved(p: Point, (u, v): (f64, f64), share: f64, size: Size) -> Point {
    let far = size.far();
    let inside = |from: i32, by: f64, far: i32| {
        let to = from + (by * share).round() as i32;
        if from == 0 || from == far { from } else { to.clamp(1, far - 1) }
    };
    Point::new(inside(p.x, u, far.x), inside(p.y, v, far.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, rank};
    use crate::flow::motion::blocks;
    use crate::flow::small::Small;
    use crate::frame::Frame;
    use crate::triangulate::triangulate;

    const SIZE: Size = Size::new(240, 160);

    fn picture(shift: impl Fn(f64, f64) -> f64) -> Small {
        let value = |x: u32, y: u32| {
            let (x, y) = (f64::from(x), f64::from(y));
            let u = x - shift(x, y);
            let g = (128.0 + 60.0 * (u * 0.21).sin() * (y * 0.17).cos() + 40.0 * (u * 0.07).cos())
                as u8;
            [g, g, g, 255]
        };
        let pixels = (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)));
        let pixels = pixels.map(|(x, y)| value(x, y)).collect();
        Small::new(&Frame::new(SIZE, pixels).expect("a small frame"))
    }

    fn mesh() -> Mesh {
        let at = |i: u32| {
            let bits = rank(4, Purpose::Noise, i, 0);
            Point::pixel_centre((bits % 240) as u32, (bits >> 20) as u32 % 160)
        };
        let mut seeds: Vec<_> = (0..700).map(at).collect();
        seeds.extend([Point::new(99 * 256, 0), Point::new(0, 60 * 256)]);
        seeds.sort_unstable();
        seeds.dedup();
        triangulate(SIZE, &seeds).expect("distinct seeds")
    }

    /// As [`Carrier::carry`], all triangles being looked at in every round.
    fn carry_slowly(mesh: &mut Mesh, motion: &Motion) {
        let from = mesh.vertices.clone();
        let mut tried = vec![0; from.len()];
        let place = |v: usize, tried: usize| {
            let share = SHARES.get(tried).copied().unwrap_or(0.0);
            moved(from[v], displacement(from[v], SIZE, motion), share, SIZE)
        };
        for v in CORNERS..from.len() {
            mesh.vertices[v] = place(v, 0);
        }
        let mut broken = true;
        while broken {
            broken = false;
            for t in 0..mesh.triangles.len() {
                if !is_folded(mesh, t) {
                    continue;
                }
                for v in mesh.triangles[t].map(|v| v as usize) {
                    if tried[v] < SHARES.len() && v >= CORNERS {
                        tried[v] += 1;
                        mesh.vertices[v] = place(v, tried[v]);
                        broken = true;
                    }
                }
            }
        }
    }

    fn carried(shift: impl Fn(f64, f64) -> f64) -> (Mesh, Mesh) {
        let (a, b) = (picture(|_, _| 0.0), picture(shift));
        let (columns, rows) = blocks(&a);
        let motion = Motion::between(&a, &b, &vec![true; columns.len() * rows.len()]);
        let before = mesh();
        let mut after = before.clone();
        Carrier::default().carry(&mut after, &motion);
        let mut slowly = before.clone();
        carry_slowly(&mut slowly, &motion);
        assert_eq!(after, slowly);
        (before, after)
    }

    #[test]
    fn a_mesh_stays_sound_whatever_the_picture_does() {
        for shift in [-14.0, -3.0, 0.5, 6.0, 14.0] {
            let (before, after) = carried(|_, _| shift);
            assert_eq!(after.check(), Ok(()), "moved by {shift}");
            assert_eq!(after.triangles, before.triangles);
            // Two halves that part or collide.
            let (_, after) = carried(|x, _| if x < 120.0 { shift } else { -shift });
            assert_eq!(after.check(), Ok(()), "split by {shift}");
        }
    }

    #[test]
    fn vertices_go_where_the_picture_goes() {
        let (before, after) = carried(|_, _| 5.0);
        let far = |p: &Point| p.x > 40 * 256 && p.x < 200 * 256 && p.y > 8 * 256 && p.y < 152 * 256;
        let moves = before.vertices.iter().zip(&after.vertices).filter(|(p, _)| far(p));
        let mut along: Vec<_> = moves.map(|(p, q)| f64::from(q.x - p.x) / 256.0).collect();
        along.sort_unstable_by(f64::total_cmp);
        let typical = along[along.len() / 2];
        assert!((typical - 5.0).abs() < 0.5, "{typical}");
    }

    #[test]
    fn rest_moves_nothing() {
        let (before, after) = carried(|_, _| 0.0);
        assert_eq!(before, after);
    }
}
