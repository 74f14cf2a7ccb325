//! An adaptive binary range coder (Martin, "Range encoding", 1979; the carry as in LZMA), and the models that
//! numbers are written with.

const RENORMALISE_BELOW: u32 = 1 << 24;

/// The probability that a bit is 0, learnt as bits pass: the mean of a quick and a slow estimate, of 16 bits each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Model {
    quick: u16,
    slow: u16,
    /// Bits seen, up to [`MOST_SEEN`]: the first ones count for more.
    seen: u8,
}

/// How far an estimate goes to each bit: a share of 1 / 2^rate of what is left.
const QUICK: u32 = 4;
const SLOW: u32 = 7;
/// Bits after which both shares are what they stay.
const MOST_SEEN: u8 = 1 << (SLOW - 1);

impl Default for Model {
    fn default() -> Self {
        Self { quick: 1 << 15, slow: 1 << 15, seen: 0 }
    }
}

impl Model {
    fn zero(self) -> u32 {
        ((u32::from(self.quick) + u32::from(self.slow)) >> 1).clamp(32, 0xffff - 31)
    }

    fn zero_of(models: &[&mut Self; 2]) -> u32 {
        let sum = models.iter().map(|m| u32::from(m.quick) + u32::from(m.slow)).sum::<u32>();
        (sum >> 2).clamp(32, 0xffff - 31)
    }

    fn steady(self) -> u32 {
        u32::from(self.slow).clamp(32, 0xffff - 31)
    }

    fn learn(&mut self, bit: bool) {
        // The share falls as that of a mean of all bits so far would.
        let rate = 8 - (self.seen + 1).leading_zeros();
        self.seen = (self.seen + 1).min(MOST_SEEN);
        let (quick, slow) = (rate.min(QUICK), rate.min(SLOW));
        if bit {
            self.quick -= self.quick >> quick;
            self.slow -= self.slow >> slow;
        } else {
            self.quick += (((1u32 << 16) - u32::from(self.quick)) >> quick) as u16;
            self.slow += (((1u32 << 16) - u32::from(self.slow)) >> slow) as u16;
        }
    }
}

/// Something that bits pass through: an encoder writes the bit that it is given and returns it, a decoder returns
/// the bit that was written. So models need to be spelt out only once.
pub(super) trait Bits {
    fn bit(&mut self, model: &mut Model, bit: bool) -> bool;

    /// As [`Bits::bit`], where two models know something: the mean of what they say counts.
    fn pair(&mut self, models: [&mut Model; 2], bit: bool) -> bool;

    /// As [`Bits::bit`], of what is nearly even: only the slow estimate counts.
    fn steady(&mut self, model: &mut Model, bit: bool) -> bool;

    /// A bit that is as likely 0 as 1.
    fn even(&mut self, bit: bool) -> bool;

    /// Whether a decoder was asked for much more than was written.
    fn is_beyond_end(&self) -> bool {
        false
    }

    /// `value`, below 2^`count`, in `count` even bits, highest first.
    fn plain(&mut self, value: u32, count: u32) -> u32 {
        (0..count).rev().fold(0, |found, i| found << 1 | u32::from(self.even(value >> i & 1 == 1)))
    }
}

/// Writes bits to bytes.
#[derive(Debug)]
pub(super) struct Encoder {
    low: u64,
    range: u32,
    cache: u8,
    pending: u64,
    bytes: Vec<u8>,
    /// Where the first byte goes, which is always 0.
    start: usize,
}

impl Encoder {
    /// Writes behind what `bytes` hold already.
    pub(super) fn new(bytes: Vec<u8>) -> Self {
        let start = bytes.len();
        Self { low: 0, range: u32::MAX, cache: 0, pending: 1, bytes, start }
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

    fn narrow(&mut self, bound: u32, bit: bool) -> bool {
        if bit {
            self.low += u64::from(bound);
            self.range -= bound;
        } else {
            self.range = bound;
        }
        while self.range < RENORMALISE_BELOW {
            self.range <<= 8;
            self.shift();
        }
        bit
    }

    pub(super) fn finish(mut self) -> Vec<u8> {
        (0..5).for_each(|_| self.shift());
        self.bytes.remove(self.start);
        // A decoder takes zeros for what is missing.
        while self.bytes.len() > self.start && self.bytes.last() == Some(&0) {
            self.bytes.pop();
        }
        self.bytes
    }
}

impl Bits for Encoder {
    fn bit(&mut self, model: &mut Model, bit: bool) -> bool {
        let bound = (self.range >> 16) * model.zero();
        model.learn(bit);
        self.narrow(bound, bit)
    }

    fn pair(&mut self, models: [&mut Model; 2], bit: bool) -> bool {
        let bound = (self.range >> 16) * Model::zero_of(&models);
        models.into_iter().for_each(|model| model.learn(bit));
        self.narrow(bound, bit)
    }

    fn steady(&mut self, model: &mut Model, bit: bool) -> bool {
        let bound = (self.range >> 16) * model.steady();
        model.learn(bit);
        self.narrow(bound, bit)
    }

    fn even(&mut self, bit: bool) -> bool {
        self.narrow(self.range >> 1, bit)
    }
}

/// Reads what [`Encoder`] wrote.
#[derive(Debug)]
pub(super) struct Decoder<'a> {
    code: u32,
    range: u32,
    bytes: std::slice::Iter<'a, u8>,
    missing: u32,
}

/// Bytes that may be missing at the end: those of the last number, and zeros that were left out.
const MOST_MISSING: u32 = 64;

impl<'a> Decoder<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let mut decoder = Self { code: 0, range: u32::MAX, bytes: bytes.iter(), missing: 0 };
        (0..4).for_each(|_| decoder.code = decoder.code << 8 | decoder.next());
        decoder
    }

    fn next(&mut self) -> u32 {
        match self.bytes.next() {
            Some(&byte) => u32::from(byte),
            None => {
                self.missing = self.missing.saturating_add(1);
                0
            }
        }
    }

    fn narrow(&mut self, bound: u32) -> bool {
        let bit = self.code >= bound;
        if bit {
            self.code -= bound;
            self.range -= bound;
        } else {
            self.range = bound;
        }
        while self.range < RENORMALISE_BELOW {
            self.range <<= 8;
            self.code = self.code << 8 | self.next();
        }
        bit
    }
}

impl Bits for Decoder<'_> {
    fn bit(&mut self, model: &mut Model, _: bool) -> bool {
        let bit = self.narrow((self.range >> 16) * model.zero());
        model.learn(bit);
        bit
    }

    fn pair(&mut self, models: [&mut Model; 2], _: bool) -> bool {
        let bit = self.narrow((self.range >> 16) * Model::zero_of(&models));
        models.into_iter().for_each(|model| model.learn(bit));
        bit
    }

    fn steady(&mut self, model: &mut Model, _: bool) -> bool {
        let bit = self.narrow((self.range >> 16) * model.steady());
        model.learn(bit);
        bit
    }

    fn even(&mut self, _: bool) -> bool {
        self.narrow(self.range >> 1)
    }

    fn is_beyond_end(&self) -> bool {
        self.missing > MOST_MISSING
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
    /// Passes `value` but for its lowest bits that are `left_out`, which are 0.
    pub(super) fn pass(&mut self, bits: &mut impl Bits, value: u8, left_out: u32) -> u8 {
        let mut node = 1usize;
        for i in (left_out..8).rev() {
            let bit = bits.steady(&mut self.0[node], value >> i & 1 == 1);
            node = 2 * node + usize::from(bit);
        }
        (node << left_out & 0xff) as u8
    }
}

/// Numbers of 32 bits, small ones in few bits: the number of digits of value + 1 behind its highest (Elias gamma),
/// then these digits, the two highest of them modelled.
#[derive(Clone, Debug)]
pub(super) struct Number {
    digits: [Model; 32],
    below: [[Model; 4]; 33],
}

impl Default for Number {
    fn default() -> Self {
        let m = Model::default();
        Self { digits: [m; 32], below: [[m; 4]; 33] }
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
            let bit = match found - i {
                depth @ (1 | 2) => {
                    let context = 2 * (depth - 1) as usize + (result & 1) as usize;
                    bits.steady(&mut self.below[found as usize][context], bit)
                }
                _ => bits.even(bit),
            };
            result = 2 * result + u64::from(bit);
        }
        (result - 1) as u32
    }
}

/// Differences: whether there is any, its sign, and its size less one, a bit for each step of the first few.
#[derive(Clone, Debug, Default)]
pub(super) struct Steps {
    none: Model,
    sign: Model,
    steps: [Model; Self::MOST],
}

/// The same, and what goes beyond these steps, as [`Number`] has it.
#[derive(Clone, Debug, Default)]
pub(super) struct Difference {
    steps: Steps,
    beyond: Number,
}

impl Steps {
    const MOST: usize = 12;

    /// Passes `value` bit by bit: `pass` takes the number of a bit and its value.
    fn pass(value: i32, mut pass: impl FnMut(usize, bool) -> Option<bool>) -> (bool, u32) {
        let mut bit = |i: usize, bit: bool| pass(i, bit).unwrap_or(false);
        if !bit(0, value != 0) {
            return (false, 0);
        }
        let negative = bit(1, value < 0);
        let size = value.unsigned_abs();
        let most = Self::MOST as u32;
        let found = (0..most).find(|&step| !bit(2 + step as usize, size > step + 1));
        (negative, 1 + found.unwrap_or(most))
    }

    /// The model of the bit of this number.
    fn model(&mut self, i: usize) -> Option<&mut Model> {
        match i {
            0 => Some(&mut self.none),
            1 => Some(&mut self.sign),
            i => self.steps.get_mut(i - 2),
        }
    }
}

impl Difference {
    pub(super) fn pass(&mut self, bits: &mut impl Bits, value: i32) -> i32 {
        let found = Steps::pass(value, |i, bit| Some(bits.bit(self.steps.model(i)?, bit)));
        self.end(bits, value, found)
    }

    /// The same, where two models know something of the first steps.
    pub(super) fn pass_with(&mut self, bits: &mut impl Bits, other: &mut Steps, value: i32) -> i32 {
        let found = Steps::pass(value, |i, bit| {
            Some(bits.pair([self.steps.model(i)?, other.model(i)?], bit))
        });
        self.end(bits, value, found)
    }

    /// What is left of `value` behind the steps.
    fn end(&mut self, bits: &mut impl Bits, value: i32, (negative, mut size): (bool, u32)) -> i32 {
        if size > Steps::MOST as u32 {
            let more = self.beyond.pass(bits, value.unsigned_abs().wrapping_sub(size));
            size = size.wrapping_add(more);
        }
        let size = size as i32;
        if negative { size.wrapping_neg() } else { size }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back() {
        let numbers: Vec<u32> = (0..3000u32)
            .map(|i| i.wrapping_mul(2_654_435_761) >> (i % 33).min(31))
            .chain([0, 1, u32::MAX, u32::MAX - 1])
            .collect();
        // The first bits are all ones: the first byte waits for a carry.
        let mut encoder = Encoder::new(vec![7]);
        encoder.plain(u32::MAX, 32);
        let mut pair = (Difference::default(), Steps::default());
        let models = || (Number::default(), Byte::default(), Difference::default());
        let (mut number, mut byte, mut difference) = models();
        for &n in &numbers {
            number.pass(&mut encoder, n);
            byte.pass(&mut encoder, n as u8, 0);
            byte.pass(&mut encoder, n as u8 & !7, 3);
            difference.pass(&mut encoder, n as i32 >> 8);
            pair.0.pass_with(&mut encoder, &mut pair.1, n as i32 >> 22);
            encoder.plain(n & 1023, 10);
        }
        let bytes = encoder.finish();
        assert_eq!(bytes[0], 7);
        let mut decoder = Decoder::new(&bytes[1..]);
        assert_eq!(decoder.plain(0, 32), u32::MAX);
        let (mut number, mut byte, mut difference) = models();
        pair = (Difference::default(), Steps::default());
        for &n in &numbers {
            assert_eq!(number.pass(&mut decoder, 0), n);
            assert_eq!(byte.pass(&mut decoder, 0, 0), n as u8);
            assert_eq!(byte.pass(&mut decoder, 0, 3), n as u8 & !7);
            assert_eq!(difference.pass(&mut decoder, 0), n as i32 >> 8);
            assert_eq!(pair.0.pass_with(&mut decoder, &mut pair.1, 0), n as i32 >> 22);
            assert_eq!(decoder.plain(0, 10), n & 1023);
        }
        assert!(!decoder.is_beyond_end());
    }

    #[test]
    fn what_is_always_the_same_costs_next_to_nothing() {
        let mut encoder = Encoder::new(Vec::new());
        let mut byte = Byte::default();
        (0..4000).for_each(|_| {
            byte.pass(&mut encoder, 128, 0);
        });
        let bytes = encoder.finish().len();
        assert!(bytes < 90, "{bytes} bytes for 4000 equal ones");
    }
}
