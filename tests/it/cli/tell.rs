//! What the program says: reports, summaries, `info`, `inspect`, completions, manual pages.

use super::{Folder, stderr, stdout};

const STAGES: [&str; 7] =
    ["decode", "features", "sample", "triangulate", "refine", "rasterise", "encode"];

#[test]
fn the_report_holds_every_figure() {
    let folder = Folder::new();
    folder.gif("in.gif", &[40, 60, 80]);
    folder.run("render in.gif -o out.gif --report r.json").success();
    let report = folder.json("r.json");
    assert_eq!(report["input"]["paths"][0], "in.gif");
    assert_eq!(report["input"]["format"], "gif");
    assert_eq!(report["output"]["path"], "out.gif");
    assert_eq!(report["output"]["bytes"], folder.read("out.gif").len());
    assert_eq!((&report["frames"], &report["dropped"]), (&3.into(), &0.into()));
    assert!(report["wall_s"].as_f64() > Some(0.0) && report["fps"].as_f64() > Some(0.0));
    assert_eq!(report["budget"]["missed"], 0);
    for stage in STAGES {
        let times = &report["stages"][stage];
        let [p50, p95, p99] = ["p50_ms", "p95_ms", "p99_ms"].map(|p| times[p].as_f64());
        assert!(p50.is_some() && p50 <= p95 && p95 <= p99, "{stage}: {times}");
    }
    let frames = report["per_frame"].as_array().expect("a list");
    let starts: Vec<_> = frames.iter().map(|frame| frame["pts_s"].as_f64()).collect();
    assert_eq!(starts, [Some(0.0), Some(0.04), Some(0.1)]);
    for (frame, index) in frames.iter().zip(0..) {
        assert_eq!(frame["index"], index);
        let counts =
            ["candidates", "seeds", "seeds_kept", "seeds_moved", "seeds_born", "seeds_died"];
        for name in counts.iter().chain(&["triangles", "refine_steps"]) {
            assert!(frame[name].is_u64(), "{name}: {}", frame[name]);
        }
        assert!(frame["detail"].is_f64() && frame["cut"].is_boolean());
        assert!(STAGES.iter().all(|stage| frame["ms"][stage].is_f64()));
    }
}

#[test]
fn a_report_replaces_no_input_and_no_output() {
    let folder = Folder::new();
    folder.still("in.png", 20, 20);
    let before = folder.read("in.png");
    for report in ["in.png", "./in.png", "out.png", "none/r.json"] {
        let refused = folder.run(&format!("render in.png -o out.png --report {report}")).failure();
        assert!(stderr(&refused).starts_with("polyreel: error: "), "{}", stderr(&refused));
        assert_eq!(folder.listing(), ["in.png"]);
    }
    assert_eq!(folder.read("in.png"), before);
}

#[test]
fn quiet_says_nothing_and_verbose_says_more() {
    let folder = Folder::new();
    folder.still("in.png", 40, 30);
    let quiet = folder.run("render in.png -o out.png -q").success();
    assert_eq!((stderr(&quiet), stdout(&quiet)), (String::new(), String::new()));
    let verbose = stderr(&folder.run("render in.png -o out.png -y -v --seed 77").success());
    assert!(verbose.contains("seed=77"), "{verbose}");
    assert!(STAGES.iter().all(|stage| verbose.contains(stage)), "{verbose}");
}

#[test]
fn info_tells_what_headers_hold() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100; 5]);
    let table = stdout(&folder.run("info in.gif").success());
    for row in ["format    gif", "size      48x32", "frames    5", "plays     forever"] {
        assert!(table.lines().any(|line| line == row), "{row} in {table}");
    }
    let json = stdout(&folder.run("info in.gif --json").success());
    let info: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(info["paths"][0], "in.gif");
    assert_eq!((&info["size"]["width"], &info["frames"]), (&48.into(), &5.into()));
    assert_eq!((&info["duration"]["num"], &info["duration"]["den"]), (&1.into(), &2.into()));
    for key in ["rate", "alpha", "audio", "loops", "still", "live", "colour"] {
        assert!(info.get(key).is_some(), "{key} in {json}");
    }
}

#[test]
fn info_goes_by_content() {
    let folder = Folder::new();
    folder.still("in.png", 30, 20);
    std::fs::rename(folder.path("in.png"), folder.path("in.jpg")).expect("renamed");
    let table = stdout(&folder.run("info in.jpg").success());
    assert!(table.contains("png"), "{table}");
}

#[test]
fn inspect_shows_every_stage() {
    let folder = Folder::new();
    folder.still("in.png", 90, 60);
    folder.run("inspect in.png -o stages").success();
    let names = [
        "candidates",
        "grid",
        "lowpoly",
        "lowpoly-before",
        "mesh",
        "mesh-before",
        "regions",
        "seeds",
    ];
    for name in names {
        let picture = folder.open(&format!("stages/{name}.png"));
        assert_eq!(picture.dimensions(), (90, 60), "{name}");
        let first = picture.get_pixel(0, 0);
        assert!(picture.pixels().any(|pixel| pixel != first), "{name} is empty");
    }
    let maps = ["diffused", "edges", "entropy", "saliency"];
    for name in maps {
        assert_eq!(folder.open(&format!("stages/{name}.png")).dimensions(), (90, 60), "{name}");
        let exact = folder.read(&format!("stages/{name}.npy"));
        assert_eq!(exact.len(), 128 + 4 * 90 * 60, "{name}");
    }
    let convergence = 2;
    assert_eq!(folder.listing().len(), 1 + 1 + names.len() + 2 * maps.len() + convergence);
    folder.run("render in.png -o out.png").success();
    assert_eq!(folder.open("stages/lowpoly.png"), folder.open("out.png"));
    folder.run("render in.png -o before.png --refine 0").success();
    assert_eq!(folder.open("stages/lowpoly-before.png"), folder.open("before.png"));

    folder.run("inspect in.png -o stages").failure().code(1);
    folder.run("inspect in.png -o stages -y").success();
}

/// The MSE of each step in `stages/convergence.csv`.
fn errors(folder: &Folder) -> Vec<f64> {
    let csv = String::from_utf8(folder.read("stages/convergence.csv")).expect("text");
    assert!(csv.starts_with("step,mse,psnr_db\n0,"), "{csv}");
    let svg = String::from_utf8(folder.read("stages/convergence.svg")).expect("text");
    let errors: Vec<f64> = csv
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(1).and_then(|mse| mse.parse().ok()).expect("a figure"))
        .collect();
    assert_eq!(svg.matches("<circle").count(), errors.len(), "a point a step");
    errors
}

#[test]
fn inspect_tells_how_refinement_converged() {
    let folder = Folder::new();
    folder.still("in.png", 120, 80);
    for (options, steps) in [("--refine 3", 3..4), ("--quality normal", 5..6), ("", 6..61)] {
        folder.run(&format!("inspect in.png -o stages -y {options}")).success();
        let errors = errors(&folder);
        assert!(steps.contains(&(errors.len() - 1)), "{options}: {errors:?}");
        assert!(errors.windows(2).all(|pair| pair[1] <= pair[0] + 1e-9), "{errors:?}");
        assert!(errors[errors.len() - 1] < 0.9 * errors[0], "{errors:?}");
    }
    folder.run("inspect in.png -o stages -y --refine 0").success();
    assert_eq!(errors(&folder).len(), 1);
    for name in ["mesh", "lowpoly"] {
        let before = folder.open(&format!("stages/{name}-before.png"));
        assert_eq!(before, folder.open(&format!("stages/{name}.png")), "{name}");
    }
}

#[test]
fn inspect_refines_to_a_target() {
    let folder = Folder::new();
    folder.still("in.png", 120, 80);
    folder.run("inspect in.png -o stages --points auto --error psnr:25").success();
    let (source, painted) = (folder.open("in.png"), folder.open("stages/lowpoly.png"));
    let squares =
        source.iter().zip(painted.iter()).map(|(&a, &b)| f64::from(a.abs_diff(b)).powi(2));
    // Of four channels, one of which is the same.
    let mse = squares.sum::<f64>() / (3 * 120 * 80) as f64;
    assert!(mse <= 255.0 * 255.0 / 10f64.powf(2.5), "{mse}");
    folder.run("render in.png -o out.png --points auto --error psnr:25").success();
    assert_eq!(folder.open("stages/lowpoly.png"), folder.open("out.png"));
    let far = folder.run("inspect in.png -o stages -y --points 20 --error ssim:0.99").success();
    assert!(stderr(&far).contains("warning") && stderr(&far).contains("SSIM"), "{}", stderr(&far));
}

#[test]
fn inspect_takes_the_first_frame() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100; 3]);
    folder.run("inspect in.gif -o stages").success();
    assert_eq!(folder.open("stages/mesh.png").dimensions(), (48, 32));
}

#[test]
fn completions_and_manual_pages_are_printed() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = stdout(&folder.run(&format!("completions {shell}")).success());
        assert!(script.contains("hex-density"), "{shell}");
    }
    let page = stdout(&folder.run("man").success());
    assert!(page.contains(".TH polyreel 1") && page.contains("inspect"), "{page}");
    let page = stdout(&folder.run("man render").success());
    assert!(page.contains("hex\\-density"), "{page}");
    folder.run("man nothing").failure().code(2);
}

#[test]
fn a_reader_of_standard_output_may_leave() {
    let folder = Folder::new();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_polyreel"))
        .args(["completions", "zsh"])
        .current_dir(folder.path(""))
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the program");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("its end");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
