//! The plan of the house: a module uses only those that stand before it in the list of its crate's front page.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

#[test]
fn modules_of_the_engine_use_only_lower_ones() {
    check("crates/core/src");
}

#[test]
fn modules_of_the_library_use_only_lower_ones() {
    check("src");
}

#[test]
fn the_check_sees_groups_parents_and_what_follows_tests() {
    let order = ["low", "middle", "high"].map(String::from);
    let found = |module: &str, code: &str| too_high(&order, &path_of(module), code);
    let wrong = ["high".to_owned()];
    assert_eq!(found("middle.rs", "use crate::low::A; use crate::middle::B;"), [""; 0]);
    assert_eq!(found("middle.rs", "use crate::high::A;"), wrong);
    assert_eq!(found("middle.rs", "use crate::{low::{a, high}, high::B};"), wrong);
    assert_eq!(found("middle.rs", "#[cfg(test)]\nmod tests;\nuse crate::high;"), wrong);
    assert_eq!(found("middle.rs", "use super::high::A;"), wrong);
    assert_eq!(found("middle/part.rs", "use super::high::A;"), [""; 0]);
    assert_eq!(found("middle/part.rs", "use super::super::high::A;"), wrong);
    assert_eq!(found("middle/mod.rs", "fn f() { super::{high::g}() }"), wrong);
    let tests =
        "#[cfg(test)]\nmod tests { use crate::high; fn f() { '{'; \"}\"; } } use crate::low;";
    assert_eq!(found("middle.rs", tests), [""; 0]);
    assert_eq!(
        found("middle.rs", "// use crate::high;\n/// [`crate::high`]\nuse crate::low;"),
        [""; 0]
    );
    assert_eq!(found("middle.rs", &format!("{tests} use crate::high;")), wrong);
}

fn check(folder: &str) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let front = std::fs::read_to_string(root.join("lib.rs")).expect("the front page");
    let order = layers(&front);
    let declared: BTreeSet<_> = front.lines().filter_map(declared_module).collect();
    assert_eq!(
        declared,
        order.iter().map(String::as_str).collect(),
        "modules and layers of {folder}"
    );
    let mut files = Vec::new();
    sources(&root, &mut files);
    for file in files {
        let inner = file.strip_prefix(&root).expect("a file below the root");
        // Tests of a module may look at it through the modules above.
        let is_test = file.ends_with("tests.rs") || inner.iter().any(|part| part == "tests");
        let path = path_of(&inner.to_string_lossy());
        if is_test || path[0] == "lib" {
            continue;
        }
        let code = std::fs::read_to_string(&file).expect("a source file");
        let found = too_high(&order, &path, &code);
        assert!(found.is_empty(), "{} uses {found:?}, which stand above it", inner.display());
    }
}

/// The names in backticks of the section "Layers" of a front page, lowest first.
fn layers(front: &str) -> Vec<String> {
    let docs = front.lines().filter_map(|line| line.strip_prefix("//!"));
    let section = docs.skip_while(|line| line.trim() != "# Layers").skip(1);
    let section = section.take_while(|line| !line.trim().starts_with('#'));
    let text: String = section.collect();
    let list = text.rsplit_once(':').map_or("", |(_, list)| list);
    list.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// The module that a line of a front page declares.
fn declared_module(line: &str) -> Option<&str> {
    let line = line.trim();
    line.strip_prefix("pub ").unwrap_or(line).strip_prefix("mod ")?.strip_suffix(';')
}

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

/// The module that a file holds, from the crate's root.
fn path_of(file: &str) -> Vec<String> {
    let stem = file.trim_end_matches(".rs");
    stem.strip_suffix("/mod").unwrap_or(stem).split('/').map(str::to_owned).collect()
}

/// The modules that the code of module `path` uses though they stand after it in `order`.
fn too_high(order: &[String], path: &[String], code: &str) -> Vec<String> {
    let place = |name: &str| order.iter().position(|other| other == name);
    let own = place(&path[0]).unwrap_or_else(|| panic!("{} has no layer", path[0]));
    let code = without_tests(&without_comments(code));
    let to_root = "super::".repeat(path.len());
    let uses = ["crate::", &to_root].into_iter().flat_map(|prefix| used(&code, prefix));
    uses.filter(|name| place(name).is_some_and(|other| other > own)).collect()
}

/// The code without comments, white space at the ends of lines, and what stands in quotes.
fn without_comments(code: &str) -> String {
    let (mut out, mut rest) = (String::new(), code);
    while let Some(c) = rest.chars().next() {
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("'\"'") || rest.starts_with("'{'") || rest.starts_with("'}'") {
            3
        } else if c == '"' {
            string_length(rest)
        } else {
            out.push(c);
            c.len_utf8()
        };
        rest = &rest[skipped..];
    }
    out
}

/// Bytes of the string that `text` begins with, quotes included.
fn string_length(text: &str) -> usize {
    let mut escaped = false;
    for (i, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return i + 1,
            _ => {}
        }
    }
    text.len()
}

/// The code without the blocks of its test modules.
fn without_tests(code: &str) -> String {
    let mut parts = code.split("#[cfg(test)]");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let head = part.find(['{', ';']).unwrap_or(part.len());
        let is_module =
            part[..head].trim_start().trim_start_matches("pub(crate) ").starts_with("mod ");
        let is_block = is_module && part[head..].starts_with('{');
        out += if is_block { &part[head + block_length(&part[head..])..] } else { part };
    }
    out
}

/// Bytes of the block in braces that `text` begins with.
fn block_length(text: &str) -> usize {
    let mut depth = 0;
    for (i, c) in text.char_indices() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if depth == 0 {
            return i + 1;
        }
    }
    text.len()
}

/// The first names of all paths in `code` that begin with `prefix`, groups in braces included.
fn used(code: &str, prefix: &str) -> Vec<String> {
    let name = |text: &str| -> String {
        text.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
    };
    let mut found = Vec::new();
    for (at, _) in code.match_indices(prefix) {
        // A longer chain of parents is another path.
        if code[..at].ends_with("super::") {
            continue;
        }
        let path = &code[at + prefix.len()..];
        if path.starts_with('{') {
            found.extend(members(&path[1..block_length(path) - 1]).into_iter().map(name));
        } else {
            found.push(name(path));
        }
    }
    found
}

/// The parts of a group, which commas part outside of inner braces.
fn members(group: &str) -> Vec<&str> {
    let mut depth = 0;
    let parted = move |c: char| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        c == ',' && depth == 0
    };
    group.split(parted).collect()
}
