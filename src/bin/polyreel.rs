//! The polyreel program.

use std::process::ExitCode;

/// Measured: `cargo bench -p polyreel-bench --bench huge_pages`.
#[cfg(target_os = "linux")]
#[global_allocator]
static MEMORY: polyreel_huge_pages::HugePages = polyreel_huge_pages::HugePages;

fn main() -> ExitCode {
    polyreel::program::main()
}
