//! The ffmpeg and ffprobe programs.

use std::path::PathBuf;

use super::Processes;

/// The ffmpeg to run, with the list of its processes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ffmpeg {
    /// The program. Default `None`: the `ffmpeg` on the search path.
    pub program: Option<PathBuf>,
    /// The running processes.
    pub processes: Processes,
}

impl From<PathBuf> for Ffmpeg {
    fn from(program: PathBuf) -> Self {
        Self { program: Some(program), processes: Processes::default() }
    }
}

#[cfg(feature = "ffmpeg")]
impl Ffmpeg {
    /// The program to run as ffmpeg.
    pub(crate) fn ffmpeg(&self) -> PathBuf {
        self.program.clone().unwrap_or_else(|| PathBuf::from("ffmpeg"))
    }

    /// The program to run as ffprobe: the one next to the given ffmpeg if there is one, else the one on the
    /// search path.
    pub(crate) fn ffprobe(&self) -> PathBuf {
        let sibling = self.program.as_ref().and_then(|ffmpeg| {
            let name = ffmpeg.file_name()?.to_str()?;
            let name = if name.contains("ffmpeg") {
                name.replace("ffmpeg", "ffprobe")
            } else {
                "ffprobe".into()
            };
            Some(ffmpeg.with_file_name(name))
        });
        sibling.filter(|path| path.is_file()).unwrap_or_else(|| PathBuf::from("ffprobe"))
    }
}
