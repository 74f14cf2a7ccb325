//! `looks`: contact sheets.

use super::{Folder, stderr};

#[test]
fn a_sheet_shows_every_preset_and_is_the_same_again() {
    let folder = Folder::new();
    folder.still("in.png", 160, 120);
    folder.run("looks in.png -o sheet.png --tile 120").success();
    folder.run("looks in.png -o again.png --tile 120 --threads 1").success();
    assert!(folder.read("sheet.png") == folder.read("again.png"));
    let (width, height) = folder.open("sheet.png").dimensions();
    assert!(width >= 3 * 120 && height >= 2 * 90, "{width}x{height}");
    let said = stderr(&folder.run("looks in.png -o sheet.png").failure().code(1));
    assert!(said.contains("exists already"), "{said}");
}

#[test]
fn tiles_are_what_render_makes() {
    let folder = Folder::new();
    folder.still("in.png", 96, 64);
    folder.write("mine.toml", b"points = 40\noutline = \"red\"\n");
    folder
        .run("looks in.png -o sheet.png --presets mine.toml,bold --tile 96 --columns 3")
        .success();
    let sheet = folder.open("sheet.png");
    // The source, mine and bold, in their own size, between gaps of 6 pixels.
    assert_eq!(sheet.width(), 3 * 96 + 4 * 6);
    folder.run("render in.png -o mine.png --preset mine.toml").success();
    for (name, left) in [("in.png", 6), ("mine.png", 6 + 102)] {
        let tile = image::imageops::crop_imm(&sheet, left, 6, 96, 64).to_image();
        assert!(tile == folder.open(name), "{name}");
    }
    // Letters below it.
    let label = image::imageops::crop_imm(&sheet, 108, 71, 96, 18).to_image();
    assert!(label.pixels().any(|pixel| pixel.0[0] < 100), "no name");
}

#[test]
fn frames_of_a_clip_are_shown_by_their_times() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100; 5]);
    folder.run("looks in.gif -o one.png --presets bold --columns 1 --start 200ms").success();
    folder.run("looks in.gif -o two.png --presets bold --columns 1 --start 0,200ms").success();
    let (one, two) = (folder.open("one.png"), folder.open("two.png"));
    assert!(two.width() > one.width() * 3 / 2 && two.height() == one.height());
    let said = stderr(&folder.run("looks in.gif -o no.png --start 9").failure().code(2));
    assert!(said.contains("no frame"), "{said}");
}

#[test]
fn bad_requests_are_refused_clearly() {
    let folder = Folder::new();
    folder.still("in.png", 48, 32);
    folder.write("bad.png", b"no picture");
    folder.write("bad.toml", b"pionts = 3\n");
    for (line, code, word) in [
        ("looks in.png -o sheet.mp4", 2, "sheet.png"),
        ("looks in.png -o sheet.svg", 2, "sheet.png"),
        ("looks in.png -o sheet.png --presets crytal", 2, "did you mean 'crystal'?"),
        ("looks in.png -o sheet.png --presets bad.toml", 1, "pionts"),
        ("looks bad.png -o sheet.png", 1, "bad.png"),
        ("looks none.png -o sheet.png", 1, "no such file"),
        ("looks in.png -o in.png -y", 1, "is the input"),
        ("looks in.png -o sheet.png --tile 3", 2, "--tile"),
    ] {
        let said = stderr(&folder.run(line).failure().code(code));
        assert!(said.contains(word), "{line}: {said}");
    }
    assert_eq!(folder.listing(), ["bad.png", "bad.toml", "in.png"]);
}

#[test]
fn studies_are_looks_too_and_misspelt_names_are_recognised() {
    let folder = Folder::new();
    folder.still("in.png", 60, 40);
    folder.gif("in.gif", &[40; 4]);
    folder.run("looks in.png -o some.png -q --study gai-2015,hslp").success();
    folder.run("looks in.png -o all.png -q --studies").success();
    folder.run("render in.gif -o out.gif -q --study ma-2017 --coherence 0.4").success();
    let wrong = super::stderr(&folder.run("render in.png -o a.png --study gai2015").code(2));
    assert!(wrong.contains("did you mean 'gai-2015'?"), "{wrong}");
    folder.run("render in.png -o a.png --study hrlp --preset paper").code(2);
    let text = super::stdout(&folder.run("presets ma-2017").success());
    assert!(text.contains("thinning") && text.contains("saliency"), "{text}");
    folder.run("render in.png -o study.png -q --study hrlp").success();
    folder.run("render in.png -o paper.png -q --preset paper").success();
    assert!(folder.read("study.png") == folder.read("paper.png"));
}
