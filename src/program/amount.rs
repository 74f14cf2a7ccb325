//! Parses times, rates and sizes of the command line exactly.

use std::num::NonZeroUsize;

use polyreel::frame::Rational;
use polyreel::pipeline::MOST_THREADS;

/// Digits after the point that are read: nanoseconds.
const DIGITS: usize = 9;

/// Whole digits that are read: more than a thousand years of seconds.
const WHOLE_DIGITS: usize = 12;

/// A decimal number such as `12` or `0.04`, exactly.
fn decimal(text: &str) -> Option<Rational> {
    let (whole, part) = text.split_once('.').unwrap_or((text, ""));
    let digits = |s: &str| s.bytes().all(|b| b.is_ascii_digit());
    if whole.len() + part.len() == 0 || !digits(whole) || !digits(part) {
        return None;
    }
    if whole.len() > WHOLE_DIGITS || part.len() > DIGITS {
        return None;
    }
    let scale = 10i64.pow(part.len() as u32);
    let number = |s: &str| if s.is_empty() { Some(0) } else { s.parse::<i64>().ok() };
    let num = number(whole)?.checked_mul(scale)?.checked_add(number(part)?)?;
    Some(Rational::new(num, scale))
}

/// A number of threads.
pub(crate) fn threads(text: &str) -> Result<NonZeroUsize, String> {
    let number = text.parse().ok().filter(|number: &NonZeroUsize| number.get() <= MOST_THREADS);
    number.ok_or_else(|| format!("'{text}' is not a number of threads: 1 to {MOST_THREADS}"))
}

/// A time: seconds (`90`, `1.5`, `1.5s`), milliseconds (`500ms`), or `[hours:]minutes:seconds`.
pub(crate) fn time(text: &str) -> Result<Rational, String> {
    let wrong = || format!("'{text}' is not a time: write 1.5, 500ms, 1:30 or 0:01:30.5");
    if let Some(millis) = text.strip_suffix("ms") {
        let millis = decimal(millis).ok_or_else(wrong)?;
        return Ok(millis * Rational::new(1, 1000));
    }
    let parts: Vec<_> = text.strip_suffix('s').unwrap_or(text).split(':').collect();
    if parts.len() > 3 {
        return Err(wrong());
    }
    let sixty = Rational::new(60, 1);
    parts.iter().enumerate().try_fold(Rational::ZERO, |sum, (i, part)| {
        let value = decimal(part).ok_or_else(wrong)?;
        let last = i + 1 == parts.len();
        // 1.5:30 and 1:90 are mistakes.
        if (!last && value.den != 1) || (i > 0 && value >= sixty) {
            return Err(wrong());
        }
        Ok(sum * sixty + value)
    })
}

/// Bytes of memory, above 0: `1073741824`, or with K, M, G or T for powers of 1024 (`512M`, `4GiB`).
pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    let wrong = || format!("'{text}' is not an amount of memory: write 512M, 4G or bytes");
    let upper = text.to_ascii_uppercase();
    let short = upper.strip_suffix("IB").or_else(|| upper.strip_suffix('B')).unwrap_or(&upper);
    let unit = short.chars().last().and_then(|unit| "KMGT".find(unit));
    let digits = if unit.is_some() { &short[..short.len() - 1] } else { short };
    let number = decimal(digits).ok_or_else(wrong)?;
    let factor = unit.map_or(1i64, |power| 1 << (10 * (power + 1)));
    let bytes = number.num.checked_mul(factor).ok_or_else(wrong)? / number.den;
    u64::try_from(bytes).ok().filter(|&bytes| bytes > 0).ok_or_else(wrong)
}

/// A factor above 0 and at most 16.
pub(crate) fn factor(text: &str) -> Result<f64, String> {
    let value = decimal(text).map(Rational::to_f64).filter(|v| *v > 0.0 && *v <= 16.0);
    value.ok_or_else(|| format!("'{text}' is not a factor: write 1, 0.5 or 2, at most 16"))
}

/// Frames per second: `25`, `24000/1001`, or a decimal, where 23.976, 29.97, 59.94 and 119.88 mean the
/// NTSC rates that they abbreviate.
pub(crate) fn rate(text: &str) -> Result<Rational, String> {
    let wrong = || format!("'{text}' is not a rate: write 25, 29.97 or 24000/1001");
    let rate = match text.split_once('/') {
        Some((num, den)) => {
            let (num, den) = (decimal(num).ok_or_else(wrong)?, decimal(den).ok_or_else(wrong)?);
            num * den.recip().ok_or_else(wrong)?
        }
        None => ntsc(text).map_or_else(|| decimal(text).ok_or_else(wrong), Ok)?,
    };
    if rate <= Rational::ZERO || rate > Rational::new(1000, 1) {
        return Err(format!("{text} frames a second cannot be; the rate is above 0, at most 1000"));
    }
    Ok(rate)
}

/// The NTSC rate (n x 1000/1001) that a rounded decimal means.
fn ntsc(text: &str) -> Option<Rational> {
    let nominal = match text {
        "23.976" | "23.98" => 24,
        "29.97" => 30,
        "47.952" | "47.95" => 48,
        "59.94" => 60,
        "119.88" => 120,
        _ => return None,
    };
    Some(Rational::new(nominal * 1000, 1001))
}

/// The words of a line; quotes of both kinds and a backslash keep blanks in a word.
pub(crate) fn words(line: &str) -> Result<Vec<String>, String> {
    let (mut words, mut word) = (Vec::new(), None::<String>);
    let (mut quote, mut letters) = (None, line.chars());
    while let Some(letter) = letters.next() {
        match (letter, quote) {
            (_, Some(open)) if letter == open => quote = None,
            ('"' | '\'', None) => {
                quote = Some(letter);
                word.get_or_insert_default();
            }
            ('\\', None | Some('"')) => {
                let kept = letters.next().ok_or("a backslash at the end has nothing to keep")?;
                word.get_or_insert_default().push(kept);
            }
            (_, None) if letter.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(letter),
        }
    }
    if let Some(open) = quote {
        return Err(format!("{line}: a quote {open} is not closed"));
    }
    words.extend(word);
    Ok(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_exact() {
        for (text, num, den) in [
            ("0", 0, 1),
            ("1.5", 3, 2),
            ("1.5s", 3, 2),
            (".04", 1, 25),
            ("500ms", 1, 2),
            ("33.4ms", 167, 5000),
            ("1:30", 90, 1),
            ("0:01:30.5", 181, 2),
            ("100:00:00", 360_000, 1),
        ] {
            assert_eq!(time(text), Ok(Rational::new(num, den)), "{text}");
        }
        for text in ["", ".", "-1", "1e3", "1:90", "1.5:30", "1:2:3:4", "soon", "99999999999999"] {
            assert!(time(text).is_err(), "{text}");
        }
    }

    #[test]
    fn rates_are_exact() {
        for (text, num, den) in [
            ("25", 25, 1),
            ("24000/1001", 24000, 1001),
            ("29.97", 30000, 1001),
            ("23.976", 24000, 1001),
            ("12.5", 25, 2),
            ("0.5", 1, 2),
        ] {
            assert_eq!(rate(text), Ok(Rational::new(num, den)), "{text}");
        }
        for text in ["0", "-5", "1/0", "24000/", "1001", "ntsc", "0/5"] {
            assert!(rate(text).is_err(), "{text}");
        }
    }

    #[test]
    fn memory_is_counted_in_powers_of_1024() {
        for (text, expected) in [
            ("1000", 1000),
            ("512M", 512 << 20),
            ("4GiB", 4 << 30),
            ("1.5k", 1536),
            ("2gb", 2 << 30),
        ] {
            assert_eq!(bytes(text), Ok(expected), "{text}");
        }
        for text in ["", "0", "M", "-1", "12 apples", "1e9", "99999999T"] {
            assert!(bytes(text).is_err(), "{text}");
        }
    }
}
