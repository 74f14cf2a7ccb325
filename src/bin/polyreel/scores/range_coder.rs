//! An adaptive binary range coder (Martin, "Range encoding", 1979; the carry and the bit models as in
//! LZMA), and the models that numbers are written with.

/// Bits of a probability, and how quickly it adapts.
const PRECISION: u32 = 11;
const RATE: u32 = 5;
const RENORMALISE_BELOW: u32 = 1 << 24;

/// The probability that a bit is 0, learnt as bits pass.
#[derive(Clone, Copy, Debug)]
pub(super) struct Model(u16);

impl Default for Model {
    fn default() -> Self {
        Self(1 << (PRECISION - 1))
    }
}

impl Model {
    fn learn(&mut self, bit: bool) {
        if bit {
            self.0 -= self.0 >> RATE;
        } else {
            self.0 += ((1 << PRECISION) - self.0) >> RATE;
        }
    }
}

/// Something that bits pass through: an encoder writes the bit that it is given and returns it, a
/// decoder returns the bit that was written. So models need to be spelt out only once.
pub(super) trait Bits {
    fn bit(&mut self, model: &mut Model, bit: bool) -> bool;
}

/// Writes bits to bytes.
#[derive(Debug)]
pub(super) struct Encoder {
    low: u64,
    range: u32,
    cache: u8,
    pending: u64,
    bytes: Vec<u8>,
}

impl Encoder {
    pub(super) fn new() -> Self {
        Self { low: 0, range: u32::MAX, cache: 0, pending: 1, bytes: Vec::new() }
    }

    fn shift(&mut self) {
        if self.low < 0xff00_0000 || self.low > 0xffff_ffff {
            let carry = (self.low >> 32) as u8;
            let mut byte = self.cache;
            while self.pending > 0 {
                self.bytes.push(byte.wrapping_add(carry));
                byte = 0xff;
                self.pending -= 1;
            }
            self.cache = (self.low >> 24) as u8;
        }
        self.pending += 1;
        self.low = (self.low & 0x00ff_ffff) << 8;
    }

    pub(super) fn finish(mut self) -> Vec<u8> {
        (0..5).for_each(|_| self.shift());
        self.bytes
    }
}

impl Bits for Encoder {
    fn bit(&mut self, model: &mut Model, bit: bool) -> bool {
        let bound = (self.range >> PRECISION) * u32::from(model.0);
        if bit {
            self.low += u64::from(bound);
            self.range -= bound;
        } else {
            self.range = bound;
        }
        model.learn(bit);
        while self.range < RENORMALISE_BELOW {
            self.range <<= 8;
            self.shift();
        }
        bit
    }
}

/// Numbers of 8 bits, each bit in the context of those above it.
#[derive(Clone, Debug)]
pub(super) struct Byte([Model; 256]);

impl Default for Byte {
    fn default() -> Self {
        Self([Model::default(); 256])
    }
}

impl Byte {
    pub(super) fn pass(&mut self, bits: &mut impl Bits, value: u8) -> u8 {
        let mut node = 1usize;
        for i in (0..8).rev() {
            let bit = bits.bit(&mut self.0[node], value >> i & 1 == 1);
            node = 2 * node + usize::from(bit);
        }
        (node & 0xff) as u8
    }
}

/// Numbers of 32 bits, small ones in few bits: the number of digits, then the digits of value + 1
/// (Elias gamma), the two highest of them modelled.
#[derive(Clone, Debug)]
pub(super) struct Number {
    digits: [Model; 64],
    below: [[Model; 4]; 33],
    rest: Model,
}

impl Default for Number {
    fn default() -> Self {
        let m = Model::default();
        Self { digits: [m; 64], below: [[m; 4]; 33], rest: m }
    }
}

impl Number {
    pub(super) fn pass(&mut self, bits: &mut impl Bits, value: u32) -> u32 {
        let value = u64::from(value) + 1;
        let length = 63 - value.leading_zeros();
        let mut found = 0;
        while found < 32 && bits.bit(&mut self.digits[found as usize], found < length) {
            found += 1;
        }
        let mut result = 1u64;
        for i in (0..found).rev() {
            let bit = value >> i & 1 == 1;
            let context = found - i;
            let model = match context {
                1 | 2 => {
                    &mut self.below[found as usize]
                        [(2 * (context - 1) + (result & 1) as u32) as usize]
                }
                _ => {
                    // Lower digits are as good as even: a model that does not learn.
                    self.rest = Model::default();
                    &mut self.rest
                }
            };
            result = 2 * result + u64::from(bits.bit(model, bit));
        }
        (result - 1) as u32
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Reads what [`Encoder`] wrote.
    pub(in super::super) struct Decoder<'a> {
        code: u32,
        range: u32,
        bytes: std::slice::Iter<'a, u8>,
    }

    impl<'a> Decoder<'a> {
        pub(in super::super) fn new(bytes: &'a [u8]) -> Self {
            let mut bytes = bytes.iter();
            let mut code = 0;
            for _ in 0..5 {
                code = code << 8 | u32::from(*bytes.next().expect("five bytes at least"));
            }
            Self { code, range: u32::MAX, bytes }
        }
    }

    impl Bits for Decoder<'_> {
        fn bit(&mut self, model: &mut Model, _: bool) -> bool {
            let bound = (self.range >> PRECISION) * u32::from(model.0);
            let bit = self.code >= bound;
            if bit {
                self.code -= bound;
                self.range -= bound;
            } else {
                self.range = bound;
            }
            model.learn(bit);
            while self.range < RENORMALISE_BELOW {
                self.range <<= 8;
                self.code = self.code << 8 | u32::from(*self.bytes.next().unwrap_or(&0));
            }
            bit
        }
    }

    #[test]
    fn numbers_come_back() {
        let numbers: Vec<u32> = (0..3000u32)
            .map(|i| i.wrapping_mul(2_654_435_761) >> (i % 33).min(31))
            .chain([0, 1, u32::MAX, u32::MAX - 1])
            .collect();
        let mut encoder = Encoder::new();
        let (mut number, mut byte) = (Number::default(), Byte::default());
        for &n in &numbers {
            number.pass(&mut encoder, n);
            byte.pass(&mut encoder, n as u8);
        }
        let bytes = encoder.finish();
        let mut decoder = Decoder::new(&bytes);
        let (mut number, mut byte) = (Number::default(), Byte::default());
        for &n in &numbers {
            assert_eq!(number.pass(&mut decoder, 0), n);
            assert_eq!(byte.pass(&mut decoder, 0), n as u8);
        }
    }

    #[test]
    fn what_is_always_the_same_costs_next_to_nothing() {
        let mut encoder = Encoder::new();
        let mut byte = Byte::default();
        (0..4000).for_each(|_| {
            byte.pass(&mut encoder, 128);
        });
        let bytes = encoder.finish().len();
        assert!(bytes < 140, "{bytes} bytes for 4000 equal ones");
    }
}
