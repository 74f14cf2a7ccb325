//! The looks that were chosen: the current one, and those that can come back.

use polyreel::options::{Options, PRESETS};

use super::keys::{Recall, Way};

/// The number of changes that can be undone.
const DEEPEST: usize = 200;

/// A look, and the preset that it began with.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chosen {
    pub(super) options: Options,
    /// A number in [`PRESETS`].
    preset: Option<usize>,
}

impl Chosen {
    /// A look of the command line.
    fn new(options: Options) -> Self {
        let preset = PRESETS
            .iter()
            .position(|preset| Options::preset(preset.name).is_ok_and(|preset| preset == options));
        Self { options, preset }
    }

    /// `crystal`, and `crystal *` where it was changed; `None` for the user's own look.
    pub(super) fn name(&self) -> Option<String> {
        let name = PRESETS[self.preset?].name;
        let is_changed = Options::preset(name).ok().as_ref() != Some(&self.options);
        Some(if is_changed { format!("{name} *") } else { name.to_owned() })
    }
}

/// See the [module](self).
#[derive(Clone, Debug)]
pub(super) struct History {
    now: Chosen,
    first: Chosen,
    before: Vec<Chosen>,
    /// The look to compare with: the one before the last preset or reset, or else before the first change.
    other: Option<Chosen>,
}

impl History {
    /// Begins with the look of the command line.
    pub(super) fn new(options: Options) -> Self {
        let first = Chosen::new(options);
        Self { now: first.clone(), first, before: Vec::new(), other: None }
    }

    /// The current look.
    pub(super) fn now(&self) -> &Chosen {
        &self.now
    }

    /// Changes an option.
    pub(super) fn change(&mut self, options: Options) {
        if options == self.now.options {
            return;
        }
        if self.other.is_none() {
            self.other = Some(self.now.clone());
        }
        self.push(Chosen { options, ..self.now.clone() });
    }

    /// Takes the next or previous preset. Its coherence and seed are those of the command line.
    pub(super) fn step_preset(&mut self, way: Way) -> &Chosen {
        let count = PRESETS.len();
        let next = match (self.now.preset, way) {
            (None, Way::Up) => 0,
            (None, Way::Down) => count - 1,
            (Some(at), Way::Up) => (at + 1) % count,
            (Some(at), Way::Down) => (at + count - 1) % count,
        };
        let options = Options::preset(PRESETS[next].name).unwrap_or_default();
        self.other = Some(self.now.clone());
        self.push(Chosen { options, preset: Some(next) });
        &self.now
    }

    /// Brings a look back; `None` where there is none.
    pub(super) fn recall(&mut self, recall: Recall) -> Option<&Chosen> {
        match recall {
            Recall::Undo => self.now = self.before.pop()?,
            Recall::Compare => {
                let other = self.other.take()?;
                self.other = Some(self.now.clone());
                self.push(other);
            }
            Recall::Reset => {
                let first = Some(self.first.clone()).filter(|first| *first != self.now)?;
                self.other = Some(self.now.clone());
                self.push(first);
            }
        }
        Some(&self.now)
    }

    fn push(&mut self, chosen: Chosen) {
        if self.before.len() == DEEPEST {
            self.before.remove(0);
        }
        self.before.push(std::mem::replace(&mut self.now, chosen));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_seed(seed: u64) -> Options {
        Options { seed, ..Options::default() }
    }

    #[test]
    fn changes_are_undone_one_by_one() {
        let mut history = History::new(Options::default());
        assert_eq!(history.recall(Recall::Undo), None);
        (1..4).for_each(|seed| history.change(with_seed(seed)));
        history.change(with_seed(3));
        for seed in [2, 1, 0] {
            assert_eq!(history.recall(Recall::Undo).map(|look| look.options.seed), Some(seed));
        }
        assert_eq!(history.recall(Recall::Undo), None);
    }

    #[test]
    fn two_looks_are_compared() {
        let mut history = History::new(with_seed(7));
        assert_eq!(history.recall(Recall::Compare), None);
        let crystal = loop {
            let chosen = history.step_preset(Way::Up).clone();
            if chosen.name().as_deref() == Some("crystal") {
                break chosen;
            }
        };
        let bold = history.step_preset(Way::Up).clone();
        assert_eq!(history.recall(Recall::Compare), Some(&crystal));
        assert_eq!(history.recall(Recall::Compare), Some(&bold));
        assert_eq!(history.recall(Recall::Reset).map(|look| look.options.seed), Some(7));
        assert_eq!(history.recall(Recall::Compare), Some(&bold));
    }

    #[test]
    fn presets_go_round_and_say_when_they_were_changed() {
        let mut history =
            History::new(Options { points: "17".parse().expect("a count"), ..Options::default() });
        assert_eq!(history.now().name(), None);
        let first = history.step_preset(Way::Up).clone();
        (0..PRESETS.len()).for_each(|_| drop(history.step_preset(Way::Up).clone()));
        assert_eq!(history.now(), &first);
        let options = Options { seed: 99, ..first.options.clone() };
        history.change(options);
        assert_eq!(history.now().name(), Some(format!("{} *", PRESETS[0].name)));
    }
}
