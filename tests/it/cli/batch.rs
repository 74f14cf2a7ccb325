//! Batches: each input by itself, to a folder.

use super::{Folder, picture, stderr};

/// A folder with pictures of three sizes and formats.
fn pictures() -> Folder {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("in")).expect("a new folder");
    folder.still("in/wide.jpg", 64, 32);
    folder.still("in/tall.png", 32, 64);
    folder.still("in/small.bmp", 24, 24);
    folder
}

fn outputs(folder: &Folder) -> Vec<String> {
    folder.listing().into_iter().filter(|name| name.starts_with("out/")).collect()
}

#[test]
fn pictures_of_several_sizes_keep_their_names_and_bytes() {
    let folder = pictures();
    // The folder needs no slash, nor to be there.
    for output in ["out/", "out"] {
        let said = stderr(&folder.run(&format!("render in -o {output}")).success());
        assert!(said.contains("3 of 3 inputs"), "{said}");
        assert_eq!(outputs(&folder), ["out/small.png", "out/tall.png", "out/wide.png"]);
        folder.run("render in/wide.jpg -o alone.png -y").success();
        assert!(folder.read("out/wide.png") == folder.read("alone.png"));
        std::fs::remove_dir_all(folder.path("out")).expect("it is there");
    }
    folder.run("render in/wide.jpg in/tall.png -o out --format jpg").success();
    assert_eq!(outputs(&folder), ["out/tall.jpg", "out/wide.jpg"]);
    folder.run("render in -o out.gif").failure().code(1);
}

#[test]
fn pictures_of_one_size_are_a_sequence_unless_a_batch_is_asked_for() {
    let folder = Folder::new();
    folder.sequence("in", 2);
    folder.run("render in -o out/").success();
    assert_eq!(outputs(&folder), ["out/0001.png", "out/0002.png"]);
    folder.run("render in -o out/ --batch").success();
    assert_eq!(outputs(&folder), ["out/0001.png", "out/0002.png", "out/f0.png", "out/f1.png"]);
    folder.run("render in/f0.png -o alone.png").success();
    assert!(folder.read("out/f0.png") == folder.read("alone.png"));
}

#[test]
fn a_bad_file_is_reported_and_the_others_are_done() {
    let folder = pictures();
    folder.write("in/bad.png", b"no picture");
    let said = stderr(&folder.run("render in -o out/").failure().code(1));
    assert!(said.contains("bad.png") && said.contains("passed over"), "{said}");
    assert!(said.contains("1 of 4 inputs in all"), "{said}");
    assert_eq!(outputs(&folder), ["out/small.png", "out/tall.png", "out/wide.png"]);
    // What is there already is not replaced.
    let said = stderr(&folder.run("render in/tall.png -o out/ --batch").failure().code(1));
    assert!(said.contains("exists already"), "{said}");
    folder.run("render in/tall.png -o out/ --batch -y").success();
}

#[test]
fn nothing_is_left_where_all_inputs_are_bad() {
    let folder = Folder::new();
    folder.write("bad.png", b"no picture");
    folder.run("render bad.png none.png -o out/ --batch").failure().code(1);
    assert_eq!(folder.listing(), ["bad.png"]);
}

#[test]
fn names_that_clash_are_numbered_and_said() {
    let folder = pictures();
    folder.still("in/wide.png", 40, 20);
    let said = stderr(&folder.run("render in -o out/").success());
    assert!(said.contains("wide.png is written as wide-2"), "{said}");
    let expected = ["out/small.png", "out/tall.png", "out/wide-2.png", "out/wide.png"];
    assert_eq!(outputs(&folder), expected);
    assert_eq!(folder.open("out/wide.png").dimensions(), (64, 32));
    assert_eq!(folder.open("out/wide-2.png").dimensions(), (40, 20));
}

#[test]
fn animations_of_a_batch_stay_animations() {
    let folder = pictures();
    folder.gif("in/dance.gif", &[50, 70]);
    folder.run("render in -o out/").success();
    assert!(outputs(&folder).contains(&"out/dance.gif".to_owned()), "{:?}", outputs(&folder));
    assert_eq!(folder.delays("out/dance.gif"), [50, 70]);
    // Of one size, too: no sequence has an animation in it.
    folder.still("same.png", 48, 32);
    folder.run("render same.png in/dance.gif -o both").success();
    assert!(folder.listing().contains(&"both/same.png".to_owned()), "{:?}", folder.listing());
}

#[test]
fn what_a_batch_cannot_be_is_refused_before_any_work() {
    let folder = pictures();
    for (line, word) in [
        ("render in -o out.png --batch", "-o out/"),
        ("render in -o out/ --batch --format xyz", "--format xyz"),
        ("render - -o out/ --batch", "name files"),
        ("render in -o in/tall.png/ --batch", "tall.png"),
        ("render in -o out/ --batch --report r.json", "--report"),
        ("render in -o out/ --batch --saturation 9", "saturation"),
    ] {
        let said = stderr(&folder.run(line).failure().code(2));
        assert!(said.contains(word), "{line}: {said}");
        assert_eq!(outputs(&folder), [""; 0], "{line}");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_whole_pictures_only() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("in")).expect("a new folder");
    let first = folder.path("in/0.png");
    picture(400, 400, 0).save(&first).expect("a writable folder");
    for n in 1..200 {
        std::fs::hard_link(&first, folder.path(&format!("in/{n}.png"))).expect("a link");
    }
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_polyreel"))
        .args(["render", "in", "-o", "out", "--batch"])
        .current_dir(folder.path(""))
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("the program");
    crate::wait::until("the first picture", || (!outputs(&folder).is_empty()).then_some(()));
    let pid = child.id().to_string();
    let sent = std::process::Command::new("kill").args(["-INT", &pid]).status();
    assert!(sent.expect("kill is there").success());
    assert_eq!(child.wait().expect("its end").code(), Some(130));
    let left = outputs(&folder);
    assert!((1..200).contains(&left.len()), "{}", left.len());
    for name in left {
        assert_eq!(folder.open(&name).dimensions(), (400, 400), "{name}");
    }
}
