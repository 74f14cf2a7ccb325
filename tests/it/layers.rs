//! A module uses only modules that stand before it in the list of layers on its crate's front page.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

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
fn modules_use_only_those_before_them() {
    check("crates/core/src");
    check("src");
}

/// The modules that the front page of a crate lists below "Layers", lowest first.
fn layers(front_page: &str) -> Vec<&str> {
    let after = front_page.split("# Layers").nth(1).expect("the front page lists the layers");
    let lines = after.lines().map_while(|line| line.strip_prefix("//!")).map(str::trim);
    let lists = lines.filter(|line| line.starts_with(|c: char| c == '`' || c.is_numeric()));
    lists.flat_map(|line| line.split('`').skip(1).step_by(2)).collect()
}

fn check(folder: &str) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let front_page = std::fs::read_to_string(root.join("lib.rs")).expect("a library");
    let layers = layers(&front_page);
    assert!(layers.len() > 5, "{folder}: {layers:?}");
    let place: BTreeMap<_, _> = layers.into_iter().zip(0..).collect();
    let mut files = Vec::new();
    sources(&root, &mut files);
    for file in files {
        let inner = file.strip_prefix(&root).expect("a file below the root");
        let path: Vec<_> = inner.iter().map(|part| part.to_string_lossy()).collect();
        let path: Vec<_> = path.iter().map(|part| part.trim_end_matches(".rs")).collect();
        let path = path.strip_suffix(&["mod"]).unwrap_or(&path);
        // Tests of a module may use modules above it.
        if path == ["lib"] || path.contains(&"tests") {
            continue;
        }
        let module = path[0];
        let own: i32 =
            *place.get(module).unwrap_or_else(|| panic!("{folder}: {module} is in no layer"));
        let text = std::fs::read_to_string(&file).expect("a source file");
        for name in used_modules(&without_tests(&text), path.len()) {
            let Some(&other) = place.get(name) else { continue };
            assert!(other <= own, "{} uses {name}, which is in a layer above", inner.display());
        }
    }
}

/// Code without comments and without items that are marked as tests.
fn without_tests(text: &str) -> String {
    let mut code = String::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line.trim_start().starts_with("//") {
            continue;
        }
        if line.trim() != "#[cfg(test)]" {
            code.push_str(line);
            code.push('\n');
            continue;
        }
        // The item that is marked: to its closing brace, or one line.
        let item = lines.find(|line| !line.trim_start().starts_with("#[")).unwrap_or_default();
        let indent = &item[..item.len() - item.trim_start().len()];
        if item.ends_with('{') {
            let end = format!("{indent}}}");
            lines.find(|line| *line == end);
        }
    }
    code
}

/// Names after `crate::`, also in braces, and after as many `super::` as lead out of a module whose path has
/// `depth` parts.
fn used_modules(code: &str, depth: usize) -> Vec<&str> {
    let mut used = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let after = &code[at + "crate::".len()..];
        match after.strip_prefix('{') {
            Some(list) => used.extend(first_names(list)),
            None => used.push(identifier(after)),
        }
    }
    let climb = "super::".repeat(depth);
    for (at, _) in code.match_indices(&climb) {
        let after = &code[at + climb.len()..];
        if !code[..at].ends_with("super::") && !after.starts_with("super::") {
            used.push(identifier(after));
        }
    }
    used
}

fn identifier(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    &text[..end]
}

/// The first name of each path in a list of imports, up to the brace that closes it.
fn first_names(list: &str) -> Vec<&str> {
    let (mut depth, mut names, mut is_start) = (0, Vec::new(), true);
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => is_start = true,
            c if is_start && c.is_alphabetic() => {
                names.push(identifier(&list[at..]));
                is_start = false;
            }
            _ => {}
        }
    }
    names
}

#[test]
fn uses_are_found_in_lists_behind_tests_and_through_parents() {
    let code = "use crate::frame::Frame;\n#[cfg(test)]\nmod tests;\n#[cfg(test)]\nmod more {\n    \
                use crate::hidden;\n}\n// crate::comment\nuse crate::{echo, mesh::{Mesh, Edge}, \
                plane};\nuse super::super::flow::Small;\nuse super::own;\n";
    let code = without_tests(code);
    assert_eq!(used_modules(&code, 2), ["frame", "echo", "mesh", "plane", "flow"]);
}
