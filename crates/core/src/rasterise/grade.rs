//! Colours as they are shown: contrast and strength as the eye has them, two tones, a palette.

use crate::parallel::prelude::*;

use crate::feature::lab;
use crate::frame::{Fill, Rgba, luma};
use crate::geom::orient;
use crate::mesh::Mesh;
use crate::options::{Duotone, FillMode, Options, Palette};

/// Colours that are one piece of work.
const PACK: usize = 1024;

/// Colours as strong as that do not become any stronger.
const STRONG: f64 = 90.0;

/// What is done to colours after they were found.
#[derive(Clone, Debug, PartialEq)]
pub struct Grade {
    fill: FillMode,
    contrast: f64,
    chroma: f64,
    saturation: f64,
    duotone: Option<Duotone>,
    wash: f64,
    palette: Option<Palette>,
    /// The colours of the palette, once they are known, by L*a*b*.
    colours: Vec<([f64; 3], Rgba)>,
}

impl Grade {
    /// That of `options`.
    pub fn of(options: &Options) -> Self {
        let colours = match &options.palette {
            Some(Palette::Colours(colours)) => {
                colours.iter().map(|colour| (lab::of(colour.0), colour.0)).collect()
            }
            _ => Vec::new(),
        };
        Self {
            fill: options.fill,
            contrast: options.contrast,
            chroma: options.chroma,
            saturation: options.saturation,
            duotone: options.duotone,
            wash: options.wash,
            palette: options.palette.clone(),
            colours,
        }
    }

    /// The same as `options` have it now. A palette that was learned stays as long as all else does.
    pub(super) fn retune(&mut self, options: &Options) {
        let new = Self::of(options);
        let same = Self { colours: Vec::new(), ..self.clone() }
            == Self { colours: Vec::new(), ..new.clone() };
        if !same {
            *self = new;
        }
    }

    /// Whether colours are changed at all.
    pub(super) fn is_any(&self) -> bool {
        self.fill == FillMode::None
            || self.saturation != 1.0
            || self.wash != 0.0
            || self.is_perceptual()
            || self.palette.is_some()
    }

    fn is_perceptual(&self) -> bool {
        self.contrast != 1.0 || self.chroma != 1.0 || self.duotone.is_some()
    }

    /// Learns the palette, where it is to be learned and is not known: from the colours of the triangles of `mesh`, by
    /// their areas. It is kept.
    pub(super) fn learn(&mut self, mesh: &Mesh, colours: impl Iterator<Item = Rgba>) {
        let Some(Palette::Learned(count)) = self.palette else { return };
        if !self.colours.is_empty() {
            return;
        }
        let weigh = |(t, colour): (usize, Rgba)| {
            let [a, b, c] = mesh.triangle(t);
            (lab::of(self.toned(colour)), orient(a, b, c).max(0) as f64 * f64::from(colour[3]))
        };
        let samples: Vec<_> =
            colours.enumerate().filter(|(_, colour)| colour[3] > 0).map(weigh).collect();
        self.colours = clusters(&samples, count as usize)
            .into_iter()
            .map(|centre| {
                let [r, g, b] = lab::to_rgb(centre);
                (lab::of([r, g, b, 255]), [r, g, b, 255])
            })
            .collect();
    }

    /// Changes the colours as asked for.
    pub(super) fn apply(&self, fills: &mut [Fill]) {
        if self.is_any() {
            fills.par_chunks_mut(PACK).for_each(|fills| {
                fills.iter_mut().for_each(|fill| fill.colour = self.colour(fill.colour));
            });
        }
    }

    /// The same of a picture, pixel by pixel.
    pub(super) fn pixels(&self, pixels: &mut [Rgba]) {
        if self.is_any() {
            pixels.par_chunks_mut(PACK).for_each(|pixels| {
                for same in pixels.chunk_by_mut(|a, b| a == b) {
                    same.fill(self.colour(same[0]));
                }
            });
        }
    }

    /// The `colours` of the triangles of `mesh` as they are shown. The first ones teach a palette that is to be
    /// learned.
    pub fn graded(&mut self, mesh: &Mesh, colours: &[Rgba]) -> Vec<Rgba> {
        self.learn(mesh, colours.iter().copied());
        colours
            .iter()
            .map(|&colour| if self.is_any() { self.colour(colour) } else { colour })
            .collect()
    }

    /// A colour as it is shown.
    pub(super) fn colour(&self, colour: Rgba) -> Rgba {
        if self.fill == FillMode::None {
            return [0; 4];
        }
        if colour[3] == 0 {
            return colour;
        }
        let toned = self.toned(colour);
        if self.colours.is_empty() {
            return toned;
        }
        let here = lab::of(toned);
        let far = |there: &[f64; 3]| (0..3).map(|c| (here[c] - there[c]).powi(2)).sum::<f64>();
        let nearest = self.colours.iter().min_by(|a, b| far(&a.0).total_cmp(&far(&b.0)));
        nearest.map_or(toned, |(_, [r, g, b, _])| [*r, *g, *b, colour[3]])
    }

    /// By how much a colour of this strength grows: the less the stronger it is, so that what is pale gains most and
    /// skin does not burn. It falls by the same share for all.
    fn strength(&self, chroma: f64) -> f64 {
        if self.chroma <= 1.0 {
            return self.chroma;
        }
        1.0 + (self.chroma - 1.0) * (1.0 - chroma / STRONG).max(0.0)
    }

    /// All but the palette.
    fn toned(&self, mut colour: Rgba) -> Rgba {
        if self.is_perceptual() {
            let [lightness, a, b] = lab::of(colour);
            let lightness = (50.0 + self.contrast * (lightness - 50.0)).clamp(0.0, 100.0);
            let toned = match self.duotone {
                Some(Duotone { dark, light }) => {
                    let (dark, light) = (lab::of(dark.0), lab::of(light.0));
                    std::array::from_fn(|c| dark[c] + lightness / 100.0 * (light[c] - dark[c]))
                }
                None => {
                    let share = self.strength((a * a + b * b).sqrt());
                    [lightness, share * a, share * b]
                }
            };
            let [r, g, b] = lab::to_rgb(within(toned));
            colour = [r, g, b, colour[3]];
        }
        if self.saturation == 1.0 && self.wash == 0.0 {
            return colour;
        }
        let grey = f64::from(luma(colour));
        for channel in &mut colour[..3] {
            let vivid = grey + self.saturation * (f64::from(*channel) - grey);
            let vivid = vivid.clamp(0.0, 255.0);
            // The cast takes whole numbers within 0..=255. Black stays black: water thins paint, it does not veil it.
            *channel = (255.0 * (vivid / 255.0).powf(1.0 - self.wash)).round() as u8;
        }
        colour
    }
}

/// A colour of the same lightness and hue that can be shown: its strength falls as far as it must. Clamped channels
/// would change the hue: skin would turn orange.
fn within([lightness, a, b]: [f64; 3]) -> [f64; 3] {
    let shown = |share: f64| {
        let wanted = [lightness, share * a, share * b];
        let [r, g, blue] = lab::to_rgb(wanted);
        let found = lab::of([r, g, blue, 255]);
        (0..3).map(|c| (wanted[c] - found[c]).powi(2)).sum::<f64>() < 16.0
    };
    let (mut low, mut high) = (0.0, 1.0);
    if !shown(1.0) {
        for _ in 0..6 {
            let middle = (low + high) / 2.0;
            if shown(middle) { low = middle } else { high = middle }
        }
        high = low;
    }
    [lightness, high * a, high * b]
}

/// Rounds of the clustering: it has settled by then.
const ROUNDS: usize = 12;

/// Up to `count` centres of weighted `samples`: the mean first, then always the sample that matters most, by its
/// weight and its distance, and from there to the means of those that are nearest (Lloyd's algorithm).
fn clusters(samples: &[([f64; 3], f64)], count: usize) -> Vec<[f64; 3]> {
    let squared = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>();
    let mut centres: Vec<[f64; 3]> = Vec::with_capacity(count);
    let mut far: Vec<f64> = vec![f64::INFINITY; samples.len()];
    let heaviest = samples.iter().enumerate().max_by(|a, b| a.1.1.total_cmp(&b.1.1));
    let mut next = heaviest.map(|(i, _)| i);
    while let Some(i) = next.filter(|_| centres.len() < count) {
        let centre = samples[i].0;
        centres.push(centre);
        for (far, (sample, _)) in far.iter_mut().zip(samples) {
            *far = far.min(squared(sample, &centre));
        }
        // The square root: small areas count, too, or eyes and lips would have no colour.
        let matter = |i: usize| far[i] * samples[i].1.sqrt();
        let most = (0..samples.len()).max_by(|&a, &b| matter(a).total_cmp(&matter(b)));
        next = most.filter(|&i| matter(i) > 0.0);
    }
    for _ in 0..ROUNDS {
        let mut sums = vec![([0.0; 3], 0.0); centres.len()];
        for (sample, weight) in samples {
            let nearest = (0..centres.len()).min_by(|&a, &b| {
                squared(sample, &centres[a]).total_cmp(&squared(sample, &centres[b]))
            });
            let Some((sum, all)) = nearest.map(|i| &mut sums[i]) else { break };
            (0..3).for_each(|c| sum[c] += weight * sample[c]);
            *all += weight;
        }
        for (centre, (sum, all)) in centres.iter_mut().zip(sums) {
            if all > 0.0 {
                *centre = sum.map(|v| v / all);
            }
        }
    }
    centres
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Point, Size};
    use crate::triangulate::triangulate;

    fn graded(options: Options, colour: Rgba) -> Rgba {
        Grade::of(&options).colour(colour)
    }

    #[test]
    fn contrast_and_strength_are_as_the_eye_has_them() {
        let base = Options::default;
        let red = [180, 60, 60, 200];
        assert_eq!(graded(base(), red), red);
        let grey = graded(Options { chroma: 0.0, ..base() }, red);
        assert!((0..3).all(|c| grey[c].abs_diff(grey[0]) <= 2) && grey[3] == 200, "{grey:?}");
        let lightness = |colour: Rgba| lab::of(colour)[0];
        assert!((lightness(grey) - lightness(red)).abs() < 2.0, "{grey:?}");
        let skin = [224, 172, 140, 255];
        let vivid = graded(Options { chroma: 1.8, ..base() }, skin);
        let hue = |colour: Rgba| lab::of(colour)[2].atan2(lab::of(colour)[1]);
        assert!((hue(vivid) - hue(skin)).abs() < 0.12, "{vivid:?}");
        assert!((lightness(vivid) - lightness(skin)).abs() < 3.0, "{vivid:?}");
        let hard = graded(Options { contrast: 1.5, ..base() }, [60, 60, 60, 255]);
        assert!(hard[0] < 40, "{hard:?}");
        assert_eq!(graded(Options { contrast: 0.0, ..base() }, [9, 9, 9, 255])[0], 119);
    }

    #[test]
    fn two_tones_take_the_place_of_black_and_white() {
        let duotone = Some("navy,#ffe8c0".parse().expect("two colours"));
        let tone =
            |grey: u8| graded(Options { duotone, ..Options::default() }, [grey, grey, grey, 255]);
        let near = |a: Rgba, b: Rgba| (0..4).all(|c| a[c].abs_diff(b[c]) <= 4);
        assert!(near(tone(0), [0, 0, 128, 255]), "{:?}", tone(0));
        assert!(near(tone(255), [255, 232, 192, 255]), "{:?}", tone(255));
    }

    #[test]
    fn a_palette_has_its_colours_alone_and_is_learned_once() {
        let size = Size::new(30, 20);
        let seeds: Vec<_> = (1..9).map(|i| Point::pixel_centre(3 * i, (7 * i) % 19)).collect();
        let mesh = triangulate(size, &seeds).expect("distinct seeds");
        let colours: Vec<Rgba> =
            (0..mesh.triangles.len()).map(|t| [(t * 11) as u8, 90, 200 - t as u8, 255]).collect();
        let palette = Some(Palette::Learned(3));
        let mut grade = Grade::of(&Options { palette, ..Options::default() });
        let distinct = |mut colours: Vec<Rgba>| {
            colours.sort_unstable();
            colours.dedup();
            colours
        };
        let first = distinct(grade.graded(&mesh, &colours));
        assert_eq!(first.len(), 3);
        let others: Vec<Rgba> = colours.iter().map(|&[r, g, b, a]| [b, r, g, a]).collect();
        let next = distinct(grade.graded(&mesh, &others));
        assert!(next.iter().all(|colour| first.contains(colour)), "{next:?}");
        let given = Some("black,red,#fff".parse().expect("colours"));
        let mut grade = Grade::of(&Options { palette: given, ..Options::default() });
        let allowed = [[0, 0, 0, 255], [255, 0, 0, 255], [255; 4]];
        assert!(grade.graded(&mesh, &colours).iter().all(|colour| allowed.contains(colour)));
    }
}
