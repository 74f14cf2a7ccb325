//! Outputs that are received while they are sent: UDP, RTMP, SRT and HLS, to an ffmpeg on the same machine.

use std::fs;
use std::net::{TcpListener, UdpSocket};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use tempfile::TempDir;

use crate::given::*;
use crate::program::{assert_sound, clip, polyreel, run, said};
use crate::wait::until;

/// A child that does not outlive its test.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Ended {
    /// Waits for its end, at most a minute; whether it succeeded.
    fn succeeded(&mut self) -> bool {
        until("the end of a child", || self.0.try_wait().expect("a child")).success()
    }
}

fn free_port(udp: bool) -> u16 {
    let address = ("127.0.0.1", 0);
    let of_udp = || UdpSocket::bind(address).and_then(|socket| socket.local_addr());
    let of_tcp = || TcpListener::bind(address).and_then(|socket| socket.local_addr());
    if udp { of_udp() } else { of_tcp() }.expect("a free port").port()
}

/// Waits until somebody listens at `port`.
fn wait_for(port: u16, udp: bool) {
    let (list, listens) = if udp { ("/proc/net/udp", "07") } else { ("/proc/net/tcp", "0A") };
    let end = format!(":{port:04X}");
    until("a receiver", || {
        let sockets = fs::read_to_string(list).expect("a list of sockets");
        let mut fields = sockets.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
        let is_there = fields.any(|fields| fields[1].ends_with(&end) && fields[3] == listens);
        is_there.then_some(())
    });
}

/// An ffmpeg that receives `url` into `name`.
fn receiver(dir: &TempDir, options: &str, url: &str, name: &str) -> Ended {
    let mut command = Command::new("ffmpeg");
    command.current_dir(dir.path()).args(["-v", "error", "-nostdin", "-y"]);
    command.args(options.split_whitespace()).args(["-i", url, "-c", "copy", name]);
    Ended(command.stdin(Stdio::null()).spawn().expect("ffmpeg runs"))
}

/// How a stream without an end is received: three seconds of it, and all tracks are found on a busy machine, too.
const PATIENTLY: &str = "-analyzeduration 5000000 -t 3";

/// Starts a render that is not waited for.
fn begin(dir: &TempDir, line: &str) -> Ended {
    let mut command = polyreel(dir, line);
    Ended(command.stdin(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the program"))
}

/// Fails unless the file has `seconds` of picture, and of sound that begins at most `early` seconds before it: a
/// receiver waits for a key frame, and encoders of sound have a run-in.
fn assert_received(path: &Path, seconds: f64, early: f64) {
    let begin =
        |stream| -> f64 { ask(path, stream, "stream=start_time")[0].parse().expect("a start") };
    let lag = begin("a:0") - begin("v:0");
    assert!((-early..=0.04).contains(&lag), "sound is {lag} s late");
    let all = times(path);
    let length = all[all.len() - 1] - all[0];
    assert!(length >= seconds, "{length} s of {seconds}");
    let (from, to) = sound(path).expect("sound");
    assert!(to - from >= seconds, "{} s of sound", to - from);
}

/// Processes that have `word` in their command line.
fn processes_with(word: &str) -> usize {
    let entries = fs::read_dir("/proc").expect("processes").flatten();
    let lines = entries.filter_map(|entry| fs::read(entry.path().join("cmdline")).ok());
    lines.filter(|line| String::from_utf8_lossy(line).contains(word)).count()
}

#[test]
fn networks_are_sent_to_at_the_speed_of_the_film() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "short.mp4", "96x64", 3);
    clip(&dir, "long.mp4", "96x64", 9);
    for (scheme, udp) in [("rtmp", false), ("srt", true), ("udp", true)] {
        let port = free_port(udp);
        let url = format!("{scheme}://127.0.0.1:{port}");
        let (url, options, receive) = match scheme {
            "rtmp" => (format!("{url}/live/x"), "-listen 1", String::new()),
            "srt" => (url, "", "?mode=listener".to_owned()),
            // A stream without an end: a little less than all of it.
            _ => (url, "", "?timeout=60000000".to_owned()),
        };
        let options = if scheme == "udp" { PATIENTLY } else { options };
        let name = format!("{scheme}.mkv");
        let mut receiver = receiver(&dir, options, &format!("{url}{receive}"), &name);
        wait_for(port, udp);
        let began = std::time::Instant::now();
        let film = if scheme == "udp" { "long.mp4" } else { "short.mp4" };
        let output = run(&dir, &format!("render {film} -o {url} --points 60"));
        assert!(output.status.success(), "{url}: {}", said(&output));
        assert!(began.elapsed().as_secs_f64() > 2.0, "{url} was sent at once");
        assert!(receiver.succeeded(), "{url}");
        assert_sound(&dir.path().join(&name));
        let (seconds, early) = if scheme == "udp" { (1.5, 1.1) } else { (2.5, 0.04) };
        assert_received(&dir.path().join(&name), seconds, early);
    }
}

#[test]
fn a_receiver_that_goes_is_an_error_and_leaves_no_orphan() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "96x64", 30);
    let port = free_port(false);
    let url = format!("rtmp://127.0.0.1:{port}/live/gone");
    let receiver = receiver(&dir, "-listen 1", &url, "got.flv");
    wait_for(port, false);
    let mut sender = begin(&dir, &format!("render in.mp4 -o {url} --points 60"));
    until("a part of the stream", || {
        fs::metadata(dir.path().join("got.flv")).ok().filter(|file| file.len() > 2000)
    });
    drop(receiver);
    let status = until("the end of the sender", || sender.0.try_wait().expect("a child"));
    let mut words = String::new();
    std::io::Read::read_to_string(&mut sender.0.stderr.take().expect("a pipe"), &mut words)
        .expect("text");
    assert_eq!(status.code(), Some(1), "{words}");
    assert!(words.contains(&url) && words.contains("cannot be sent any more"), "{words}");
    until("no orphan", || (processes_with(&url) == 0).then_some(()));
    // Nobody is there at all.
    let output = run(&dir, &format!("render in.mp4 -o {url} --points 60"));
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
}

#[test]
fn playlists_are_finished_with_their_segments() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "96x64", 5);
    let output = run(&dir, "render in.mp4 -o x.m3u8 --points 60");
    assert!(output.status.success(), "{}", said(&output));
    let list = dir.path().join("x.m3u8");
    let text = fs::read_to_string(&list).expect("a playlist");
    assert!(text.contains("x_00001.ts") && text.contains("#EXT-X-ENDLIST"), "{text}");
    assert_sound(&list);
    assert_received(&list, 4.9, 0.04);
    let refused = run(&dir, "render in.mp4 -o x.m3u8 --points 60");
    assert!(said(&refused).contains("exists already"), "{}", said(&refused));
    // A failure takes what was written with it.
    make(&dir, "long.ts", &format!("-i {}/in.mp4 -c copy", dir.path().display()));
    let line = "render long.ts -o y.m3u8 --points 60 --ffmpeg-args -hls_flags=nonsense";
    let output = run(&dir, line);
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(!dir.path().join("y.m3u8").exists() && !dir.path().join("y_00000.ts").exists());
}

#[test]
fn live_sound_is_kept_and_the_delay_is_told() {
    if !require() {
        return;
    }
    let dir = folder();
    let (from, to) = (free_port(true), free_port(true));
    // Sends for as long as the test runs.
    let mut camera = Command::new("ffmpeg");
    camera.args(["-v", "error", "-nostdin", "-re", "-f", "lavfi", "-i", "testsrc2=s=96x64:r=25"]);
    camera.args(["-re", "-f", "lavfi", "-i", "sine", "-c:v", "libx264", "-preset", "ultrafast"]);
    camera.args(["-tune", "zerolatency", "-g", "12", "-c:a", "aac", "-f", "mpegts"]);
    camera.arg(format!("udp://127.0.0.1:{from}?pkt_size=1316"));
    let camera = Ended(camera.stdin(Stdio::null()).spawn().expect("ffmpeg runs"));
    let url = format!("udp://127.0.0.1:{to}");
    let mut receiver = receiver(&dir, PATIENTLY, &format!("{url}?timeout=60000000"), "got.mkv");
    wait_for(to, true);
    let line = format!("render udp://127.0.0.1:{from} -o {url} --points 60 --budget auto");
    let mut command = polyreel(&dir, &line);
    let relay = command.stdin(Stdio::null()).stderr(Stdio::piped()).spawn();
    let mut relay = Ended(relay.expect("the program"));
    assert!(receiver.succeeded());
    assert_received(&dir.path().join("got.mkv"), 1.5, 1.1);
    let pid = relay.0.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().expect("kill").success());
    let status = until("the end of the relay", || relay.0.try_wait().expect("a child"));
    let mut words = String::new();
    std::io::Read::read_to_string(&mut relay.0.stderr.take().expect("a pipe"), &mut words)
        .expect("text");
    assert_eq!(status.code(), Some(130), "{words}");
    assert!(words.contains("delay") && words.contains("ms"), "{words}");
    drop(camera);
}

#[test]
fn standard_input_takes_what_ffmpeg_reads_with_its_sound() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "96x64", 2);
    let folder = dir.path().display();
    make(&dir, "in.ts", &format!("-i {folder}/in.mp4 -c copy"));
    make(&dir, "in.mkv", &format!("-i {folder}/in.mp4 -c copy"));
    make(&dir, "deep.y4m", &format!("-i {folder}/in.mp4 -pix_fmt yuv420p10le -strict -1"));
    make(&dir, "quarter.y4m", &format!("-i {folder}/in.mp4 -pix_fmt yuv411p"));
    for (input, output, heard) in [
        ("in.ts", "a.mkv", true),
        ("in.mkv", "b.mp4", true),
        ("deep.y4m", "c.mkv", false),
        ("quarter.y4m", "d.mkv", false),
    ] {
        let line = format!("render - -o {output} --points 60");
        let input = fs::File::open(dir.path().join(input)).expect("a clip");
        let done = polyreel(&dir, &line).stdin(input).output().expect("the program");
        assert!(done.status.success(), "{line}: {}", said(&done));
        let path = dir.path().join(output);
        assert_sound(&path);
        assert_eq!(times(&path).len(), 50, "{output}");
        assert_eq!(sound(&path).is_some(), heard, "{output}");
        if heard {
            assert_received(&path, 1.9, 0.06);
        }
    }
    // A named pipe of it, and a part.
    let pipe = dir.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("mkfifo").success());
    let (from, to) = (dir.path().join("in.ts"), pipe.clone());
    let writer = std::thread::spawn(move || {
        let mut pipe = fs::File::options().write(true).open(to).expect("a reader");
        // The reader may end before all of it.
        let _ = std::io::copy(&mut fs::File::open(from).expect("a clip"), &mut pipe);
    });
    let output = run(&dir, "render pipe -o part.mkv --points 60 --start 0.4 --end 1.4");
    assert!(output.status.success(), "{}", said(&output));
    writer.join().expect("a writer");
    let path = dir.path().join("part.mkv");
    assert_eq!(times(&path).len(), 25);
    let (begin, end) = sound(&path).expect("sound");
    assert!((end - begin - 1.0).abs() < 0.12, "{begin} to {end}");
}
