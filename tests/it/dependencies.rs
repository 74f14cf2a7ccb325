//! What the crates pull in, as `cargo tree` tells it.

use std::collections::BTreeSet;
use std::process::Command;

/// The names of all packages that `package` depends on in ordinary builds.
fn packages(package: &str, features: &[&str]) -> BTreeSet<String> {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(env!("CARGO_MANIFEST_DIR")).args([
        "tree",
        "--offline",
        "--locked",
        "-e",
        "normal",
        "--prefix",
        "none",
        "--format",
        "{p}",
        "-p",
        package,
    ]);
    let output = cargo.args(features).output().expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let tree = String::from_utf8(output.stdout).expect("names are text");
    tree.lines().filter_map(|line| line.split(' ').next()).map(str::to_owned).collect()
}

fn assert_none(packages: &BTreeSet<String>, forbidden: &[&str]) {
    let found: Vec<_> = forbidden.iter().filter(|name| packages.contains(**name)).collect();
    assert!(found.is_empty(), "{found:?} among {packages:?}");
}

/// What reads files, starts processes, parses command lines or shows windows.
const OUTSIDE: [&str; 10] = [
    "clap",
    "ctrlc",
    "ffmpeg-sidecar",
    "gif",
    "indicatif",
    "minifb",
    "rustix",
    "serde_json",
    "tempfile",
    "toml",
];

#[test]
fn the_engine_depends_on_nothing_outside() {
    let default = packages("polyreel-core", &[]);
    assert!(default.contains("rayon"), "{default:?}");
    assert_none(&default, &OUTSIDE);
    assert_none(&default, &["image", "serde"]);
    assert_none(&packages("polyreel-core", &["--all-features"]), &OUTSIDE);
    assert_none(
        &packages("polyreel-core", &["--no-default-features"]),
        &["image", "rayon", "serde"],
    );
}

#[test]
fn the_library_alone_has_nothing_of_the_program() {
    let program = [
        "clap",
        "clap_complete",
        "clap_mangen",
        "ctrlc",
        "indicatif",
        "embedded-graphics",
        "minifb",
    ];
    let library = packages("polyreel", &["--no-default-features"]);
    assert!(library.contains("polyreel-core"), "{library:?}");
    assert_none(&library, &program);
}
