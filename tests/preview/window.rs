//! What the window shows, and what its keys do.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};

use polyreel::options::{Options, Points};

use crate::display::{Display, Shot};
use crate::given;
use crate::wait::until;

/// The colours of the program's letters and marks.
const HELP_KEYS: u32 = 0xff_c83c;
const SEEDS: u32 = 0xff_3030;
const SLIDER: u32 = 0xff_ffff;
const PLAYED: u32 = 0x6c_b6ff;
const TRACK: u32 = 0x3a_3a40;

const LEFT: u32 = 0xff51;
const ESCAPE: u32 = 0xff1b;
const F11: u32 = 0xffc8;

/// There is one keyboard: one test at a time.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The program; it ends with the test.
struct Running(Child);

impl Running {
    fn start(folder: &Path, args: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_polyreel"));
        let command = command.current_dir(folder).args(args).stderr(Stdio::inherit());
        Self(command.spawn().expect("the program starts"))
    }

    /// Its exit code.
    fn end(mut self) -> i32 {
        let status = until("the end", || self.0.try_wait().expect("a child"));
        status.code().expect("no signal ended it")
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The program with a GIF of a disc, `disc.gif` in `folder`, and its window when the first picture is there.
fn preview_disc(display: &Display, folder: &Path, frames: u32, more: &[&str]) -> (Running, u32) {
    given::gif(&folder.join("disc.gif"), frames);
    let running = Running::start(folder, &[&["preview", "disc.gif"], more].concat());
    let window = display.window("disc");
    display.shot_where(window, "a picture", is_lit);
    (running, window)
}

fn is_lit(shot: &Shot) -> bool {
    shot.picture().iter().filter(|&&pixel| pixel != 0).count() > shot.picture().len() / 2
}

/// The window when its picture no longer moves.
fn still(display: &Display, window: u32) -> Shot {
    until("it stands still", || {
        let shot = display.shot(window)?;
        std::thread::sleep(std::time::Duration::from_millis(300));
        display.shot(window).filter(|later| later.picture() == shot.picture())
    })
}

fn names(folder: &Path, part: &str) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut names: Vec<_> = names.filter(|name| name.contains(part)).collect();
    names.sort();
    names
}

#[test]
fn keys_change_what_the_window_shows() {
    let Some(display) = Display::open() else { return };
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (running, window) = preview_disc(&display, folder.path(), 25, &[]);
    let first = display.shot_where(window, "a picture", is_lit);
    display.shot_where(window, "it moves", |shot| shot.picture() != first.picture());

    for (key, colour, least) in [('h', HELP_KEYS, 200), ('g', SEEDS, 50), ('s', SLIDER, 400)] {
        display.press(key.into());
        display.shot_where(window, "it is shown", |shot| shot.count(colour) >= least);
        display.press(key.into());
        display.shot_where(window, "it is gone", |shot| shot.count(colour) < least / 2);
    }

    display.press(' '.into());
    let rest = still(&display, window);
    // Every change of the look is seen on the frame that stands still.
    let mut before = rest;
    let keys = "n b o l 2 - = [ ] ; , o d i v y u a 0 t t m m .";
    for key in keys.chars().filter(|key| *key != ' ') {
        display.press(key.into());
        let what = format!("a change by {key}");
        before = display.shot_where(window, &what, |shot| shot.pixels != before.pixels);
    }
    display.press(LEFT);
    display.shot_where(window, "a jump", |shot| shot.picture() != before.picture());
    display.press(ESCAPE);
    assert_eq!(running.end(), 0);
}

#[test]
fn keys_write_files_and_never_replace_one() {
    let Some(display) = Display::open() else { return };
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let (running, window) = preview_disc(&display, folder, 25, &["--points", "90"]);

    display.press(' '.into());
    for count in 1..=2 {
        display.press('p'.into());
        until("a picture is saved", || (names(folder, ".png").len() == count).then_some(()));
    }
    for name in names(folder, ".png") {
        // It is there as soon as its name is.
        let picture = image::open(folder.join(name)).expect("a picture");
        assert_eq!((picture.width(), picture.height()), given::SIZE);
    }
    display.press('w'.into());
    let read = || {
        let text = fs::read_to_string(folder.join("disc-preset.toml")).ok()?;
        toml::from_str::<Options>(&text).ok().filter(|options| options.points == Points::Count(90))
    };
    until("a preset with what was asked for", read);

    let before = names(folder, "").len();
    display.press(' '.into());
    display.press('r'.into());
    // A slow machine may see both presses of `r` at once, and nothing would be recorded.
    until("the recording begins", || (names(folder, "").len() > before).then_some(()));
    for _ in 0..3 {
        let moving = display.shot_where(window, "a picture", is_lit);
        display.shot_where(window, "it goes on", |shot| shot.picture() != moving.picture());
    }
    display.press('r'.into());
    let recorded = until("a recording", || names(folder, "disc-recording").pop());
    display.press('q'.into());
    assert_eq!(running.end(), 0);
    assert!(fs::metadata(folder.join(recorded)).expect("a file").len() > 100);
    assert_eq!(names(folder, "").len(), 5, "{:?}", names(folder, ""));
}

#[test]
fn the_mouse_zooms_and_jumps() {
    let Some(display) = Display::open() else { return };
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a temporary folder");
    // A budget that nothing exceeds: on a busy machine a pause would be followed by a picture of more detail.
    let (running, window) = preview_disc(&display, folder.path(), 50, &["--budget", "10s"]);
    display.press(' '.into());
    let rest = still(&display, window);
    display.resize(window, 800, 600);
    display.shot_where(window, "the whole", |shot| shot.width == 800 && is_lit(shot));
    let whole = still(&display, window);
    display.point(window, (400, 200));
    for _ in 0..4 {
        display.button(4, true);
        display.button(4, false);
    }
    let zoomed = display.shot_where(window, "a part", |shot| shot.picture() != whole.picture());
    display.button(1, true);
    let mut places = [(300, 150), (340, 190)].into_iter().cycle();
    until("another part", || {
        display.point(window, places.next()?);
        display.shot(window).filter(|shot| shot.picture() != zoomed.picture())
    });
    display.button(1, false);
    display.press('z'.into());
    display.shot_where(window, "the whole again", |shot| shot.picture() == whole.picture());
    // Near the end of the timeline, which is in the middle of the second line.
    let played = |shot: &Shot| shot.count(PLAYED);
    let before = played(&whole);
    let y = (0..whole.height).rfind(|y| {
        whole.pixels[y * whole.width..][..whole.width].iter().filter(|&&p| p == TRACK).count() > 50
    });
    display.point(window, (600, y.expect("a timeline") as i16));
    display.button(1, true);
    display.shot_where(window, "a jump", |shot| {
        played(shot) > before + 200 && shot.picture() != rest.picture()
    });
    display.button(1, false);
    display.press('q'.into());
    assert_eq!(running.end(), 0);
}

#[test]
fn an_export_is_a_render_with_the_look_of_the_window() {
    let Some(display) = Display::open() else { return };
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    let (running, _) = preview_disc(&display, folder, 25, &["--points", "90"]);
    display.press('d'.into());
    display.press('x'.into());
    until("an export", || folder.join("disc-lowpoly.gif").exists().then_some(()));
    display.press('q'.into());
    assert_eq!(running.end(), 0);
    let line = ["render", "disc.gif", "-o", "same.gif", "--points", "90", "--seed", "1"];
    assert_eq!(Running::start(folder, &line).end(), 0);
    let read = |name: &str| fs::read(folder.join(name)).expect("a file");
    assert!(read("disc-lowpoly.gif") == read("same.gif"), "it has the bytes of a render");
}

#[test]
fn a_resized_window_keeps_the_proportion() {
    let Some(display) = Display::open() else { return };
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a temporary folder");
    given::picture(0).save(folder.path().join("still.png")).expect("a writable folder");
    let running = Running::start(folder.path(), &["preview", "still.png"]);
    let window = display.window("still");
    display.shot_where(window, "a picture", is_lit);
    // Without the bar there is nothing but the picture.
    display.press('m'.into());
    for (width, height) in [(900, 300), (300, 700), (1000, 760)] {
        display.resize(window, width, height);
        let (width, height) = (width as usize, height as usize);
        display.shot_where(window, "the picture in its new size", |shot| {
            let lit: Vec<_> = (0..shot.pixels.len())
                .filter(|&i| shot.pixels[i] != 0)
                .map(|i| (i % shot.width, i / shot.width))
                .collect();
            let extent = |of: fn(&(usize, usize)) -> usize| {
                let (least, most) = (lit.iter().map(of).min(), lit.iter().map(of).max());
                Some(most? + 1 - least?)
            };
            let (Some(across), Some(down)) = (extent(|p| p.0), extent(|p| p.1)) else {
                return false;
            };
            let ratio = across as f64 / down as f64;
            (shot.width, shot.height) == (width, height)
                && (ratio - 1.5).abs() < 0.02
                && (across > width * 9 / 10 || down > height / 2)
        });
    }
    display.close(window);
    assert_eq!(running.end(), 0);
}

#[test]
fn the_window_fills_the_screen_and_escape_ends_that() {
    let Some(display) = Display::open() else { return };
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (running, window) = preview_disc(&display, folder.path(), 5, &[]);
    let size = |shot: &Shot| (shot.width, shot.height);
    let before = size(&display.shot(window).expect("a picture"));
    for key in [F11, 'f'.into()] {
        display.press(key);
        display.shot_where(window, "it fills the screen", |shot| {
            size(shot) == display.size() && is_lit(shot)
        });
        display.press(ESCAPE);
        display.shot_where(window, "it is as before", |shot| size(shot) == before && is_lit(shot));
    }
    display.press(ESCAPE);
    assert_eq!(running.end(), 0, "Esc quits");
}

#[test]
fn closing_the_window_of_a_render_finishes_its_output() {
    let Some(display) = Display::open() else { return };
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    // Long enough that nobody sees its end.
    given::y4m(&folder.join("bar.y4m"), 4000);
    let running = Running::start(folder, &["render", "bar.y4m", "-o", "out.gif", "--preview"]);
    let window = display.window("bar");
    let first = display.shot_where(window, "a picture", is_lit);
    display.shot_where(window, "it goes on", |shot| shot.picture() != first.picture());
    display.close(window);
    assert_eq!(running.end(), 0);
    assert_eq!(names(folder, ""), ["bar.y4m", "out.gif"]);
    let file = std::io::BufReader::new(fs::File::open(folder.join("out.gif")).expect("a file"));
    let frames = image::AnimationDecoder::into_frames(
        image::codecs::gif::GifDecoder::new(file).expect("a GIF"),
    );
    let frames = frames.collect_frames().expect("a complete GIF").len();
    assert!((1..4000).contains(&frames), "{frames}");
}
