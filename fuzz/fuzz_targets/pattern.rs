//! File names with a number in them. A name that a pattern makes has the number that it was made of.
#![no_main]

use libfuzzer_sys::fuzz_target;
use polyreel::pattern::Pattern;

fuzz_target!(|text: &str| {
    let Some(pattern) = Pattern::parse(text) else { return };
    for number in [0, 1, 9_999, u64::MAX] {
        assert_eq!(pattern.number(&pattern.name(number)), Some(number));
    }
});
