//! `polyreel evaluate`: its formats, its page, and what it does with broken files.

use super::{Folder, stderr, stdout};

const FAST: &str = "--methods hrlp,rlp --points 60";

#[test]
fn all_formats_hold_the_same_figures() {
    let folder = Folder::new();
    folder.still("a.png", 90, 60);
    folder.still("b, c.png", 60, 70);
    let line = [
        "evaluate",
        "a.png",
        "b, c.png",
        "--points",
        "60",
        "--json=r.json",
        "--csv=r.csv",
        "--markdown=r.md",
        "--html",
        "r.html",
    ];
    let run = folder.run_args(&line).success();
    let text = stdout(&run);
    assert!(text.contains("Table 1") && text.lines().count() < 20, "{text}");
    let markdown = String::from_utf8(folder.read("r.md")).expect("text");
    for title in ["Table 1", "Table 2", "Table 3", "Table 4", "Robustness", "Refinement, means"] {
        assert!(markdown.contains(title), "{title} in {markdown}");
    }
    let json = folder.json("r.json");
    let stills = json["evaluation"]["stills"].as_array().expect("a list");
    assert_eq!(stills.len(), 2);
    for still in stills {
        let methods = still["methods"].as_array().expect("a list");
        let names: Vec<_> = methods.iter().filter_map(|m| m["method"].as_str()).collect();
        assert_eq!(names, ["hrlp", "help", "hslp", "rlp", "entropy", "pic2polyart"]);
        for method in methods {
            assert_eq!(method["seeds"], 60, "{method}");
            assert!(method["likeness"]["ssim"].as_f64() > Some(0.0));
            assert!(method["mesh_bytes"].as_u64() > Some(60));
            assert_eq!(method["robustness"].as_array().map(Vec::len), Some(4));
            assert_eq!(method["refine_steps"], 0, "the paper's tables are without refinement");
        }
        let refined = still["refined"].as_array().expect("a list");
        assert_eq!(refined.len(), methods.len());
        for (before, after) in methods.iter().zip(refined) {
            for same in ["method", "candidates", "seeds", "triangles"] {
                assert_eq!(before[same], after[same]);
            }
            let mse = |scores: &serde_json::Value| scores["likeness"]["mse"].as_f64();
            assert!(mse(after) < mse(before), "{after}");
            assert!(after["refine_steps"].as_u64() > Some(0));
        }
    }
    let csv = String::from_utf8(folder.read("r.csv")).expect("text");
    let lines: Vec<_> = csv.lines().collect();
    assert_eq!(lines.len(), 1 + 2 * 2 * 6);
    assert!(lines[13].starts_with("\"b, c.png\",still,hrlp,60,70,1,"), "{}", lines[13]);
    assert!(lines[13].ends_with(",false,0") && lines[19].contains(",true,"), "{csv}");
    let commas = |line: &str| line.matches(',').count();
    assert!(lines[..13].iter().all(|line| commas(line) == commas(lines[0])), "{csv}");
    assert!(markdown.contains("| picture | method |"));

    let page = String::from_utf8(folder.read("r.html")).expect("text");
    assert_eq!(page.matches("data:image/jpeg;base64,").count(), 2 * 13);
    assert!(page.matches("<svg").count() >= 2 && page.ends_with("</html>\n"));
    for outside in ["http:", "https:", "url(", "<script src", "@import", "<link"] {
        assert!(!page.contains(outside), "{outside}");
    }
}

#[test]
fn a_broken_file_is_passed_over_and_told() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("in")).expect("a new folder");
    folder.still("in/a.png", 60, 50);
    folder.write("in/broken.png", b"\x89PNG\r\n\x1a\nnothing");
    let run = folder.run(&format!("evaluate in {FAST} --json r.json")).failure().code(1);
    assert!(stderr(&run).contains("broken.png"), "{}", stderr(&run));
    let json = folder.json("r.json");
    assert_eq!(json["evaluation"]["stills"].as_array().map(Vec::len), Some(1));
    assert_eq!(json["evaluation"]["failures"].as_array().map(Vec::len), Some(1));
}

#[test]
fn clips_have_their_own_table() {
    let folder = Folder::new();
    folder.gif("in.gif", &[40; 4]);
    let run = folder.run(&format!("evaluate in.gif {FAST} --json")).success();
    let json: serde_json::Value = serde_json::from_str(&stdout(&run)).expect("JSON alone");
    let clip = &json["evaluation"]["clips"][0];
    assert_eq!((&clip["frames"], clip["methods"].as_array().map(Vec::len)), (&4.into(), Some(2)));
    for method in clip["methods"].as_array().expect("a list") {
        assert!(method["fps"].as_f64() > Some(0.0) && method["fdb"].as_f64() >= Some(0.0));
        assert!(method["seeds_kept"].is_f64() && method["warp_error"].is_f64(), "{method}");
    }
    assert_eq!(clip["refined"].as_array().map(Vec::len), Some(2));
    for (before, after) in (0..2).map(|i| (&clip["methods"][i], &clip["refined"][i])) {
        assert!(after["mse"].as_f64() < before["mse"].as_f64(), "{after}");
    }
}

#[test]
fn nothing_is_replaced_unasked() {
    let folder = Folder::new();
    folder.still("a.png", 40, 40);
    folder.write("r.csv", b"mine");
    folder.run(&format!("evaluate a.png {FAST} --csv=r.csv")).failure().code(1);
    assert_eq!(folder.read("r.csv"), b"mine");
    folder.run(&format!("evaluate a.png {FAST} --csv=r.csv -y")).success();
    folder.run(&format!("evaluate a.png {FAST} --html a.png -y")).failure().code(2);
    folder.run("evaluate a.png --methods magic").failure().code(2);
    folder.run("evaluate nowhere.png").failure().code(1);
}

#[test]
fn the_smallest_picture_has_figures() {
    let folder = Folder::new();
    folder.still("dot.png", 1, 1);
    let run = folder.run("evaluate dot.png --csv").success();
    assert_eq!(stdout(&run).lines().count(), 1 + 2 * 6);
}

#[test]
fn refinement_is_what_the_options_say() {
    let folder = Folder::new();
    folder.still("a.png", 90, 60);
    for (options, steps) in [
        ("--refine 3", Some(3)),
        ("--refine 0", None),
        ("--quality draft", None),
        ("--preset paper", None),
        ("--error psnr:1", Some(0)),
    ] {
        let run = folder.run(&format!("evaluate a.png {FAST} --no-robustness --json {options}"));
        let json: serde_json::Value = serde_json::from_str(&stdout(&run.success())).expect("JSON");
        let still = &json["evaluation"]["stills"][0];
        assert_eq!(still["methods"].as_array().map(Vec::len), Some(2), "{options}");
        assert_eq!(still["refined"][0]["refine_steps"].as_u64(), steps, "{options}");
    }
}

#[test]
fn studies_are_compared_at_the_same_number_of_points() {
    let folder = Folder::new();
    folder.still("a.png", 90, 60);
    let line = "evaluate a.png --studies --points 60 --no-robustness --refine 1 --json=r.json --html r.html";
    let text = stdout(&folder.run(line).success());
    assert!(text.contains("gai-2015") && text.contains("study"), "{text}");
    let json = folder.json("r.json");
    for list in ["methods", "refined"] {
        let scores = json["evaluation"]["stills"][0][list].as_array().expect("a list");
        assert_eq!(scores.len(), 14);
        scores.iter().for_each(|scores| assert_eq!(scores["seeds"], 60, "{scores}"));
    }
    let page = String::from_utf8(folder.read("r.html")).expect("text");
    assert_eq!(page.matches("data:image/jpeg;base64,").count(), 1 + 2 * 14);
    folder.run("evaluate a.png --studies --methods hrlp").failure().code(2);
    let one = folder.run("evaluate a.png --study hslp --points 60 --no-robustness --csv").success();
    assert_eq!(stdout(&one).lines().count(), 3);
}

#[test]
fn presets_are_compared_as_they_are() {
    let folder = Folder::new();
    folder.still("a.png", 60, 40);
    let run = folder.run("evaluate a.png --presets --no-robustness --csv").success();
    let text = stdout(&run);
    assert_eq!(text.lines().count(), 1 + 15, "{text}");
    assert!(text.contains(",stained-glass,"), "{text}");
}

/// They are compared at the same number of points.
#[test]
fn methods_do_not_find_a_number_of_points_each() {
    let folder = Folder::new();
    folder.still("a.png", 40, 40);
    let run = folder.run("evaluate a.png --points auto --error psnr:20").failure().code(2);
    assert!(stderr(&run).contains("render --points auto"), "{}", stderr(&run));
}
