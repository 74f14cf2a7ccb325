//! The polyreel program: parses, runs, and says how it went. It is a module of the library, so that the Python
//! package has the same commands and options ([`embed`]); `src/bin/polyreel.rs` only calls [`main`].
//!
//! Exit codes: 0 done, 1 failed, 2 usage, 130 stopped by Ctrl-C.

mod advice;
mod amount;
mod batch;
mod budget;
mod cli;
mod convergence;
mod crash;
pub mod embed;
mod evaluate;
mod film;
mod info;
mod inspect;
mod interrupt;
mod letters;
mod look;
mod looks;
mod manual;
mod npy;
mod parse;
mod plot;
mod presets;
#[cfg(feature = "preview")]
mod preview;
#[cfg(not(feature = "preview"))]
#[path = "no_preview.rs"]
mod preview;
mod progress;
mod record;
mod remark;
mod render;
mod repaint;
mod scores;
mod suggest;
mod terminal;

use std::ffi::OsString;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use polyreel::error::{Error, Result};

use cli::Command;

/// How a command ended that did not fail.
enum Outcome {
    /// As was asked.
    Done,
    /// Early, by Ctrl-C.
    Interrupted,
}

/// Whether this process is the program, and not another one that the program is a part of.
static IS_PROGRAM: AtomicBool = AtomicBool::new(false);

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    IS_PROGRAM.store(true, Ordering::Relaxed);
    ExitCode::from(main_of(std::env::args_os()))
}

/// A command that runs the program: this process's own, or Python's with the package.
///
/// # Errors
/// When the path of this program cannot be found.
fn itself() -> std::io::Result<std::process::Command> {
    let mut command = std::process::Command::new(std::env::current_exe()?);
    if !IS_PROGRAM.load(Ordering::Relaxed) {
        command.args(["-m", "polyreel"]);
    }
    Ok(command)
}

/// Runs the command line `arguments`, the program's name first, and returns the exit code. What signals and panics
/// do in this process is changed.
pub fn main_of(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    interrupt::survive_limits();
    // A wrong command line ends here, with exit code 2.
    let cli = parse::parse(arguments).unwrap_or_else(|error| refuse(&error));
    let ended = crash::catch(|| run(cli.command));
    interrupt::let_it_end();
    match ended {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::Interrupted) => 130,
        Err(error) => {
            report(&error);
            if error.is_usage() { 2 } else { 1 }
        }
    }
}

fn run(command: Command) -> Result<Outcome> {
    match command {
        Command::Render(args) => render::render(&args),
        Command::Plan(args) => film::plan(&args),
        Command::Join(args) => film::join(&args),
        Command::Preview(args) => preview::preview(&args),
        Command::Looks(args) => looks::looks(&args),
        Command::Evaluate(args) => evaluate::evaluate(&args.settled()),
        Command::Inspect(args) => inspect::inspect(&args),
        Command::Info(args) => info::info(&args),
        Command::Presets { name } => presets::presets(name.as_deref()),
        Command::Completions { shell } => manual::completions(shell),
        Command::Man { command } => manual::man(command.as_deref()),
    }
}

/// Ends the program with clap's message about the command line, or with the help that was asked for.
fn refuse(error: &clap::Error) -> ! {
    let text = error.to_string();
    let escaped = text.split('\n').map(terminal::escape).collect::<Vec<_>>().join("\n");
    if escaped == text {
        error.exit();
    }
    // Styled text cannot be escaped: what styles it looks the same as what has to be.
    terminal::say_lines(&escaped);
    std::process::exit(error.exit_code());
}

/// Says the error with all that led to it. A cause that the message before spelt out is not repeated.
fn report(error: &Error) {
    let mut said = in_one_line(error);
    terminal::say(format_args!("error: {said}"));
    let mut cause = std::error::Error::source(error);
    while let Some(error) = cause {
        let text = in_one_line(error);
        // Messages spell the system's errors out.
        if !said.contains(&text) && !error.is::<std::io::Error>() {
            terminal::say(format_args!("because: {text}"));
            said = text;
        }
        cause = error.source();
    }
}

/// An error's message without the line breaks that some libraries have in theirs.
fn in_one_line(error: &dyn std::error::Error) -> String {
    let text = error.to_string();
    text.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Writes `text` to standard output. A reader who has gone had enough.
fn print(text: &[u8]) -> Result<Outcome> {
    use std::io::{ErrorKind, Write};
    let mut out = std::io::stdout().lock();
    match out.write_all(text).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::output("-", error.to_string()).caused_by(error))
        }
        _ => Ok(Outcome::Done),
    }
}
