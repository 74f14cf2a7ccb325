//! The plan of the house: a module uses only what stands above it in this list.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Modules of the engine, lowest layer first.
const CORE: [&str; 25] = [
    "geom",
    "stage",
    "error",
    "vector",
    "colour",
    "frame",
    "chance", // layer 0
    "plane",
    "options",
    "mesh",
    "hex",
    "residual",
    "scan",
    "draw",
    "flow",
    "feature", // layer 1
    "sample",
    "triangulate",
    "refine",
    "rasterise",
    "governor",
    "metric",
    "chain",
    "render", // layer 2
    "svg",    // layer 3
];

/// Modules of the library, lowest layer first. Those of the engine stand below them all.
const LIBRARY: [&str; 9] =
    ["error", "memory", "stream", "pattern", "ffmpeg", "preset", "source", "sink", "pipeline"];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("the sources can be read") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            if path.file_name().is_none_or(|name| name != "bin") {
                sources(&path, found);
            }
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn modules_use_only_what_stands_above_them() {
    check("crates/core/src", &CORE);
    check("src", &LIBRARY);
}

fn check(folder: &str, order: &[&str]) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let place: BTreeMap<_, _> = order.iter().enumerate().map(|(i, name)| (*name, i)).collect();
    let mut files = Vec::new();
    sources(&root, &mut files);
    for file in files {
        let inner = file.strip_prefix(&root).expect("a file below the root");
        let first = inner.components().next().expect("a name").as_os_str().to_string_lossy();
        let module = first.trim_end_matches(".rs");
        // Tests of a module may look at it through the rooms above.
        let is_test = file.ends_with("tests.rs") || inner.iter().any(|part| part == "tests");
        if module == "lib" || is_test {
            continue;
        }
        let own = *place.get(module).unwrap_or_else(|| panic!("{module} has no place in the plan"));
        let text = std::fs::read_to_string(&file).expect("a source file");
        let code = text.split("#[cfg(test)]").next().unwrap_or(&text);
        for line in code.lines().filter(|line| !line.trim_start().starts_with("//")) {
            for used in line.split("crate::").skip(1) {
                let name: String =
                    used.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                let Some(&other) = place.get(name.as_str()) else { continue };
                assert!(other <= own, "{} uses {name}: {line}", inner.display());
            }
        }
    }
}
