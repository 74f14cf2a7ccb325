//! What can go wrong, said so that the reader knows where and what to do.

use std::path::PathBuf;

use crate::stage::Stage;

/// Result with polyreel's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// An error that names the file, the frame and the stage, as far as they are known.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The request itself cannot be meant (exit code 2 in the program).
    #[error("{0}")]
    Usage(String),
    /// An input could not be read or understood. `what` says what was expected and what to do.
    #[error("{}{}: {what}", path.display(), at_frame(*frame))]
    Input {
        /// The file as it was named (`-` for standard input).
        path: PathBuf,
        /// The frame, counted from 0, where one is known.
        frame: Option<u64>,
        /// What was found, what was expected, what to do.
        what: String,
    },
    /// An output could not be written.
    #[error("{}: {what}", path.display())]
    Output {
        /// The file as it was named (`-` for standard output).
        path: PathBuf,
        /// What went wrong and what to do.
        what: String,
    },
    /// The reader of our output has gone (a closed pipe). The run ends quietly, as `head` users expect.
    #[error("the reader of the output closed it")]
    Closed,
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
    /// Whether the request itself cannot be meant (exit code 2 in the program).
    pub fn is_usage(&self) -> bool {
        match self {
            Self::Usage(_) => true,
            Self::Core(error) => error.is_usage(),
            _ => false,
        }
    }

    /// A usage error.
    pub fn usage(what: impl Into<String>) -> Self {
        Self::Usage(what.into())
    }

    /// An error about the input `path` as a whole.
    pub fn input(path: impl Into<PathBuf>, what: impl Into<String>) -> Self {
        Self::Input { path: path.into(), frame: None, what: what.into() }
    }

    /// An error about frame `frame` of the input `path`.
    pub fn input_frame(path: impl Into<PathBuf>, frame: u64, what: impl Into<String>) -> Self {
        Self::Input { path: path.into(), frame: Some(frame), what: what.into() }
    }

    /// An error about the output `path`.
    pub fn output(path: impl Into<PathBuf>, what: impl Into<String>) -> Self {
        Self::Output { path: path.into(), what: what.into() }
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
