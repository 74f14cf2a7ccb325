//! Containers, pipes and transparency: what is written can be read again, with its times.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use image::RgbaImage;
use tempfile::TempDir;

use crate::given::*;
use crate::program::{assert_sound, clip, listing, polyreel, run, said};

fn done(dir: &TempDir, line: &str) -> String {
    let output = run(dir, line);
    let words = said(&output);
    assert!(output.status.success(), "{line}: {words}");
    words
}

/// Times of frames, counted from the first.
fn from_first(path: &Path) -> Vec<f64> {
    let times: Vec<f64> = ask(path, "v:0", "frame=best_effort_timestamp_time")
        .iter()
        .map(|line| line.trim_end_matches(',').parse().expect("a time"))
        .collect();
    times.iter().map(|time| time - times[0]).collect()
}

/// How much later the sound begins than the picture.
fn lag(path: &Path) -> f64 {
    let begin =
        |stream| -> f64 { ask(path, stream, "stream=start_time")[0].parse().expect("a start") };
    begin("a:0") - begin("v:0")
}

#[test]
fn every_container_holds_times_and_sound() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "96x64", 2);
    let wanted = times(&dir.path().join("in.mp4"));
    for (output, codec, heard) in [
        ("out.ts", "h264", "aac"),
        ("out.avi", "mpeg4", "mp3"),
        ("out.flv", "h264", "aac"),
        ("out.ogv", "theora", "opus"),
    ] {
        done(&dir, &format!("render in.mp4 -o {output} --points 60"));
        let path = dir.path().join(output);
        assert_sound(&path);
        assert_eq!(ask(&path, "v:0", "stream=codec_name")[0], codec, "{output}");
        assert_eq!(ask(&path, "a:0", "stream=codec_name")[0], heard, "{output}");
        assert!(apart(&wanted, &from_first(&path)) <= 0.001, "{output}: {:?}", times(&path));
        assert!(lag(&path).abs() <= 0.04, "{output}: {}", lag(&path));
        let (begin, end) = sound(&path).expect("sound");
        assert!((end - begin - 2.0).abs() <= 0.1, "{output}: {begin} to {end}");
        done(&dir, &format!("render {output} -o again.mkv -y --points 60"));
        let again = from_first(&dir.path().join("again.mkv"));
        assert!(apart(&wanted, &again) <= 0.0011, "{output}: {again:?}");
    }
}

#[test]
fn any_muxer_is_taken_by_its_name() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "96x64", 1);
    for (output, options, format) in [
        ("out.mxf", "--format mxf", "mxf"),
        ("video", "--format matroska", "matroska,webm"),
        ("out.nut", "--format nut --codec ffv1", "nut"),
        ("out.wmv", "--format asf --codec msmpeg4", "asf"),
    ] {
        done(&dir, &format!("render in.mp4 -o {output} {options} --points 60"));
        let path = dir.path().join(output);
        assert_sound(&path);
        let found = ask(&path, "v:0", "format=format_name")[0].replace('"', "");
        assert_eq!(found, format, "{output}");
        assert_eq!(from_first(&path).len(), 25, "{output}");
    }
    let refused = run(&dir, "render in.mp4 -o out.bin --format nonsense");
    assert_eq!(refused.status.code(), Some(1), "{}", said(&refused));
    done(&dir, "render in.mp4 -o clip --format gif --frames 2 --points 60");
    assert!(fs::read(dir.path().join("clip")).expect("a GIF").starts_with(b"GIF89a"));
}

#[test]
fn pipes_get_any_video() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "96x64", 1);
    for (format, name) in [("mpegts", "mpegts"), ("mkv", "matroska,webm"), ("mp4", "mov,mp4")] {
        for place in ["-", "/dev/stdout"] {
            let line = format!("render in.mp4 -o {place} --format {format} --points 60");
            let output = polyreel(&dir, &line).stdin(Stdio::null()).output().expect("the program");
            assert!(output.status.success(), "{}", said(&output));
            let path = dir.path().join("got");
            fs::write(&path, output.stdout).expect("a file");
            assert_sound(&path);
            let found = ask(&path, "v:0", "format=format_name")[0].replace('"', "");
            assert!(found.starts_with(name), "{found}");
            assert_eq!(from_first(&path).len(), 25);
            let (begin, end) = sound(&path).expect("sound");
            assert!((end - begin - 1.0).abs() < 0.1, "{begin} to {end}");
        }
    }
    // A named pipe by its ending, y4m without one.
    for (pipe, words) in [("pipe.mkv", "matroska"), ("pipe", "yuv4mpegpipe")] {
        assert!(Command::new("mkfifo").arg(dir.path().join(pipe)).status().expect("x").success());
        let mut reader = Command::new("ffprobe");
        reader.args(["-v", "error", "-show_entries", "format=format_name", "-of", "csv=p=0"]);
        reader.arg("-count_frames").args(["-show_entries", "stream=nb_read_frames"]);
        let reader = reader.arg(dir.path().join(pipe)).stdout(Stdio::piped()).spawn();
        let reader = reader.expect("ffprobe runs");
        done(&dir, &format!("render in.mp4 -o {pipe} --points 60"));
        let found = reader.wait_with_output().expect("its end").stdout;
        let found = String::from_utf8_lossy(&found).into_owned();
        assert!(found.contains(words) && found.contains("25"), "{pipe}: {found}");
    }
    // A reader that has had enough is an end.
    let line = "render in.mp4 -o - --format mpegts --points 60";
    let mut child = polyreel(&dir, line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let child = child.as_mut().expect("the program");
    drop(child.stdout.take());
    assert!(child.wait().expect("its end").success());
}

/// A picture with smooth alpha, opaque and clear parts, and colours that differ.
fn with_alpha(x: u32, y: u32) -> [u8; 4] {
    let alpha = (x * 4).min(255) as u8;
    [if y < 32 { 220 } else { 40 }, 120, 60, alpha]
}

/// The frames of `name` as RGBA, decoded by ffmpeg with the decoder `options`.
fn decoded(dir: &TempDir, name: &str, options: &str, size: (u32, u32)) -> Vec<RgbaImage> {
    let mut command = Command::new("ffmpeg");
    command.args(["-v", "error"]).args(options.split_whitespace());
    command.arg("-i").arg(dir.path().join(name));
    command.args(["-f", "rawvideo", "-pix_fmt", "rgba", "-"]);
    let bytes = command.output().expect("ffmpeg runs").stdout;
    let frame = (4 * size.0 * size.1) as usize;
    assert!(
        !bytes.is_empty() && bytes.len().is_multiple_of(frame),
        "{name}: {} bytes",
        bytes.len()
    );
    let image = |bytes: &[u8]| RgbaImage::from_raw(size.0, size.1, bytes.to_vec());
    bytes.chunks(frame).map(|bytes| image(bytes).expect("a frame")).collect()
}

/// Mean difference of alpha.
fn alpha_error(a: &RgbaImage, b: &RgbaImage) -> f64 {
    let sum: u64 = a.pixels().zip(b.pixels()).map(|(a, b)| u64::from(a[3].abs_diff(b[3]))).sum();
    sum as f64 / f64::from(a.width() * a.height())
}

#[test]
fn alpha_stays_in_video() {
    if !require() {
        return;
    }
    let dir = folder();
    let size = (70, 64);
    for i in 0..5 {
        let picture = RgbaImage::from_fn(size.0, size.1, |x, y| image::Rgba(with_alpha(x + i, y)));
        picture.save(dir.path().join(format!("in_{i}.png"))).expect("a picture");
    }
    done(&dir, "render in_%d.png -o ref_%d.png --points 80");
    let reference = |i: usize| {
        let path = dir.path().join(format!("ref_{}.png", i + 1));
        image::open(path).expect("a picture").to_rgba8()
    };
    for (output, options, decoder) in [
        ("out.webm", "", "-c:v libvpx-vp9"),
        ("vp8.webm", "--codec vp8", "-c:v libvpx"),
        ("prores.mov", "--codec prores", ""),
        ("out.mkv", "--codec ffv1", ""),
        ("png.mov", "--codec png", ""),
        ("rle.mov", "--codec qtrle", ""),
    ] {
        let words = done(&dir, &format!("render in_%d.png -o {output} {options} --points 80"));
        assert!(!words.contains("warning"), "{output}: {words}");
        let frames = decoded(&dir, output, decoder, size);
        assert_eq!(frames.len(), 5, "{output}");
        for (i, frame) in frames.iter().enumerate() {
            let off = alpha_error(frame, &reference(i));
            assert!(off < 2.0, "{output}: alpha of frame {i} is {off} off");
            let (seen, wanted) = (frame.get_pixel(66, 10), *reference(i).get_pixel(66, 10));
            let far = (0..3).map(|c| seen[c].abs_diff(wanted[c])).max();
            assert!(far <= Some(12), "{output}: {seen:?}, not {wanted:?}");
        }
        // And polyreel reads it again.
        done(&dir, &format!("render {output} -o back.png -y --frames 1 --points 80"));
        let back = image::open(dir.path().join("back.png")).expect("a picture").to_rgba8();
        assert!(alpha_error(&back, &reference(0)) < 4.0, "{output}");
    }
    for output in ["out.mp4", "av1.webm --codec libaom-av1 --encoder-preset 8"] {
        let words = done(&dir, &format!("render in_%d.png -o {output} --points 80"));
        let warned = words.contains("transparency is lost") && words.contains(".webm");
        assert!(warned && words.contains("prores"), "{output}: {words}");
    }
    assert!(listing(&dir).iter().all(|name| !name.starts_with('.')));
}

#[test]
fn dispositions_dates_and_timecodes_come_along() {
    if !require() {
        return;
    }
    let dir = folder();
    let tones = "-f lavfi -i sine=d=1 -f lavfi -i sine=f=600:d=1";
    make(
        &dir,
        "in.mov",
        &format!(
            "-f lavfi -i testsrc2=s=96x64:r=25:d=1 {tones} -map 0 -map 1 -map 2 -c:v libx264 -preset ultrafast \
             -c:a aac -metadata title=Film -metadata date=2024 -timecode 01:02:03:04 \
             -metadata:s:a:0 language=eng -metadata:s:a:1 language=fra -disposition:a:0 0 -disposition:a:1 default"
        ),
    );
    let of = |name: &str, entries: &str| ask(&dir.path().join(name), "", entries).join(" ");
    for output in ["out.mov", "out.mp4", "out.mkv"] {
        done(&dir, &format!("render in.mov -o {output} --points 60"));
        let default = ask(&dir.path().join(output), "a", "stream_disposition=default");
        assert_eq!(default, ["0", "1"], "{output}");
        assert!(of(output, "format_tags=date,title").contains("2024"), "{output}");
        let code = of(output, "stream_tags=timecode:format_tags=timecode");
        assert!(code.contains("01:02:03:04"), "{output}: {code}");
    }
    done(&dir, "render in.mov -o bare.mkv --points 60 --no-metadata");
    let left = of("bare.mkv", "format_tags=date,title,timecode:stream_tags=language,timecode");
    assert!(!left.contains("2024") && !left.contains("fra") && !left.contains("01:02"), "{left}");
    assert_eq!(ask(&dir.path().join("bare.mkv"), "a", "stream=codec_name").len(), 2);
    let table = String::from_utf8_lossy(&run(&dir, "info in.mov").stdout).into_owned();
    for note in ["sound: stream 2, fra, aac, default", "title: Film", "timecode: 01:02:03:04"] {
        assert!(table.contains(note), "{note}: {table}");
    }
    assert!(done(&dir, "render in.mov -o v.mkv --points 60 -v").contains("timecode: 01:02:03:04"));
}

/// How much rows differ from the mean of their neighbours.
fn comb(picture: &RgbaImage) -> f64 {
    let value = |x: u32, y: u32| i64::from(picture.get_pixel(x, y)[1]);
    let rows = (1..picture.height() - 1).flat_map(|y| (0..picture.width()).map(move |x| (x, y)));
    let sum: i64 =
        rows.map(|(x, y)| (2 * value(x, y) - value(x, y - 1) - value(x, y + 1)).abs()).sum();
    sum as f64 / f64::from(picture.width() * picture.height())
}

#[test]
fn interlaced_film_is_deinterlaced() {
    if !require() {
        return;
    }
    let dir = folder();
    let stripes = "-f lavfi -i nullsrc=s=128x96:r=50:d=1,geq=lum='if(mod(floor((X+8*N)/16),2),220,30)':cb=128:cr=128";
    make(
        &dir,
        "in.mkv",
        &format!(
            "{stripes} -vf tinterlace=interleave_top,setfield=tff -flags +ilme+ildct -c:v libx264 \
             -preset ultrafast -qp 4"
        ),
    );
    let combed = decoded(&dir, "in.mkv", "", (128, 96));
    let (frames, ended) = read(&dir.path().join("in.mkv"));
    assert!(ended.is_ok());
    assert_eq!(frames.len(), combed.len());
    let smooth = RgbaImage::from_raw(128, 96, frames[10].frame.pixels().concat()).expect("a frame");
    let (before, after) = (comb(&combed[10]), comb(&smooth));
    assert!(before > 40.0 && after < before / 3.0, "{before}, {after}");
    let table = String::from_utf8_lossy(&run(&dir, "info in.mkv").stdout).into_owned();
    assert!(table.contains("interlaced (") && table.contains("): deinterlaced"), "{table}");
}

#[test]
fn hdr_becomes_sdr_unless_it_is_to_stay() {
    if !require() {
        return;
    }
    let dir = folder();
    let white = "color=white:s=128x96:r=10:d=0.5,format=yuv420p10le,geq=lum=573:cb=512:cr=512,\
                 setparams=color_trc=smpte2084:color_primaries=bt2020:colorspace=bt2020nc:range=tv";
    let tags = "-color_trc smpte2084 -color_primaries bt2020 -colorspace bt2020nc -color_range tv";
    let x265 = "-c:v libx265 -pix_fmt yuv420p10le -x265-params log-level=error";
    make(&dir, "in.mp4", &format!("-f lavfi -i {white} {x265} {tags}"));
    let entries = "stream=codec_name,pix_fmt,color_transfer";
    done(&dir, "render in.mp4 -o sdr.mp4 --points 30");
    assert_eq!(ask(&dir.path().join("sdr.mp4"), "v", entries), ["h264,yuv420p,bt709"]);
    let level = decoded(&dir, "sdr.mp4", "", (128, 96))[0].get_pixel(30, 20)[1];
    assert!(level > 210, "{level}");
    done(&dir, "render in.mp4 -o hdr.mp4 --points 30 --hdr");
    assert_eq!(ask(&dir.path().join("hdr.mp4"), "v", entries), ["hevc,yuv420p10le,smpte2084"]);
    done(&dir, "render in.mp4 -o hdr.mkv --points 30 --hdr --codec av1 --encoder-preset 10");
    assert_eq!(ask(&dir.path().join("hdr.mkv"), "v", entries), ["av1,yuv420p10le,smpte2084"]);
    let refused = run(&dir, "render in.mp4 -o no.mp4 --hdr --codec h264");
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    assert!(said(&refused).contains("--codec h265"), "{}", said(&refused));
}

/// Says of an MP4 whose first track is HEVC, and whose index stands at its end, that it is Dolby Vision of this `profile`
/// and `base`.
fn make_dolby_vision(path: &Path, profile: u8, base: u8) {
    let mut bytes = fs::read(path).expect("a file");
    let find = |bytes: &[u8], name: &[u8; 4]| {
        bytes.windows(4).rposition(|window| window == name).expect("a box") - 4
    };
    let mut record = vec![0, 0, 0, 32];
    record.extend(b"dvcC");
    // Level 1; a base layer and metadata.
    record.extend([1, 0, profile << 1, 1 << 3 | 0b101, base << 4]);
    record.resize(32, 0);
    let entry = find(&bytes, b"hvcC");
    let parents = [b"moov", b"trak", b"mdia", b"minf", b"stbl", b"stsd", b"hev1"]
        .map(|name| find(&bytes, name));
    bytes.splice(entry..entry, record);
    for at in parents {
        let size = u32::from_be_bytes(bytes[at..at + 4].try_into().expect("four bytes")) + 32;
        bytes[at..at + 4].copy_from_slice(&size.to_be_bytes());
    }
    fs::write(path, bytes).expect("written");
}

#[test]
fn dolby_vision_is_read_by_its_base_layer_or_refused() {
    if !require() {
        return;
    }
    let dir = folder();
    let film = "-f lavfi -i testsrc2=s=96x64:r=10:d=0.5 -c:v libx265 -tag:v hev1 -pix_fmt yuv420p10le \
                -x265-params log-level=error -color_trc smpte2084 -color_primaries bt2020 -colorspace bt2020nc";
    for (profile, base) in [(8, 1), (5, 0)] {
        let path = make(&dir, &format!("in{profile}.mp4"), film);
        make_dolby_vision(&path, profile, base);
    }
    let words = said(&run(&dir, "render in8.mp4 -o out.mp4 --points 30 -v"));
    assert!(words.contains("Dolby Vision (profile 8)"), "{words}");
    let refused = run(&dir, "render in5.mp4 -o no.mp4");
    assert_eq!(refused.status.code(), Some(1), "{}", said(&refused));
    assert!(said(&refused).contains("Dolby Vision of profile 5"), "{}", said(&refused));
}

#[test]
fn animated_webp_may_be_lossy() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "96x64", 1);
    done(&dir, "render in.mp4 -o plain.webp --points 60");
    done(&dir, "render in.mp4 -o lossy.webp --points 60 --lossy 60");
    let size = |name: &str| fs::metadata(dir.path().join(name)).expect("a file").len();
    assert!(size("lossy.webp") < size("plain.webp"));
    for name in ["plain.webp", "lossy.webp"] {
        let info = run(&dir, &format!("info {name} --json")).stdout;
        let info: serde_json::Value = serde_json::from_slice(&info).expect("JSON");
        assert_eq!((&info["frames"], &info["loops"]), (&25.into(), &"forever".into()), "{name}");
        assert_eq!(info["duration"]["num"], info["duration"]["den"], "{name}");
    }
}
