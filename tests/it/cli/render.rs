//! What `render` writes.

use super::{Folder, stderr, stdout};

#[test]
fn a_still_becomes_a_still_of_every_format() {
    let folder = Folder::new();
    folder.still("in.png", 96, 64);
    for output in ["out.png", "out.jpg", "out.webp", "out.bmp", "out.tiff"] {
        let done = folder.run(&format!("render in.png -o {output}")).success();
        assert_eq!(stdout(&done), "", "standard output is for frames");
        assert!(stderr(&done).contains("1 frame of 96x64"), "{}", stderr(&done));
        let (picture, source) = (folder.open(output), folder.open("in.png"));
        assert_eq!(picture.dimensions(), (96, 64));
        assert_ne!(picture, source);
    }
    assert_eq!(
        folder.listing(),
        ["in.png", "out.bmp", "out.jpg", "out.png", "out.tiff", "out.webp"]
    );
}

#[test]
fn sequences_and_gifs_become_each_other() {
    let folder = Folder::new();
    folder.sequence("in", 4);
    folder.run("render in -o a.gif --fps 10").success();
    assert_eq!(folder.delays("a.gif"), [100; 4]);
    folder.run("render a.gif -o frame_%02d.png").success();
    folder.run("render frame_%02d.png -o b/").success();
    folder.run_args(&["render", "in/f*.png", "-o", "c.gif"]).success();
    folder.run("render in/f0.png in/f1.png -o d.gif").success();
    assert_eq!(folder.delays("c.gif").len(), 4);
    assert_eq!(folder.delays("d.gif").len(), 2);
    for name in ["frame_01.png", "frame_04.png", "b/0001.png", "b/0004.png"] {
        assert_eq!(folder.open(name).dimensions(), (48, 32));
    }
    assert!(!folder.path("b/0005.png").exists());
}

#[test]
fn delays_of_a_gif_come_through() {
    let folder = Folder::new();
    let delays = [100, 40, 200, 70];
    folder.gif("in.gif", &delays);
    folder.run("render in.gif -o out.gif").success();
    assert_eq!(folder.delays("out.gif"), delays);
    folder.run("render in.gif -o part.gif --frames 2").success();
    assert_eq!(folder.delays("part.gif"), delays[..2]);
    folder.run("render in.gif -o late.gif --start 140ms").success();
    assert_eq!(folder.delays("late.gif"), delays[2..]);
}

#[test]
fn edges_are_smooth_but_where_hard_ones_are_asked_for_and_in_gifs() {
    let folder = Folder::new();
    folder.still("in.png", 60, 40);
    let colours = |name: &str| {
        let picture = folder.open(name);
        picture.pixels().map(|pixel| pixel.0).collect::<std::collections::BTreeSet<_>>()
    };
    folder.run("render in.png -o smooth.png --points 30").success();
    folder.run("render in.png -o hard.png --points 30 --edges hard").success();
    folder.run("render in.png -o paper.png --points 30 --preset paper").success();
    // So few that each has its place in the palette.
    folder.run("render in.png -o out.gif --points 30 --edges smooth").success();
    let most = 2 * (30 + 4);
    for name in ["hard.png", "paper.png", "out.gif"] {
        assert!(colours(name).len() <= most, "{name} has others than its triangles' colours");
    }
    assert_eq!(colours("out.gif"), colours("hard.png"));
    assert!(colours("smooth.png").len() > 2 * most);
}

#[test]
fn a_still_to_a_gif_is_one_frame() {
    let folder = Folder::new();
    folder.still("in.png", 40, 30);
    folder.run("render in.png -o out.gif").success();
    assert_eq!(folder.delays("out.gif").len(), 1);
}

#[test]
fn the_bytes_depend_on_options_and_not_on_threads() {
    let folder = Folder::new();
    folder.gif("in.gif", &[50; 6]);
    folder.run("render in.gif -o auto.gif").success();
    let expected = folder.read("auto.gif");
    for threads in [1, 2, 8] {
        folder.run(&format!("render in.gif -o out.gif -y --threads {threads}")).success();
        assert!(folder.read("out.gif") == expected, "{threads} threads give other bytes");
    }
    for options in ["--seed 1", "--points 3%", "--clusters 3", "--outline", "--max-points 2"] {
        folder.run(&format!("render in.gif -o out.gif -y {options}")).success();
        assert!(folder.read("out.gif") != expected, "{options} changes nothing");
    }
}

#[test]
fn an_outline_has_the_colour_that_was_asked_for() {
    let folder = Folder::new();
    folder.still("in.png", 64, 48);
    let count = |option: &str, colour: [u8; 4]| {
        folder.run(&format!("render in.png -o out.png -y {option}")).success();
        folder.open("out.png").pixels().filter(|pixel| pixel.0 == colour).count()
    };
    assert_eq!(count("", [0, 0, 0, 255]), 0);
    assert!(count("--outline --outline-width 3", [0, 0, 0, 255]) > 60);
    assert!(count("--outline=#12ab34 --outline-width 5%", [0x12, 0xab, 0x34, 255]) > 60);
}

#[test]
fn points_are_never_exceeded() {
    let folder = Folder::new();
    folder.still("in.png", 160, 120);
    for (points, most) in [("200", 200), ("2%", 384)] {
        folder
            .run(&format!("render in.png -o o.png -y --report r.json --points {points}"))
            .success();
        let seeds = folder.json("r.json")["per_frame"][0]["seeds"].as_u64().expect("a count");
        assert!(seeds <= most && seeds >= most * 98 / 100, "{seeds} for {points}");
    }
}

#[test]
fn frames_are_shrunk_on_request() {
    let folder = Folder::new();
    folder.still("in.png", 160, 120);
    folder.run("render in.png -o out.png --max-size 80").success();
    assert_eq!(folder.open("out.png").dimensions(), (80, 60));
}

#[test]
fn transparency_is_kept_or_flattened() {
    let folder = Folder::new();
    let clear = image::RgbaImage::from_pixel(20, 20, image::Rgba([9, 9, 9, 0]));
    clear.save(folder.path("in.png")).expect("a writable folder");
    folder.run("render in.png -o out.png").success();
    assert!(folder.open("out.png").pixels().all(|pixel| pixel.0[3] == 0));
    folder.run("render in.png -o out.jpg --background #ff0000").success();
    let [r, g, b, _] = folder.open("out.jpg").get_pixel(10, 10).0;
    assert!(r > 245 && g < 10 && b < 10, "{r} {g} {b}");
}

#[test]
fn outputs_are_replaced_only_on_request() {
    let folder = Folder::new();
    folder.still("in.png", 40, 30);
    folder.write("out.png", b"precious");
    let refused = folder.run("render in.png -o out.png").failure().code(1);
    assert!(stderr(&refused).contains("-y"), "{}", stderr(&refused));
    assert_eq!(folder.read("out.png"), b"precious");
    folder.run("render in.png -o out.png -y").success();
    assert_eq!(folder.open("out.png").dimensions(), (40, 30));
}

#[cfg(unix)]
#[test]
fn names_that_are_not_utf8_are_read_and_written() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = Folder::new();
    folder.sequence("in", 2);
    let name = |bytes: &'static [u8]| folder.path("").join(OsStr::from_bytes(bytes));
    std::fs::rename(folder.path("in/f0.png"), name(b"caf\xe9_1.png")).expect("a new name");
    std::fs::rename(folder.path("in/f1.png"), name(b"caf\xe9_2.png")).expect("a new name");
    let render = |input: &'static [u8], output: &'static [u8]| {
        let names = ["render".into(), name(input), "-o".into(), name(output)];
        assert_cmd::Command::new(env!("CARGO_BIN_EXE_polyreel")).args(names).assert().success();
        assert!(name(output).exists() || output.contains(&b'%'), "{}", output.escape_ascii());
    };
    render(b"caf\xe9_1.png", b"\xe9.png");
    render(b"caf\xe9_%d.png", b"\xe9.gif");
    render(b"caf\xe9_%d.png", b"\xe8_%02d.png");
    assert!(name(b"\xe8_02.png").exists());
}

#[test]
fn a_percent_sign_before_a_word_is_part_of_the_name() {
    let folder = Folder::new();
    folder.still("in.png", 40, 30);
    folder.run("render in.png -o 100%done.png").success();
    folder.run("render in.png -o 100%.png").success();
    assert_eq!(folder.listing(), ["100%.png", "100%done.png", "in.png"]);
}
