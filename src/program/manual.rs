//! Completions and manual pages, from the same definitions as the command line.

use clap::{Command, CommandFactory};
use polyreel::error::{Error, Result};
use polyreel::options::{PRESETS, STUDIES};

use crate::program::cli::Cli;
use crate::program::{Outcome, print};

/// Prints the completion script for `shell`.
pub(crate) fn completions(shell: clap_complete::Shell) -> Result<Outcome> {
    let mut script = Vec::new();
    let mut command = Cli::command().mut_subcommands(with_presets);
    clap_complete::generate(shell, &mut command, "polyreel", &mut script);
    print(&script)
}

/// `command` with the names of presets and studies as the values that shells offer.
fn with_presets(command: Command) -> Command {
    let lists = command.get_name() == "presets";
    command.mut_args(|arg| match arg.get_id().as_str() {
        "preset" => arg.value_parser(PRESETS.map(|preset| preset.name)),
        "study" => arg.value_parser(STUDIES.map(|study| study.name)),
        "name" if lists => arg.value_parser(PRESETS.map(|preset| preset.name)),
        _ => arg,
    })
}

/// Prints the manual page of the program, or of `command`.
pub(crate) fn man(command: Option<&str>) -> Result<Outcome> {
    let mut program = Cli::command();
    program.build();
    let subject = match command {
        None => program,
        Some(name) => {
            let found = program.find_subcommand(name);
            found.ok_or_else(|| Error::usage(format!("there is no command '{name}'")))?.clone()
        }
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(subject)
        .render(&mut page)
        .map_err(|error| Error::output("-", error.to_string()).caused_by(error))?;
    print(&page)
}
