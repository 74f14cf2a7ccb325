//! Draws the picture and what lies over it, and the bar below.

use polyreel::geom::Size;
use polyreel::hex::HexGrid;

use super::canvas::{Area, Canvas};
use super::lens::Lens;
use super::mailbox::Shown;
use super::panel::{self, Panel};
use super::picture::{Sheet, lay};

const SLIDER: u32 = 0xff_ffff;
const GRID: u32 = 0xff_c83c;
const SEED: u32 = 0xff_3030;

/// The content of the window.
#[derive(Debug, Default)]
pub(super) struct Scene<'a> {
    pub(super) shown: Option<&'a Shown>,
    pub(super) lens: Lens,
    /// The position of the slider between source (left) and picture (right), 0 to 1.
    pub(super) split: Option<f64>,
    /// The grid of the seeds, to be drawn with them.
    pub(super) grid: Option<HexGrid>,
    pub(super) panel: Panel,
}

/// Where things are in the window, for the mouse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Places {
    /// The room of the picture.
    pub(super) room: Area,
    /// The part of it that the picture fills.
    pub(super) picture: Area,
    /// The timeline, where there is one.
    pub(super) timeline: Option<Area>,
}

/// Draws `scene` on the canvas.
pub(super) fn draw(canvas: &mut Canvas, scene: &Scene) -> Places {
    let bar = panel::bar((canvas.width, canvas.height), &scene.panel);
    let room = Area { x: 0, y: 0, width: canvas.width, height: bar.y };
    let sheet = scene.shown.map(|shown| scene.lens.sheet(shown.frame.size(), room));
    let picture = sheet.map_or(Area { width: 0, ..room }, |sheet| sheet.within(room));
    around(canvas, picture, room);
    if let (Some(shown), Some(sheet)) = (scene.shown, sheet) {
        draw_picture(canvas, shown, sheet, picture, scene.split);
        if let Some(grid) = &scene.grid {
            draw_grid(canvas, grid, sheet, picture);
            draw_seeds(canvas, shown, sheet, picture);
        }
    }
    let timeline = scene.panel.draw(canvas, bar);
    Places { room, picture, timeline }
}

/// Blackens what `picture` leaves of `room`.
fn around(canvas: &mut Canvas, picture: Area, room: Area) {
    let (right, below) = (picture.x + picture.width, picture.y + picture.height);
    let (width, bottom) = (room.width, room.height);
    canvas.fill(Area { x: 0, y: 0, width, height: picture.y }, 0);
    canvas.fill(Area { x: 0, y: below, width, height: bottom.saturating_sub(below) }, 0);
    canvas.fill(Area { x: 0, y: picture.y, width: picture.x, height: picture.height }, 0);
    canvas.fill(Area { x: right, width: width - right, ..picture }, 0);
}

fn draw_picture(canvas: &mut Canvas, shown: &Shown, sheet: Sheet, seen: Area, split: Option<f64>) {
    let Some(split) = split else {
        lay(canvas, &shown.frame, sheet, seen);
        return;
    };
    let at = (split.clamp(0.0, 1.0) * seen.width as f64) as usize;
    let (left, right) =
        (Area { width: at, ..seen }, Area { x: seen.x + at, width: seen.width - at, ..seen });
    lay(canvas, &shown.origin.frame, sheet, left);
    lay(canvas, &shown.frame, sheet, right);
    let width = 2;
    let x = right.x.saturating_sub(width / 2);
    let x = x.clamp(seen.x, (seen.x + seen.width).saturating_sub(width));
    canvas.fill(Area { x, width, ..seen }, SLIDER);
    panel::label(canvas, "source", left, true);
    panel::label(canvas, "polyreel", right, false);
}

/// From the frame's pixels to the canvas.
fn onto(sheet: Sheet, size: Size) -> impl Fn((f64, f64)) -> (f64, f64) {
    let across = sheet.width as f64 / f64::from(size.width);
    let down = sheet.height as f64 / f64::from(size.height);
    move |(x, y)| (sheet.x as f64 + x * across, sheet.y as f64 + y * down)
}

fn draw_grid(canvas: &mut Canvas, grid: &HexGrid, sheet: Sheet, seen: Area) {
    let place = onto(sheet, grid.size());
    for cell in 0..grid.cells() {
        // The other three sides are drawn by the neighbours to the left and above.
        for pair in grid.lower_right(cell).windows(2) {
            canvas.line(place(pair[0]), place(pair[1]), seen, GRID);
        }
    }
}

fn draw_seeds(canvas: &mut Canvas, shown: &Shown, sheet: Sheet, seen: Area) {
    let mesh = &shown.origin.mesh;
    let place = onto(sheet, mesh.size);
    let reach = (canvas.height / 1000 + 1).min(8) as i32;
    for seed in mesh.seeds() {
        canvas.square(place(seed.to_pixels()), reach, seen, SEED);
    }
}

/// The share of `area` from its left end to column `x`: the position of a slider, or a place on the timeline.
pub(super) fn slid(x: f64, area: Area) -> f64 {
    ((x - area.x as f64) / area.width.max(1) as f64).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use polyreel::frame::{Frame, Rational};
    use polyreel::mesh::Mesh;
    use polyreel::sink::Origin;
    use polyreel::stream::Span;

    const SIZE: Size = Size::new(64, 32);
    const GREEN: u32 = 0x00_c000;
    const BLUE: u32 = 0x00_00c0;

    fn shown() -> Shown {
        let flat = |colour| Frame::filled(SIZE, colour).expect("a frame");
        let mut vertices = Mesh::corners(SIZE).to_vec();
        vertices.push(polyreel::geom::Point::from_pixels(32.0, 16.0));
        let mesh = Mesh::new(SIZE, vertices, Vec::new());
        let origin = Origin { frame: flat([0, 192, 0, 255]), mesh };
        let span = Span { start: Rational::ZERO, length: None };
        Shown { frame: flat([0, 0, 192, 255]), origin, span }
    }

    fn count(canvas: &Canvas, colour: u32) -> usize {
        canvas.pixels.iter().filter(|&&pixel| pixel == colour).count()
    }

    #[test]
    fn picture_and_bar_share_the_window() {
        let shown = shown();
        for (width, height) in [(640, 400), (200, 300), (3840, 2160), (33, 21), (1, 1)] {
            let mut canvas = Canvas::new(width, height);
            let Places { room, picture, .. } =
                draw(&mut canvas, &Scene { shown: Some(&shown), ..Scene::default() });
            assert!(picture.y + picture.height <= room.height && room.height <= height);
            assert!(picture.x + picture.width <= width);
            let ratio = picture.width as f64 / picture.height.max(1) as f64;
            assert!(picture.height < 40 || (ratio - 2.0).abs() < 0.1, "{width}x{height}: {ratio}");
        }
    }

    #[test]
    fn a_message_does_not_move_the_picture() {
        let shown = shown();
        let mut canvas = Canvas::new(500, 300);
        let mut places =
            |panel| draw(&mut canvas, &Scene { shown: Some(&shown), panel, ..Scene::default() });
        let quiet = places(Panel::default());
        let note = Some("a message that is much too long for one line ".repeat(9));
        assert_eq!(places(Panel { note, ..Panel::default() }), quiet);
        let hidden = places(Panel { is_hidden: true, ..Panel::default() });
        assert_eq!(hidden.room.height, 300, "without the bar the picture has the whole window");
    }

    #[test]
    fn the_slider_parts_source_and_picture() {
        let shown = shown();
        for split in [0.0, 0.25, 1.0] {
            let mut canvas = Canvas::new(400, 260);
            let scene = Scene { shown: Some(&shown), split: Some(split), ..Scene::default() };
            let area = draw(&mut canvas, &scene).picture;
            let share = count(&canvas, GREEN) as f64 / (area.width * area.height) as f64;
            assert!((share - split).abs() < 0.06, "{split}: {share}");
            assert!(
                count(&canvas, GREEN) + count(&canvas, BLUE) > area.width * area.height * 9 / 10
            );
        }
        let area = Area { x: 100, y: 0, width: 200, height: 100 };
        assert_eq!((slid(150.0, area), slid(0.0, area), slid(999.0, area)), (0.25, 0.0, 1.0));
    }

    #[test]
    fn seeds_and_grid_lie_over_the_picture_alone() {
        let shown = shown();
        let mut canvas = Canvas::new(640, 400);
        let grid = Some(HexGrid::new(SIZE, 8.0));
        let area =
            draw(&mut canvas, &Scene { shown: Some(&shown), grid, ..Scene::default() }).picture;
        assert_eq!(count(&canvas, SEED), 9, "one seed, three by three pixels");
        let line = 0x7f_641e + 0x00_0060;
        assert!(count(&canvas, line) > 1000, "half the grid's colour, half the picture's");
        for (i, &pixel) in canvas.pixels.iter().enumerate() {
            let (x, y) = (i % 640, i / 640);
            let inside = (area.x..area.x + area.width).contains(&x)
                && (area.y..area.y + area.height).contains(&y);
            assert!(inside || pixel != line && pixel != SEED, "({x}, {y})");
        }
    }

    #[test]
    fn nothing_of_the_last_scene_stays_around_the_picture() {
        let shown = shown();
        let mut canvas = Canvas::new(300, 300);
        canvas.pixels.fill(0xab_cdef);
        draw(&mut canvas, &Scene { shown: Some(&shown), ..Scene::default() });
        assert_eq!(count(&canvas, 0xab_cdef), 0);
    }
}
