//! Changes the options by keys.

use polyreel::geom::Size;
use polyreel::options::{Colour, Edges, Length, Method, Options, Points, Quality};
use polyreel::refine::RefineOptions;

use super::keys::{Look, Way};

/// The factor of a change of the number of points: two presses are about half as many again.
const POINTS: f64 = 1.25;

/// A step of coherence, regularity and colour strength.
const TENTH: f64 = 0.1;

/// The numbers of refinement steps to choose from.
const REFINEMENT: [u32; 13] = [0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64];

/// `options` changed by `look`, for frames of `size`, and a note for the user. `outline` is the colour of a new
/// outline.
pub(super) fn changed(
    options: &Options,
    look: Look,
    size: Size,
    outline: Colour,
) -> (Options, String) {
    let mut options = options.clone();
    let note = match look {
        Look::Method(number) => {
            options.method = Method::ALL.get(number).copied().unwrap_or_default();
            format!("method {}", options.method.name())
        }
        Look::Points(way) => {
            let points = options.points.target(size) as f64;
            let wanted = if way == Way::Up { points * POINTS } else { points / POINTS };
            let most = u32::try_from(size.pixels() / 4).unwrap_or(u32::MAX).max(4);
            let count = (wanted.round() as u32).clamp(4, most);
            // A chosen number of points replaces the grid.
            options.hex_density = None;
            options.points = Points::Count(count);
            format!("{count} points")
        }
        Look::Coherence(way) => {
            options.coherence = stepped(options.coherence, tenth(way), 1.0);
            format!("coherence {}", options.coherence)
        }
        Look::Refinement(way) => {
            let steps = refined(RefineOptions::live_steps(&options, size), way);
            options.refine = Some(steps);
            // A target would replace the number of steps.
            options.error = None;
            format!("{steps} refinement steps a frame")
        }
        Look::Seed => {
            options.seed = options.seed.wrapping_add(1) % MOST_SEEDS;
            format!("seed {}", options.seed)
        }
        Look::Quality => {
            let at = Quality::ALL.iter().position(|&quality| quality == options.quality);
            options.quality = Quality::ALL[at.map_or(0, |at| (at + 1) % Quality::ALL.len())];
            // A number of steps or a target would replace it.
            (options.refine, options.error) = (None, None);
            format!("quality {}", options.quality.name())
        }
        Look::Regularity(way) => {
            options.regularity = stepped(options.regularity, tenth(way), 1.0);
            format!("regularity {}", options.regularity)
        }
        Look::Chroma(way) => {
            options.chroma = stepped(options.chroma, tenth(way), 4.0);
            format!("chroma {}", options.chroma)
        }
        Look::OutlineWidth(way) => {
            let (width, there) = (options.outline_width, options.outline.is_some());
            (options.outline, options.outline_width) = match way {
                Way::Up if !there => (Some(outline), width),
                Way::Up => (options.outline, wider(width, 1.0)),
                Way::Down if wider(width, -1.0) == width => (None, width),
                Way::Down => (options.outline, wider(width, -1.0)),
            };
            match options.outline {
                Some(_) => format!("outline width {}", options.outline_width),
                None => "outline off".to_owned(),
            }
        }
        Look::Outline => {
            options.outline = if options.outline.is_some() { None } else { Some(outline) };
            format!("outline {}", options.outline.map_or("off".to_owned(), |c| c.to_string()))
        }
        Look::Edges => {
            options.edges = match options.edges {
                Edges::Smooth => Edges::Hard,
                _ => Edges::Smooth,
            };
            format!("{} edges", options.edges.name())
        }
    };
    (options, note)
}

/// Seeds of keys stay below this number, so that preset files can hold them.
const MOST_SEEDS: u64 = 1 << 32;

fn tenth(way: Way) -> f64 {
    if way == Way::Up { TENTH } else { -TENTH }
}

/// `value` after a `step` of some tenths, 0 to `most`. Whole steps: 0.1 ten times over is 1.
fn stepped(value: f64, step: f64, most: f64) -> f64 {
    ((value + step) * 10.0).round().clamp(0.0, most * 10.0) / 10.0
}

/// A width that is `steps` pixels, or thousandths of the shorter side, wider; at least one.
fn wider(width: Length, steps: f64) -> Length {
    match width {
        Length::Pixels(pixels) => Length::Pixels((pixels + steps).clamp(1.0, 32.0)),
        Length::Share(share) => {
            Length::Share((1000.0 * share + steps).round().clamp(1.0, 30.0) / 1000.0)
        }
    }
}

fn refined(steps: u32, way: Way) -> u32 {
    let next = match way {
        Way::Up => REFINEMENT.into_iter().find(|&choice| choice > steps),
        Way::Down => REFINEMENT.into_iter().rev().find(|&choice| choice < steps),
    };
    next.unwrap_or(steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size::new(640, 360);
    const RED: Colour = Colour([255, 0, 0, 255]);

    fn press(options: &Options, look: Look) -> Options {
        let options = changed(options, look, SIZE, RED).0;
        options.validate().expect("keys keep options sound");
        options
    }

    #[test]
    fn each_key_changes_its_field_alone() {
        let base = Options { coherence: 0.5, ..Options::default() };
        assert_eq!(press(&base, Look::Method(2)), Options { method: Method::Hslp, ..base.clone() });
        assert_eq!(
            press(&base, Look::Coherence(Way::Up)),
            Options { coherence: 0.6, ..base.clone() }
        );
        let outlined = press(&base, Look::Outline);
        assert_eq!(outlined, Options { outline: Some(RED), ..base.clone() });
        assert_eq!(press(&outlined, Look::Outline), base);
        let hard = press(&base, Look::Edges);
        assert_eq!(hard, Options { edges: Edges::Hard, ..base.clone() });
        assert_eq!(press(&hard, Look::Edges), base);
        let refined = press(&base, Look::Refinement(Way::Up));
        assert_eq!(refined, Options { refine: Some(12), ..base.clone() });
        let points = (base.points.target(SIZE) as f64 * POINTS).round() as u32;
        let points = Points::Count(points);
        assert_eq!(press(&base, Look::Points(Way::Up)), Options { points, ..base });
    }

    #[test]
    fn keys_stop_at_the_ends_of_the_ranges() {
        for way in [Way::Up, Way::Down] {
            for look in [Look::Points(way), Look::Coherence(way), Look::Refinement(way)] {
                let mut options = Options::default();
                for _ in 0..60 {
                    options = press(&options, look);
                }
                assert_eq!(press(&options, look), options, "{look:?}");
            }
        }
    }

    #[test]
    fn a_target_gives_way_to_keys() {
        let error = Some(polyreel::options::Target::Psnr(30.0));
        let auto = Options { points: Points::Auto, error, ..Options::default() };
        press(&auto, Look::Refinement(Way::Down));
        press(&auto, Look::Points(Way::Down));
    }
}
