//! Mutations of bytes, decided by a seed.

/// Numbers that look random (SplitMix64).
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number from 0 to `end`, which is left out; 0 if that is 0.
    pub(super) fn below(&mut self, end: usize) -> usize {
        if end == 0 { 0 } else { (self.next() % end as u64) as usize }
    }
}

/// Words that numbers in headers are replaced with.
const EXTREMES: [u32; 8] = [0, 1, 0x7f, 0xff, 0x7fff, 0xffff, 0x7fff_ffff, 0xffff_ffff];

/// `bytes` with one to six changes; `other` is what parts are taken from. Of formats with checksums, which `mend`
/// makes right, two in three results have right ones: else nothing behind them would be tried.
pub(super) fn mutated(
    bytes: &[u8],
    other: &[u8],
    mend: Option<fn(&mut [u8])>,
    random: &mut Random,
) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=random.below(6) {
        change(&mut bytes, other, random);
    }
    if let Some(mend) = mend.filter(|_| random.below(3) > 0) {
        mend(&mut bytes);
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    // Half of the changes hit the first bytes, where the headers are.
    let reach = if random.below(2) == 0 { bytes.len().min(64) } else { bytes.len() };
    let at = random.below(reach);
    let length = 1 + random.below(16);
    let end = (at + length).min(bytes.len());
    match random.below(10) {
        0 | 1 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
        2 if at < bytes.len() => bytes[at] = random.below(256) as u8,
        3 => overwrite(bytes, at, &EXTREMES[random.below(8)].to_be_bytes()),
        4 => overwrite(bytes, at, &EXTREMES[random.below(8)].to_le_bytes()),
        5 => overwrite(bytes, at, &(EXTREMES[random.below(8)] as u16).to_le_bytes()),
        6 => bytes.truncate(at),
        7 => drop(bytes.drain(at..end)),
        8 => {
            let part = bytes[at..end].to_vec();
            bytes.splice(at..at, part);
        }
        _ => {
            let from = random.below(other.len());
            let part = other[from..(from + 4 * length).min(other.len())].to_vec();
            bytes.splice(at..end, part);
        }
    }
}

fn overwrite(bytes: &mut [u8], at: usize, with: &[u8]) {
    for (byte, &new) in bytes.iter_mut().skip(at).zip(with) {
        *byte = new;
    }
}
