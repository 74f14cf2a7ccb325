//! The polyreel program.

use std::process::ExitCode;

/// A library leaves the choice of an allocator to the program: this is the program.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    polyreel::program::main()
}
