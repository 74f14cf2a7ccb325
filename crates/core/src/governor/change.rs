//! The changes of detail by the governor, for the user and for reports.

/// A change of detail, and why.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Change {
    /// What was changed: `steps`, `rows`, `map`, `motion` or `seeds`.
    pub what: &'static str,
    /// The value before.
    pub from: f64,
    /// The value now.
    pub to: f64,
    /// The expected time of the frame without the change, in milliseconds.
    pub expected_ms: f64,
    /// The budget, in milliseconds.
    pub budget_ms: f64,
}

impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { what, from, to, expected_ms, budget_ms } = self;
        match *what {
            "steps" => write!(f, "refinement steps {from} -> {to}"),
            "rows" => write!(f, "colours from every {from}. -> {to}. row"),
            "map" => write!(f, "feature map 1/{from} -> 1/{to} of the size"),
            "motion" => write!(f, "motion found in every {from}. -> {to}. frame"),
            _ => write!(f, "{what} {from} % -> {to} %"),
        }?;
        write!(f, ": {expected_ms:.1} ms expected of {budget_ms:.1} ms")
    }
}

/// A change of `what`; `expected` and `budget` in seconds.
pub(super) fn change(what: &'static str, from: f64, to: f64, expected: f64, budget: f64) -> Change {
    // Rounded to microseconds.
    let ms = |seconds: f64| (seconds * 1e6).round() / 1e3;
    Change { what, from, to, expected_ms: ms(expected), budget_ms: ms(budget) }
}
