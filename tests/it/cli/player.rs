//! The page that plays: its reader of mesh streams, written by the specification, against our own; and the page
//! itself in a browser.

use std::path::PathBuf;
use std::process::Command;

use super::{Folder, picture};

/// Whether `program` runs; if not the test is skipped, loudly, or fails where `REQUIRE_BROWSER` is set.
fn runs(program: &str) -> bool {
    let found =
        Command::new(program).arg("--version").output().is_ok_and(|done| done.status.success());
    if !found {
        assert!(std::env::var_os("REQUIRE_BROWSER").is_none(), "{program} is missing");
        eprintln!("SKIPPED: there is no {program} to play a page");
    }
    found
}

/// Prints every frame of the stream named first as RGBA, `scale` pixels a pixel, by the player's own reader.
const PAINT_ALL: &str = r"
const fs = require('fs'), [code, name, scale, out] = process.argv.slice(1);
const { openStream, readFrame, shapes, lookOf, paint, S } = new Function(
  fs.readFileSync(code, 'utf8') + 'return { openStream, readFrame, shapes, lookOf, paint, S }')();
const { fields, frames } = openStream(new Uint8Array(fs.readFileSync(name)));
const width = Math.round(S.width * scale), height = Math.round(S.height * scale);
const pictures = frames.map(frame => {
  readFrame(frame);
  const pixels = new Uint32Array(width * height);
  paint(shapes(lookOf(fields)), pixels, width, height);
  return Buffer.from(pixels.buffer);
});
fs.writeFileSync(out, Buffer.concat(pictures));
";

fn reader() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "src/sink/html/stream.js"].iter().collect()
}

/// Frames of 48x32 with a transparent part, a wandering disc, and a cut in the middle.
fn clip(folder: &Folder, name: &str, frames: u32) {
    std::fs::create_dir(folder.path(name)).expect("a new folder");
    for t in 0..frames {
        let mut picture = image::DynamicImage::from(picture(48, 32, t)).to_rgba8();
        for (x, y, pixel) in picture.enumerate_pixels_mut() {
            if 2 * t >= frames {
                pixel.0.swap(0, 2);
                pixel.0[1] ^= (x * y) as u8 & 127;
            }
            pixel.0[3] = if x < 9 {
                0
            } else if y < 7 {
                130
            } else {
                255
            };
        }
        picture.save(folder.path(&format!("{name}/f{t}.png"))).expect("a writable folder");
    }
}

/// Needs Node; skipped, loudly, where there is none.
#[test]
fn the_reader_in_the_page_reads_what_we_write() {
    if !runs("node") {
        return;
    }
    let folder = Folder::new();
    folder.gif("opaque", &[100, 40, 60, 60, 60, 60]);
    clip(&folder, "clear", 6);
    for (input, look) in [
        ("opaque", "--points 60"),
        ("opaque", "--points 300 --saturation 1.6 --wash 0.2 --vertex-grid 4"),
        ("clear", "--points 120 --vertex-grid 1"),
        ("clear", "--points 200"),
    ] {
        for scale in ["1", "2.5"] {
            folder.run(&format!("render {input} -o in.polyreel -y --edges hard {look}")).success();
            folder.run(&format!("render in.polyreel -o f%d.png -y --scale {scale}")).success();
            let (stream, raw) = (folder.path("in.polyreel"), folder.path("raw"));
            let mut node = Command::new("node");
            let done =
                node.args(["-e", PAINT_ALL]).arg(reader()).arg(stream).arg(scale).arg(raw).output();
            let done = done.expect("it ran before");
            assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
            let raw = folder.read("raw");
            let frame = raw.len() / 6;
            for t in 0..6 {
                let wanted = folder.open(&format!("f{}.png", t + 1));
                assert!(
                    wanted.as_raw()[..] == raw[t * frame..][..frame],
                    "{input} {look} {scale}: frame {t}"
                );
            }
        }
    }
}

/// The browser that there is.
fn browser() -> Option<&'static str> {
    let names = ["chromium-headless-shell", "chromium", "chromium-browser", "google-chrome"];
    let quiet = |name: &&str| {
        Command::new(name).arg("--version").output().is_ok_and(|done| done.status.success())
    };
    let found = names.into_iter().find(quiet);
    if found.is_none() {
        runs(names[0]);
    }
    found
}

/// Has the browser open `page`, of `folder`, with `args`; returns what it prints.
fn browse(browser: &str, folder: &Folder, page: &str, args: &[&str]) -> String {
    // One profile a run: two browsers do not share one.
    let profile = tempfile::tempdir().expect("a temporary folder");
    let done = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--hide-scrollbars", "--use-angle=swiftshader"])
        .args(["--enable-unsafe-swiftshader", "--disable-dev-shm-usage"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .args(args)
        .arg(format!("file://{}", folder.path(page).display()))
        .current_dir(folder.0.path())
        .output()
        .expect("it ran before");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8_lossy(&done.stdout).into_owned()
}

/// A picture of `page` in a window of 480x320 dots.
fn screenshot(browser: &str, folder: &Folder, page: &str, args: &[&str]) -> image::RgbaImage {
    let size = if args.contains(&"--force-device-scale-factor=2") { "240,160" } else { "480,320" };
    let size = format!("--window-size={size}");
    browse(browser, folder, page, &[&["--screenshot=shot.png", &size], args].concat());
    folder.open("shot.png")
}

/// The peak signal-to-noise ratio over red, green and blue, of `picture` laid over white.
fn psnr(picture: &image::RgbaImage, shot: &image::RgbaImage) -> f64 {
    assert_eq!(picture.dimensions(), shot.dimensions());
    let squares = picture.pixels().zip(shot.pixels()).flat_map(|(a, b)| {
        let alpha = f64::from(a[3]) / 255.0;
        (0..3).map(move |c| {
            (f64::from(a[c]) * alpha + 255.0 * (1.0 - alpha) - f64::from(b[c])).powi(2)
        })
    });
    let count = 3.0 * f64::from(picture.width() * picture.height());
    let error: f64 = squares.sum::<f64>() / count;
    10.0 * (255.0f64.powi(2) / error.max(1e-9)).log10()
}

/// Needs Chromium; skipped, loudly, where there is none.
#[test]
fn the_page_shows_the_frame_of_each_time() {
    let Some(browser) = browser() else { return };
    let folder = Folder::new();
    folder.gif("in.gif", &[100, 40, 60]);
    clip(&folder, "clear", 3);
    for (input, look) in [("in.gif", "--points 60"), ("clear", "--points 120 --fps 20")] {
        for edges in ["hard", "smooth"] {
            let look = format!("{input} -y --edges {edges} {look}");
            folder.run(&format!("render {look} -o clip.html")).success();
            folder.run(&format!("render {look} -o f%d.png --scale 10")).success();
            let wanted = |t: usize| folder.open(&format!("f{t}.png"));
            let times = if input == "in.gif" { [0.05, 0.12, 0.15] } else { [0.01, 0.06, 0.12] };
            let at = |t: f64, more: &str| format!("clip.html#t={t}{more}");
            let last = screenshot(browser, &folder, &at(times[2], ""), &[]);
            assert!(psnr(&wanted(3), &last) > 30.0, "{look}: {}", psnr(&wanted(3), &last));
            assert!(psnr(&wanted(1), &last) < 30.0, "{look}: frames differ");
            if edges == "hard" {
                let second = screenshot(browser, &folder, &at(times[1], "&draw=2d"), &[]);
                assert!(psnr(&wanted(2), &second) > 50.0, "{look}: {}", psnr(&wanted(2), &second));
                let dense = ["--force-device-scale-factor=2"];
                let first = screenshot(browser, &folder, &at(times[0], "&draw=2d"), &dense);
                assert!(psnr(&wanted(1), &first) > 50.0, "{look}: {}", psnr(&wanted(1), &first));
            }
        }
    }
}

/// Needs Chromium; skipped, loudly, where there is none.
#[test]
fn no_ground_shows_between_the_facets_of_the_page() {
    let Some(browser) = browser() else { return };
    let folder = Folder::new();
    folder.still("in.png", 96, 64);
    folder.run("render in.png -o still.html --points 400").success();
    let page = String::from_utf8(folder.read("still.html")).expect("text");
    let [magenta, green] = ["#f0f", "#0f0"].map(|ground| {
        folder.write(
            "page.html",
            page.replace("background:#111", &format!("background:{ground}")).as_bytes(),
        );
        screenshot(browser, &folder, "page.html", &[])
    });
    assert!(magenta == green, "the ground shows");
}

/// Needs Chromium; skipped, loudly, where there is none.
#[test]
fn the_page_plays_pauses_and_ends() {
    let Some(browser) = browser() else { return };
    let folder = Folder::new();
    folder.gif("in.gif", &[100, 40, 60]);
    folder.run("render in.gif -o forever.html --points 60").success();
    folder.run("render in.gif -o in.y4m --points 60").success();
    folder.run("render in.y4m -o once.html --points 60").success();
    // A click after 400 ms, the space bar after 700: what is seen then, in the browser's own time.
    let watch = "<script>
const log = {};
const note = name => {
  log[name] = { current, paused: zero === null };
};
setTimeout(() => note('playing'), 350);
setTimeout(() => {
  document.body.click();
  note('clicked');
}, 400);
setTimeout(() => note('paused'), 650);
setTimeout(() => {
  dispatchEvent(new KeyboardEvent('keydown', { key: ' ' }));
  note('pressed');
}, 700);
setTimeout(() => {
  if (zero !== null) tick(performance.now());
  note('last');
  document.body.append('LOG' + JSON.stringify({ gl: !!gl, plays, duration, count: frames.length, log }) + 'END');
}, 3000);
</script>";
    let run = |name: &str| -> serde_json::Value {
        let page = String::from_utf8(folder.read(name)).expect("text") + watch;
        folder.write("watched.html", page.as_bytes());
        let dom =
            browse(browser, &folder, "watched.html", &["--virtual-time-budget=6000", "--dump-dom"]);
        let log = dom.rsplit("LOG").next().and_then(|rest| rest.split("END").next());
        serde_json::from_str(log.expect("a log")).expect("JSON")
    };
    let forever = run("forever.html");
    assert_eq!((&forever["gl"], &forever["plays"]), (&true.into(), &0.into()), "{forever}");
    assert!((forever["duration"].as_f64().expect("a number") - 0.2).abs() < 1e-9);
    let log = &forever["log"];
    assert_eq!(log["playing"]["paused"], false, "{forever}");
    assert_eq!((&log["clicked"]["paused"], &log["paused"]["paused"]), (&true.into(), &true.into()));
    assert_eq!(log["clicked"]["current"], log["paused"]["current"], "{forever}");
    assert_eq!((&log["pressed"]["paused"], &log["last"]["paused"]), (&false.into(), &false.into()));
    let once = run("once.html");
    assert_eq!(
        (&once["plays"], &once["log"]["last"]["paused"]),
        (&1.into(), &true.into()),
        "{once}"
    );
    let last = once["count"].as_u64().expect("a number") - 1;
    assert_eq!(once["log"]["last"]["current"], last, "{once}");
}
