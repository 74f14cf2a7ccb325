//! What can go wrong, said so that the reader knows where and what to do.

use std::io;
use std::path::PathBuf;

use crate::stage::Stage;

/// Result with polyreel's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What led to an error, for [`std::error::Error::source`]. Often an [`io::Error`].
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// An error that names the file, the frame and the stage, as far as they are known.
///
/// What led to it is kept as its source: [`Error::io_kind`] tells a file that is missing from a full disk.
///
/// ```
/// use polyreel::Error;
/// use std::io;
///
/// let missing = io::Error::from(io::ErrorKind::NotFound);
/// let error = Error::input("in.png", format!("cannot be read: {missing}")).caused_by(missing);
/// assert_eq!(error.io_kind(), Some(io::ErrorKind::NotFound));
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The request itself makes no sense, whatever the input (exit code 2 in the program).
    #[error("{0}")]
    Usage(String),
    /// An input could not be read or understood. `what` says what was expected and what to do.
    #[error("{}{}: {what}", path.display(), at_frame(*frame))]
    #[non_exhaustive]
    Input {
        /// The file as it was named (`-` for standard input).
        path: PathBuf,
        /// The frame, counted from 0, where one is known.
        frame: Option<u64>,
        /// What was found, what was expected, what to do.
        what: String,
        /// What led to it.
        #[source]
        cause: Option<Cause>,
    },
    /// An output could not be written.
    #[error("{}: {what}", path.display())]
    #[non_exhaustive]
    Output {
        /// The file as it was named (`-` for standard output).
        path: PathBuf,
        /// What went wrong and what to do.
        what: String,
        /// What led to it.
        #[source]
        cause: Option<Cause>,
    },
    /// The input has no frame to render, or none in the part that was asked for.
    #[error("there are no frames to render")]
    NoFrames,
    /// The reader of the output has gone (a closed pipe). The run ends quietly, as `head` users expect.
    #[error("the reader of the output closed it")]
    Closed,
    /// A thread could not be started.
    #[error("the {name} thread cannot be started: {source}")]
    Thread {
        /// What the thread is for.
        name: String,
        /// What the system says.
        source: Cause,
    },
    /// There is not enough memory.
    #[error(
        "{what} take {bytes} bytes of memory or more, which cannot be had; make them smaller with --max-size"
    )]
    Memory {
        /// What the memory was for.
        what: String,
        /// Bytes that were asked for.
        bytes: u64,
    },
    /// Something else failed that concerns neither an input nor an output.
    #[error("{what}")]
    Failed {
        /// What failed.
        what: String,
        /// What led to it.
        #[source]
        cause: Option<Cause>,
    },
    /// A stage failed on a frame.
    #[error("frame {frame}, {stage}: {source}")]
    Frame {
        /// The frame, counted from 0.
        frame: u64,
        /// Where it happened.
        stage: Stage,
        /// What happened there.
        source: Box<Error>,
    },
    /// The engine refused the options or the picture.
    #[error(transparent)]
    Core(#[from] polyreel_core::Error),
    /// A stage panicked; the panic itself is resumed at the caller of the run.
    #[error("stage {0} panicked")]
    Panicked(Stage),
}

fn at_frame(frame: Option<u64>) -> String {
    frame.map_or_else(String::new, |f| format!(", frame {f}"))
}

impl Error {
    /// Whether the request itself makes no sense (exit code 2 in the program).
    pub fn is_usage(&self) -> bool {
        match self {
            Self::Usage(_) => true,
            Self::Core(error) => error.is_usage(),
            // A wrong encoder, for one, is found out when frames come.
            Self::Frame { source, .. } => source.is_usage(),
            _ => false,
        }
    }

    /// The kind of the I/O error that led to this one, if one did.
    pub fn io_kind(&self) -> Option<io::ErrorKind> {
        let mut error: Option<&(dyn std::error::Error + 'static)> = Some(self);
        while let Some(now) = error {
            if let Some(io) = now.downcast_ref::<io::Error>() {
                return Some(io.kind());
            }
            error = now.source();
        }
        None
    }

    /// Whether the input ends before its data does.
    pub fn is_truncation(&self) -> bool {
        self.is_decoding() && self.io_kind() == Some(io::ErrorKind::UnexpectedEof)
    }

    /// Whether the data of the input is damaged. What could not be read for another reason is not: a disk
    /// or a decoder that failed, a file that is missing.
    pub fn is_corruption(&self) -> bool {
        self.is_decoding() && self.io_kind() == Some(io::ErrorKind::InvalidData)
    }

    /// Whether the input breaks off, because it ends too early or is damaged: what came before is sound.
    pub fn breaks_off(&self) -> bool {
        self.is_truncation() || self.is_corruption()
    }

    fn is_decoding(&self) -> bool {
        matches!(self, Self::Input { .. } | Self::Frame { stage: Stage::Decode, .. })
    }

    /// A usage error.
    pub fn usage(what: impl Into<String>) -> Self {
        Self::Usage(what.into())
    }

    /// An error about the input `path` as a whole.
    pub fn input(path: impl Into<PathBuf>, what: impl Into<String>) -> Self {
        Self::Input { path: path.into(), frame: None, what: what.into(), cause: None }
    }

    /// An error about frame `frame` of the input `path`.
    pub fn input_frame(path: impl Into<PathBuf>, frame: u64, what: impl Into<String>) -> Self {
        Self::Input { path: path.into(), frame: Some(frame), what: what.into(), cause: None }
    }

    /// An error about the output `path`.
    pub fn output(path: impl Into<PathBuf>, what: impl Into<String>) -> Self {
        Self::Output { path: path.into(), what: what.into(), cause: None }
    }

    /// An error that concerns neither an input nor an output, nor the request.
    pub fn failed(what: impl Into<String>) -> Self {
        Self::Failed { what: what.into(), cause: None }
    }

    /// The `name` thread could not be started.
    pub fn thread(name: impl Into<String>, source: impl Into<Cause>) -> Self {
        Self::Thread { name: name.into(), source: source.into() }
    }

    /// This error with what led to it as its source. Variants that hold no cause are returned as they are.
    #[must_use]
    pub fn caused_by(mut self, error: impl Into<Cause>) -> Self {
        if let Self::Input { cause, .. } | Self::Output { cause, .. } | Self::Failed { cause, .. } =
            &mut self
        {
            *cause = Some(error.into());
        }
        self
    }

    /// This error, marked as an input that ends before its data does.
    #[must_use]
    pub fn truncated(self) -> Self {
        self.caused_by(io::Error::from(io::ErrorKind::UnexpectedEof))
    }

    /// This error, marked as an input whose data is damaged.
    #[must_use]
    pub fn corrupt(self) -> Self {
        self.caused_by(io::Error::from(io::ErrorKind::InvalidData))
    }

    /// This error with the frame's number and the stage. Input errors already say both.
    #[must_use]
    pub fn at(self, frame: u64, stage: Stage) -> Self {
        match self {
            Self::Input { .. } | Self::Frame { .. } | Self::Closed | Self::Panicked(_) => self,
            other => Self::Frame { frame, stage, source: Box::new(other) },
        }
    }
}

/// Another error that says the same.
pub(crate) fn copied(error: &io::Error) -> io::Error {
    match error.raw_os_error() {
        Some(code) => io::Error::from_raw_os_error(code),
        None => io::Error::new(error.kind(), error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::error::Error as _;

    #[test]
    fn the_cause_of_an_error_can_be_matched() {
        let full = io::Error::from(io::ErrorKind::StorageFull);
        let error = Error::output("a.gif", "cannot be written").caused_by(full);
        assert_eq!(error.io_kind(), Some(io::ErrorKind::StorageFull));
        let error = error.at(3, Stage::Encode);
        assert_eq!(error.io_kind(), Some(io::ErrorKind::StorageFull));
        assert!(!error.is_truncation() && !error.is_usage());
        let short = Error::input_frame("a.y4m", 2, "is cut short").truncated();
        assert!(short.is_truncation() && short.source().is_some() && short.breaks_off());
        let damaged = Error::input("a.gif", "is broken").corrupt();
        assert!(damaged.is_corruption() && !damaged.is_truncation() && damaged.breaks_off());
        let gone = Error::input("a.gif", "is not there").caused_by(io::Error::from_raw_os_error(2));
        assert!(!gone.breaks_off());
        assert!(!Error::output("a.gif", "cannot be written").truncated().breaks_off());
        assert_eq!(Error::NoFrames.io_kind(), None);
    }

    #[test]
    fn a_wrong_request_stays_one_at_any_frame() {
        let error = Error::usage("there is no such encoder").at(3, Stage::Encode);
        assert!(error.is_usage(), "{error}");
    }

    #[test]
    fn a_thread_that_cannot_be_started_is_no_usage_error() {
        let error = Error::thread("mesh", io::Error::from(io::ErrorKind::WouldBlock));
        assert!(!error.is_usage());
        assert_eq!(error.io_kind(), Some(io::ErrorKind::WouldBlock));
        assert!(error.to_string().starts_with("the mesh thread cannot be started: "), "{error}");
    }
}
