//! What is compared, and with which options.

use polyreel::options::{Method, Options, PRESETS, Points, Preset, Quality, STUDIES};
use polyreel::refine::RefineOptions;
use serde::Serialize;

/// What is compared with its like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Kind {
    /// Methods, with all other options the same.
    Methods,
    /// Earlier systems and the paper's own, at the same number of points.
    Studies,
    /// Presets, each with its own number of points and its own colours.
    Presets,
}

impl Kind {
    /// What one of them is called.
    pub(crate) const fn noun(self) -> &'static str {
        match self {
            Self::Methods => "method",
            Self::Studies => "study",
            Self::Presets => "preset",
        }
    }
}

/// A method, study or preset.
#[derive(Clone, Debug)]
pub(crate) struct Subject {
    pub(crate) name: String,
    /// As it is published, or as it is.
    plain: Options,
    /// With refinement after it.
    refined: Option<Options>,
}

/// As its name.
impl Serialize for Subject {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.name)
    }
}

/// A subject, without or with refinement after it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Variant<'a> {
    pub(crate) subject: &'a Subject,
    pub(crate) refined: bool,
}

impl Variant<'_> {
    /// The options that it renders with.
    pub(crate) fn options(&self) -> &Options {
        let refined = self.subject.refined.as_ref().filter(|_| self.refined);
        refined.unwrap_or(&self.subject.plain)
    }
}

impl std::fmt::Display for Variant<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&name(&self.subject.name, self.refined))
    }
}

/// What a subject is called, without or with refinement.
pub(crate) fn name(subject: &str, refined: bool) -> String {
    if refined { format!("{subject}, refined") } else { subject.to_owned() }
}

/// What is evaluated.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct Plan {
    /// What the subjects are.
    pub(crate) kind: Kind,
    /// The options that all have in common.
    pub(crate) options: Options,
    /// The subjects, in the order of the tables.
    #[serde(rename = "methods")]
    pub(crate) subjects: Vec<Subject>,
    /// Whether stills are rendered disturbed as well, which takes four more renders a subject.
    pub(crate) robustness: bool,
}

impl Plan {
    /// Compares `methods`: without refinement, as in the paper, and with it if `options` ask for any.
    pub(crate) fn of_methods(options: Options, methods: &[Method], robustness: bool) -> Self {
        let refines = RefineOptions::fresh(&options).steps > 0;
        let subject = |&method: &Method| {
            // An outline is drawn over the picture and would be counted as error.
            let refined = Options { method, outline: None, ..options.clone() };
            let plain = unrefined(&refined);
            let name = method.name().to_owned();
            Subject { name, plain, refined: refines.then_some(refined) }
        };
        let subjects = methods.iter().map(subject).collect();
        Self { kind: Kind::Methods, options, subjects, robustness }
    }

    /// Compares studies, or the one called `only`, all with `points`: as they are published, and refined as `options`
    /// say.
    pub(crate) fn of_studies(
        options: Options,
        points: Points,
        only: Option<&str>,
        robustness: bool,
    ) -> Self {
        let refines = RefineOptions::fresh(&options).steps > 0;
        let options = Options { points, ..options };
        let subject = |study: &Preset| {
            let own = Options::study(study.name).unwrap_or_default().ungraded();
            let plain = Options { points, seed: options.seed, error: None, outline: None, ..own };
            let Options { quality, refine, regularity, edges, .. } = options;
            let refined = Options { quality, refine, regularity, edges, ..plain.clone() };
            Subject { name: study.name.to_owned(), plain, refined: refines.then_some(refined) }
        };
        let chosen = STUDIES.iter().filter(|study| only.is_none_or(|only| only == study.name));
        let subjects = chosen.map(subject).collect();
        Self { kind: Kind::Studies, options, subjects, robustness }
    }

    /// Compares all presets as they are.
    pub(crate) fn of_presets(options: Options, robustness: bool) -> Self {
        let subject = |preset: &Preset| {
            let own = Options::preset(preset.name).unwrap_or_default();
            let plain = Options { seed: options.seed, ..own };
            Subject { name: preset.name.to_owned(), plain, refined: None }
        };
        let subjects = PRESETS.iter().map(subject).collect();
        Self { kind: Kind::Presets, options, subjects, robustness }
    }

    /// Whether subjects are refined as well.
    pub(crate) fn refines(&self) -> bool {
        self.subjects.iter().any(|subject| subject.refined.is_some())
    }

    /// The names of the subjects.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.subjects.iter().map(|subject| subject.name.as_str())
    }

    /// All variants: all subjects without refinement, then, if any, with it.
    pub(crate) fn variants(&self) -> impl Iterator<Item = Variant<'_>> {
        let refined = if self.refines() { &[false, true][..] } else { &[false] };
        let all = |&refined| self.subjects.iter().map(move |subject| Variant { subject, refined });
        refined.iter().flat_map(all)
    }
}

fn unrefined(options: &Options) -> Options {
    Options { quality: Quality::Draft, refine: None, error: None, ..options.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn studies_have_the_same_points_and_their_own_colours_only() {
        let points = Points::Count(300);
        let plan = Plan::of_studies(Options::default(), points, None, false);
        assert_eq!(plan.variants().count(), 2 * STUDIES.len());
        for variant in plan.variants() {
            let options = variant.options();
            options.validate().expect("sound");
            assert_eq!((options.points, options.contrast, options.outline), (points, 1.0, None));
            assert_eq!(options.error, None);
        }
        let one = Plan::of_studies(Options::paper(), points, Some("hslp"), false);
        assert_eq!(one.names().collect::<Vec<_>>(), ["hslp"]);
        assert!(!one.refines(), "the paper has no refinement");
    }

    #[test]
    fn presets_are_as_they_are() {
        let plan = Plan::of_presets(Options::default(), false);
        let names: Vec<_> = plan.names().collect();
        assert_eq!(names, PRESETS.map(|preset| preset.name));
        let all = plan.variants().zip(&PRESETS);
        all.for_each(|(v, p)| assert_eq!(*v.options(), Options::preset(p.name).expect(p.name)));
    }
}
