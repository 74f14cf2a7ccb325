//! What a misspelt name was probably meant to be.

use polyreel::error::Error;
use strsim::normalized_damerau_levenshtein;

/// The least likeness of two names, 0 to 1, at which one is suggested for the other: a letter in three may differ.
const LIKENESS: f64 = 0.6;

/// Letters of a part of a name that suggest the whole: `glass` for `stained-glass`.
const PART: usize = 4;

/// The one of `names` that is most like `given`, if one is. Case and punctuation do not count.
pub(crate) fn nearest<'a>(given: &str, names: &[&'a str]) -> Option<&'a str> {
    let given = plain(given);
    let scored = names.iter().map(|name| (likeness(&given, &plain(name)), *name));
    let best = scored.max_by(|one, other| one.0.total_cmp(&other.0))?;
    (best.0 >= LIKENESS).then_some(best.1)
}

/// The error `unknown` of the name `given`, with the one of `names` that was probably meant.
pub(crate) fn meant(unknown: impl Into<Error>, given: &str, names: &[&str]) -> Error {
    let unknown = unknown.into();
    match nearest(given, names) {
        Some(name) => Error::usage(format!("did you mean '{name}'? {unknown}")),
        None => unknown,
    }
}

fn likeness(given: &str, name: &str) -> f64 {
    let whole = normalized_damerau_levenshtein(given, name);
    if given.len() >= PART && name.contains(given) { whole.max(LIKENESS) } else { whole }
}

fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspelt_names_are_recognised() {
        let names = ["bold", "stained-glass", "crystal", "sketch"];
        for (given, meant) in [
            ("crytal", Some("crystal")),
            ("Crystal", Some("crystal")),
            ("stainedglass", Some("stained-glass")),
            ("glass", Some("stained-glass")),
            ("blod", Some("bold")),
            ("watercolour", None),
            ("", None),
        ] {
            assert_eq!(nearest(given, &names), meant, "{given}");
        }
    }

    #[test]
    fn of_names_that_hold_it_the_nearest_is_meant() {
        for (given, meant) in [("point", "points"), ("outlin", "outline")] {
            let names = ["points", "min-points", "outline", "outline-tint"];
            assert_eq!(nearest(given, &names), Some(meant));
        }
    }
}
