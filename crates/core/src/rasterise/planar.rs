//! Mean colours and painting of planes, the form of video. Because a mean is linear, a colour is converted once for
//! each triangle, not for each pixel, and less than half of the memory is read and written.

use crate::parallel::prelude::*;

use super::per_thread::PerThread;
use super::sparse::has_enough;
use super::{centroid, each_triangle};
use crate::colour::{Form, FromYuv, Layout, Planes, Siting, ToYuv};
use crate::frame::{Fill, Rgba};
use crate::geom::Point;
use crate::mesh::Mesh;
use crate::scan::bytes::{ByteSums, MOST_ROWS};
use crate::scan::runs::{BAND, Bands};
use crate::scan::{rows, spans};
use crate::simd::dispatch;

/// As [`super::means`], from the `planes` of a frame. A sample of chroma counts for the triangles of the two pixels
/// above and below it; a triangle without any takes the sample nearest to its centroid. Triangles with [rows
/// enough](has_enough) use every `every`-th row only; areas are exact.
pub(super) fn means(mesh: &Mesh, planes: &Planes, every: u32) -> Vec<Fill> {
    let factors = FromYuv::new(planes.form.coding);
    let split = planes.split();
    each_triangle(
        mesh,
        #[inline(always)]
        |triangle| {
            let (mut codes, area) = if every > 1 && has_enough(triangle, every) {
                sparse_mean(planes, split, triangle, every)
            } else {
                mean(planes, split, triangle, |_| true)
            };
            nearest_for_none(&mut codes, planes, triangle);
            Fill { colour: factors.mean(codes), area }
        },
    )
}

/// As [`mean`], from every `every`-th row; from all if those cover no pixel.
#[inline(never)]
fn sparse_mean(
    planes: &Planes,
    split: [&[u8]; 3],
    triangle: [Point; 3],
    every: u32,
) -> ([(u64, u64); 3], u32) {
    let some = mean(planes, split, triangle, |row| row % every == 0);
    if some.0[0].1 == 0 { mean(planes, split, triangle, |_| true) } else { some }
}

/// Sums of luma, Cb and Cr over the rows that are `looked_at`, each with the number of its samples; and the area.
#[inline(always)]
fn mean(
    planes: &Planes,
    split: [&[u8]; 3],
    triangle: [Point; 3],
    looked_at: impl Fn(u32) -> bool,
) -> ([(u64, u64); 3], u32) {
    let layout = &planes.form.layout;
    let (width, chroma_width) = (layout.size.width as usize, layout.chroma().0);
    let [luma, cb, cr] = split;
    let (mut codes, mut all) = ([(0, 0); 3], 0);
    // Nearly always one iteration.
    for first in rows(triangle).step_by(MOST_ROWS) {
        let last = (first + MOST_ROWS as u32).min(layout.size.height);
        // Not an array: these stay in registers.
        let (mut y, mut u, mut v) = (ByteSums::default(), ByteSums::default(), ByteSums::default());
        let (mut area, mut samples) = (0, 0);
        spans(
            triangle,
            first..last,
            #[inline(always)]
            |row, columns| {
                all += columns.len();
                if !looked_at(row) {
                    return;
                }
                let row = row as usize;
                area += columns.len();
                y.add(luma, row * width + columns.start, columns.len());
                let (start, end) = (columns.start.div_ceil(2), columns.end.div_ceil(2));
                samples += end - start;
                let first = row / 2 * chroma_width + start;
                u.add(cb, first, end - start);
                v.add(cr, first, end - start);
            },
        );
        let counts = [area, samples, samples].map(|count| count as u64);
        for ((code, sum), count) in codes.iter_mut().zip([y, u, v]).zip(counts) {
            *code = (code.0 + sum.total(), code.1 + count);
        }
    }
    (codes, all as u32)
}

/// Takes the samples nearest to the centroid for means over no sample.
#[inline(always)]
fn nearest_for_none(codes: &mut [(u64, u64); 3], planes: &Planes, triangle: [Point; 3]) {
    if codes[0].1 == 0 || codes[1].1 == 0 {
        let (x, y) = centroid(triangle).pixel(planes.form.layout.size);
        for (code, near) in codes.iter_mut().zip(planes.at(x, y)).filter(|(code, _)| code.1 == 0) {
            *code = (near.into(), 1);
        }
    }
}

/// Scratch memory for painting planes.
pub(super) type PlaneScratches = PerThread<PlaneScratch>;

#[derive(Debug, Default)]
pub(super) struct PlaneScratch {
    /// A band of pixels: luma, Cb, Cr and 255.
    pixels: Vec<Rgba>,
    /// Sums of chroma of two of its rows: Cb in the lower half of each number, Cr in the upper.
    columns: Vec<u32>,
}

/// Paints the triangles of `mesh` in the opaque colours of `fills` as planes of `form`, which is
/// [squared](Layout::is_squared), in the buffer `data`. A colour is converted once for its triangle; otherwise the
/// planes are those of the painted pixels, see [`crate::colour::from_rgba`].
pub(super) fn paint(
    mesh: &Mesh,
    fills: &[Fill],
    form: Form,
    (bands, scratches): (&mut Bands, &mut PlaneScratches),
    mut data: Vec<u8>,
) -> Planes {
    let factors = ToYuv::new(form.coding);
    let painted = fills.iter().enumerate().map(|(t, fill)| {
        let [y, u, v] = factors.codes(fill.colour);
        (mesh.triangle(t), [y, u, v, 255])
    });
    bands.sort(mesh.size.height, painted);
    let (bands, scratches) = (&*bands, scratches.prepare());
    data.resize(form.layout.bytes(), 0);
    let mut planes = Planes { form, data };
    let width = form.layout.size.width as usize;
    let [luma, u, v] = planes.split_mut();
    let of_chroma = BAND as usize / 2 * form.layout.chroma().0;
    let chroma = u.par_chunks_mut(of_chroma).zip(v.par_chunks_mut(of_chroma));
    let parts = luma.par_chunks_mut(BAND as usize * width).zip(chroma).enumerate();
    parts.for_each(|(band, (luma, (u, v)))| {
        let mut scratch = scratches.local();
        scratch.pixels.resize(luma.len(), [0; 4]);
        bands.fill(band, width, &mut scratch.pixels);
        scratch.part(&form.layout, [luma, u, v]);
    });
    planes
}

impl PlaneScratch {
    /// The planes of the band's pixels.
    fn part(&mut self, layout: &Layout, [luma, u, v]: [&mut [u8]; 3]) {
        let (width, chroma_width) = (layout.size.width as usize, layout.chroma().0);
        let two = 2 * width;
        let chroma = u.chunks_mut(chroma_width).zip(v.chunks_mut(chroma_width));
        let rows = self.pixels.chunks(two).zip(luma.chunks_mut(two)).zip(chroma);
        for ((pixels, luma), (u, v)) in rows {
            dispatch(
                #[inline(always)]
                || {
                    for (luma, pixel) in luma.iter_mut().zip(pixels) {
                        *luma = pixel[0];
                    }
                    let (upper, lower) = pixels.split_at(width);
                    add_columns(upper, lower, &mut self.columns);
                    narrow(layout.siting, &self.columns, u, v);
                },
            );
        }
    }
}

/// The sum of the chroma of two rows, with one more column on the left, which repeats its neighbour.
#[inline(always)]
fn add_columns(upper: &[Rgba], lower: &[Rgba], columns: &mut Vec<u32>) {
    columns.resize(upper.len() + 2, 0);
    for ((column, &a), &b) in columns[1..].iter_mut().zip(upper).zip(lower) {
        let [a, b] = [a, b].map(u32::from_le_bytes);
        let chroma = |pixel: u32| pixel >> 8 & 0xff | pixel & 0xff_0000;
        *column = chroma(a) + chroma(b);
    }
    columns[0] = columns[1];
}

/// A row of chroma: each sample is the mean of the columns nearest to it.
#[inline(always)]
fn narrow(siting: Siting, columns: &[u32], u: &mut [u8], v: &mut [u8]) {
    const HALVES: u32 = 4 << 16 | 4;
    let (pairs, _) = columns.as_chunks::<2>();
    let out = u.iter_mut().zip(v).zip(pairs.iter().zip(&pairs[1..]));
    match siting {
        Siting::Left => {
            for ((u, v), (&[before, at], &[after, _])) in out {
                let sum = before + 2 * at + after + HALVES;
                (*u, *v) = ((sum >> 3) as u8, (sum >> 19) as u8);
            }
        }
        Siting::Centre => {
            for ((u, v), (&[_, left], &[right, _])) in out {
                let sum = 2 * (left + right) + HALVES;
                (*u, *v) = ((sum >> 3) as u8, (sum >> 19) as u8);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, rank};
    use crate::colour::{Coding, Matrix, Range, Sampling};
    use crate::geom::Size;
    use crate::triangulate::triangulate;
    use proptest::prelude::*;

    fn form(size: Size, siting: Siting) -> Form {
        let layout = Layout { size, sampling: Sampling::Yuv420, siting, alpha: false };
        Form { layout, coding: Coding { matrix: Matrix::Bt601, range: Range::Full } }
    }

    /// A mesh of `size` with up to `count` seeds by chance.
    fn mesh(size: Size, count: u32, seed: u64) -> Mesh {
        let far = size.far();
        let place = |i: u32| {
            let bits = rank(seed, Purpose::Noise, i, 0);
            let (x, y) =
                (bits as u32 % (far.x as u32 + 1), (bits >> 32) as u32 % (far.y as u32 + 1));
            Point::new(x as i32, y as i32)
        };
        let mut seeds: Vec<_> =
            (0..count).map(place).filter(|p| !Mesh::corners(size).contains(p)).collect();
        seeds.sort_unstable();
        seeds.dedup();
        triangulate(size, &seeds).expect("distinct seeds")
    }

    /// The triangle of each pixel.
    fn owners(mesh: &Mesh) -> Vec<usize> {
        let mut owners = vec![0; mesh.size.pixels()];
        for t in 0..mesh.triangles.len() {
            spans(mesh.triangle(t), 0..mesh.size.height, |y, columns| {
                owners[y as usize * mesh.size.width as usize..][columns].fill(t);
            });
        }
        owners
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// The slow, obvious version: each pixel tells its triangle its luma, every other column's pixels
        /// their chroma.
        #[test]
        fn sums_are_those_of_the_samples(
            (width, height) in (1u32..40, 1u32..160), (count, seed) in (0u32..40, any::<u64>())
        ) {
            let size = Size::new(2 * width, 2 * height);
            let mesh = mesh(size, count, seed);
            let form = form(size, Siting::Left);
            let bytes = 0..form.layout.bytes() as u32;
            let data = bytes.map(|i| rank(seed, Purpose::Noise, i, 1) as u8).collect();
            let planes = Planes { form, data };
            let mut slow = vec![[(0, 0); 3]; mesh.triangles.len()];
            for (i, t) in owners(&mesh).into_iter().enumerate() {
                let (x, y) = (i as u32 % size.width, i as u32 / size.width);
                for (plane, code) in planes.at(x, y).into_iter().enumerate() {
                    if plane == 0 || x % 2 == 0 {
                        slow[t][plane].0 += u64::from(code);
                        slow[t][plane].1 += 1;
                    }
                }
            }
            for (t, slow) in slow.iter().enumerate() {
                let found = mean(&planes, planes.split(), mesh.triangle(t), |_| true);
                prop_assert_eq!(found, (*slow, slow[0].1 as u32));
                // Rows that share the work have all of it together, and the same area.
                let some = |part| mean(&planes, planes.split(), mesh.triangle(t), |y| y % 2 == part);
                let ((even, of_even), (odd, of_odd)) = (some(0), some(1));
                prop_assert_eq!([of_even, of_odd], [found.1; 2]);
                for ((even, odd), all) in even.iter().zip(odd).zip(found.0) {
                    prop_assert_eq!((even.0 + odd.0, even.1 + odd.1), all);
                }
            }
        }

        /// The slow, obvious version: the means of the pixels around the places of the samples.
        #[test]
        fn planes_are_those_of_the_painted_pixels(
            (width, height) in (1u32..40, 1u32..80), (count, seed) in (0u32..40, any::<u64>())
        ) {
            let size = Size::new(2 * width, 2 * height);
            let mesh = mesh(size, count, seed);
            let colour = |t| {
                let [r, g, b, ..] = rank(seed, Purpose::Noise, t, 2).to_le_bytes();
                Fill { colour: [r, g, b, 255], area: 0 }
            };
            let fills: Vec<_> = (0..mesh.triangles.len() as u32).map(colour).collect();
            let owners = owners(&mesh);
            for siting in [Siting::Left, Siting::Centre] {
                let form = form(size, siting);
                let factors = ToYuv::new(form.coding);
                let codes = |x: u32, y: u32| {
                    factors.codes(fills[owners[(y * size.width + x) as usize]].colour)
                };
                let memory = (&mut Bands::default(), &mut PlaneScratches::default());
                let planes = paint(&mesh, &fills, form, memory, vec![9; 7]);
                for (x, y) in (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))) {
                    let found = planes.at(x, y);
                    prop_assert_eq!(found[0], codes(x, y)[0]);
                    let (x, y) = (x / 2 * 2, y / 2 * 2);
                    let columns = match siting {
                        Siting::Left => [x.saturating_sub(1), x, x, x + 1],
                        Siting::Centre => [x, x, x + 1, x + 1],
                    };
                    for plane in [1, 2] {
                        let around = columns.iter().flat_map(|&x| [codes(x, y), codes(x, y + 1)]);
                        let sum: u32 = around.map(|codes| u32::from(codes[plane])).sum();
                        prop_assert_eq!(u32::from(found[plane]), (sum + 4) / 8);
                    }
                }
            }
        }
    }

    #[test]
    fn means_of_some_rows_are_near_those_of_all_and_areas_exact() {
        let size = Size::new(120, 90);
        let form = form(size, Siting::Left);
        let luma = (0..size.pixels()).map(|i| (i % 120 + i / 120) as u8);
        let planes = Planes { form, data: luma.chain(vec![90; size.pixels() / 2]).collect() };
        let mesh = mesh(size, 25, 3);
        let exact = means(&mesh, &planes, 1);
        for every in [2, 4] {
            let sparse = means(&mesh, &planes, every);
            assert_ne!(sparse, exact);
            for (sparse, exact) in sparse.iter().zip(&exact) {
                assert_eq!(sparse.area, exact.area);
                let far = (0..4).map(|c| sparse.colour[c].abs_diff(exact.colour[c])).max();
                assert!(far <= Some(8), "every {every}: {sparse:?}, not {exact:?}");
            }
        }
    }
}
