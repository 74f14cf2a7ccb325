//! Reads the input ahead on its own thread, again and again.

use std::sync::Arc;
use std::thread;
use std::time::Instant;

use polyreel::error::{Error, Result};
use polyreel::frame::Rational;
use polyreel::source::{Input, Source};

use super::playback::Deck;

/// Starts to read `input` for `deck`. A file is read again from its beginning when it ends; a still, and
/// what can be read only once, is not. The thread ends when `deck` does; a camera that delivers nothing
/// may keep it, which [`polyreel::ffmpeg::Processes::end_readers`] helps.
///
/// # Errors
/// When no thread can be started.
pub(super) fn spawn(input: Input, allow_truncated: bool, deck: &Arc<Deck>) -> Result<()> {
    let deck = deck.clone();
    let read = move || {
        if let Err(error) = read(input, allow_truncated, &deck) {
            deck.fail(error);
        }
    };
    let spawned = thread::Builder::new().name("feed".to_owned()).spawn(read);
    spawned.map(|_| ()).map_err(|error| Error::thread("feed", error))
}

fn read(mut input: Input, allow_truncated: bool, deck: &Deck) -> Result<()> {
    let rounds = input.repeats() && !input.info().still;
    let mut from = Rational::ZERO;
    loop {
        let source = input.restart()?;
        let fed = read_round(source, from, allow_truncated, deck)?;
        if fed == 0 && from == Rational::ZERO && !deck.looks_away() {
            return Err(Error::NoFrames);
        }
        if !rounds && !deck.wait_for_jump() {
            return Ok(());
        }
        if deck.is_over() {
            return Ok(());
        }
        from = deck.sought().unwrap_or(Rational::ZERO);
    }
}

/// Reads what starts at `from` or later to the end, or until the window is gone. Returns the number of frames.
fn read_round(
    mut source: Box<dyn Source>,
    from: Rational,
    allow_truncated: bool,
    deck: &Deck,
) -> Result<u64> {
    if from > Rational::ZERO {
        source.skip_to(from);
    }
    let mut fed = 0;
    loop {
        let began = Instant::now();
        let decoded = match source.next() {
            Ok(Some(decoded)) => decoded,
            Ok(None) => return Ok(fed),
            Err(_) if deck.looks_away() => return Ok(fed),
            Err(error) if allow_truncated && fed > 0 && error.breaks_off() => return Ok(fed),
            Err(error) => return Err(error),
        };
        // Not every format can leave frames out.
        let early = decoded.span.start < from;
        if early && deck.looks_away() || !early && !deck.feed(decoded, fed == 0, began.elapsed()) {
            return Ok(fed);
        }
        fed += u64::from(!early);
    }
}
