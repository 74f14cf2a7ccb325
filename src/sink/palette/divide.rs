//! Many colours split into few sets, where that lowers the squared error most.

use super::{MOST, Rgb, Weighted, add};

/// A set of colours, the axis on which it is split best, and what that gains.
struct Cell {
    colours: Vec<Weighted>,
    /// How much the split lowers the squared error; 0 if it cannot be split.
    gain: f64,
    /// The first colour of the upper half, in the order of the axis.
    at: usize,
}

/// [`MOST`] colours for more than that.
pub(super) fn divide(colours: &[Weighted]) -> Vec<Rgb> {
    let mut cells = vec![Cell::new(colours.to_vec())];
    while cells.len() < MOST {
        let mut best = 0;
        for (i, cell) in cells.iter().enumerate() {
            if cell.gain > cells[best].gain {
                best = i;
            }
        }
        if cells[best].gain <= 0.0 {
            break;
        }
        let cell = cells.swap_remove(best);
        let mut lower = cell.colours;
        let upper = lower.split_off(cell.at);
        cells.extend([Cell::new(lower), Cell::new(upper)]);
    }
    cells.iter().map(Cell::mean).collect()
}

impl Cell {
    fn new(mut colours: Vec<Weighted>) -> Self {
        let axis = dispatch(&colours);
        // Colours are distinct, so that the order is decided.
        colours.sort_unstable_by_key(|w| (w.colour[axis], w.colour));
        let (gain, at) = best_split(&colours);
        Self { colours, gain, at }
    }

    fn mean(&self) -> Rgb {
        let [r, g, b, n] = sums(&self.colours);
        [r, g, b].map(|s| ((s + n / 2) / n.max(1)) as u8)
    }
}

/// Sums of the channels, and of the weights.
fn sums(colours: &[Weighted]) -> [u64; 4] {
    let mut sums = [0; 4];
    for w in colours {
        add(&mut sums, w);
    }
    sums
}

/// The channel of the largest variance.
fn dispatch(colours: &[Weighted]) -> usize {
    let [r, g, b, n] = sums(colours);
    let mut squares = [0u64; 3];
    for w in colours {
        for (s, c) in squares.iter_mut().zip(w.colour) {
            *s += w.weight * u64::from(c) * u64::from(c);
        }
    }
    let n = n.max(1) as f64;
    let spread = |i: usize, sum: u64| squares[i] as f64 - sum as f64 * (sum as f64 / n);
    let spreads = [spread(0, r), spread(1, g), spread(2, b)];
    (1..3).fold(0, |best, i| if spreads[i] > spreads[best] { i } else { best })
}

/// Where splitting a sorted list lowers the squared error most, and by how much: the sum of
/// |channel sums|^2 / weight of both halves less that of the whole.
fn best_split(colours: &[Weighted]) -> (f64, usize) {
    let part = |s: [u64; 4]| {
        let [r, g, b, n] = s.map(|v| v as f64);
        (r * r + g * g + b * b) / n
    };
    let whole = sums(colours);
    let (mut lower, mut best) = ([0; 4], (0.0, 0));
    for (i, w) in colours.iter().enumerate().take(colours.len().saturating_sub(1)) {
        add(&mut lower, w);
        let upper = std::array::from_fn(|k| whole[k] - lower[k]);
        let gain = part(lower) + part(upper) - part(whole);
        if gain > best.0 {
            best = (gain, i + 1);
        }
    }
    best
}
