//! Which lines there are, and how strong: by contrast, and held in time, so that lines of a video do not blink.

use super::strokes::Stroke;
use super::style::Style;
use super::wanted::{Wanted, wanted};
use crate::frame::Rgba;
use crate::geom::{Point, SUBPIXEL, Size};
use crate::mesh::Mesh;
use crate::options::FillMode;

/// Frames that a line takes to come and to go, at coherence 1: a short-lived one is hardly seen, and one whose edge is
/// gone does not stay behind.
const COMING: f64 = 24.0;
const GOING: f64 = 8.0;

/// The end of a line stays where it was drawn as long as its vertex is no further away, in pixels at coherence 1 for
/// a line without width, and follows at that distance. Vertices tremble by less.
const TREMBLE: f64 = 4.0;

/// A line keeps its strength as long as the one it should have is no further away, of 255, at coherence 1.
const HELD: f64 = 250.0;

/// The mesh is a new one where fewer than one line in this number was there before, and near.
const KNOWN: usize = 2;

/// How far that is, as a share of the frame's shorter side.
const NEAR: u32 = 24;

/// A line of the frame before.
#[derive(Clone, Copy, Debug)]
struct Line {
    /// The lasting ids of its ends, ascending.
    ends: (u64, u64),
    stroke: Stroke,
}

/// The lines of a stream of frames.
#[derive(Clone, Debug, Default)]
pub(super) struct Lines {
    /// Those of the frame before, by their ends, with those that are going.
    before: Vec<Line>,
    /// Where the vertices of the frame before were drawn, by their ids.
    places: Vec<(u64, Point)>,
}

impl Lines {
    fn forget(&mut self) {
        self.before.clear();
        self.places.clear();
    }

    /// The lines along the edges of `mesh`, the most opaque first. `colours` are those of the triangles, `graded`
    /// the same as they are shown. From frame to frame strengths change slowly; a line whose edge is gone fades where
    /// it was.
    pub(super) fn of(
        &mut self,
        style: &Style,
        mesh: &Mesh,
        (colours, graded): (&[Rgba], &[Rgba]),
        coherence: f64,
    ) -> Vec<Stroke> {
        let mut lines = lines_of(style, mesh, (colours, graded));
        if coherence > 0.0 {
            lines.sort_unstable_by_key(|line| line.ends);
            let is_new = self.is_new(&lines, mesh.size);
            if is_new {
                self.forget();
            }
            self.place(mesh, coherence * (TREMBLE + style.width(mesh.size)));
            if !is_new {
                lines = self.steady(lines, coherence);
            }
            lines.iter_mut().for_each(|line| {
                let (a, b) = (self.placed(line.ends.0), self.placed(line.ends.1));
                // One whose vertex is gone stays where it was.
                if let (Some(a), Some(b)) = (a, b) {
                    line.stroke.ends = (a, b);
                }
            });
            self.before.clone_from(&lines);
        }
        let mut strokes: Vec<Stroke> = lines.into_iter().map(|line| line.stroke).collect();
        strokes.retain(|stroke| stroke.strength > 0);
        // By their places: a mesh stream has other ids.
        for Stroke { ends, .. } in &mut strokes {
            *ends = (ends.0.min(ends.1), ends.0.max(ends.1));
        }
        strokes.sort_unstable_by_key(|stroke| {
            (std::cmp::Reverse(stroke.paint[3]), stroke.ends, stroke.paint, stroke.strength)
        });
        strokes
    }

    /// Whether `lines` are of another mesh than those before: few of them were there.
    fn is_new(&self, lines: &[Line], size: Size) -> bool {
        let most = size.width.min(size.height) * SUBPIXEL as u32 / NEAR;
        let is_near = |a: Point, b: Point| a.x.abs_diff(b.x) <= most && a.y.abs_diff(b.y) <= most;

        let mut before = self.before.iter().peekable();
        let known = lines.iter().filter(|line| {
            while before.next_if(|old| old.ends < line.ends).is_some() {}
            before.next_if(|old| old.ends == line.ends).is_some_and(|old| {
                let ((a, b), (c, d)) = (old.stroke.ends, line.stroke.ends);
                is_near(a, c) && is_near(b, d)
            })
        });
        known.count() * KNOWN < lines.len()
    }

    /// Moves the ends of lines after the vertices of `mesh`, as far as those are more than `lag` pixels away.
    fn place(&mut self, mesh: &Mesh, lag: f64) {
        let lag = lag * f64::from(SUBPIXEL);
        let drawn = (0u32..).zip(&mesh.vertices).map(|(v, &to)| {
            let id = id(mesh, v);
            let from = self.placed(id).unwrap_or(to);
            let (dx, dy) = (f64::from(to.x - from.x), f64::from(to.y - from.y));
            let share = 1.0 - (lag / dx.hypot(dy).max(1.0)).min(1.0);
            let moved = |from: i32, d: f64| from + (share * d).round() as i32;
            (id, Point::new(moved(from.x, dx), moved(from.y, dy)))
        });
        let mut drawn: Vec<_> = drawn.collect();
        drawn.sort_unstable_by_key(|place| place.0);
        self.places = drawn;
    }

    /// Where the vertex of this id is drawn.
    fn placed(&self, id: u64) -> Option<Point> {
        let at = self.places.binary_search_by_key(&id, |place| place.0).ok()?;
        Some(self.places[at].1)
    }

    /// `lines` with strengths near those before, and the lines before that are not among them, fading.
    fn steady(&self, lines: Vec<Line>, coherence: f64) -> Vec<Line> {
        let step = |frames: f64| (255.0 / (1.0 + coherence * (frames - 1.0))).round() as u8;
        let (coming, going) = (step(COMING), step(GOING));
        let held = (HELD * coherence).round() as u8;
        let mut before = self.before.iter().peekable();
        let mut kept = Vec::with_capacity(lines.len());
        let gone = |line: &Line| {
            let strength = line.stroke.strength.saturating_sub(going);
            let stroke = Stroke { strength, ..line.stroke };
            (strength > 0).then_some(Line { stroke, ..*line })
        };
        for mut line in lines {
            while let Some(old) = before.next_if(|old| old.ends < line.ends) {
                kept.extend(gone(old));
            }
            let old = before.next_if(|old| old.ends == line.ends);
            let from = old.map_or(0, |old| old.stroke.strength);
            line.stroke.strength = approached(from, line.stroke.strength, coming, held);
            kept.push(line);
        }
        before.for_each(|old| kept.extend(gone(old)));
        kept
    }
}

/// `to`, or a strength between it and `from`.
fn approached(from: u8, to: u8, step: u8, held: u8) -> u8 {
    // What is all there, or not at all, is reached.
    let is_end = to == 0 || to == 255;
    if from.abs_diff(to) <= held && !is_end {
        return from;
    }
    to.clamp(from.saturating_sub(step), from.saturating_add(step))
}

/// The lines as they should be: those of no strength are among them.
fn lines_of(style: &Style, mesh: &Mesh, (colours, graded): (&[Rgba], &[Rgba])) -> Vec<Line> {
    let shown = if style.fill == FillMode::None { colours } else { graded };
    let lined = wanted(style, mesh, colours, shown).into_iter();
    lined
        .map(|Wanted { edge, paint, strength, ground }| {
            let [(from, a), (to, b)] = edge.map(|v| (id(mesh, v), mesh.vertices[v as usize]));
            let (ends, places) =
                if from < to { ((from, to), (a, b)) } else { ((to, from), (b, a)) };
            Line { ends, stroke: Stroke { ends: places, paint, strength, ground } }
        })
        .collect()
}

/// The lasting id of a vertex; its number where there is none.
fn id(mesh: &Mesh, v: u32) -> u64 {
    mesh.ids.get(v as usize).copied().unwrap_or(u64::from(v))
}

/// The strength, of 255, of a line between colours whose `difference` has half of it at `contrast`.
pub(super) fn strength(difference: u32, contrast: u32) -> u8 {
    if contrast == 0 {
        return 255;
    }
    let (difference, contrast) = (f64::from(difference), f64::from(contrast));
    let share = ((difference - 0.5 * contrast) / contrast).clamp(0.0, 1.0);
    (255.0 * share * share * (3.0 - 2.0 * share)).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;
    use crate::options::{Colour, Options};
    use crate::triangulate::triangulate;

    #[test]
    fn strength_follows_contrast_without_a_step() {
        assert_eq!([0, 10, 20, 30, 90].map(|d| strength(d, 20)), [0, 0, 128, 255, 255]);
        assert_eq!(strength(0, 0), 255);
        let all: Vec<_> = (0..60).map(|d| strength(d, 20)).collect();
        assert!(all.windows(2).all(|w| w[1] >= w[0] && w[1] - w[0] < 25), "{all:?}");
    }

    #[test]
    fn lines_come_and_go_slowly_and_grain_does_not_move_them() {
        let options = Options {
            outline: Some(Colour([0, 0, 0, 255])),
            outline_contrast: 20,
            ..Options::default()
        };
        let style = Style::of(&options);
        let size = Size::new(40, 30);
        let mesh = triangulate(size, &[Point::pixel_centre(20, 14)]).expect("one seed");
        let mut lines = Lines::default();
        let strongest = |difference: u8, lines: &mut Lines| {
            let mut colours = vec![[90, 90, 90, 255]; mesh.triangles.len()];
            colours[0] = [90 + difference, 90, 90, 255];
            let strokes = lines.of(&style, &mesh, (&colours, &colours), 0.4);
            strokes.iter().map(|stroke| stroke.strength).max().unwrap_or(0)
        };
        assert_eq!(strongest(60, &mut lines), 255);
        let went: Vec<_> = (0..12).map(|_| strongest(0, &mut lines)).collect();
        assert!(went[0] > 150 && went[0] < 255 && went[11] == 0, "{went:?}");
        let came: Vec<_> = (0..12).map(|_| strongest(60, &mut lines)).collect();
        assert!(came[0] > 0 && came[0] < 100 && came[11] == 255, "{came:?}");
        lines.forget();
        let first = strongest(20, &mut lines);
        let grain: Vec<_> = [21, 19, 22, 18].map(|d| strongest(d, &mut lines)).to_vec();
        assert!(grain.iter().all(|&strength| strength == first), "{first}, {grain:?}");
    }
}
