//! The polyreel program.

use std::process::ExitCode;

fn main() -> ExitCode {
    polyreel::program::main()
}
