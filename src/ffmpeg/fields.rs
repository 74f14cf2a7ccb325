//! Parses the fields of ffprobe.

use serde_json::Value;

use crate::frame::Rational;

/// A field, unless it means "unknown".
pub(super) fn text<'a>(value: &'a Value, key: &str) -> Option<&'a str> {
    value[key].as_str().filter(|text| !matches!(*text, "unknown" | "reserved" | "N/A" | ""))
}

/// `30000/1001` or `4:3`; neither part may be 0.
pub(super) fn fraction(text: &str) -> Option<Rational> {
    let (num, den) = text.split_once(['/', ':'])?;
    let (num, den): (i64, i64) = (num.parse().ok()?, den.parse().ok()?);
    (num > 0 && den > 0).then(|| Rational::new(num, den))
}

/// Seconds with up to nine decimals.
pub(super) fn decimal(text: &str) -> Option<Rational> {
    let (whole, part) = text.split_once('.').unwrap_or((text, ""));
    let part = part.get(..part.len().min(9))?;
    let scale = 10i64.checked_pow(part.len() as u32)?;
    let sum: i64 = format!("{}{part}", whole.trim_start_matches('-')).parse().ok()?;
    Some(Rational::new(if whole.starts_with('-') { -sum } else { sum }, scale))
}

/// `00:01:02.500000000`, as Matroska's tags have it.
pub(super) fn clock(text: &str) -> Option<Rational> {
    let mut parts = text.split(':');
    let (hours, minutes, seconds) = (parts.next()?, parts.next()?, parts.next()?);
    let minutes = hours.parse::<i64>().ok()?.checked_mul(60)?.checked_add(minutes.parse().ok()?)?;
    Some(Rational::new(minutes.checked_mul(60)?, 1) + decimal(seconds)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_as_ffprobe_writes_them() {
        assert_eq!(fraction("30000/1001"), Some(Rational::new(30000, 1001)));
        assert_eq!(fraction("0/0"), None);
        assert_eq!(decimal("-1.40"), Some(Rational::new(-7, 5)));
        assert_eq!(decimal("-0.5"), Some(Rational::new(-1, 2)));
        assert_eq!(clock("00:01:02.500000000"), Some(Rational::new(125, 2)));
        assert_eq!(clock("99999999999999999999:00:00"), None);
    }
}
