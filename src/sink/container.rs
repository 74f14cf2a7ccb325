//! Containers of video, by ffmpeg's names, and what each can hold.

use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;

use crate::ffmpeg::command::arguments;

/// A container that can be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Container {
    /// MPEG-4 (`.mp4`, `.m4v`).
    Mp4,
    /// QuickTime (`.mov`).
    Mov,
    /// Matroska (`.mkv`).
    Mkv,
    /// WebM (`.webm`).
    WebM,
    /// MPEG transport stream (`.ts`, `.m2ts`, `.mts`).
    Ts,
    /// AVI (`.avi`).
    Avi,
    /// Flash Video (`.flv`).
    Flv,
    /// Ogg (`.ogv`).
    Ogg,
    /// Animated WebP with lossy pictures.
    WebP,
    /// A playlist of HLS (`.m3u8`), and its segments.
    Hls,
    /// Raw pictures for a video device.
    Device,
    /// Any other, by the name of ffmpeg's muxer.
    Other(Arc<str>),
}

impl Container {
    /// The container that the extension of `path` names.
    pub fn of(path: &Path) -> Option<Self> {
        Self::of_extension(&path.extension()?.to_str()?.to_ascii_lowercase())
    }

    fn of_extension(extension: &str) -> Option<Self> {
        Some(match extension {
            "mp4" | "m4v" => Self::Mp4,
            "mov" => Self::Mov,
            "mkv" => Self::Mkv,
            "webm" => Self::WebM,
            "ts" | "m2ts" | "mts" => Self::Ts,
            "avi" => Self::Avi,
            "flv" => Self::Flv,
            "ogv" => Self::Ogg,
            _ => return None,
        })
    }

    /// That of lossy WebP.
    pub(crate) fn webp() -> Self {
        Self::WebP
    }

    /// The container called `name`: an extension of its files, or a muxer of ffmpeg.
    pub fn named(name: &str) -> Self {
        let name = name.to_ascii_lowercase();
        let all = [
            Self::Mp4,
            Self::Mov,
            Self::Mkv,
            Self::WebM,
            Self::Ts,
            Self::Avi,
            Self::Flv,
            Self::Ogg,
            Self::Hls,
            Self::Device,
        ];
        let known = Self::of_extension(&name);
        let known = known.or_else(|| all.into_iter().find(|one| one.muxer() == name));
        known.unwrap_or_else(|| Self::Other(name.into()))
    }

    /// ffmpeg's name of it.
    pub(crate) fn muxer(&self) -> &str {
        match self {
            Self::Mp4 => "mp4",
            Self::Mov => "mov",
            Self::Mkv => "matroska",
            Self::WebM => "webm",
            Self::Ts => "mpegts",
            Self::Avi => "avi",
            Self::Flv => "flv",
            Self::Ogg => "ogg",
            Self::WebP => "webp",
            Self::Hls => "hls",
            Self::Device => "v4l2",
            Self::Other(name) => name,
        }
    }

    /// Whether it is of the family whose tables may stand before the frames.
    pub(crate) fn is_quicktime(&self) -> bool {
        matches!(self, Self::Mp4 | Self::Mov)
    }

    /// Whether it holds how long the last frame is shown.
    pub(crate) fn holds_lengths(&self) -> bool {
        matches!(self, Self::Mp4 | Self::Mov | Self::Mkv | Self::WebM)
    }

    /// Whether it counts frames rather than telling the time of each: then times are in frames of the nominal rate.
    pub(crate) fn counts_frames(&self) -> bool {
        matches!(self, Self::Avi | Self::Ogg | Self::Other(_))
    }

    /// Whether frames must be stored in the order in which they are shown.
    pub(crate) fn is_in_order(&self) -> bool {
        matches!(self, Self::Avi | Self::Flv)
    }

    /// Whether sound in `codec` can be copied into it such that common players play it.
    pub(crate) fn takes_sound(&self, codec: &str) -> bool {
        let known: &[&str] = match self {
            Self::Mp4 => &["aac", "mp3", "ac3", "eac3", "alac", "opus"],
            Self::Mov => {
                &["aac", "mp3", "ac3", "alac", "pcm_s16le", "pcm_s16be", "pcm_s24le", "pcm_s24be"]
            }
            Self::Mkv => return true,
            Self::WebM => &["opus", "vorbis"],
            Self::Hls => &["aac"],
            Self::Ts => &["aac", "mp2", "mp3", "ac3", "eac3"],
            Self::Avi => &["mp3", "mp2", "ac3", "pcm_s16le"],
            Self::Flv => &["aac", "mp3"],
            Self::Ogg => &["vorbis", "opus", "flac"],
            Self::WebP | Self::Device | Self::Other(_) => &[],
        };
        known.contains(&codec)
    }

    /// Whether it can have sound at all, as far as is known.
    pub(crate) fn has_sound(&self) -> bool {
        !matches!(self, Self::WebP | Self::Device)
    }

    /// ffmpeg's encoder for subtitles in `codec`: `copy` if the container takes them unchanged, `None` if it cannot
    /// have them. Bitmap subtitles are not converted to text, nor text to bitmaps.
    pub(crate) fn subtitle_encoder(&self, codec: &str) -> Option<&'static str> {
        let text = ["subrip", "ass", "ssa", "webvtt", "mov_text", "text"].contains(&codec);
        let pictures = ["hdmv_pgs_subtitle", "dvd_subtitle", "dvb_subtitle"].contains(&codec);
        match self {
            Self::Mkv if codec == "mov_text" => Some("subrip"),
            Self::Mkv if text || pictures => Some("copy"),
            Self::Mp4 | Self::Mov if codec == "mov_text" => Some("copy"),
            Self::Mp4 | Self::Mov if text => Some("mov_text"),
            Self::WebM if codec == "webvtt" => Some("copy"),
            Self::WebM if text => Some("webvtt"),
            Self::Ts if ["dvb_subtitle", "dvb_teletext"].contains(&codec) => Some("copy"),
            _ => None,
        }
    }

    /// Options that make sound stream `index` one that the container takes.
    pub(crate) fn sound_encoder(&self, index: usize) -> Vec<OsString> {
        let (codec, rate) = match self {
            Self::WebM | Self::Ogg => ("libopus", "160k"),
            Self::Avi => ("libmp3lame", "192k"),
            // The muxer knows its own; MXF takes this rate alone, and all others take it, too.
            Self::Other(_) => return arguments([&format!("-ar:a:{index}"), &"48000"]),
            _ => ("aac", "192k"),
        };
        let option = |name: &str| format!("-{name}:a:{index}");
        let mut args = arguments([&option("c"), &codec, &option("b"), &rate]);
        let filter = match codec {
            // For six and more channels the encoder has only these layouts.
            "libopus" => "aformat=channel_layouts=mono|stereo|3.0|quad|5.0|5.1|6.1|7.1",
            "libmp3lame" => "aformat=channel_layouts=mono|stereo",
            _ => return args,
        };
        args.extend(arguments([&option("filter"), &filter]));
        args
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn containers_go_by_extension() {
        assert_eq!(Container::of(Path::new("a/b.MP4")), Some(Container::Mp4));
        assert_eq!(Container::of(Path::new("b.webm")), Some(Container::WebM));
        assert_eq!(Container::of(Path::new("b.m2ts")), Some(Container::Ts));
        assert_eq!(Container::of(Path::new("mp4")), None);
    }

    #[test]
    fn containers_have_several_names() {
        assert_eq!(Container::named("MKV"), Container::named("matroska"));
        assert_eq!(Container::named("mpegts"), Container::Ts);
        assert_eq!(Container::named("mxf").muxer(), "mxf");
    }

    #[test]
    fn subtitles_go_where_they_fit() {
        assert_eq!(Container::Mp4.subtitle_encoder("subrip"), Some("mov_text"));
        assert_eq!(Container::Mkv.subtitle_encoder("dvd_subtitle"), Some("copy"));
        assert_eq!(Container::WebM.subtitle_encoder("ass"), Some("webvtt"));
        assert_eq!(Container::Mp4.subtitle_encoder("hdmv_pgs_subtitle"), None);
        assert_eq!(Container::Mkv.subtitle_encoder("dvb_teletext"), None);
    }

    #[test]
    fn sound_is_copied_where_it_fits() {
        assert!(Container::Mp4.takes_sound("mp3") && !Container::WebM.takes_sound("pcm_s16le"));
        assert!(!Container::Mp4.takes_sound("vorbis") && Container::Mkv.takes_sound("vorbis"));
    }
}
