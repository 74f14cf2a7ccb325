//! YuNet, the network "n": a chain of layers that halves the picture five times, its last three maps joined from coarse
//! to fine, and for each of them three readings of every place.

use crate::layers::{HEAD, Head, Map, Unit, add_coarse, pool};

/// The parameters, as `scripts/convert` writes them: half-precision numbers, little-endian.
const MODEL: &[u8] = include_bytes!("../model/yunet_n.f16");

/// Pixels between the places of each map that is read.
pub(crate) const STRIDES: [usize; 3] = [8, 16, 32];

/// What is read of a map, for each place: how likely it is a face's and not the ground's, how well its box will fit, and
/// the box.
#[derive(Debug)]
pub(crate) struct Reading {
    pub(crate) stride: usize,
    pub(crate) is_face: Map,
    pub(crate) fits: Map,
    pub(crate) bounds: Map,
}

/// The network.
#[derive(Debug)]
pub(crate) struct Net {
    head: Head,
    first: Unit,
    /// Two layers for each halving.
    stages: [[Unit; 2]; 5],
    /// For the maps from the coarsest to the finest.
    joints: [Unit; 3],
    /// These and the next ones from the finest to the coarsest.
    shared: [Unit; 3],
    is_face: [Unit; 3],
    bounds: [Unit; 3],
    fits: [Unit; 3],
}

impl Net {
    pub(crate) fn new() -> Self {
        let mut model =
            MODEL.as_chunks::<2>().0.iter().map(|bytes| half(u16::from_le_bytes(*bytes)));
        let mut take = |count: usize| -> Vec<f32> { model.by_ref().take(count).collect() };
        let head = Head { weights: take(9 * HEAD.0 * HEAD.1), added: take(HEAD.1) };
        let mut unit = |inputs: usize, outputs: usize| Unit {
            outputs,
            mix: take(inputs * outputs),
            mix_added: take(outputs),
            around: take(9 * outputs),
            around_added: take(outputs),
        };
        let net = Self {
            head,
            first: unit(16, 16),
            stages: [(16, 16), (64, 64), (64, 64), (64, 64), (64, 64)]
                .map(|(inputs, between)| [unit(inputs, between), unit(between, 64)]),
            joints: [64; 3].map(|n| unit(n, 64)),
            shared: [64; 3].map(|n| unit(n, 64)),
            is_face: [1; 3].map(|n| unit(64, n)),
            bounds: [4; 3].map(|n| unit(64, n)),
            fits: [1; 3].map(|n| unit(64, n)),
        };
        debug_assert!(model.next().is_none(), "all is used");
        net
    }

    /// The readings of `input`, whose sides are multiples of the last of [`STRIDES`].
    pub(crate) fn run(&self, input: &Map) -> [Reading; 3] {
        let [a, b, c, d, e] = &self.stages;
        let stage = |[first, second]: &[Unit; 2], map: &Map| second.run(&first.run(map));
        let half = pool(&self.first.run(&self.head.run(input)));
        let quarter = pool(&stage(b, &stage(a, &half)));
        let fine = stage(c, &quarter);
        let middle = stage(d, &pool(&fine));
        let coarse = self.joints[0].run(&stage(e, &pool(&middle)));
        let middle = self.joints[1].run(&add_coarse(&middle, &coarse));
        let fine = self.joints[2].run(&add_coarse(&fine, &middle));
        let maps = [fine, middle, coarse];
        std::array::from_fn(|i| {
            let map = self.shared[i].run(&maps[i]);
            Reading {
                stride: STRIDES[i],
                is_face: self.is_face[i].read(&map),
                fits: self.fits[i].read(&map),
                bounds: self.bounds[i].read(&map),
            }
        })
    }
}

/// A half-precision number (IEEE 754 binary16) that is finite.
fn half(bits: u16) -> f32 {
    let sign = u32::from(bits & 0x8000) << 16;
    // Exponent and mantissa in their places of binary32, and the exponent's bias made up for by a product, which is
    // exact and takes numbers below the normal ones, too.
    let magnitude = f32::from_bits(u32::from(bits & 0x7fff) << 13) * f32::from_bits(0x7780_0000);
    f32::from_bits(magnitude.to_bits() | sign)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_precision_numbers_are_read() {
        let read = [0x3c00, 0xc000, 0x7bff, 0x0001, 0x8400, 0x0000, 0x3555].map(half);
        let exact = [1.0, -2.0, 65504.0, 2f32.powi(-24), -(2f32.powi(-14)), 0.0, 0.333_251_95];
        assert_eq!(read, exact);
    }

    #[test]
    fn the_model_has_as_many_numbers_as_the_network() {
        let unit = |inputs: usize, outputs: usize| inputs * outputs + 11 * outputs;
        let body = unit(16, 16) * 2 + unit(16, 64) + 14 * unit(64, 64);
        let readings = 3 * (2 * unit(64, 1) + unit(64, 4));
        assert_eq!(MODEL.len() / 2, 27 * 16 + 16 + body + readings);
    }
}
