//! Trims a source: to a start time, an end time, a number of frames.
//!
//! A frame belongs to the part if its start time is in it. Output times count from the start of the part.

use super::{Decoded, Source, SourceOptions};
use crate::error::{Error, Result};
use crate::frame::{Frame, Rational};
use crate::stream::{Span, StreamInfo};

/// A part of a stream.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    start: Rational,
    end: Option<Rational>,
    frames: u64,
}

impl Part {
    /// The part that `options` select; `None` for the whole stream.
    ///
    /// # Errors
    /// When it is empty.
    pub(crate) fn of(options: &SourceOptions) -> Result<Option<Self>> {
        let SourceOptions { start, end, frames, .. } = options;
        if start.is_none() && end.is_none() && frames.is_none() {
            return Ok(None);
        }
        let part = Self {
            start: start.unwrap_or(Rational::ZERO),
            end: *end,
            frames: frames.unwrap_or(u64::MAX),
        };
        if part.start < Rational::ZERO {
            return Err(Error::usage("a start before the input's first moment cannot be met"));
        }
        if part.end.is_some_and(|end| end <= part.start) {
            return Err(Error::usage("the end must be later than the start"));
        }
        if part.frames == 0 {
            return Err(Error::usage("0 frames make no output; ask for at least 1"));
        }
        Ok(Some(part))
    }

    /// The number of frames of a constant `rate` that have to be decoded, counted from the start of the stream.
    pub(crate) fn needed(&self, rate: Rational) -> u64 {
        let upto = |end: Rational| ceil(end * rate);
        let by_frames = upto(self.start).saturating_add(self.frames);
        self.end.map_or(by_frames, |end| upto(end).min(by_frames))
    }

    /// The properties of the part of the stream `info`. The number of frames is known if the rate is constant, or if
    /// only the number is limited.
    pub(crate) fn info(&self, mut info: StreamInfo) -> StreamInfo {
        if info.still {
            return info;
        }
        let total = info.frames;
        let steady = info.rate.filter(|&rate| is_steady(rate, &info));
        let whole = self.start == Rational::ZERO && self.end.is_none();
        info.frames = match (steady, total) {
            (Some(rate), Some(total)) => {
                let skipped = ceil(self.start * rate);
                Some(self.needed(rate).min(total).saturating_sub(skipped).min(self.frames))
            }
            (_, Some(total)) if whole => Some(total.min(self.frames)),
            // One frame makes a still.
            _ => (self.frames == 1).then_some(1),
        };
        info.duration = match (info.frames, steady) {
            (Some(frames), _) if whole && Some(frames) == total => info.duration,
            (Some(frames), Some(rate)) => {
                rate.recip().map(|length| length * Rational::new(frames as i64, 1))
            }
            // Unknown with a limit on the number of frames.
            _ => info.duration.filter(|_| self.frames == u64::MAX).map(|duration| {
                let end = self.end.map_or(duration, |end| end.min(duration));
                (end - self.start).max(Rational::ZERO)
            }),
        };
        info
    }
}

/// Whether the number of frames and the duration of a stream agree with its `rate`. That of a video with a variable
/// rate is only the finest step between frames.
fn is_steady(rate: Rational, info: &StreamInfo) -> bool {
    let (Some(frames), Some(duration)) = (info.frames, info.duration) else { return false };
    let frames = Rational::new(i64::try_from(frames).unwrap_or(i64::MAX), 1);
    let off = duration * rate - frames;
    off.max(-off) <= Rational::new(1, 1)
}

/// `value`, at least 0, rounded up.
fn ceil(value: Rational) -> u64 {
    u64::try_from(-(-value.num).div_euclid(value.den)).unwrap_or(0)
}

/// A source that delivers a part of another.
pub(crate) struct Trim {
    inner: Box<dyn Source>,
    part: Part,
    delivered: u64,
    /// Whether frames of the part were skipped on request.
    skipped: bool,
}

impl Trim {
    /// `part` of `inner`.
    pub(crate) fn new(mut inner: Box<dyn Source>, part: Part) -> Self {
        if part.start > Rational::ZERO {
            inner.skip_to(part.start);
        }
        Self { inner, part, delivered: 0, skipped: false }
    }

    /// The end of the part: an error if it had no frame.
    fn end(&self) -> Result<Option<Decoded>> {
        if self.delivered == 0 && !self.skipped {
            let start = self.part.start.to_f64();
            return Err(Error::usage(format!(
                "no frame of the input starts at {start} s or later within the part asked for; \
                 choose an earlier start"
            )));
        }
        Ok(None)
    }
}

impl Source for Trim {
    fn recycle(&mut self, frame: Frame) {
        self.inner.recycle(frame);
    }

    fn skip_to(&mut self, start: Rational) {
        // Skipped frames count too if the number of frames is limited: then none can be skipped.
        if self.part.frames == u64::MAX {
            self.skipped = start > Rational::ZERO;
            self.inner.skip_to(self.part.start + start);
        }
    }

    fn next(&mut self) -> Result<Option<Decoded>> {
        if self.delivered == self.part.frames {
            return Ok(None);
        }
        loop {
            let Some(Decoded { frame, span, is_warmup }) = self.inner.next()? else {
                return self.end();
            };
            if self.part.end.is_some_and(|end| span.start >= end) {
                return self.end();
            }
            if span.start >= self.part.start {
                self.delivered += 1;
                let span = Span { start: span.start - self.part.start, ..span };
                return Ok(Some(Decoded { frame, span, is_warmup }));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(start: (i64, i64), end: Option<(i64, i64)>, frames: Option<u64>) -> Part {
        let time = |(num, den)| Rational::new(num, den);
        let options = SourceOptions {
            start: Some(time(start)),
            end: end.map(time),
            frames,
            ..SourceOptions::default()
        };
        Part::of(&options).expect("a part").expect("not the whole")
    }

    #[test]
    fn frames_that_start_in_the_part_are_counted() {
        let rate = Rational::new(10, 1);
        // Frames start at 0, 0.1, 0.2 ...; those at 0.2 to 0.4 lie in the part.
        assert_eq!(part((15, 100), Some((5, 10)), None).needed(rate), 5);
        assert_eq!(part((15, 100), Some((5, 10)), Some(2)).needed(rate), 4);
        assert_eq!(part((0, 1), None, Some(7)).needed(rate), 7);
        assert_eq!(part((3, 1), None, None).needed(rate), u64::MAX);
    }

    #[test]
    fn empty_parts_are_usage_errors() {
        let second = Some(Rational::new(1, 1));
        for options in [
            SourceOptions { start: second, end: second, ..SourceOptions::default() },
            SourceOptions { frames: Some(0), ..SourceOptions::default() },
            SourceOptions { start: Some(Rational::new(-1, 1)), ..SourceOptions::default() },
        ] {
            assert!(matches!(Part::of(&options), Err(Error::Usage(_))), "{options:?}");
        }
    }
}
