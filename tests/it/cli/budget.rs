//! A time budget, replays of its runs, and presets.

use serde_json::Value;

use super::{Folder, stderr, stdout};

const RUN: &str = "render in.gif -o out.gif -q -y --points 80";

fn film(folder: &Folder) {
    folder.gif("in.gif", &[40; 30]);
}

#[test]
fn a_run_under_a_budget_is_replayed_to_the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new();
    film(&folder);
    // Two that hardly anything fits in, and one with time for many steps: details differ by load.
    for budget in ["0.2ms", "1ms", "1s"] {
        folder.run(&format!("{RUN} --budget {budget} --report r.json")).success();
        let bytes = folder.read("out.gif");
        let report = folder.json("r.json");
        assert_eq!(report["per_frame"].as_array().map(Vec::len), Some(30));
        for threads in [1, 2, 8] {
            let line = format!("{RUN} --replay r.json --threads {threads} --report again.json");
            folder.run(&line).success();
            assert!(folder.read("out.gif") == bytes, "{budget}, {threads} threads");
            let again = folder.json("again.json");
            assert_eq!(orders(&again), orders(&report));
            assert_eq!(again["budget"]["ms"], Value::Null);
        }
    }
}

#[test]
fn parts_of_steps_are_replayed_to_the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new();
    film(&folder);
    folder.run(&format!("{RUN} --report r.json")).success();
    let whole = folder.read("out.gif");
    let mut report = folder.json("r.json");
    for (i, frame) in (0u32..).zip(report["per_frame"].as_array_mut().expect("a list")) {
        frame["orders"]["steps"] = (f64::from(i * 3 % 17) / 8.0).into();
    }
    folder.write("r.json", report.to_string().as_bytes());
    let bytes = [1, 2, 8].map(|threads| {
        folder.run(&format!("{RUN} --replay r.json --threads {threads}")).success();
        folder.read("out.gif")
    });
    assert!(bytes[0] != whole && bytes[1] == bytes[0] && bytes[2] == bytes[0]);
    report["per_frame"][7]["orders"]["steps"] = 0.3.into();
    folder.write("r.json", report.to_string().as_bytes());
    let said = stderr(&folder.run(&format!("{RUN} --replay r.json")).code(1));
    assert!(said.contains("r.json, frame 7: 'orders': steps is 0.3"), "{said}");
}

fn orders(report: &Value) -> Vec<Value> {
    let frames = report["per_frame"].as_array().expect("a list");
    frames.iter().map(|frame| frame["orders"].clone()).collect()
}

#[test]
fn spare_time_goes_to_refinement_and_changes_are_told() {
    let folder = Folder::new();
    film(&folder);
    let line = "render in.gif -o out.gif -y --points 80 --report r.json -v --budget";
    let said = stderr(&folder.run(&format!("{line} 5s")).success());
    assert!(said.contains("refinement steps 1 -> 2: "), "{said}");
    assert!(said.contains(" of 5000.0 ms"), "{said}");
    let report = folder.json("r.json");
    assert_eq!((&report["budget"]["ms"], &report["budget"]["missed"]), (&5000.0.into(), &0.into()));
    let last = &report["per_frame"][29]["orders"];
    assert!(last["steps"].as_f64() > Some(2.0) && last["seeds"] == 100, "{last}");
    let changes = report["per_frame"].as_array().expect("a list").iter();
    let changes: usize =
        changes.filter_map(|frame| frame["changes"].as_array()).map(Vec::len).sum();
    assert_eq!(report["budget"]["changes"], changes);
    // Steps that are counted are a cap.
    folder.run(&format!("{line} 5s --refine 1")).success();
    let report = folder.json("r.json");
    let later = report["per_frame"].as_array().expect("a list").iter().skip(1);
    assert!(later.into_iter().all(|frame| frame["orders"]["steps"].as_f64() <= Some(1.0)));
}

#[test]
fn without_a_budget_nothing_is_changed() {
    let folder = Folder::new();
    film(&folder);
    folder.run(&format!("{RUN} --report r.json")).success();
    let bytes = folder.read("out.gif");
    let report = folder.json("r.json");
    assert_eq!(report["budget"]["ms"], Value::Null);
    let full = |frame: &Value| frame["detail"] == 1.0 && frame["orders"]["steps"] == Value::Null;
    assert!(report["per_frame"].as_array().expect("a list").iter().all(full));
    folder.run(&format!("{RUN} --replay r.json")).success();
    assert!(folder.read("out.gif") == bytes);
}

#[test]
fn budgets_that_cannot_be_meant_are_refused() {
    let folder = Folder::new();
    folder.still("in.png", 30, 20);
    let said = stderr(&folder.run("render in.png -o out.png --budget auto").code(2));
    assert!(said.contains("--budget 33ms"), "{said}");
    for wrong in ["33", "0ms", "soon"] {
        let said =
            stderr(&folder.run(&format!("render in.png -o out.png --budget {wrong}")).code(2));
        assert!(said.contains("is not a budget"), "{said}");
    }
    film(&folder);
    folder.run("render in.gif -o out.gif -q --budget auto --report r.json").success();
    assert_eq!(folder.json("r.json")["budget"]["ms"], 40.0);
}

#[test]
fn replays_that_do_not_fit_say_why() {
    let folder = Folder::new();
    film(&folder);
    folder.run(&format!("{RUN} --report r.json")).success();
    let said = |line: &str| stderr(&folder.run(line).code(1));
    let other = said(&format!("{RUN} --clusters 9 --replay r.json"));
    assert!(other.contains("r.json: clusters was 8 in that run and is 9 now"), "{other}");
    let few = said(&format!("{RUN} --frames 12 --replay r.json"));
    assert!(few.contains("it holds 30 frames, and the input only 12"), "{few}");
    folder.gif("in.gif", &[40; 31]);
    let many = said(&format!("{RUN} --replay r.json"));
    assert!(many.contains("the input has more than its 30 frames"), "{many}");
    let mut report = folder.json("r.json");
    report["per_frame"][7]["orders"]["rows"] = 0.into();
    folder.write("r.json", report.to_string().as_bytes());
    let damaged = said(&format!("{RUN} --replay r.json"));
    assert!(damaged.contains("r.json, frame 7: 'orders': rows is 0"), "{damaged}");
    folder.write("r.json", b"{\"frames\": 3");
    assert!(said(&format!("{RUN} --replay r.json")).contains("r.json: is no report (JSON)"));
    assert!(said(&format!("{RUN} --replay none.json")).contains("none.json: cannot be read"));
    folder.run(&format!("{RUN} --replay r.json --budget 9ms")).code(2);
}

#[test]
fn presets_are_listed_written_and_read() {
    let folder = Folder::new();
    let list = stdout(&folder.run("presets").success());
    for name in ["paper", "bold", "fine", "sketch", "stained-glass"] {
        let line = list.lines().find(|line| line.starts_with(name));
        assert!(line.is_some_and(|line| line.len() > name.len() + 10), "{list}");
        folder.still("in.png", 90, 60);
        folder.run(&format!("render in.png -o named.png -q -y --preset {name}")).success();
        let text = stdout(&folder.run(&format!("presets {name}")).success());
        folder.write("mine.toml", text.as_bytes());
        folder.run("render in.png -o file.png -q -y --preset mine.toml").success();
        assert!(folder.read("named.png") == folder.read("file.png"), "{name}");
    }
    let none = stderr(&folder.run("presets bald").code(2));
    assert!(none.contains("'bald'") && none.contains("stained-glass"), "{none}");
}

#[test]
fn preset_files_that_are_wrong_name_file_line_and_key() {
    let folder = Folder::new();
    folder.still("in.png", 30, 20);
    for (text, part) in [
        ("seed = 3\npionts = \"9\"\n", "line 2: unknown field `pionts`"),
        ("clusters = 1\n", "line 1: clusters is 1; it can be 2 to 64"),
        ("\npoints = \"many\"", "line 2, points: 'many' is not a number of points"),
        ("outline = [", "line 1"),
    ] {
        folder.write("mine.toml", text.as_bytes());
        let said = stderr(&folder.run("render in.png -o out.png --preset mine.toml").failure());
        assert!(said.contains("mine.toml: ") && said.contains(part), "{said}");
    }
    let none = stderr(&folder.run("render in.png -o out.png --preset none.toml").failure());
    assert!(none.contains("none.toml: cannot be read"), "{none}");
}

#[test]
fn a_loop_under_a_budget_is_replayed_to_the_same_bytes_and_counts_its_frames_once() {
    let folder = Folder::new();
    film(&folder);
    folder.run(&format!("{RUN} --loop --budget 1ms --report r.json")).success();
    let bytes = folder.read("out.gif");
    let report = folder.json("r.json");
    assert_eq!((&report["frames"], orders(&report).len()), (&30.into(), 30));
    assert_eq!(folder.delays("out.gif"), [40; 30]);
    folder.run(&format!("{RUN} --loop --replay r.json")).success();
    assert!(folder.read("out.gif") == bytes);
    // Nobody waits for what never comes: the replay of a loop is no replay without it.
    folder.run(&format!("{RUN} --replay r.json")).success();
    assert!(folder.read("out.gif") != bytes);
}
