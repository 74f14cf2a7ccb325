//! Tasks of development, `cargo xtask NAME`: packing a release, installing the plug-in, and measuring constants again.

mod corpus;
mod dist;
mod install;
mod measure;
mod run;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

const HELP: &str = "\
cargo xtask dist [linux] [windows]   pack the program, completions, man pages and licences (both systems)
cargo xtask install-frei0r [FOLDER]  build the frei0r plug-in and install it for this user (~/.frei0r-1/lib)
cargo xtask measure                  list the constants that can be measured
cargo xtask measure NAME [--frames N] [--clips WORD]
                                     measure one again, on the clips whose names contain WORD
cargo xtask corpus                   fetch or make the clips, and print where they are";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let done = match args[..] {
        ["dist", ref systems @ ..] => dist::dist(systems),
        ["install-frei0r"] => install::frei0r(None),
        ["install-frei0r", folder] => install::frei0r(Some(folder)),
        ["measure"] => measure::list(),
        ["measure", name, ref options @ ..] => measure::measure(name, options),
        ["corpus"] => corpus::print(),
        _ => {
            eprintln!("{HELP}");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// The folder of the workspace.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}

/// Where builds go: as Cargo has it.
fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}
