//! Path data in as few bytes as SVG allows: relative steps, no separator where a sign is one.

/// The text of a `d` attribute.
#[derive(Debug, Default)]
pub(super) struct PathData {
    text: String,
    /// The current point, once there was one.
    at: Option<(i32, i32)>,
}

impl PathData {
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// Adds a polygon. Fills close it by themselves; `closed` says that a line around it does, too.
    pub(super) fn polygon(&mut self, points: impl IntoIterator<Item = (i32, i32)>, closed: bool) {
        let mut first = None;
        for point in points {
            if first.is_none() {
                self.jump(point);
                first = Some(point);
            } else if self.at != Some(point) {
                self.line(point);
            }
        }
        if closed {
            self.text.push('z');
            self.at = first;
        }
    }

    /// Begins a line at `point`.
    pub(super) fn jump(&mut self, point: (i32, i32)) {
        self.text.push('m');
        self.step(point, true);
    }

    /// A line to `point`.
    pub(super) fn line(&mut self, point: (i32, i32)) {
        self.step(point, false);
    }

    fn step(&mut self, (x, y): (i32, i32), begins: bool) {
        let (from_x, from_y) = self.at.unwrap_or((0, 0));
        self.number(x - from_x, begins);
        self.number(y - from_y, false);
        self.at = Some((x, y));
    }

    fn number(&mut self, value: i32, begins: bool) {
        use std::fmt::Write as _;
        if value >= 0 && !begins {
            self.text.push(' ');
        }
        // Writing to a string cannot fail.
        let _ = write!(self.text, "{value}");
    }
}

/// `value` with at most `digits` after the point, without zeros that say nothing.
pub(super) fn decimal(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    if !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_relative_and_signs_separate() {
        let mut data = PathData::default();
        data.polygon([(10, 20), (15, 18), (9, 9)], false);
        assert_eq!(data.text(), "m10 20 5-2-6-9");
        data.polygon([(9, 9), (9, 12), (9, 12), (3, 3)], false);
        assert_eq!(data.text(), "m10 20 5-2-6-9m0 0 0 3-6-9");
    }

    #[test]
    fn a_closed_polygon_ends_where_it_began() {
        let mut data = PathData::default();
        data.polygon([(1, 1), (2, 1), (2, 2)], true);
        data.polygon([(1, 1), (2, 1), (2, 2)], true);
        assert_eq!(data.text(), "m1 1 1 0 0 1zm0 0 1 0 0 1z");
    }

    #[test]
    fn decimals_are_short() {
        assert_eq!(decimal(0.5, 3), "0.5");
        assert_eq!(decimal(8.0, 2), "8");
        assert_eq!(decimal(100.0, 0), "100");
        assert_eq!(decimal(1.0 / 3.0, 2), "0.33");
    }
}
