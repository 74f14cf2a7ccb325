//! The meaning of keys. Keys are known by the characters that they type, so that all keyboard layouts have them.

/// A key that was pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stroke {
    /// One that types a character.
    Char(char),
    /// The arrow to the left.
    Left,
    /// The arrow to the right.
    Right,
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
    WritePreset,
    Quit,
    Split,
    Overlay,
    /// A change of the options.
    Look(Look),
}

/// The option that a key changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Look {
    /// The method of this number, from 0.
    Method(usize),
    Points(Way),
    Coherence(Way),
    Refinement(Way),
    Outline,
    Edges,
}

impl Action {
    /// Whether it repeats while the key is held down.
    pub(super) fn repeats(self) -> bool {
        matches!(
            self,
            Self::Step
                | Self::Seek(_)
                | Self::Look(Look::Points(_) | Look::Coherence(_) | Look::Refinement(_))
        )
    }

    /// Whether it changes only the window, not the rendering.
    pub(super) fn only_looks(self) -> bool {
        matches!(self, Self::Help | Self::Save | Self::Quit | Self::Split | Self::Overlay)
    }
}

/// The action of `stroke`.
pub(super) fn action(stroke: Stroke) -> Option<Action> {
    let key = match stroke {
        Stroke::Left => return Some(Action::Seek(Way::Down)),
        Stroke::Right => return Some(Action::Seek(Way::Up)),
        Stroke::Char(key) => key,
    };
    Some(match key.to_ascii_lowercase() {
        'h' | '?' => Action::Help,
        ' ' => Action::Pause,
        '.' => Action::Step,
        'p' => Action::Save,
        'r' => Action::Record,
        'w' => Action::WritePreset,
        'q' | '\u{1b}' => Action::Quit,
        's' => Action::Split,
        'g' => Action::Overlay,
        'o' => Action::Look(Look::Outline),
        'e' => Action::Look(Look::Edges),
        // The key of the plus sign types an equals sign where Shift is needed for it.
        '+' | '=' => Action::Look(Look::Points(Way::Up)),
        '-' | '_' => Action::Look(Look::Points(Way::Down)),
        ']' => Action::Look(Look::Coherence(Way::Up)),
        '[' => Action::Look(Look::Coherence(Way::Down)),
        ';' => Action::Look(Look::Refinement(Way::Up)),
        ',' => Action::Look(Look::Refinement(Way::Down)),
        digit @ '1'..='6' => Action::Look(Look::Method(digit as usize - '1' as usize)),
        _ => return None,
    })
}

/// The keys and what they do, a line each.
pub(super) const HELP: [(&str, &str); 16] = [
    ("h", "this help"),
    ("space", "pause, go on"),
    (".", "one frame further"),
    ("left right", "back, on: 5 s, or a tenth of a short clip"),
    ("1 ... 6", "method: hrlp help hslp rlp entropy pic2polyart"),
    ("- +", "fewer, more points"),
    ("[ ]", "less, more coherence from frame to frame"),
    (", ;", "less, more refinement"),
    ("o", "outline"),
    ("e", "smooth or hard edges"),
    ("s", "side by side with the source; drag the slider"),
    ("g", "seeds and grid"),
    ("p", "save this picture (PNG)"),
    ("r", "start, stop recording"),
    ("w", "write these settings as a preset"),
    ("q Esc", "quit"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use polyreel::options::Method;

    #[test]
    fn every_key_of_the_help_does_something() {
        for (keys, _) in HELP {
            for key in keys.split(' ') {
                let stroke = match key {
                    "space" => Stroke::Char(' '),
                    "left" => Stroke::Left,
                    "right" => Stroke::Right,
                    "Esc" => Stroke::Char('\u{1b}'),
                    "..." => continue,
                    key => Stroke::Char(key.chars().next().expect("a character")),
                };
                assert!(action(stroke).is_some(), "{key}");
            }
        }
        assert_eq!(action(Stroke::Char('x')), None);
        assert_eq!(action(Stroke::Char('7')), None);
    }

    #[test]
    fn the_help_names_the_methods_in_their_order() {
        let (_, text) = HELP[4];
        let names: Vec<_> = Method::ALL.iter().map(|method| method.name()).collect();
        assert_eq!(text, format!("method: {}", names.join(" ")));
    }

    #[test]
    fn plus_needs_no_shift_and_capitals_count() {
        assert_eq!(action(Stroke::Char('=')), action(Stroke::Char('+')));
        assert_eq!(action(Stroke::Char('G')), Some(Action::Overlay));
    }

    #[test]
    fn only_what_has_degrees_repeats() {
        assert!(Action::Look(Look::Points(Way::Up)).repeats());
        assert!(!Action::Pause.repeats() && !Action::Record.repeats() && !Action::Save.repeats());
    }
}
