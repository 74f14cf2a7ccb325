//! Names of inputs and outputs that are no files.

use std::path::Path;

/// Whether `path` is the address of a stream rather than of a file.
pub(crate) fn is_url(path: &Path) -> bool {
    path.to_str().is_some_and(|text| {
        text.split_once("://").is_some_and(|(scheme, _)| {
            !scheme.is_empty() && scheme.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'+')
        })
    })
}

/// Whether `path` is a camera, or another video device.
pub(crate) fn is_camera(path: &Path) -> bool {
    path.to_str().is_some_and(|text| text.starts_with("/dev/video"))
}
