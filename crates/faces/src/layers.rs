//! The layers of the network. A map has its channels innermost, so that the loops over them become vectors.

#[cfg(feature = "parallel")]
use rayon::prelude::*;

/// A picture of many channels: `[row][column][channel]`.
#[derive(Clone, Debug)]
pub(crate) struct Map {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) channels: usize,
    pub(crate) values: Vec<f32>,
}

impl Map {
    pub(crate) fn new(width: usize, height: usize, channels: usize) -> Self {
        Self { width, height, channels, values: vec![0.0; width * height * channels] }
    }

    fn row(&self, y: usize) -> &[f32] {
        let long = self.width * self.channels;
        &self.values[y * long..][..long]
    }

    /// Calls `work` with each row and its number, on all processors.
    fn for_rows(&mut self, work: impl Fn(usize, &mut [f32]) + Sync) {
        let long = (self.width * self.channels).max(1);
        let work = |(y, row): (usize, &mut [f32])| work(y, row);
        #[cfg(feature = "parallel")]
        self.values.par_chunks_mut(long).enumerate().for_each(work);
        #[cfg(not(feature = "parallel"))]
        self.values.chunks_mut(long).enumerate().for_each(work);
    }
}

/// Runs `work` with the widest vector instructions of the machine; nothing is fused, so that the results are the same on
/// all. The closure and the functions that it calls must be `#[inline(always)]`.
#[inline(always)]
fn dispatch(work: impl FnOnce()) {
    pulp::Arch::new().dispatch(work);
}

/// The first layer: a convolution of 3 x 3 pixels at every second place, and what is below 0 becomes 0.
#[derive(Clone, Debug)]
pub(crate) struct Head {
    /// `[row][column][input][output]`.
    pub(crate) weights: Vec<f32>,
    pub(crate) added: Vec<f32>,
}

/// The channels of the picture, and those that the first layer makes of them.
pub(crate) const HEAD: (usize, usize) = (3, 16);

impl Head {
    pub(crate) fn run(&self, input: &Map) -> Map {
        let mut output = Map::new(input.width / 2, input.height / 2, HEAD.1);
        output.for_rows(|y, row| {
            dispatch(
                #[inline(always)]
                || self.convolve_row(input, y, row),
            );
        });
        output
    }

    #[inline(always)]
    fn convolve_row(&self, input: &Map, y: usize, row: &mut [f32]) {
        const PARTS: usize = HEAD.1 / 8;
        let (added, weights) = (self.added.as_chunks::<8>().0, self.weights.as_chunks::<8>().0);
        for (x, out) in row.as_chunks_mut::<8>().0.chunks_exact_mut(PARTS).enumerate() {
            let mut sums = [added[0], added[1]];
            for (i, weights) in weights.chunks_exact(HEAD.0 * PARTS).enumerate() {
                let (x, y) = (2 * x + i % 3, 2 * y + i / 3);
                if (1..=input.width).contains(&x) && (1..=input.height).contains(&y) {
                    let pixel = &input.row(y - 1)[(x - 1) * HEAD.0..][..HEAD.0];
                    for (value, weights) in pixel.iter().zip(weights.chunks_exact(PARTS)) {
                        add_product(&mut sums[0], *value, &weights[0]);
                        add_product(&mut sums[1], *value, &weights[1]);
                    }
                }
            }
            out.copy_from_slice(&sums);
            floor(out.as_flattened_mut());
        }
    }
}

/// The layer that the rest consists of: a mix of the channels of each pixel, then for each channel a convolution of 3 x 3
/// pixels.
#[derive(Clone, Debug)]
pub(crate) struct Unit {
    pub(crate) outputs: usize,
    /// `[input][output]`.
    pub(crate) mix: Vec<f32>,
    pub(crate) mix_added: Vec<f32>,
    /// `[row][column][channel]`.
    pub(crate) around: Vec<f32>,
    pub(crate) around_added: Vec<f32>,
}

impl Unit {
    /// What is below 0 becomes 0.
    pub(crate) fn run(&self, input: &Map) -> Map {
        let mut output = self.run_as::<8>(input);
        output.for_rows(|_, row| floor(row));
        output
    }

    /// The values as they are: the last layer, whose outputs are one or four.
    pub(crate) fn read(&self, input: &Map) -> Map {
        match self.outputs {
            1 => self.run_as::<1>(input),
            _ => self.run_as::<4>(input),
        }
    }

    /// `N` outputs at a time, of which there is a multiple.
    fn run_as<const N: usize>(&self, input: &Map) -> Map {
        let mut mixed = Map::new(input.width, input.height, self.outputs);
        mixed.for_rows(|y, row| {
            dispatch(
                #[inline(always)]
                || self.mix_row::<N>(input.row(y), input.channels, row),
            )
        });
        let mut output = Map::new(input.width, input.height, self.outputs);
        output.for_rows(|y, row| {
            dispatch(
                #[inline(always)]
                || self.convolve_row::<N>(&mixed, y, row),
            )
        });
        output
    }

    #[inline(always)]
    fn mix_row<const N: usize>(&self, input: &[f32], channels: usize, row: &mut [f32]) {
        // As many sums as there are vector registers for.
        const AT_ONCE: usize = 8;
        let (inputs, outputs) = (AT_ONCE * channels, AT_ONCE * self.outputs);
        let (many, rest) = (input.chunks_exact(inputs), row.len() / outputs * outputs);
        let left = many.remainder().chunks_exact(channels);
        let (row, row_left) = row.split_at_mut(rest);
        for (out, pixels) in row.chunks_exact_mut(outputs).zip(many) {
            self.mix::<AT_ONCE, N>(pixels, channels, out);
        }
        for (out, pixel) in row_left.chunks_exact_mut(self.outputs).zip(left) {
            self.mix::<1, N>(pixel, channels, out);
        }
    }

    /// Mixes the channels of `P` pixels.
    #[inline(always)]
    fn mix<const P: usize, const N: usize>(
        &self,
        pixels: &[f32],
        channels: usize,
        out: &mut [f32],
    ) {
        let parts = self.outputs / N;
        let (added, weights) = (self.mix_added.as_chunks::<N>().0, self.mix.as_chunks::<N>().0);
        let out = out.as_chunks_mut::<N>().0;
        let pixels: [&[f32]; P] = std::array::from_fn(|p| &pixels[p * channels..][..channels]);
        for (part, added) in added.iter().enumerate() {
            let mut sums = [*added; P];
            for i in 0..channels {
                let weights = &weights[i * parts + part];
                for p in 0..P {
                    add_product(&mut sums[p], pixels[p][i], weights);
                }
            }
            for (p, sum) in sums.iter().enumerate() {
                out[p * parts + part] = *sum;
            }
        }
    }

    #[inline(always)]
    fn convolve_row<const N: usize>(&self, mixed: &Map, y: usize, row: &mut [f32]) {
        let parts = self.outputs / N;
        let rows = [y.checked_sub(1), Some(y), Some(y + 1).filter(|y| *y < mixed.height)];
        let rows = rows.map(|y| y.map_or(&[][..], |y| mixed.row(y).as_chunks::<N>().0));
        let (added, weights) = (self.around_added.as_chunks::<N>().0, self.around.as_chunks().0);
        for (x, out) in row.as_chunks_mut::<N>().0.chunks_exact_mut(parts).enumerate() {
            out.copy_from_slice(added);
            for (row, weights) in rows.iter().zip(weights.chunks_exact(3 * parts)) {
                // Outside the frame there is nothing to add.
                let from = x.saturating_sub(1) * parts;
                let to = ((x + 2) * parts).min(row.len());
                let first = if x == 0 { parts } else { 0 };
                let Some(values) = row.get(from..to) else { continue };
                let columns = weights[first..].chunks_exact(parts);
                for (weights, values) in columns.zip(values.chunks_exact(parts)) {
                    for ((sum, value), weights) in out.iter_mut().zip(values).zip(weights) {
                        add_products(sum, value, weights);
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn add_product<const N: usize>(sums: &mut [f32; N], value: f32, weights: &[f32; N]) {
    for (sum, weight) in sums.iter_mut().zip(weights) {
        *sum += value * weight;
    }
}

#[inline(always)]
fn add_products<const N: usize>(sums: &mut [f32; N], values: &[f32; N], weights: &[f32; N]) {
    for (sum, (value, weight)) in sums.iter_mut().zip(values.iter().zip(weights)) {
        *sum += value * weight;
    }
}

#[inline(always)]
fn floor(values: &mut [f32]) {
    for value in values {
        *value = value.max(0.0);
    }
}

/// The largest of each two by two pixels.
pub(crate) fn pool(input: &Map) -> Map {
    let channels = input.channels;
    let mut output = Map::new(input.width / 2, input.height / 2, channels);
    output.for_rows(
        #[inline(always)]
        |y, row| {
            let (above, below) = (input.row(2 * y), input.row(2 * y + 1));
            for (x, out) in row.chunks_exact_mut(channels).enumerate() {
                let part = |row: &'_ [f32], right: usize| (2 * x + right) * channels..row.len();
                let (a, b) = (&above[part(above, 0)], &above[part(above, 1)]);
                let (c, d) = (&below[part(below, 0)], &below[part(below, 1)]);
                for (k, out) in out.iter_mut().enumerate() {
                    *out = a[k].max(b[k]).max(c[k].max(d[k]));
                }
            }
        },
    );
    output
}

/// Adds to `fine` the map `coarse` of half its size.
pub(crate) fn add_coarse(fine: &Map, coarse: &Map) -> Map {
    let mut output = fine.clone();
    let channels = fine.channels;
    output.for_rows(
        #[inline(always)]
        |y, row| {
            let from = coarse.row(y / 2);
            for (x, out) in row.chunks_exact_mut(channels).enumerate() {
                for (out, value) in out.iter_mut().zip(&from[x / 2 * channels..]) {
                    *out += value;
                }
            }
        },
    );
    output
}
