//! The polyreel program.
fn main() {}
