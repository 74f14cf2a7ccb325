//! Changes GIF delays to those that browsers use.

use super::{Decoded, Input, Source};
use crate::error::Result;
use crate::frame::{Frame, Rational};
use crate::stream::Span;

/// The longest delay that browsers replace, and the one that they use instead, in hundredths of a second.
const TOO_SHORT: Rational = Rational { num: 1, den: 100 };
const SHOWN: Rational = Rational { num: 1, den: 10 };

/// A GIF with the delays 0 and 1 replaced by ten hundredths.
struct Delays {
    inner: Box<dyn Source>,
    /// The sum of the added delays so far.
    shift: Rational,
}

/// The animation `input` with the delays that browsers show.
pub(super) fn as_shown(input: Input) -> Input {
    if input.info.still || input.info.format != "gif" {
        return input;
    }
    let Input { mut info, mut start, .. } = input;
    let short = info.rate.and_then(Rational::recip).is_some_and(|delay| delay <= TOO_SHORT);
    if short || info.duration == Some(Rational::ZERO) {
        info.rate = SHOWN.recip();
        let frames = info.frames.and_then(|frames| i64::try_from(frames).ok());
        info.duration = frames.map(|frames| SHOWN * Rational::new(frames, 1));
    }
    let start = Box::new(move || {
        Ok(Box::new(Delays { inner: start()?, shift: Rational::ZERO }) as Box<dyn Source>)
    });
    Input { info, start, ..input }
}

impl Source for Delays {
    fn next(&mut self) -> Result<Option<Decoded>> {
        let Some(mut decoded) = self.inner.next()? else { return Ok(None) };
        decoded.span.start = decoded.span.start + self.shift;
        if let Some(length) = decoded.span.length.filter(|length| *length <= TOO_SHORT) {
            self.shift = self.shift + SHOWN - length;
            decoded.span = Span { length: Some(SHOWN), ..decoded.span };
        }
        Ok(Some(decoded))
    }

    fn recycle(&mut self, frame: Frame) {
        self.inner.recycle(frame);
    }
}
