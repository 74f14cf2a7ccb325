//! A pipe by which the ffmpeg that decodes a picture hands its sound to the one that encodes: for inputs that can be
//! read only once.

use std::fs::File;
use std::io;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use tempfile::TempDir;

/// The pipe, once somebody wants it. Clones are the same one.
#[derive(Clone, Debug, Default)]
pub(crate) struct SoundPipe(Arc<Mutex<Option<Fifo>>>);

#[derive(Debug)]
struct Fifo {
    /// Removed, with the pipe, when the last clone goes.
    folder: TempDir,
    /// Its end for reading is kept open, so that the writer need not wait for the reader. Nothing is read from it.
    #[cfg_attr(not(unix), expect(dead_code, reason = "there are no such pipes"))]
    reader: File,
    /// So is one for writing, until the picture ends: a reader that comes after the writer has gone would wait for ever.
    writer: Option<File>,
}

impl Fifo {
    /// Whether something waits to be read.
    #[cfg(unix)]
    fn holds_bytes(&self) -> bool {
        rustix::io::ioctl_fionread(&self.reader).is_ok_and(|bytes| bytes > 0)
    }

    /// Whether something waits to be read.
    #[cfg(not(unix))]
    fn holds_bytes(&self) -> bool {
        false
    }
}

/// Pipes are equal when they are the same pipe.
impl PartialEq for SoundPipe {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl SoundPipe {
    fn fifo(&self) -> MutexGuard<'_, Option<Fifo>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Makes it, for who reads.
    ///
    /// # Errors
    /// When the system has no named pipes, or does not give one.
    #[cfg(unix)]
    pub(crate) fn open(&self) -> io::Result<()> {
        use rustix::fs::{CWD, FileType, Mode, OFlags, mknodat, open};
        let folder = tempfile::Builder::new().prefix(".polyreel-").tempdir()?;
        let path = folder.path().join(NAME);
        mknodat(CWD, &path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0)?;
        let reader =
            open(&path, OFlags::RDONLY | OFlags::NONBLOCK | OFlags::CLOEXEC, Mode::empty())?;
        // Sound waits in it until the first picture is there, several seconds where a stream is joined between two key
        // frames. Refused if the user has too many pipes: then there is less room.
        #[cfg(target_os = "linux")]
        let _ = rustix::pipe::fcntl_setpipe_size(&reader, ROOM);
        let writer = Some(File::options().write(true).open(&path)?);
        *self.fifo() = Some(Fifo { folder, reader: reader.into(), writer });
        Ok(())
    }

    /// There is none here.
    ///
    /// # Errors
    /// Always.
    #[cfg(not(unix))]
    pub(crate) fn open(&self) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }

    /// Lets its reader see its end, once the writer has gone and the reader is there: it has read what was written.
    pub(crate) fn close(&self) {
        if let Some(fifo) = self.fifo().as_mut().filter(|fifo| fifo.writer.is_some()) {
            let began = Instant::now();
            while fifo.holds_bytes() && began.elapsed() < LONGEST {
                thread::sleep(PAUSE);
            }
            fifo.writer = None;
        }
    }

    /// Its path, if somebody reads it.
    pub(crate) fn path(&self) -> Option<PathBuf> {
        self.fifo().as_ref().map(|fifo| fifo.folder.path().join(NAME))
    }

    /// The folder that it is in, if it was made.
    pub(crate) fn folder(&self) -> Option<PathBuf> {
        self.fifo().as_ref().map(|fifo| fifo.folder.path().to_owned())
    }
}

const NAME: &str = "sound";
/// How long the reader may take to come, and how often it is looked for.
const LONGEST: Duration = Duration::from_secs(20);
const PAUSE: Duration = Duration::from_millis(5);
/// Bytes: six seconds of stereo.
#[cfg(target_os = "linux")]
const ROOM: usize = 1 << 20;

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::io::{Read, Write};

    #[test]
    fn a_writer_need_not_wait_and_a_reader_sees_the_end() {
        let pipe = SoundPipe::default();
        assert_eq!(pipe.path(), None);
        pipe.open().expect("a pipe");
        let path = pipe.path().expect("a path");
        let mut writer = File::options().write(true).open(&path).expect("a reader is there");
        let mut reader = File::open(&path).expect("a writer is there");
        writer.write_all(b"la").expect("room");
        drop(writer);
        let reading = thread::spawn(move || {
            let mut heard = Vec::new();
            reader.read_to_end(&mut heard).map(|_| heard)
        });
        pipe.close();
        let heard = reading.join().expect("no panic").expect("the end");
        assert_eq!(heard, b"la");
        let folder = pipe.folder().expect("a folder");
        drop(pipe);
        assert!(!folder.exists());
    }
}
