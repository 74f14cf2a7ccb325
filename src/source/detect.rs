//! Detects the format of a file by its first bytes.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use image::ImageFormat;

use crate::error::{Error, Result};

/// The kind of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A picture; an APNG or animated WebP, which have the same first bytes.
    Picture(ImageFormat),
    /// A GIF, of one frame or many.
    Gif,
    /// Uncompressed video with a plain text header.
    Y4m,
    /// A mesh stream of polyreel.
    MeshStream,
    /// Another file: a video, or not a picture.
    Other,
    /// A pipe: its first bytes cannot be read twice.
    Stream,
}

/// Number of bytes that distinguish all kinds.
pub(crate) const MAGIC: usize = 16;

/// Extensions of the pictures that can be read. Files of a folder with one of these must be pictures, whatever they
/// hold.
const PICTURE_EXTENSIONS: [&str; 14] = [
    "png", "apng", "jpg", "jpeg", "jfif", "webp", "bmp", "tif", "tiff", "pnm", "pbm", "pgm", "ppm",
    "gif",
];

/// The formats that can be read, for messages.
pub(crate) const READABLE: &str = "PNG, JPEG, WebP, BMP, TIFF, PNM or GIF";

/// Whether the extension of `path` is that of a picture.
pub(crate) fn is_called_picture(path: &Path) -> bool {
    path.extension().is_some_and(|extension| {
        PICTURE_EXTENSIONS.iter().any(|known| extension.eq_ignore_ascii_case(known))
    })
}

/// The error of a file that should be a picture.
pub(crate) fn no_picture(path: PathBuf) -> Error {
    let what = format!("is not a picture that can be read; expected {READABLE} by content");
    Error::input(path, what)
}

/// The kind of the file `path`.
///
/// # Errors
/// When it is missing, unreadable, a folder, or empty.
pub(crate) fn detect(path: &Path) -> Result<Kind> {
    let mut magic = Vec::with_capacity(MAGIC);
    if is_pipe(path) {
        return Ok(Kind::Stream);
    }
    open(path)?
        .take(MAGIC as u64)
        .read_to_end(&mut magic)
        .map_err(|e| Error::input(path, format!("cannot be read: {e}")).caused_by(e))?;
    if magic.is_empty() {
        return Err(Error::input(path, "the file is empty; expected a picture or a video"));
    }
    Ok(kind(&magic))
}

/// Whether `path` is a named pipe, or the end of a pipe (`/dev/fd/63` in shells).
#[cfg(unix)]
pub(crate) fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    std::fs::metadata(path).is_ok_and(|file| file.file_type().is_fifo())
}

#[cfg(not(unix))]
pub(crate) fn is_pipe(_path: &Path) -> bool {
    false
}

/// Opens a file, not a folder.
///
/// # Errors
/// When it is missing, unreadable, or a folder.
pub(crate) fn open(path: &Path) -> Result<File> {
    let file = File::open(path).map_err(|e| Error::input(path, why(&e)).caused_by(e))?;
    let folder = file.metadata().is_ok_and(|m| m.is_dir());
    if folder {
        return Err(Error::input(path, "is a folder, where a file is expected"));
    }
    Ok(file)
}

/// The message for an error of opening a file, with advice.
fn why(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file; check the name".into(),
        std::io::ErrorKind::PermissionDenied => {
            "may not be read; check the file's permissions".into()
        }
        _ => format!("cannot be opened: {error}"),
    }
}

/// The kind of what begins with `magic`.
pub(crate) fn kind(magic: &[u8]) -> Kind {
    let webp = magic.starts_with(b"RIFF") && magic.get(8..12) == Some(b"WEBP".as_slice());
    match magic {
        [0x89, b'P', b'N', b'G', ..] => Kind::Picture(ImageFormat::Png),
        [0xff, 0xd8, 0xff, ..] => Kind::Picture(ImageFormat::Jpeg),
        [b'G', b'I', b'F', b'8', ..] => Kind::Gif,
        _ if webp => Kind::Picture(ImageFormat::WebP),
        [b'B', b'M', ..] => Kind::Picture(ImageFormat::Bmp),
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => {
            Kind::Picture(ImageFormat::Tiff)
        }
        [b'P', b'1'..=b'7', space, ..] if space.is_ascii_whitespace() || *space == b'#' => {
            Kind::Picture(ImageFormat::Pnm)
        }
        _ if magic.starts_with(b"YUV4MPEG2") => Kind::Y4m,
        _ if magic.starts_with(crate::mesh_stream::MAGIC) => Kind::MeshStream,
        _ => Kind::Other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_recognised_by_content() {
        for (bytes, expected) in [
            (b"\x89PNG\r\n\x1a\n".as_slice(), Kind::Picture(ImageFormat::Png)),
            (b"\xff\xd8\xff\xe0", Kind::Picture(ImageFormat::Jpeg)),
            (b"GIF89a", Kind::Gif),
            (b"RIFF\x10\0\0\0WEBPVP8 ", Kind::Picture(ImageFormat::WebP)),
            (b"RIFF\x10\0\0\0WAVEfmt ", Kind::Other),
            (b"BM\x10\0\0\0", Kind::Picture(ImageFormat::Bmp)),
            (b"II*\0", Kind::Picture(ImageFormat::Tiff)),
            (b"MM\0*", Kind::Picture(ImageFormat::Tiff)),
            // BigTIFF.
            (b"II+\0", Kind::Picture(ImageFormat::Tiff)),
            (b"P6\n1 1", Kind::Picture(ImageFormat::Pnm)),
            (b"P6x", Kind::Other),
            (b"YUV4MPEG2 W2", Kind::Y4m),
            (b"Hello, world", Kind::Other),
            (b"G", Kind::Other),
        ] {
            assert_eq!(kind(bytes), expected, "{bytes:?}");
        }
    }
}
