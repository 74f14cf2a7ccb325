//! Chooses the pixel format of the pipe from ffmpeg.

use serde_json::Value;

use super::tracks::tag;
use crate::colour::Sampling;

/// ffmpeg's own decoders of VP8 and VP9 ignore alpha; libvpx does not.
pub(crate) fn alpha_decoder(stream: &Value, codec: &str) -> Option<&'static str> {
    match (tag(stream, "alpha_mode")?, codec) {
        ("1", "vp8") => Some("libvpx"),
        ("1", "vp9") => Some("libvpx-vp9"),
        _ => None,
    }
}

/// The format for a stream with `pix_fmt`: the same if it has planes of 8 bits, else the one with the least loss; its
/// sampling (`None` for RGB); and whether it has alpha.
pub(crate) fn pipe_format(
    pix_fmt: &str,
    with_alpha: bool,
) -> (&'static str, Option<Sampling>, bool) {
    use Sampling::{Gray, Yuv420, Yuv422, Yuv444};
    let has = |parts: &[&str]| parts.iter().any(|part| pix_fmt.contains(part));
    let alpha = with_alpha
        || pix_fmt.starts_with("ya")
        || has(&["yuva", "rgba", "bgra", "argb", "abgr", "gbrap", "pal8", "vuya", "ayuv"]);
    let sampling = if has(&["420", "nv12", "nv21", "p010", "p012", "p016"]) {
        Yuv420
    } else if has(&["422", "nv16", "nv20", "p210", "p216", "y210", "y212"]) {
        Yuv422
    } else if has(&["yuv", "nv24", "nv42", "p410", "p416", "vuy", "xv"]) {
        Yuv444
    } else if has(&["gray", "mono"]) && !alpha {
        Gray
    } else {
        return ("rgba", None, alpha);
    };
    // The `j` formats have full range: with the other ones ffmpeg would convert it.
    let full = pix_fmt.starts_with("yuvj");
    let format = match (sampling, alpha, full) {
        (Yuv420, true, _) => "yuva420p",
        (Yuv422, true, _) => "yuva422p",
        (Yuv444, true, _) => "yuva444p",
        (Yuv420, _, true) => "yuvj420p",
        (Yuv422, _, true) => "yuvj422p",
        (Yuv444, _, true) => "yuvj444p",
        (Yuv420, ..) => "yuv420p",
        (Yuv422, ..) => "yuv422p",
        (Yuv444, ..) => "yuv444p",
        // Without alpha.
        (Gray, ..) => "gray",
    };
    (format, Some(sampling), alpha)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_keep_what_they_can() {
        assert_eq!(pipe_format("yuv420p", false).0, "yuv420p");
        assert_eq!(pipe_format("yuvj422p", false).0, "yuvj422p");
        assert_eq!(pipe_format("yuv422p10le", false).0, "yuv422p");
        assert_eq!(pipe_format("nv12", false).0, "yuv420p");
        assert_eq!(pipe_format("yuva444p12le", false), ("yuva444p", Some(Sampling::Yuv444), true));
        assert_eq!(pipe_format("gbrp", false), ("rgba", None, false));
        assert_eq!(pipe_format("bgra", false), ("rgba", None, true));
        assert_eq!(pipe_format("yuv420p", true).0, "yuva420p");
        assert_eq!(pipe_format("gray10le", false).0, "gray");
        assert_eq!(pipe_format("ya8", false), ("rgba", None, true));
        assert_eq!(pipe_format("gray", true), ("rgba", None, true));
    }
}
