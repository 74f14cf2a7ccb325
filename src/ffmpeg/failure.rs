//! How an ffmpeg failed, for who asks an error for its source.

use std::fmt;
use std::io::{self, ErrorKind};
use std::process::ExitStatus;

/// An ffmpeg or ffprobe that failed: the source of the [`Error`](crate::Error) about the file that it read or wrote.
/// Its own source is an [`io::Error`] where the reason is known: its kind is `UnexpectedEof` for an input that ends
/// too early, `InvalidData` for one that is damaged, `StorageFull` for a full disk, `NotFound` for a missing program.
#[derive(Debug)]
pub struct FfmpegError {
    words: String,
    status: Option<ExitStatus>,
    cause: Option<io::Error>,
}

impl FfmpegError {
    /// What it said last, or how it ended if it said nothing.
    pub fn words(&self) -> &str {
        &self.words
    }

    /// How it ended. `None` if it could not be started, or its output was not what it should be.
    pub fn status(&self) -> Option<ExitStatus> {
        self.status
    }

    /// A failure in other words than ffmpeg's.
    pub(crate) fn new(words: impl Into<String>) -> Self {
        Self { words: words.into(), status: None, cause: None }
    }

    /// The same, with what led to it.
    pub(crate) fn caused_by(self, cause: impl Into<io::Error>) -> Self {
        Self { cause: Some(cause.into()), ..self }
    }

    /// An ffmpeg that ended with `status`, or `hung` and was ended, after it had said `words`. What came from a
    /// network ends where the connection does.
    pub(crate) fn ended(
        words: String,
        status: Option<ExitStatus>,
        hung: bool,
        from_network: bool,
    ) -> Self {
        let code = status.map(|status| status.code());
        let killed = code.is_some_and(|code| code.is_none_or(|code| KILLED.contains(&code)));
        let says = |list: &[&str]| list.iter().any(|text| words.contains(text));
        let cause = match () {
            () if hung => from_network.then_some(ErrorKind::UnexpectedEof),
            () if killed => None,
            () if says(&CUT) || from_network && says(&LOST) => Some(ErrorKind::UnexpectedEof),
            () if says(&["No space left"]) => Some(ErrorKind::StorageFull),
            () if says(&LOST) || says(&LACKS) => None,
            () if code == Some(Some(0)) || says(&DAMAGED) => Some(ErrorKind::InvalidData),
            () => None,
        };
        Self { words, status, cause: cause.map(io::Error::from) }
    }

    /// Whether the input ends before its data does.
    pub(crate) fn is_truncation(&self) -> bool {
        self.is(ErrorKind::UnexpectedEof)
    }

    /// Whether the data of the input is damaged.
    pub(crate) fn is_corruption(&self) -> bool {
        self.is(ErrorKind::InvalidData)
    }

    fn is(&self, kind: ErrorKind) -> bool {
        self.cause.as_ref().is_some_and(|cause| cause.kind() == kind)
    }
}

/// Exit codes of a shell whose program was ended by a signal: ABRT, KILL, SEGV, TERM.
const KILLED: [i32; 4] = [134, 137, 139, 143];

/// What ffmpeg says of files that end too early.
const CUT: [&str; 7] = [
    "partial file",
    "ended prematurely",
    "ends prematurely",
    "moov atom not found",
    "End of file",
    "end of file",
    "runcat",
];

/// What it says of a connection or a disk that failed.
const LOST: [&str; 6] = [
    "Input/output error",
    "Connection ",
    "Broken pipe",
    "timed out",
    "Network is unreachable",
    "No route to host",
];

/// What it says where the machine lacks something, or the file is gone.
const LACKS: [&str; 4] =
    ["Cannot allocate memory", "Too many open files", "Permission denied", "No such file"];

/// What it says of damaged data before it gives up.
const DAMAGED: [&str; 6] = [
    "Invalid data found",
    "rror while decoding",
    "rror submitting packet to decoder",
    "error rate",
    "orrupt",
    "could not find corresponding",
];

impl fmt::Display for FfmpegError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words)
    }
}

impl std::error::Error for FfmpegError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.cause.as_ref().map(|cause| cause as _)
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::process::ExitStatusExt;

    /// The kind of the failure of an ffmpeg that ended with `status` of wait(2).
    fn kind(status: i32, words: &str, from_network: bool) -> Option<ErrorKind> {
        let status = Some(ExitStatus::from_raw(status));
        let error = FfmpegError::ended(words.into(), status, false, from_network);
        error.cause.map(|cause| cause.kind())
    }

    #[test]
    fn what_is_cut_short_or_damaged_is_told_from_what_failed() {
        use ErrorKind::{InvalidData, StorageFull, UnexpectedEof};
        let code = |code: i32| code << 8;
        for (status, words, wanted) in [
            (0, "mov: stream 0, offset 0x30: partial file", Some(UnexpectedEof)),
            (code(1), "matroska,webm: File ended prematurely", Some(UnexpectedEof)),
            (0, "h264: error while decoding MB 12 3, bytestream -7", Some(InvalidData)),
            (code(183), "h264: Invalid data found when processing input", Some(InvalidData)),
            (code(1), "I give up (exit status: 1)", None),
            (0, "in.mkv: Input/output error", None),
            (code(1), "Cannot allocate memory", None),
            (code(1), "av_interleaved_write_frame(): No space left on device", Some(StorageFull)),
            (9, "h264: error while decoding MB 12 3, bytestream -7", None),
            (code(137), "Killed; File ended prematurely", None),
        ] {
            assert_eq!(kind(status, words, false), wanted, "{words}");
        }
        assert_eq!(kind(0, "http: Connection reset by peer", true), Some(UnexpectedEof));
        assert_eq!(kind(9, "http: Connection reset by peer", true), None);
    }

    #[test]
    fn what_hangs_is_no_damage_but_a_silent_network_is_an_end() {
        let error = |network| FfmpegError::ended("it stopped".into(), None, true, network);
        assert!(!error(false).is_truncation() && !error(false).is_corruption());
        assert!(error(true).is_truncation());
    }
}
