//! Containers and encoders, by ffmpeg's names, and their options.

use std::ffi::OsString;
use std::path::Path;

use crate::error::{Error, Result};
use crate::ffmpeg::command::arguments;

/// A container that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Container {
    /// MPEG-4 (`.mp4`, `.m4v`).
    Mp4,
    /// QuickTime (`.mov`).
    Mov,
    /// Matroska (`.mkv`).
    Mkv,
    /// WebM (`.webm`).
    WebM,
}

impl Container {
    /// The container that the extension of `path` names.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "mp4" | "m4v" => Some(Self::Mp4),
            "mov" => Some(Self::Mov),
            "mkv" => Some(Self::Mkv),
            "webm" => Some(Self::WebM),
            _ => None,
        }
    }

    /// ffmpeg's name of it.
    pub(crate) fn muxer(self) -> &'static str {
        match self {
            Self::Mp4 => "mp4",
            Self::Mov => "mov",
            Self::Mkv => "matroska",
            Self::WebM => "webm",
        }
    }

    /// Whether it is of the family whose tables may stand before the frames.
    pub(crate) fn is_quicktime(self) -> bool {
        matches!(self, Self::Mp4 | Self::Mov)
    }

    /// Whether sound in `codec` can be copied into it such that common players play it.
    pub(crate) fn takes_sound(self, codec: &str) -> bool {
        match self {
            Self::Mp4 => ["aac", "mp3", "ac3", "eac3", "alac", "opus"].contains(&codec),
            Self::Mov => {
                ["aac", "mp3", "ac3", "alac"].contains(&codec)
                    || ["pcm_s16le", "pcm_s16be", "pcm_s24le", "pcm_s24be"].contains(&codec)
            }
            Self::Mkv => true,
            Self::WebM => ["opus", "vorbis"].contains(&codec),
        }
    }

    /// ffmpeg's encoder for subtitles in `codec`: `copy` if the container takes them unchanged, `None` if it cannot
    /// have them. Bitmap subtitles are not converted to text, nor text to bitmaps.
    pub(crate) fn subtitle_encoder(self, codec: &str) -> Option<&'static str> {
        let text = ["subrip", "ass", "ssa", "webvtt", "mov_text", "text"].contains(&codec);
        let pictures = ["hdmv_pgs_subtitle", "dvd_subtitle", "dvb_subtitle"].contains(&codec);
        match self {
            Self::Mkv if codec == "mov_text" => Some("subrip"),
            Self::Mkv if text || pictures => Some("copy"),
            Self::Mp4 | Self::Mov if codec == "mov_text" => Some("copy"),
            Self::Mp4 | Self::Mov if text => Some("mov_text"),
            Self::WebM if codec == "webvtt" => Some("copy"),
            Self::WebM if text => Some("webvtt"),
            _ => None,
        }
    }

    /// Options that make sound stream `index` one that the container takes.
    pub(crate) fn sound_encoder(self, index: usize) -> Vec<OsString> {
        let (codec, rate) = match self {
            Self::WebM => ("libopus", "160k"),
            _ => ("aac", "192k"),
        };
        let option = |name: &str| format!("-{name}:a:{index}");
        let mut args = arguments([&option("c"), &codec, &option("b"), &rate]);
        if self == Self::WebM {
            // For six and more channels the encoder has only these layouts.
            let layouts = "aformat=channel_layouts=mono|stereo|3.0|quad|5.0|5.1|6.1|7.1";
            args.extend(arguments([&option("filter"), &layouts]));
        }
        args
    }
}

/// A video encoder of ffmpeg.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Encoder {
    /// ffmpeg's name of it.
    pub(crate) name: String,
}

/// Common names of codecs, their encoders, and the constant quality of each that looks like x264's 18 on flat
/// colours.
const CODECS: [(&str, &str, Option<u32>); 8] = [
    ("h264", "libx264", Some(18)),
    ("x264", "libx264", Some(18)),
    ("h265", "libx265", Some(20)),
    ("hevc", "libx265", Some(20)),
    ("vp8", "libvpx", Some(10)),
    ("vp9", "libvpx-vp9", Some(24)),
    ("av1", "libsvtav1", Some(28)),
    ("prores", "prores_ks", None),
];

/// x264's presets, from fast to slow.
const PRESETS: [&str; 10] = [
    "ultrafast",
    "superfast",
    "veryfast",
    "faster",
    "fast",
    "medium",
    "slow",
    "slower",
    "veryslow",
    "placebo",
];

impl Encoder {
    /// The encoder for `codec`, a common name or ffmpeg's own name of an encoder; without one,
    /// H.264, in WebM VP9.
    pub(crate) fn of(codec: Option<&str>, container: Container) -> Self {
        let codec = codec.unwrap_or(if container == Container::WebM { "vp9" } else { "h264" });
        let known = CODECS.iter().find(|(name, ..)| codec.eq_ignore_ascii_case(name));
        Self { name: known.map_or(codec, |(_, encoder, _)| encoder).to_string() }
    }

    /// Whether it takes pictures of odd width or height in 4:2:0.
    pub(crate) fn takes_odd(&self) -> bool {
        ["libvpx", "libvpx-vp9", "libaom-av1", "ffv1"].contains(&self.name.as_str())
    }

    /// The most time units in a second, if there is a limit (MPEG-4 part 2).
    pub(crate) fn most_units(&self) -> Option<i64> {
        ["mpeg4", "libxvid"].contains(&self.name.as_str()).then_some(65535)
    }

    /// The tag of H.265 that Apple's players need.
    pub(crate) fn tag(&self, container: Container) -> Vec<OsString> {
        let wanted = self.name == "libx265" && container.is_quicktime();
        if wanted { arguments([&"-tag:v", &"hvc1"]) } else { Vec::new() }
    }

    /// The largest constant quality of the encoder, where it is known.
    fn worst_crf(&self) -> Option<u32> {
        match self.name.as_str() {
            "libx264" | "libx265" => Some(51),
            "libvpx" | "libvpx-vp9" | "libsvtav1" | "libaom-av1" => Some(63),
            _ => None,
        }
    }

    fn check_crf(&self, crf: Option<u32>) -> Result<()> {
        match (crf, self.worst_crf()) {
            (Some(crf), Some(worst)) if crf > worst => Err(Error::usage(format!(
                "--crf {crf} is out of range: for {} it can be 0 (best) to {worst}",
                self.name
            ))),
            _ => Ok(()),
        }
    }

    /// Its options for quality `crf` and speed `preset` (x264's names).
    ///
    /// # Errors
    /// [`Error::Usage`] when the encoder has no such preset or quality.
    pub(crate) fn options(&self, crf: Option<u32>, preset: Option<&str>) -> Result<Vec<OsString>> {
        let mut args = arguments([&"-c:v", &self.name]);
        let usual = CODECS.iter().find(|(_, encoder, _)| *encoder == self.name);
        self.check_crf(crf)?;
        let crf = crf.or_else(|| usual.and_then(|(.., crf)| *crf));
        if let Some(crf) = crf {
            args.extend(arguments([&"-crf", &crf.to_string()]));
        }
        let vpx = self.name.starts_with("libvpx");
        if vpx {
            // Constant quality: without a rate of 0 the crf would only be a limit.
            let rate = if self.name == "libvpx" { "20M" } else { "0" };
            args.extend(arguments([&"-b:v", &rate, &"-deadline", &"good"]));
        }
        if self.name == "libvpx-vp9" {
            args.extend(arguments([&"-row-mt", &"1"]));
        }
        let x26 = self.name.starts_with("libx26");
        match preset {
            Some(preset) if x26 || vpx => {
                let place = PRESETS.iter().position(|name| *name == preset).ok_or_else(|| {
                    let all = PRESETS.join(", ");
                    Error::usage(format!("there is no encoder preset '{preset}': there are {all}"))
                })?;
                if x26 {
                    args.extend(arguments([&"-preset", &preset]));
                } else {
                    args.extend(arguments([&"-cpu-used", &speed(place)]));
                }
            }
            Some(preset) => args.extend(arguments([&"-preset", &preset])),
            None if vpx => args.extend(arguments([&"-cpu-used", &speed(5)])),
            None => {}
        }
        Ok(args)
    }
}

/// libvpx's speed, 8 (fast) to 0 (slow), for an index in [`PRESETS`].
fn speed(place: usize) -> String {
    8usize.saturating_sub(place + place / 6).min(8).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn containers_go_by_extension() {
        assert_eq!(Container::of(Path::new("a/b.MP4")), Some(Container::Mp4));
        assert_eq!(Container::of(Path::new("b.webm")), Some(Container::WebM));
        assert_eq!(Container::of(Path::new("mp4")), None);
    }

    #[test]
    fn encoders_by_common_name_or_their_own() {
        let name = |codec, container| Encoder::of(codec, container).name;
        assert_eq!(name(None, Container::Mov), "libx264");
        assert_eq!(name(None, Container::WebM), "libvpx-vp9");
        assert_eq!(name(Some("HEVC"), Container::Mkv), "libx265");
        assert_eq!(name(Some("mpeg4"), Container::Mkv), "mpeg4");
    }

    #[test]
    fn presets_are_x264s() {
        let x264 = Encoder::of(None, Container::Mp4);
        assert!(x264.options(None, Some("slowest")).is_err());
        let args = x264.options(Some(23), Some("slow")).expect("a preset");
        assert_eq!(args, ["-c:v", "libx264", "-crf", "23", "-preset", "slow"]);
        let speeds: Vec<String> = (0..PRESETS.len()).map(speed).collect();
        assert_eq!(speeds, ["8", "7", "6", "5", "4", "3", "1", "0", "0", "0"]);
    }

    #[test]
    fn a_quality_out_of_range_is_refused() {
        let said = |codec, crf| {
            Encoder::of(codec, Container::Mkv).options(Some(crf), None).map_err(|e| e.to_string())
        };
        assert!(said(None, 51).is_ok() && said(Some("av1"), 63).is_ok());
        assert!(said(Some("ffv1"), 99).is_ok(), "what is not known is left to ffmpeg");
        assert!(said(None, 52).expect_err("too large").contains("0 (best) to 51"));
        assert!(said(Some("vp9"), 99).expect_err("too large").contains("63"));
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
