//! A stream of frames, whose mesh is carried while time goes forward.

use polyreel_core::{Frame, Options, Renderer, Result, Rgba, Size};

/// A step forward of more than this number of frames is a jump: the mesh starts afresh. Hosts that drop frames skip
/// fewer.
const JUMP: f64 = 12.5;

/// A renderer and the time of its last frame, in the unit of the host: ffmpeg passes milliseconds, others seconds.
#[derive(Debug, Default)]
pub(crate) struct Stream {
    renderer: Option<(Renderer, Options)>,
    last: Option<f64>,
    /// The shortest step between two frames so far.
    step: Option<f64>,
    /// The last picture, and its rendering.
    shown: (Vec<Rgba>, Vec<Rgba>),
}

impl Stream {
    /// The time of the last frame; `None` before the first one.
    pub(crate) fn last(&self) -> Option<f64> {
        self.last
    }

    /// Whether the distance of frames is known.
    pub(crate) fn knows_step(&self) -> bool {
        self.step.is_some()
    }

    /// Whether a frame at `time` is the next one, by the steps so far.
    pub(crate) fn is_next(&self, time: f64) -> bool {
        match (self.last, self.step) {
            (Some(last), Some(step)) => time - last <= 1.5 * step,
            _ => true,
        }
    }

    /// Whether a frame at `time` continues the last one: time has not gone back or jumped.
    pub(crate) fn goes_on(&self, time: f64) -> bool {
        let Some(last) = self.last else { return true };
        let passed = time - last;
        // The same time again: a paused host, or one without times.
        passed == 0.0 || passed > 0.0 && self.step.is_none_or(|step| passed <= JUMP * step)
    }

    /// Forgets all frames: the next one starts afresh.
    pub(crate) fn reset(&mut self) {
        *self = Self { shown: std::mem::take(&mut self.shown), ..Self::default() };
    }

    /// Renders the frame `input` at `time` into `output`; both hold width x height pixels.
    ///
    /// # Errors
    /// When the size is not possible, or the frame cannot be rendered.
    pub(crate) fn render(
        &mut self,
        size: Size,
        options: &Options,
        time: f64,
        input: &[Rgba],
        output: &mut [Rgba],
    ) -> Result<()> {
        if !self.goes_on(time) {
            self.reset();
        }
        let (mut pixels, mut painted) = std::mem::take(&mut self.shown);
        // The same frame again, from a host that redraws it or from several of its workers, gives the same result.
        let again = self.last == Some(time) && self.has(options) && pixels == input;
        if !again {
            pixels.clear();
            pixels.extend_from_slice(input);
            let frame = Frame::new(size, pixels)?;
            painted = self.renderer(options)?.render(&frame)?.picture.into_pixels();
            pixels = frame.into_pixels();
            self.remember(time);
        }
        output.copy_from_slice(&painted);
        self.shown = (pixels, painted);
        Ok(())
    }

    /// Whether the last frame was rendered with `options`.
    fn has(&self, options: &Options) -> bool {
        self.renderer.as_ref().is_some_and(|(_, last)| last == options)
    }

    fn remember(&mut self, time: f64) {
        if let Some(last) = self.last
            && time > last
        {
            self.step = Some(self.step.map_or(time - last, |step| step.min(time - last)));
        }
        self.last = Some(time);
    }

    /// The renderer, made at the first frame and retuned when options change.
    fn renderer(&mut self, options: &Options) -> Result<&mut Renderer> {
        match &mut self.renderer {
            Some((renderer, old)) if old != options => {
                renderer.retune(options)?;
                old.clone_from(options);
            }
            Some(_) => {}
            none => *none = Some((Renderer::new(options)?, options.clone())),
        }
        Ok(self.renderer.as_mut().map(|(renderer, _)| renderer).expect("it was made above"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size { width: 40, height: 30 };

    fn picture(shift: usize) -> Vec<Rgba> {
        let at = |i: usize| (i % 40 + shift, i / 40);
        let dot = |(x, y): (usize, usize)| if (x / 9 + y / 7) % 2 == 0 { 220 } else { 30 };
        (0..SIZE.pixels()).map(|i| [dot(at(i)), (i % 251) as u8, 90, 255]).collect()
    }

    fn render(stream: &mut Stream, time: f64, shift: usize) -> Vec<Rgba> {
        let mut out = vec![[0; 4]; SIZE.pixels()];
        stream
            .render(SIZE, &Options::default(), time, &picture(shift), &mut out)
            .expect("a small frame");
        out
    }

    #[test]
    fn it_renders_what_the_renderer_renders() {
        let (mut stream, mut renderer) =
            (Stream::default(), Renderer::new(&Options::default()).expect("the defaults"));
        for i in 0..5 {
            let frame = Frame::new(SIZE, picture(i)).expect("a small frame");
            let expected = renderer.render(&frame).expect("a frame").picture;
            assert_eq!(render(&mut stream, i as f64 * 40.0, i), expected.pixels());
        }
    }

    #[test]
    fn a_step_back_or_a_leap_begins_anew() {
        let fresh = render(&mut Stream::default(), 0.0, 3);
        for jump in [-1.0, 2.0 + 13.0] {
            let mut stream = Stream::default();
            for i in 0..3 {
                render(&mut stream, f64::from(i), i as usize);
            }
            assert_eq!(render(&mut stream, jump, 3), fresh, "to {jump}");
        }
    }

    #[test]
    fn dropped_frames_and_a_time_that_stands_still_go_on() {
        let mut stream = Stream::default();
        for time in [0.0, 1.0, 4.0, 4.0, 5.0] {
            assert!(stream.goes_on(time));
            render(&mut stream, time, 0);
        }
        assert!(stream.is_next(6.0) && !stream.is_next(7.0));
    }
}
