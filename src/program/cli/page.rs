//! `-h` on one page: the options that most users need, in a line each. `--help` has all of them, at length.

use clap::{Arg, Command};

/// Commands whose `-h` shows only the options in [`PAGE`]: they have many more.
const LONG: [&str; 4] = ["render", "preview", "inspect", "evaluate"];

/// The options on the page, and their lines.
const PAGE: [(&str, &str); 27] = [
    ("output", "What to write: out.png, out.gif, out.mp4, out/ for pictures, - for y4m"),
    ("overwrite", "Replace an output that is there already"),
    ("batch", "Each input by itself, to a folder; names stay"),
    ("start", "Leave out what comes before TIME: 1.5, 500ms, 1:30"),
    ("end", "Leave out what comes at TIME or later"),
    ("fps", "Frames per second of a sequence of pictures [default: 25]"),
    ("max-size", "Shrink the input until its longest side has at most PX pixels"),
    ("scale", "Draw at S times the size, crisp"),
    ("crf", "Quality of video, smaller is better"),
    ("preset", "A look by its name (polyreel presets lists them), or from a file"),
    ("points", "How many: a count (800), a share of the pixels (1.5%), or auto"),
    ("quality", "How much work goes into it"),
    ("seed", "Another picture by chance"),
    ("coherence", "How firmly frames hold together, 0 to 1 (least flicker)"),
    ("regularity", "How well-shaped triangles are, 0 to 1"),
    ("outline", "Draw lines between triangles, black or COLOUR (gold, #802040)"),
    ("outline-width", "How wide: pixels, or a share (0.3%)"),
    ("saturation", "How strong colours are, 0 (grey) to 4"),
    ("fill", "Colours of triangles: flat, or otherwise"),
    ("shape", "Triangles, panes of like colour, or cells"),
    ("palette", "So many colours, or these: 12, #102030,gold,white, or a file"),
    ("focus", "Where more points go: faces, saliency, X,Y,R or a mask picture"),
    ("loop", "Let the end lead into the beginning"),
    ("budget", "Time for each frame: 33ms, 0.5s, or auto"),
    ("preview", "Show the render in a window as it goes"),
    ("html", "Write one page with pictures, plots and tables"),
    ("quiet", "Say nothing unless something is wrong"),
];

/// `command` with a short `-h`. Its options also take negative numbers as values, so that those are refused by the
/// option's name.
pub(crate) fn paged(command: Command) -> Command {
    command.mut_subcommands(|command| {
        let is_long = LONG.contains(&command.get_name());
        command.mut_args(|arg| if is_long { on_page(signed(arg)) } else { signed(arg) })
    })
}

fn signed(arg: Arg) -> Arg {
    let has_value = arg.get_action().takes_values() && !arg.is_positional();
    if has_value { arg.allow_negative_numbers(true) } else { arg }
}

fn on_page(arg: Arg) -> Arg {
    // The size of the window is not that of a picture.
    if arg.is_positional() || arg.get_help_heading() == Some("Window") {
        return arg;
    }
    let name = arg.get_long();
    let Some((_, line)) = PAGE.iter().find(|(listed, _)| name == Some(*listed)) else {
        return arg.hide_short_help(true);
    };
    let long = arg.get_long_help().or(arg.get_help()).cloned().unwrap_or_default();
    arg.help(*line).long_help(long)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::cli::Cli;
    use clap::CommandFactory;

    #[test]
    fn every_line_is_of_an_option() {
        let program = Cli::command();
        let options: Vec<&str> = program
            .get_subcommands()
            .filter(|command| LONG.contains(&command.get_name()))
            .flat_map(|command| command.get_arguments().filter_map(Arg::get_long))
            .collect();
        for (name, _) in PAGE {
            assert!(options.contains(&name), "{name}");
        }
        paged(program).debug_assert();
    }
}
