//! Recognises the format of an input and opens it.

use std::ffi::OsStr;
use std::io::{self, Cursor, Read};
use std::path::Path;

use image::ImageFormat;

use super::detect::{self, Kind};
use super::limit::Limit;
use super::trim::Part;
use super::{
    Input, SEQUENCE_RATE, SourceOptions, animation, apng, expand, ffmpeg, gif, mesh_stream,
    sequence, webp, y4m,
};
use crate::error::{Error, Result};

/// Opens `inputs`: files that exist, an address, or standard input. Of a sequence no more pictures than `part` needs.
pub(super) fn recognised(
    inputs: &[&OsStr],
    part: Option<Part>,
    options: &SourceOptions,
) -> Result<Input> {
    if inputs == ["-"] {
        let path = Path::new("-");
        return if mesh_stream::waits_on_standard_input() {
            within_memory(mesh_stream::open_standard()?, path, options)
        } else if y4m::waits_on_standard_input() {
            within_memory(y4m::open_standard()?, path, options)
        } else {
            within_memory(
                ffmpeg::open_pipe(path, Box::new(std::io::stdin()), options)?,
                path,
                options,
            )
        };
    }
    if let [one] = inputs
        && ffmpeg::is_address(Path::new(one))
    {
        return within_memory(ffmpeg::open(one.into(), options)?, Path::new(one), options);
    }
    let mut paths = expand::expand(inputs)?;
    if paths.len() > 1 {
        if let Some(part) = part {
            let needed = part.needed(options.fps.unwrap_or(SEQUENCE_RATE));
            paths.truncate(usize::try_from(needed).unwrap_or(usize::MAX).max(1));
        }
        return sequence::open_sequence(&paths, options);
    }
    let Some(path) = paths.pop() else { return Err(Error::usage("no input is named")) };
    match detect::detect(&path)? {
        Kind::Gif => gif::open(path, options),
        Kind::Picture(ImageFormat::Png) => match apng::facts(&path)? {
            Some(facts) => animation::open(path, animation::Format::Apng, facts, options),
            None => sequence::open_still(path, ImageFormat::Png, options),
        },
        Kind::Picture(ImageFormat::WebP) => match webp::facts(&path)? {
            Some(facts) => animation::open(path, animation::Format::WebP, facts, options),
            None => sequence::open_still(path, ImageFormat::WebP, options),
        },
        Kind::Picture(format) => sequence::open_still(path, format, options),
        Kind::MeshStream => within_memory(mesh_stream::open(path.clone())?, &path, options),
        Kind::Y4m => within_memory(y4m::open(path.clone())?, &path, options),
        Kind::Stream => within_memory(open_pipe(&path, options)?, &path, options),
        Kind::Other => {
            let picture = detect::is_called_picture(&path);
            let video = ffmpeg::open(path.clone(), options)
                .map_err(|error| if picture { detect::no_picture(path.clone()) } else { error })?;
            within_memory(video, &path, options)
        }
    }
}

/// Opens what comes out of the named pipe `path`, by its first bytes.
fn open_pipe(path: &Path, options: &SourceOptions) -> Result<Input> {
    let failed = |e: io::Error| Error::input(path, format!("cannot be read: {e}")).caused_by(e);
    let mut pipe = detect::open(path)?;
    let mut start = Vec::with_capacity(detect::MAGIC);
    let most = detect::MAGIC as u64;
    Read::by_ref(&mut pipe).take(most).read_to_end(&mut start).map_err(failed)?;
    let kind = detect::kind(&start);
    let is_empty = start.is_empty();
    let input = Cursor::new(start).chain(pipe);
    match kind {
        Kind::MeshStream => mesh_stream::open_pipe(Box::new(input), path.to_owned()),
        Kind::Y4m => y4m::open_pipe(input, path.to_owned()),
        _ if is_empty => y4m::open_pipe(input, path.to_owned()),
        _ => ffmpeg::open_pipe(path, Box::new(input), options),
    }
}

/// Checks that the frames of a video fit into memory: as decoded, and as RGBA.
fn within_memory(input: Input, path: &Path, options: &SourceOptions) -> Result<Input> {
    Limit::of(options).check(path, input.info.size, 8)?;
    Ok(input)
}
