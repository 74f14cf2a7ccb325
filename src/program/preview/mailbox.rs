//! A slot for finished pictures, until the window takes them: it holds the newest one.
//!
//! A writer never waits, and a reader gets the newest picture.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use polyreel::error::Result;
use polyreel::frame::{Buffers, Frame};
use polyreel::pipeline::FrameReport;
use polyreel::sink::{Needs, Origin, Picture, Sink};
use polyreel::stream::Span;

use super::playback::Deck;
use super::recorder::Recorder;

/// A picture with all data that the window can show.
#[derive(Debug)]
pub(super) struct Shown {
    /// The low-poly picture.
    pub(super) frame: Frame,
    /// Its source frame and mesh.
    pub(super) origin: Origin,
    /// Its time in the stream.
    pub(super) span: Span,
}

#[derive(Debug, Default)]
struct Slot {
    newest: Option<Arc<Shown>>,
    /// Whether the window has taken it.
    fetched: bool,
    /// Pictures that were replaced before the window came for them.
    missed: u64,
    report: Option<FrameReport>,
    /// Nothing more will come.
    over: bool,
}

/// Slots for the newest picture and for the newest report.
#[derive(Debug, Default)]
pub(super) struct Mailbox {
    slot: Mutex<Slot>,
    brought: Condvar,
}

impl Mailbox {
    fn lock(&self) -> MutexGuard<'_, Slot> {
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Stores a picture in place of the last one.
    pub(super) fn bring(&self, shown: Shown) {
        let mut slot = self.lock();
        slot.missed += u64::from(slot.newest.is_some() && !slot.fetched);
        slot.newest = Some(Arc::new(shown));
        slot.fetched = false;
        drop(slot);
        self.brought.notify_all();
    }

    /// Whether the window has taken the last picture, or there was none.
    fn is_empty(&self) -> bool {
        let slot = self.lock();
        slot.fetched || slot.newest.is_none()
    }

    /// A new picture; waits for one at most `patience`.
    pub(super) fn fetch(&self, patience: Duration) -> Option<Arc<Shown>> {
        let nothing = |slot: &mut Slot| !slot.over && (slot.fetched || slot.newest.is_none());
        let waited = self.brought.wait_timeout_while(self.lock(), patience, nothing);
        let mut slot = waited.unwrap_or_else(PoisonError::into_inner).0;
        if slot.fetched {
            return None;
        }
        slot.fetched = slot.newest.is_some();
        slot.newest.clone()
    }

    /// The last picture, taken or not.
    pub(super) fn newest(&self) -> Option<Arc<Shown>> {
        self.lock().newest.clone()
    }

    /// Stores the report of the newest frame.
    pub(super) fn note(&self, report: &FrameReport) {
        self.lock().report = Some(report.clone());
    }

    /// The report of the newest frame.
    pub(super) fn noted(&self) -> Option<FrameReport> {
        self.lock().report.clone()
    }

    /// Pictures that were replaced before the window came for them.
    pub(super) fn missed(&self) -> u64 {
        self.lock().missed
    }

    /// Nothing more will come.
    pub(super) fn close(&self) {
        self.lock().over = true;
        self.brought.notify_all();
    }

    /// Whether nothing more will come.
    pub(super) fn is_closed(&self) -> bool {
        self.lock().over
    }
}

/// The sink of a preview: the mailbox, and the recording while there is one.
pub(super) struct Screen {
    pub(super) mailbox: Arc<Mailbox>,
    pub(super) deck: Arc<Deck>,
    pub(super) recorder: Arc<Recorder>,
}

impl Sink for Screen {
    fn needs(&self) -> Needs {
        Needs { origin: true, ..Needs::default() }
    }

    fn write(&mut self, picture: Picture, origin: Option<Origin>) -> Result<Buffers> {
        self.recorder.write(&picture);
        let Picture { frame, span, .. } = picture;
        if let Some(origin) = origin {
            self.mailbox.bring(Shown { frame, origin, span });
        }
        self.deck.arrived();
        Ok(Buffers::default())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}

/// A sink that shows its pictures in the window. Only pictures that the window has time for are copied.
pub(super) struct Glance {
    pub(super) inner: Box<dyn Sink>,
    pub(super) mailbox: Arc<Mailbox>,
}

impl Sink for Glance {
    fn needs(&self) -> Needs {
        // The window shows pixels.
        Needs { origin: true, form: None, ..self.inner.needs() }
    }

    fn write(&mut self, picture: Picture, origin: Option<Origin>) -> Result<Buffers> {
        if let Some(origin) = origin.filter(|_| self.mailbox.is_empty()) {
            let (frame, span) = (picture.frame.clone(), picture.span);
            self.mailbox.bring(Shown { frame, origin, span });
        }
        self.inner.write(picture, None)
    }

    fn finish(self: Box<Self>) -> Result<()> {
        self.inner.finish()
    }

    fn warnings(&self) -> &[String] {
        self.inner.warnings()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use polyreel::frame::Rational;
    use polyreel::geom::Size;
    use polyreel::mesh::Mesh;

    fn shown(index: i64) -> Shown {
        let size = Size::new(1, 1);
        let frame = Frame::filled(size, [0; 4]).expect("a frame");
        let mesh = Mesh::new(size, Vec::new(), Vec::new());
        let span = Span { start: Rational::new(index, 1), length: None };
        Shown { origin: Origin { frame: frame.clone(), mesh }, frame, span }
    }

    #[test]
    fn the_window_gets_the_newest_once_and_what_it_missed_is_counted() {
        let mailbox = Mailbox::default();
        assert!(mailbox.fetch(Duration::ZERO).is_none() && mailbox.is_empty());
        (0..3).for_each(|i| mailbox.bring(shown(i)));
        let start = |shown: Option<Arc<Shown>>| shown.map(|shown| shown.span.start.num);
        assert_eq!(start(mailbox.fetch(Duration::ZERO)), Some(2));
        assert_eq!(start(mailbox.fetch(Duration::ZERO)), None);
        assert_eq!(start(mailbox.newest()), Some(2));
        mailbox.bring(shown(3));
        assert_eq!(mailbox.missed(), 2);
        mailbox.close();
        assert_eq!(start(mailbox.fetch(Duration::from_secs(3600))), Some(3));
        assert_eq!(start(mailbox.fetch(Duration::from_secs(3600))), None, "nobody waits for more");
    }
}
