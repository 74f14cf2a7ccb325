use std::io::Write;

use super::*;
use crate::pattern::Pattern;

fn listed(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

fn numbered(folder: &Path) -> Pattern {
    Pattern::in_folder(folder, "png")
}

#[test]
fn a_file_appears_when_it_is_complete_and_not_before() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("a.gif");
    let place = Place::reserve(&output, &SinkOptions::default()).expect("a place");
    place.file().write_all(b"x").expect("written");
    assert!(!output.exists());
    place.commit().expect("in its place");
    assert_eq!(listed(folder.path()), ["a.gif"]);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let usual = folder.path().join("usual");
        File::create(&usual).expect("a file");
        let mode = |p: &Path| fs::metadata(p).expect("a file").permissions().mode();
        assert_eq!(mode(&output), mode(&usual), "rights as of any new file");
    }
}

#[test]
fn a_dropped_output_leaves_no_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let options = SinkOptions::default();
    let place = Place::reserve(&folder.path().join("a.gif"), &options).expect("a place");
    let mut there = Series::reserve(numbered(folder.path()), false, &options).expect("a place");
    there.file().expect("a file");
    let new = folder.path().join("new");
    let mut made = Series::reserve(numbered(&new), true, &options).expect("a place");
    made.file().expect("a file");
    drop((place, there, made));
    assert_eq!(listed(folder.path()), [""; 0]);
}

#[test]
fn a_series_leaves_other_files_in_its_folder_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("notes.txt"), b"x").expect("a file");
    let options = SinkOptions::default();
    let mut series = Series::reserve(numbered(folder.path()), false, &options).expect("a place");
    for _ in 0..2 {
        series.file().expect("a file");
    }
    series.commit().expect("in their places");
    assert_eq!(listed(folder.path()), ["0001.png", "0002.png", "notes.txt"]);
    let error = Series::reserve(numbered(folder.path()), false, &options)
        .expect_err("they exist")
        .to_string();
    assert!(error.contains("exists") && error.contains("-y"), "{error}");
}

#[test]
fn no_file_is_replaced_unless_overwriting_is_allowed() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("a.png");
    let place = Place::reserve(&output, &SinkOptions::default()).expect("a place");
    fs::write(&output, b"came meanwhile").expect("a file");
    assert!(place.commit().is_err());
    assert_eq!(fs::read(&output).expect("still there"), b"came meanwhile");
    let error = Place::reserve(&output, &SinkOptions::default()).expect_err("it exists");
    assert!(error.to_string().contains("-y"), "{error}");
    let options = SinkOptions { overwrite: true, ..SinkOptions::default() };
    Place::reserve(&output, &options).expect("a place").commit().expect("replaced");
    assert_eq!(fs::read(&output).expect("replaced"), b"");
}

#[test]
#[cfg(unix)]
fn a_link_to_nothing_is_written_through() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().expect("a folder");
    let link = folder.path().join("link.png");
    symlink("there.png", &link).expect("a link");
    for overwrite in [false, true] {
        let options = SinkOptions { overwrite, ..SinkOptions::default() };
        Place::reserve(&link, &options).expect("a place").commit().expect("written");
        assert!(fs::symlink_metadata(&link).expect("a link").is_symlink());
    }
    assert_eq!(listed(folder.path()), ["link.png", "there.png"]);
    symlink("round", folder.path().join("round")).expect("a link");
    let error = Place::reserve(&folder.path().join("round"), &SinkOptions::default());
    assert!(error.expect_err("no file").to_string().contains("circle"));
}

#[test]
#[cfg(unix)]
fn a_file_that_replaces_another_keeps_its_mode() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a folder");
    let options = SinkOptions { overwrite: true, ..SinkOptions::default() };
    for (name, mode) in [("a.gif", 0o600), ("b.gif", 0o444), ("c.gif", 0o777)] {
        let output = folder.path().join(name);
        fs::write(&output, b"x").expect("a file");
        fs::set_permissions(&output, PermissionsExt::from_mode(mode)).expect("its mode");
        Place::reserve(&output, &options).expect("a place").commit().expect("replaced");
        let now = fs::metadata(&output).expect("a file").permissions().mode();
        assert_eq!(now & 0o777, mode, "{name}");
    }
    let first = folder.path().join("0001.png");
    fs::write(&first, b"x").expect("a file");
    fs::set_permissions(&first, PermissionsExt::from_mode(0o640)).expect("its mode");
    let mut series = Series::reserve(numbered(folder.path()), false, &options).expect("places");
    series.file().expect("a file");
    series.commit().expect("replaced");
    assert_eq!(fs::metadata(&first).expect("a file").permissions().mode() & 0o777, 0o640);
}

#[test]
fn of_two_series_with_the_same_names_one_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let new = folder.path().join("new");
    let options = SinkOptions::default();
    let [mut one, mut other] =
        [(); 2].map(|()| Series::reserve(numbered(&new), true, &options).expect("a place"));
    for _ in 0..2 {
        one.file().expect("a file");
    }
    for _ in 0..3 {
        other.file().expect("a file");
    }
    // What came meanwhile is in the way of the third.
    fs::write(new.join("0003.png"), b"x").expect("a file");
    other.commit().expect_err("the third is there");
    assert_eq!(listed(&new).iter().filter(|name| name.ends_with("png")).count(), 1);
    one.commit().expect("in its place");
    assert_eq!(listed(&new), ["0001.png", "0002.png", "0003.png"]);
}

#[test]
fn an_input_is_never_the_output() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = folder.path().join("0001.png");
    let link = folder.path().join("link.png");
    fs::write(&input, b"x").expect("a file");
    fs::hard_link(&input, &link).expect("a link");
    let round = folder.path().join("..").join(folder.path().file_name().expect("a name"));
    let inputs = vec![input];
    let options = SinkOptions { overwrite: true, inputs, ..SinkOptions::default() };
    for output in [round.join("0001.png"), link] {
        let error = Place::reserve(&output, &options).expect_err("the input").to_string();
        assert!(error.contains("is the input"), "{error}");
    }
    assert!(Series::reserve(numbered(&round), false, &options).is_err());
}

#[test]
fn missing_folders_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("no/a.png");
    let error = Place::reserve(&output, &SinkOptions::default()).expect_err("no folder");
    assert!(error.to_string().contains("there is no folder"), "{error}");
    let error = Place::reserve(folder.path(), &SinkOptions::default()).expect_err("a folder");
    assert!(error.to_string().contains("is a folder"), "{error}");
}
