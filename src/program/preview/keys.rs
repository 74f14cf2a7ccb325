//! The meaning of keys. Keys are known by the characters that they type, so that all keyboard layouts have them.

/// The character of the key Esc.
pub(super) const ESCAPE: char = '\u{1b}';

/// A key that was pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stroke {
    /// One that types a character.
    Char(char),
    /// The arrow to the left.
    Left,
    /// The arrow to the right.
    Right,
    /// The eleventh function key.
    F11,
}

/// Less or more of something, back or on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// Less, or back.
    Down,
    /// More, or on.
    Up,
}

/// The action of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    Help,
    Pause,
    Step,
    Seek(Way),
    Save,
    Record,
    Export,
    WritePreset,
    Quit,
    Split,
    Overlay,
    /// Shows or hides times and counts.
    Figures,
    /// Shows or hides the bar below the picture.
    Bar,
    /// Fills the screen with the window, or ends that.
    FullScreen,
    /// Shows the whole picture again.
    Fit,
    /// A change of an option.
    Look(Look),
    /// The next or previous preset.
    Preset(Way),
    /// Another look of those that were there before.
    Recall(Recall),
}

/// The option that a key changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Look {
    /// The method of this number, from 0.
    Method(usize),
    Points(Way),
    Seed,
    Quality,
    Coherence(Way),
    Refinement(Way),
    Regularity(Way),
    Chroma(Way),
    Outline,
    OutlineWidth(Way),
    Edges,
}

/// Which look comes back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Recall {
    /// The one before the last change.
    Undo,
    /// The one before the last preset, and back again.
    Compare,
    /// That of the command line.
    Reset,
}

impl Action {
    /// Whether it repeats while the key is held down.
    pub(super) fn repeats(self) -> bool {
        match self {
            Self::Step | Self::Seek(_) => true,
            Self::Look(look) => matches!(
                look,
                Look::Points(_)
                    | Look::Coherence(_)
                    | Look::Refinement(_)
                    | Look::Regularity(_)
                    | Look::Chroma(_)
            ),
            _ => false,
        }
    }

    /// Whether it changes only the window, not the rendering.
    pub(super) fn only_looks(self) -> bool {
        matches!(
            self,
            Self::Help
                | Self::Save
                | Self::Quit
                | Self::Split
                | Self::Overlay
                | Self::Figures
                | Self::Bar
                | Self::FullScreen
                | Self::Fit
        )
    }
}

/// The action of `stroke`.
pub(super) fn action(stroke: Stroke) -> Option<Action> {
    let key = match stroke {
        Stroke::Left => return Some(Action::Seek(Way::Down)),
        Stroke::Right => return Some(Action::Seek(Way::Up)),
        Stroke::F11 => return Some(Action::FullScreen),
        Stroke::Char(key) => key,
    };
    // Shift turns more into less.
    let way = if key.is_uppercase() { Way::Down } else { Way::Up };
    Some(match key.to_ascii_lowercase() {
        'h' | '?' => Action::Help,
        ' ' => Action::Pause,
        '.' => Action::Step,
        'p' => Action::Save,
        'r' => Action::Record,
        'x' => Action::Export,
        'w' => Action::WritePreset,
        'q' | ESCAPE => Action::Quit,
        's' => Action::Split,
        'g' => Action::Overlay,
        't' => Action::Figures,
        'm' => Action::Bar,
        'f' => Action::FullScreen,
        'z' => Action::Fit,
        'u' => Action::Recall(Recall::Undo),
        'a' => Action::Recall(Recall::Compare),
        '0' => Action::Recall(Recall::Reset),
        'n' => Action::Preset(way),
        'b' => Action::Preset(Way::Down),
        'd' => Action::Look(Look::Seed),
        'i' => Action::Look(Look::Quality),
        'v' => Action::Look(Look::Chroma(way)),
        'y' => Action::Look(Look::Regularity(way)),
        'o' => Action::Look(Look::Outline),
        'l' => Action::Look(Look::OutlineWidth(way)),
        'e' => Action::Look(Look::Edges),
        // The key of the plus sign types an equals sign where Shift is needed for it.
        '+' | '=' => Action::Look(Look::Points(Way::Up)),
        '-' | '_' => Action::Look(Look::Points(Way::Down)),
        ']' => Action::Look(Look::Coherence(Way::Up)),
        '[' => Action::Look(Look::Coherence(Way::Down)),
        ';' => Action::Look(Look::Refinement(Way::Up)),
        ',' => Action::Look(Look::Refinement(Way::Down)),
        digit @ '1'..='9' => Action::Look(Look::Method(digit as usize - '1' as usize)),
        _ => return None,
    })
}

/// The keys and what they do, a line each, in two columns.
pub(super) const HELP: [&[(&str, &str)]; 2] = [
    &[
        ("n b", "next, previous preset"),
        ("- +", "fewer, more points"),
        ("d", "another seed"),
        ("v V", "stronger, paler colours"),
        ("y Y", "more, less regular facets"),
        ("o", "outline"),
        ("l L", "wider, finer outline"),
        ("e", "smooth or hard edges"),
        ("i", "quality: the next"),
        (", ;", "fewer, more steps of refinement"),
        ("[ ]", "less, more coherence from frame to frame"),
        ("1 ... 9", "method: hrlp help hslp rlp entropy pic2polyart ranked thinning stippling"),
        ("u", "undo"),
        ("a", "this look or the one before"),
        ("0", "the first look"),
    ],
    &[
        ("x", "export the whole with this look"),
        ("w", "write this look as a preset"),
        ("p", "save this picture"),
        ("r", "start, stop recording"),
        ("space", "pause, go on"),
        (".", "one frame further"),
        ("left right", "back, on; or click the timeline"),
        ("s", "side by side with the source"),
        ("z", "the whole picture; the wheel zooms"),
        ("g", "seeds and grid"),
        ("t", "times and counts"),
        ("m", "hide this bar"),
        ("f F11", "full screen; Esc ends it"),
        ("h", "this help"),
        ("q Esc", "quit"),
    ],
];

#[cfg(test)]
mod tests {
    use super::*;
    use polyreel::options::Method;

    #[test]
    fn every_key_of_the_help_does_something() {
        for (keys, _) in HELP.iter().copied().flatten() {
            for key in keys.split(' ') {
                let stroke = match key {
                    "space" => Stroke::Char(' '),
                    "left" => Stroke::Left,
                    "right" => Stroke::Right,
                    "Esc" => Stroke::Char(ESCAPE),
                    "F11" => Stroke::F11,
                    "..." => continue,
                    key => Stroke::Char(key.chars().next().expect("a character")),
                };
                assert!(action(stroke).is_some(), "{key}");
            }
        }
        assert_eq!(action(Stroke::Char('k')), None);
    }

    #[test]
    fn the_help_names_the_methods_in_their_order() {
        let mut lines = HELP.iter().copied().flatten();
        let text = lines.find(|(keys, _)| *keys == "1 ... 9").expect("methods").1;
        let names: Vec<_> = Method::ALL.iter().map(|method| method.name()).collect();
        assert_eq!(text, format!("method: {}", names.join(" ")));
    }

    #[test]
    fn plus_needs_no_shift_and_shift_means_less() {
        assert_eq!(action(Stroke::Char('=')), action(Stroke::Char('+')));
        assert_eq!(action(Stroke::Char('G')), Some(Action::Overlay));
        assert_eq!(action(Stroke::Char('V')), Some(Action::Look(Look::Chroma(Way::Down))));
        assert_eq!(action(Stroke::Char('N')), action(Stroke::Char('b')));
    }

    #[test]
    fn only_what_has_degrees_repeats() {
        assert!(Action::Look(Look::Points(Way::Up)).repeats());
        assert!(!Action::Pause.repeats() && !Action::Record.repeats() && !Action::Save.repeats());
        assert!(!Action::Look(Look::Seed).repeats());
    }
}
