//! What can go wrong, in words for whoever uses the page.

/// An error with its message.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// The engine refuses options or a frame.
    #[error("{0}")]
    Engine(#[from] polyreel_core::Error),
    /// Settings, or a preset file, that make no sense.
    #[error("{0}")]
    Settings(String),
    /// A file cannot be made.
    #[error("{0}")]
    File(String),
}

/// The result of what can fail.
pub(crate) type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// A file that cannot be made, because of `why`.
    pub(crate) fn file(why: impl std::fmt::Display) -> Self {
        Self::File(why.to_string())
    }
}
