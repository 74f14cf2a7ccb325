//! Outputs that hold facets rather than pixels.

use super::{Folder, stderr};

fn text(folder: &Folder, name: &str) -> String {
    String::from_utf8(folder.read(name)).expect("text")
}

#[test]
fn a_still_becomes_an_svg() {
    let folder = Folder::new();
    folder.still("in.png", 96, 64);
    folder.run("render in.png -o out.svg --points 60 --outline=white --outline-width 2").success();
    let svg = text(&folder, "out.svg");
    assert!(
        svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"96\" height=\"64\"")
    );
    assert!(svg.contains("<title>in</title>") && svg.contains("<g id=\"facets\">"), "{svg}");
    assert!(svg.contains("<g id=\"outline\" fill=\"none\" stroke=\"#ffffff\""), "{svg}");
    folder.run("render in.png -o plain.svg --points 60 --svg-seams none").success();
    folder.run("render in.png -o stroke.svg --points 60 --svg-seams stroke").success();
    assert!(text(&folder, "stroke.svg").contains("stroke-linejoin=\"round\""));
    assert!(text(&folder, "plain.svg").len() < svg.len());
}

#[test]
fn frames_become_numbered_svgs_and_svgs_in_a_folder() {
    let folder = Folder::new();
    folder.sequence("in", 3);
    folder.run("render in -o out_%02d.svg --points 40").success();
    folder.run("render in -o out/ --format svg --points 40").success();
    for number in ["01", "02", "03"] {
        let there = folder.read(&format!("out/00{number}.svg"));
        assert_eq!(folder.read(&format!("out_{number}.svg")), there);
    }
    let bad = folder.run("render in -o other/ --format mp4").failure().code(2);
    assert!(stderr(&bad).contains(".svg"), "{}", stderr(&bad));
}

#[test]
fn an_animated_svg_plays_by_itself_and_has_a_limit() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100, 40, 60]);
    folder.run("render in.gif -o out.svg --points 40").success();
    let svg = text(&folder, "out.svg");
    assert_eq!(svg.matches("<animate attributeName=\"display\"").count(), 3, "{svg}");
    assert!(svg.contains("dur=\"0.2s\"") && svg.contains("keyTimes=\"0;0.5;0.7\""), "{svg}");
    assert!(svg.contains("repeatCount=\"indefinite\"") && !svg.contains("<script"), "{svg}");
}
