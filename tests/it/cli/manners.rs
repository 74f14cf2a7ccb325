//! How the program meets its user: short help, advice for mistakes, what is understood though it is not by the book.

use super::{Folder, stderr, stdout};

/// What a wrong `line` is answered with.
fn answer(folder: &Folder, line: &str) -> String {
    stderr(&folder.run(line).failure().code(2))
}

#[test]
fn short_help_is_one_page_and_the_papers_parameters_come_last() {
    let folder = Folder::new();
    for command in ["render", "preview", "inspect", "evaluate"] {
        let short = stdout(&folder.run(&format!("{command} -h")).success());
        assert!(short.lines().count() <= 60, "{command}: {} lines", short.lines().count());
        for option in ["--points", "--preset", "--quality", "--outline"] {
            assert!(short.contains(option), "{command} {option}");
        }
        assert!(!short.contains("--clusters"), "{command}");
        let long = stdout(&folder.run(&format!("{command} --help")).success());
        let paper = long.find("The paper's parameters:").expect("their heading");
        for before in ["--points", "--preset", "--outline"] {
            assert!(long.find(before).is_some_and(|at| at < paper), "{command} {before}");
        }
        for option in ["--clusters", "--diffusion-gamma"] {
            assert!(long[paper..].contains(option), "{command} {option}");
        }
        assert!(!long[paper..].contains("      --max-size"), "{command}");
    }
}

#[test]
fn the_outline_takes_its_colour_as_a_word_of_its_own() {
    let folder = Folder::new();
    folder.still("in.png", 48, 32);
    folder.run("render --outline white in.png -o word.png").success();
    folder.run("render in.png -o equals.png --outline=white").success();
    assert!(folder.read("word.png") == folder.read("equals.png"));
    folder.run("render in.png -o black.png --outline").success();
    folder.run("render in.png -o gold.png --outline gold").success();
    let said = answer(&folder, "render in.png -o no.png --outline blurple");
    assert!(said.contains("'blurple' is not a colour") && said.contains("yellow"), "{said}");
}

#[test]
fn width_or_contrast_of_an_outline_draw_it() {
    let folder = Folder::new();
    folder.still("in.png", 64, 48);
    folder.run("render in.png -o plain.png --points 60").success();
    for option in ["--outline-width 2", "--outline-contrast 4"] {
        folder.run(&format!("render in.png -o alone.png -y --points 60 {option}")).success();
        folder
            .run(&format!("render in.png -o both.png -y --points 60 --outline {option}"))
            .success();
        assert!(folder.read("alone.png") == folder.read("both.png"), "{option}");
        assert!(folder.read("alone.png") != folder.read("plain.png"), "{option}");
    }
    // A preset's own outline stays.
    folder.run("render in.png -o a.png --preset crystal --outline-width 2").success();
    folder
        .run("render in.png -o b.png --preset crystal --outline-width 2 --outline=white")
        .success();
    assert!(folder.read("a.png") == folder.read("b.png"));
}

#[test]
fn more_points_than_make_sense_give_a_warning() {
    let folder = Folder::new();
    folder.still("in.png", 48, 32);
    for points in ["385", "50%"] {
        let said = stderr(
            &folder.run(&format!("render in.png -o out.png -y --points {points}")).success(),
        );
        assert!(
            said.contains(&format!("--points {points} is more than one for 4 pixels")),
            "{said}"
        );
    }
    let said = stderr(&folder.run("render in.png -o out.png -y --points 384").success());
    assert!(!said.contains("warning"), "{said}");
}

#[test]
fn negative_numbers_are_refused_by_the_name_of_their_option() {
    let folder = Folder::new();
    for (option, name) in
        [("--points -500", "--points"), ("--seed -1", "--seed"), ("--frames -2", "--frames")]
    {
        let said = answer(&folder, &format!("render in.png -o out.png {option}"));
        assert!(said.contains(&format!("{name} takes no negative number")), "{said}");
        assert!(!said.contains("-- -"), "{said}");
    }
    let said = answer(&folder, "render in.png -o out.png --saturation -1");
    assert!(said.contains("saturation is -1; it can be 0 to 4"), "{said}");
    let said = answer(&folder, "render in.png -o out.png --points -5%");
    assert!(said.contains("no negative numbers") && !said.contains("-- -"), "{said}");
}

#[test]
fn misspelt_words_get_a_suggestion() {
    let folder = Folder::new();
    for (line, meant) in [
        ("render in.png -o o.png --preset stainedglass", "did you mean 'stained-glass'?"),
        ("render in.png -o o.png --preset Crystal", "did you mean 'crystal'?"),
        ("presets crytal", "did you mean 'crystal'?"),
        ("render in.png -o o.png --quality high", "a similar value exists: 'best'"),
        ("render in.png -o o.png --quality Nromal", "a similar value exists: 'normal'"),
        ("render in.png -o o.png --width 3", "--outline-width"),
        ("render in.png -o o.png --outlne", "--outline"),
        ("render in.png -o o.png -points 3", "--points"),
        ("rendr in.png -o o.png", "render"),
    ] {
        let said = answer(&folder, line);
        assert!(said.contains(meant), "{line}: {said}");
    }
    // No wild guesses.
    for line in ["render in.png -o o.png --mask m.png", "render in.png -o o.png --verbosity"] {
        let said = answer(&folder, line);
        assert!(!said.contains("--max-size") && !said.contains("-- --"), "{line}: {said}");
    }
    let said = answer(&folder, "render in.png -o o.png --preset watercolour");
    assert!(!said.contains("did you mean") && said.contains("bold"), "{said}");
}

#[test]
fn a_file_in_place_of_a_command_suggests_the_command() {
    let folder = Folder::new();
    for (line, meant) in [
        ("picture.png", "polyreel render picture.png -o picture-lowpoly.png"),
        ("a/dance.gif --points 90", "polyreel render a/dance.gif --points 90 -o dance-lowpoly.gif"),
        ("clip.mp4", "polyreel render clip.mp4 -o clip-lowpoly.mp4"),
        ("in.jpg -o out.png", "polyreel render in.jpg -o out.png"),
        ("-o out.png in.jpg", "polyreel render -o out.png in.jpg"),
        ("shots/*.png", "polyreel render 'shots/*.png' -o out/"),
    ] {
        let said = answer(&folder, line);
        assert!(said.contains(meant), "{line}: {said}");
    }
}

#[test]
fn smooth_edges_on_a_gif_are_said_to_be_hard() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100; 2]);
    let said = stderr(&folder.run("render in.gif -o a.gif --edges smooth").success());
    assert!(said.contains("--edges smooth has no effect on a GIF"), "{said}");
    let said = stderr(&folder.run("render in.gif -o b.gif").success());
    assert!(!said.contains("warning"), "{said}");
}

#[test]
fn a_name_without_an_ending_says_what_to_write() {
    let folder = Folder::new();
    folder.sequence("in", 2);
    let said = answer(&folder, "render in -o outstills");
    assert!(said.contains("outstills/") && said.contains("outstills.gif"), "{said}");
}

#[test]
fn presets_are_listed_and_completed() {
    let folder = Folder::new();
    let list = stdout(&folder.run("presets list").success());
    assert_eq!(list, stdout(&folder.run("presets").success()));
    for shell in ["bash", "zsh", "fish"] {
        let script = stdout(&folder.run(&format!("completions {shell}")).success());
        assert!(script.contains("stained-glass"), "{shell}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn long_steps_say_that_they_go_on() {
    let folder = Folder::new();
    folder.still("in.png", 160, 120);
    let program = env!("CARGO_BIN_EXE_polyreel");
    for (line, words) in [
        ("render in.png -o out.png --points auto --error psnr:40", "finding the fewest points"),
        ("render in.png -o out2.png", "rendering the first frame"),
        ("inspect in.png -o stages", "finding feature points"),
        ("looks in.png -o sheet.png --presets bold", "looks"),
        ("render in.png -o out --batch", "in.png"),
    ] {
        let Some(said) = on_terminal(&folder, &format!("{program} {line}")) else { return };
        assert!(said.contains(words), "{line}: {said}");
    }
}

/// What the program shows on a terminal. `None` on a machine without `script` of util-linux.
#[cfg(target_os = "linux")]
fn on_terminal(folder: &Folder, line: &str) -> Option<String> {
    let ran = std::process::Command::new("script")
        .args(["-qec", line, "/dev/null"])
        .current_dir(folder.path(""))
        .stdin(std::process::Stdio::null())
        .output();
    Some(String::from_utf8_lossy(&ran.ok()?.stdout).into_owned())
}
