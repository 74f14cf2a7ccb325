//! Which outputs are videos, and their sinks.

use std::path::Path;

use super::ffmpeg::{Container, LiveSink, VideoSink, VideoSpec};
use super::still::Format;
use super::target::Target;
use super::{Sink, SinkOptions, animation, no_video_of_a_still, one_mesh, y4m};
use crate::error::{Error, Result};
use crate::options::FillMode;
use crate::stream::StreamInfo;

/// The lower-case extension that tells the format of `path`.
pub(super) fn format_of(path: &Path, options: &SinkOptions) -> String {
    let extension = || path.extension().map(|e| e.to_string_lossy().into_owned());
    options.format.clone().or_else(extension).unwrap_or_default().to_lowercase()
}

/// Whether `output` is a video, of ffmpeg's or y4m, in the `format` that was asked for.
#[cfg(feature = "cli")]
pub fn is_video(output: &std::ffi::OsStr, format: Option<&str>) -> bool {
    let options = SinkOptions { format: format.map(str::to_owned), ..SinkOptions::default() };
    let is_y4m = ["", "y4m"].contains(&format_of(Path::new(output), &options).as_str());
    match Target::of(output) {
        Some(Target::Pipe) => !is_y4m,
        Some(_) => true,
        None => container_of(Path::new(output), &options).is_some(),
    }
}

/// The container of the file `path`, if it is a video of ffmpeg's. A format that is none of ours is one of ffmpeg's.
pub(super) fn container_of(path: &Path, options: &SinkOptions) -> Option<Container> {
    let Some(format) = &options.format else { return Container::of(path) };
    let format = format.to_lowercase();
    let own = ["polyreel", "html", "htm", "usda", "svg", "gif", "apng", "y4m"];
    let is_own = own.contains(&format.as_str())
        || Format::of_extension(&format).is_some()
        || one_mesh::Format::of_extension(&format).is_some();
    (!is_own).then(|| Container::named(&format))
}

/// The sink of the video file `path`.
///
/// # Errors
/// As [`VideoSink::create`].
pub(super) fn video_file(
    path: &Path,
    info: &StreamInfo,
    options: &SinkOptions,
) -> Result<Box<dyn Sink>> {
    let spec = video_spec(info, options);
    let Some(container) = container_of(path, options) else {
        return Ok(Box::new(VideoSink::create(path, spec, options)?));
    };
    Ok(Box::new(VideoSink::create_in(container, path, spec, options)?))
}

/// The sink of a WebP with lossy pictures, by ffmpeg.
///
/// # Errors
/// As [`VideoSink::create`].
pub(super) fn lossy_webp(
    path: &Path,
    quality: u8,
    info: &StreamInfo,
    options: &SinkOptions,
) -> Result<Box<dyn Sink>> {
    let plays = animation::loops(info, options).plays().min(u16::MAX.into());
    let mut options = options.clone();
    let own = ["-quality", &quality.to_string(), "-loop", &plays.to_string()].map(str::to_owned);
    options.video.ffmpeg_args.splice(0..0, own);
    (options.video.codec, options.video.crf, options.video.encoder_preset) = (None, None, None);
    let spec = VideoSpec { sound: None, ..video_spec(info, &options) };
    Ok(Box::new(VideoSink::create_in(Container::webp(), path, spec, &options)?))
}

/// The sink of an output that takes frames as they come.
///
/// # Errors
/// When the format does not suit the place, or as its sink.
pub(super) fn passing(
    output: &Path,
    target: Target,
    info: &StreamInfo,
    options: &SinkOptions,
) -> Result<Box<dyn Sink>> {
    let format = format_of(output, options);
    if target == Target::Pipe && ["", "y4m"].contains(&format.as_str()) {
        let standard = output == Path::new("-") || output == Path::new("/dev/stdout");
        return if standard {
            y4m::Y4mSink::standard(info)
        } else {
            y4m::Y4mSink::pipe(output, info)
        };
    }
    if container_of(output, options).is_none() && options.format.is_some() {
        return Err(Error::usage(format!(
            "{format} is written to files, not to {}: only videos and y4m go through pipes",
            output.display()
        )));
    }
    if info.still {
        return Err(no_video_of_a_still(output));
    }
    let spec = video_spec(info, options);
    Ok(Box::new(LiveSink::create(output, target, info.live, spec, options)?))
}

/// The video that is made of `info`.
fn video_spec(info: &StreamInfo, options: &SinkOptions) -> VideoSpec {
    let alpha = info.alpha || options.look.fill == FillMode::None;
    VideoSpec { alpha, sound: options.sound.clone(), ..VideoSpec::of(info, info.size) }
}
