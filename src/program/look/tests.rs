//! Each flag of the look reaches the field of its name, and no other.

use std::collections::BTreeSet;

use clap::{Args, Command, FromArgMatches};
use polyreel::options::Options;
use serde_json::{Map, Value, json};

use super::LookArgs;

/// A value for each flag, and what the field of the same name becomes. No value is a default or one of
/// the preset `paper`.
fn table() -> [(&'static str, &'static str, Value); 42] {
    [
        ("method", "hslp", json!("hslp")),
        ("points", "90", json!("90")),
        ("seed", "7", json!(7)),
        ("coherence", "0.75", json!(0.75)),
        ("quality", "best", json!("best")),
        ("refine", "9", json!(9)),
        ("error", "psnr:31", json!("psnr:31")),
        ("regularity", "0.25", json!(0.25)),
        ("smoothing", "4", json!(4)),
        ("clusters", "11", json!(11)),
        ("interval", "7", json!(7)),
        ("interior", "0.02", json!(0.02)),
        ("hex-density", "0.003", json!(0.003)),
        ("max-points", "6", json!(6)),
        ("default-points", "2", json!(2)),
        ("thresholds", "0.5,0.25,0.125", json!({"high": 0.5, "medium": 0.25, "low": 0.125})),
        ("features", "sobel", json!("sobel")),
        ("prefilter", "blur", json!("blur")),
        ("scatter", "0.125", json!(0.125)),
        ("candidates", "0.1", json!(0.1)),
        ("min-points", "3", json!(3)),
        ("percentiles", "80,30", json!({"high": 80.0, "medium": 30.0})),
        ("entropy-radius", "6", json!(6)),
        ("diffusion-iterations", "12", json!(12)),
        ("diffusion-kappa", "40", json!(40.0)),
        ("diffusion-gamma", "0.125", json!(0.125)),
        ("outline", "#102030", json!("#102030")),
        ("outline-width", "5", json!(5)),
        ("outline-contrast", "17", json!(17)),
        ("outline-opacity", "0.75", json!(0.75)),
        ("outline-tint", "0.25", json!(0.25)),
        ("saturation", "1.5", json!(1.5)),
        ("wash", "0.375", json!(0.375)),
        ("fill", "median", json!("median")),
        ("shape", "polygons", json!("polygons")),
        ("contrast", "1.5", json!(1.5)),
        ("chroma", "0.5", json!(0.5)),
        ("duotone", "#102030,white", json!("#102030,#ffffff")),
        ("palette", "12", json!("12")),
        ("min-facet", "6", json!(6)),
        ("max-facet", "20%", json!("20%")),
        ("focus", "50%,40%,20%", json!("50%,40%,20%")),
    ]
}

/// The one flag of two values: one of them is the default, the other that of `paper`.
const EDGES: &str = "edges";

/// Flags that are no field of the options.
const NO_FIELD: [&str; 2] = ["preset", "study"];

fn command() -> Command {
    LookArgs::augment_args(Command::new("polyreel"))
}

/// The options that `args` ask for, as JSON.
fn options(args: &[String]) -> Map<String, Value> {
    let args = std::iter::once("polyreel").chain(args.iter().map(String::as_str));
    let matches = command().try_get_matches_from(args).expect("flags that exist");
    let look = LookArgs::from_arg_matches(&matches).expect("values that are sound");
    json_of(&look.options().expect("options in range"))
}

fn json_of(options: &Options) -> Map<String, Value> {
    match serde_json::to_value(options) {
        Ok(Value::Object(fields)) => fields,
        other => panic!("options are an object: {other:?}"),
    }
}

/// Fails unless `--flag=value` changes `base` in the field of that name alone, to `wanted`.
fn check(base: &[String], flag: &str, value: &str, wanted: &Value) {
    let mut expected = options(base);
    assert_ne!(expected.get(flag), Some(wanted), "--{flag} {value} is what is there already");
    expected.insert(flag.into(), wanted.clone());
    if flag.starts_with("outline-") && expected["outline"].is_null() {
        // They mean nothing without an outline.
        expected.insert("outline".into(), json!("#000000"));
    }
    let found = options(&[base, &[format!("--{flag}={value}")]].concat());
    assert_eq!(found, expected, "--{flag} {value}");
}

#[test]
fn every_flag_sets_the_field_of_its_name_and_no_other() {
    for base in [vec![], vec!["--preset=paper".to_string()]] {
        for (flag, value, wanted) in table() {
            check(&base, flag, value, &wanted);
        }
    }
    check(&[], EDGES, "hard", &json!("hard"));
    check(&["--preset=paper".into()], EDGES, "smooth", &json!("smooth"));
}

#[test]
fn every_flag_and_every_field_is_in_the_table() {
    let mut listed: BTreeSet<String> = table().map(|(flag, ..)| flag.to_string()).into();
    listed.insert(EDGES.into());
    let mut fields: BTreeSet<String> = json_of(&Options::default()).keys().cloned().collect();
    // Later options are written only where they are asked for.
    for (flag, value, _) in table() {
        fields.extend(options(&[format!("--{flag}={value}")]).keys().cloned());
    }
    assert_eq!(listed, fields, "fields of the options");
    listed.extend(NO_FIELD.map(String::from));
    let command = command();
    let flags = command.get_arguments().filter_map(|arg| arg.get_long());
    let flags: BTreeSet<String> = flags.map(String::from).collect();
    assert_eq!(flags, listed, "flags of the command line");
}

/// Flags of the table that paint, and so have an effect on a mesh stream.
const PAINT: [&str; 11] = [
    "outline",
    "outline-width",
    "outline-contrast",
    "outline-opacity",
    "outline-tint",
    "saturation",
    "wash",
    "contrast",
    "chroma",
    "duotone",
    "palette",
];

#[test]
fn every_flag_that_decides_the_mesh_is_refused_for_a_mesh_stream() {
    for (flag, value, _) in table() {
        let args = ["polyreel".to_string(), format!("--{flag}={value}")];
        let matches = command().try_get_matches_from(args).expect("flags that exist");
        let look = LookArgs::from_arg_matches(&matches).expect("values that are sound");
        let painted = look.repaint(&Options::default());
        assert_eq!(painted.is_ok(), PAINT.contains(&flag), "{flag}: {painted:?}");
    }
}

#[test]
fn every_flag_refuses_what_is_no_value_of_it() {
    for (flag, ..) in table() {
        let refused = command()
            .try_get_matches_from(["polyreel".to_string(), format!("--{flag}=none-such")])
            .map_err(|error| error.to_string())
            .and_then(|matches| {
                LookArgs::from_arg_matches(&matches).map_err(|error| error.to_string())
            });
        let words = refused.expect_err(flag);
        assert!(words.contains(&format!("--{flag}")), "{words}");
    }
}

/// Flags that take the place of another one of the preset.
#[test]
fn a_number_of_points_replaces_the_grid_of_a_preset_and_quality_its_steps() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("mine.toml");
    std::fs::write(&file, "hex-density = 0.01\nrefine = 4\n").expect("a writable folder");
    let preset = format!("--preset={}", file.display());
    let own = options(std::slice::from_ref(&preset));
    assert_eq!((&own["hex-density"], &own["refine"]), (&json!(0.01), &json!(4)));
    let points = options(&[preset.clone(), "--points=50".into()]);
    assert_eq!((&points["hex-density"], &points["points"]), (&Value::Null, &json!("50")));
    let quality = options(&[preset, "--quality=best".into()]);
    assert_eq!((&quality["refine"], &quality["quality"]), (&Value::Null, &json!("best")));
}
