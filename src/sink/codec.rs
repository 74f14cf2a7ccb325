//! Video encoders, by ffmpeg's names, and their options.

use std::ffi::OsString;

use crate::colour::Sampling;
use crate::error::{Error, Result};
use crate::ffmpeg::command::arguments;
use crate::sink::container::Container;

/// How an encoder stores pictures with alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct AlphaPixels {
    /// The sampling of the planes that it is given; `None`: pixels of red, green, blue and alpha.
    pub(crate) sampling: Option<Sampling>,
    /// ffmpeg's name of its own format.
    pub(crate) format: &'static str,
    /// Further options.
    pub(crate) options: &'static [&'static str],
}

/// A video encoder of ffmpeg.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Encoder {
    /// ffmpeg's name of it.
    pub(crate) name: String,
}

/// Common names of codecs, their encoders, and the constant quality of each that looks like x264's 18 on flat
/// colours.
const CODECS: [(&str, &str, Option<u32>); 9] = [
    ("h264", "libx264", Some(18)),
    ("x264", "libx264", Some(18)),
    ("h265", "libx265", Some(20)),
    ("hevc", "libx265", Some(20)),
    ("vp8", "libvpx", Some(10)),
    ("vp9", "libvpx-vp9", Some(24)),
    ("av1", "libsvtav1", Some(28)),
    ("prores", "prores_ks", None),
    ("theora", "libtheora", None),
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
    /// The encoder for `codec`, a common name or ffmpeg's own name of an encoder; without one, H.264, in WebM VP9, in
    /// Ogg Theora, in AVI MPEG-4, and in a container that we do not know whatever ffmpeg chooses for it.
    pub(crate) fn of(codec: Option<&str>, container: &Container) -> Self {
        let codec = codec.unwrap_or(match container {
            Container::WebM => "vp9",
            Container::Ogg => "theora",
            // Of H.264 in AVI readers do not know the times.
            Container::Avi => "mpeg4",
            Container::WebP => "libwebp_anim",
            Container::Device => "rawvideo",
            Container::Other(_) => "",
            _ => "h264",
        });
        let known = CODECS.iter().find(|(name, ..)| codec.eq_ignore_ascii_case(name));
        Self { name: known.map_or(codec, |(_, encoder, _)| encoder).to_string() }
    }

    /// Its name in messages.
    pub(crate) fn title(&self) -> &str {
        if self.name.is_empty() { "the encoder" } else { &self.name }
    }

    /// Whether one of the common names of codecs means it.
    pub(crate) fn is_common(&self) -> bool {
        CODECS.iter().any(|(_, encoder, _)| *encoder == self.name)
    }

    /// What to do where ffmpeg, which says `words`, does not have it.
    pub(crate) fn advice(&self, words: &str) -> Option<String> {
        // The last lines of ffmpeg 5, and of ffmpeg 9.
        let is_unknown = ["Unknown encoder", "Encoder not found"].iter().any(|w| words.contains(w));
        is_unknown.then(|| {
            format!(
                "this ffmpeg has no encoder '{}': --codec takes h264, h265, vp8, vp9, av1, prores, or a name that \
                 'ffmpeg -encoders' lists",
                self.name
            )
        })
    }

    /// Whether it takes pictures of odd width or height in 4:2:0.
    pub(crate) fn takes_odd(&self) -> bool {
        ["libvpx", "libvpx-vp9", "libaom-av1", "ffv1"].contains(&self.name.as_str())
    }

    /// Whether it takes 10 bits.
    pub(crate) fn takes_deep(&self) -> bool {
        ["libx265", "libsvtav1", "libaom-av1"].contains(&self.name.as_str())
    }

    /// How it stores alpha in `container`; `None` if it does not.
    pub(crate) fn alpha(&self, container: &Container) -> Option<AlphaPixels> {
        use Container::{Avi, Mkv, Mov, WebM, WebP};
        let planes = |sampling, format, options| AlphaPixels { sampling, format, options };
        let is_in = |list: &[Container]| list.contains(container);
        Some(match self.name.as_str() {
            // Alpha is a second picture, which the encoder's reference frames from the future would lose.
            "libvpx" | "libvpx-vp9" if is_in(&[Mkv, WebM]) => {
                planes(Some(Sampling::Yuv420), "yuva420p", &["-auto-alt-ref", "0"])
            }
            "prores_ks" if is_in(&[Mov, Mkv]) => {
                planes(Some(Sampling::Yuv444), "yuva444p10le", &["-profile:v", "4444"])
            }
            "ffv1" if is_in(&[Mkv, Avi, Mov]) => planes(None, "bgra", &[]),
            "png" if is_in(&[Mov, Mkv, Avi]) => planes(None, "rgba", &[]),
            "qtrle" if is_in(&[Mov]) => planes(None, "argb", &[]),
            "utvideo" if is_in(&[Mov, Mkv, Avi]) => planes(None, "gbrap", &[]),
            "libwebp_anim" if is_in(&[WebP]) => planes(None, "bgra", &[]),
            _ => return None,
        })
    }

    /// The most time units in a second, if there is a limit (MPEG-4 part 2).
    pub(crate) fn most_units(&self) -> Option<i64> {
        ["mpeg4", "libxvid"].contains(&self.name.as_str()).then_some(65535)
    }

    /// The tag of H.265 that Apple's players need, or that of MPEG-4 in AVI, and its quality there.
    pub(crate) fn tag(&self, container: &Container) -> Vec<OsString> {
        match self.name.as_str() {
            "libx265" if container.is_quicktime() => arguments([&"-tag:v", &"hvc1"]),
            "mpeg4" if *container == Container::Avi => {
                arguments([&"-tag:v", &"xvid", &"-q:v", &"2"])
            }
            _ => Vec::new(),
        }
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
        let mut args = match self.name.as_str() {
            // What an encoder without a constant quality of its own takes: 1 (best) to 31.
            "" => arguments([&"-q:v", &"2"]),
            "libtheora" => arguments([&"-c:v", &"libtheora", &"-q:v", &"9"]),
            name => arguments([&"-c:v", &name]),
        };
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
    fn encoders_by_common_name_or_their_own() {
        let name = |codec, container| Encoder::of(codec, container).name;
        assert_eq!(name(None, &Container::Mov), "libx264");
        assert_eq!(name(None, &Container::WebM), "libvpx-vp9");
        assert_eq!(name(Some("HEVC"), &Container::Mkv), "libx265");
        assert_eq!(name(Some("mpeg4"), &Container::Mkv), "mpeg4");
        assert_eq!(name(None, &Container::Other("mxf".into())), "");
    }

    #[test]
    fn presets_are_x264s() {
        let x264 = Encoder::of(None, &Container::Mp4);
        assert!(x264.options(None, Some("slowest")).is_err());
        let args = x264.options(Some(23), Some("slow")).expect("a preset");
        assert_eq!(args, ["-c:v", "libx264", "-crf", "23", "-preset", "slow"]);
        let speeds: Vec<String> = (0..PRESETS.len()).map(speed).collect();
        assert_eq!(speeds, ["8", "7", "6", "5", "4", "3", "1", "0", "0", "0"]);
    }

    #[test]
    fn a_quality_out_of_range_is_refused() {
        let said = |codec, crf| {
            Encoder::of(codec, &Container::Mkv).options(Some(crf), None).map_err(|e| e.to_string())
        };
        assert!(said(None, 51).is_ok() && said(Some("av1"), 63).is_ok());
        assert!(said(Some("ffv1"), 99).is_ok(), "what is not known is left to ffmpeg");
        assert!(said(None, 52).expect_err("too large").contains("0 (best) to 51"));
        assert!(said(Some("vp9"), 99).expect_err("too large").contains("63"));
    }

    #[test]
    fn alpha_stays_where_encoder_and_container_take_it() {
        let keeps = |codec, container| Encoder::of(codec, &container).alpha(&container).is_some();
        assert!(keeps(None, Container::WebM) && !keeps(None, Container::Mp4));
        assert!(keeps(Some("prores"), Container::Mov) && keeps(Some("ffv1"), Container::Mkv));
        assert!(!keeps(Some("vp9"), Container::Mp4) && !keeps(Some("av1"), Container::WebM));
    }
}
