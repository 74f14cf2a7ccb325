//! Draws the picture, overlays, and the status line below.

use polyreel::geom::Size;
use polyreel::hex::HexGrid;

use super::canvas::{Area, Canvas, LETTER};
use super::keys::HELP;
use super::mailbox::Shown;
use super::picture::{fitted, lay};
use super::status::lines;

const TEXT: u32 = 0xe6_e6e6;
const BAR: u32 = 0x18_1818;
const SLIDER: u32 = 0xff_ffff;
const GRID: u32 = 0xff_c83c;
const SEED: u32 = 0xff_3030;

/// Margin around text, in unmagnified pixels of letters.
const MARGIN: usize = 4;

/// The largest share of the window for the status line: one part in this number.
const BAR_SHARE: usize = 3;

/// Height of a window in pixels for which letters are magnified once more.
const LARGE: usize = 1000;

/// The content of the window.
#[derive(Debug, Default)]
pub(super) struct Scene<'a> {
    pub(super) shown: Option<&'a Shown>,
    pub(super) words: &'a [String],
    /// The position of the slider between source (left) and picture (right), 0 to 1.
    pub(super) split: Option<f64>,
    /// The grid of the seeds, to be drawn with them.
    pub(super) grid: Option<HexGrid>,
    pub(super) help: bool,
}

/// The magnification of letters in a window of `height` pixels.
pub(super) fn letter_scale(height: usize) -> usize {
    (height / LARGE + 1).min(8)
}

/// The layout of a window of `width` by `height` pixels with `words` below a picture of `size`: the picture, the bar,
/// and the bar's lines.
pub(super) fn laid_out(
    (width, height): (usize, usize),
    size: Option<Size>,
    words: &[String],
) -> (Area, Area, Vec<String>) {
    let scale = letter_scale(height);
    let columns = (width / scale).saturating_sub(2 * MARGIN) / LETTER.0;
    let mut lines = lines(words, columns.max(1));
    let line = LETTER.1 * scale;
    lines.truncate((height / BAR_SHARE / line).max(1));
    let bar_height = (lines.len() * line + 2 * MARGIN * scale).min(height);
    let bar = Area { x: 0, y: height - bar_height, width, height: bar_height };
    let room = Area { x: 0, y: 0, width, height: bar.y };
    (size.map_or(room, |size| fitted(size, room)), bar, lines)
}

/// Draws `scene` on the canvas. Returns the area of the picture.
pub(super) fn draw(canvas: &mut Canvas, scene: &Scene) -> Area {
    let size = scene.shown.map(|shown| shown.frame.size());
    let (area, bar, lines) = laid_out((canvas.width, canvas.height), size, scene.words);
    around(canvas, area, bar.y);
    if let Some(shown) = scene.shown {
        draw_picture(canvas, shown, area, scene.split);
        if let Some(grid) = &scene.grid {
            draw_grid(canvas, grid, area);
            draw_seeds(canvas, shown, area);
        }
    }
    let scale = letter_scale(canvas.height);
    canvas.fill(bar, BAR);
    for (i, line) in lines.iter().enumerate() {
        let at = (bar.x + MARGIN * scale, bar.y + (MARGIN + i * LETTER.1) * scale);
        canvas.write(line, at, scale, TEXT);
    }
    if scene.help {
        draw_help(canvas, scale);
    }
    area
}

/// Blackens the surroundings of `area` above row `bottom`.
fn around(canvas: &mut Canvas, area: Area, bottom: usize) {
    let (right, below) = (area.x + area.width, area.y + area.height);
    let width = canvas.width;
    canvas.fill(Area { x: 0, y: 0, width, height: area.y }, 0);
    canvas.fill(Area { x: 0, y: below, width, height: bottom.saturating_sub(below) }, 0);
    canvas.fill(Area { x: 0, y: area.y, width: area.x, height: area.height }, 0);
    canvas.fill(Area { x: right, y: area.y, width: width - right, height: area.height }, 0);
}

fn draw_picture(canvas: &mut Canvas, shown: &Shown, area: Area, split: Option<f64>) {
    let Some(split) = split else {
        lay(canvas, &shown.frame, area, area.x..area.x + area.width);
        return;
    };
    let at = area.x + (split.clamp(0.0, 1.0) * area.width as f64) as usize;
    lay(canvas, &shown.origin.frame, area, area.x..at);
    lay(canvas, &shown.frame, area, at..area.x + area.width);
    let width = 2;
    let x = at.saturating_sub(width / 2).clamp(area.x, (area.x + area.width).saturating_sub(width));
    canvas.fill(Area { x, width, ..area }, SLIDER);
    let scale = letter_scale(canvas.height);
    let label = |text: &str| text.len() * LETTER.0 * scale;
    let y = area.y + MARGIN * scale;
    for (text, room, left) in [
        ("source", at - area.x, at.saturating_sub(label("source") + 2 * MARGIN * scale)),
        ("polyreel", area.x + area.width - at, at + 2 * MARGIN * scale),
    ] {
        if room > label(text) + 3 * MARGIN * scale {
            let (width, height) = (label(text), LETTER.1 * scale);
            canvas.darken(Area { x: left, y, width, height });
            canvas.write(text, (left, y), scale, TEXT);
        }
    }
}

/// From the frame's pixels to the canvas.
fn onto(area: Area, size: Size) -> impl Fn((f64, f64)) -> (f64, f64) {
    let across = area.width as f64 / f64::from(size.width);
    let down = area.height as f64 / f64::from(size.height);
    move |(x, y)| (area.x as f64 + x * across, area.y as f64 + y * down)
}

fn draw_grid(canvas: &mut Canvas, grid: &HexGrid, area: Area) {
    let place = onto(area, grid.size());
    for cell in 0..grid.cells() {
        // The other three sides are drawn by the neighbours to the left and above.
        for pair in grid.lower_right(cell).windows(2) {
            canvas.line(place(pair[0]), place(pair[1]), area, GRID);
        }
    }
}

fn draw_seeds(canvas: &mut Canvas, shown: &Shown, area: Area) {
    let mesh = &shown.origin.mesh;
    let place = onto(area, mesh.size);
    let reach = letter_scale(canvas.height) as i32;
    for seed in mesh.seeds() {
        canvas.square(place(seed.to_pixels()), reach, area, SEED);
    }
}

fn draw_help(canvas: &mut Canvas, scale: usize) {
    let keys = HELP.iter().map(|(keys, _)| keys.len()).max().unwrap_or(0) + 3;
    let columns = keys + HELP.iter().map(|(_, text)| text.len()).max().unwrap_or(0);
    let (letter, line, margin) = (LETTER.0 * scale, (LETTER.1 + 2) * scale, 3 * MARGIN * scale);
    let width = (columns * letter + 2 * margin).min(canvas.width);
    let height = (HELP.len() * line + 2 * margin).min(canvas.height);
    let (x, y) = ((canvas.width - width) / 2, (canvas.height - height) / 2);
    canvas.darken(Area { x, y, width, height });
    for (i, (key, text)) in HELP.iter().enumerate() {
        let y = y + margin + i * line;
        canvas.write(key, (x + margin, y), scale, GRID);
        canvas.write(text, (x + margin + keys * letter, y), scale, TEXT);
    }
}

/// The position of the slider for the mouse at column `x`.
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
        let words: Vec<_> = (0..12).map(|i| format!("word number {i}")).collect();
        for (width, height) in [(640, 400), (200, 300), (3840, 2160), (33, 21), (1, 1)] {
            let (area, bar, lines) = laid_out((width, height), Some(SIZE), &words);
            assert!(area.y + area.height <= bar.y && bar.y + bar.height == height);
            assert!(area.x + area.width <= width && bar.width == width);
            let ratio = area.width as f64 / area.height.max(1) as f64;
            assert!(area.height < 40 || (ratio - 2.0).abs() < 0.1, "{width}x{height}: {ratio}");
            let columns = (width / letter_scale(height)) / LETTER.0;
            assert!(lines.iter().all(|line| line.len() <= columns.max(1)));
        }
        assert_eq!((letter_scale(600), letter_scale(1200), letter_scale(2160)), (1, 2, 3));
    }

    #[test]
    fn the_slider_parts_source_and_picture() {
        let shown = shown();
        for split in [0.0, 0.25, 1.0] {
            let mut canvas = Canvas::new(400, 260);
            let scene = Scene { shown: Some(&shown), split: Some(split), ..Scene::default() };
            let area = draw(&mut canvas, &scene);
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
        let area = draw(&mut canvas, &Scene { shown: Some(&shown), grid, ..Scene::default() });
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

    #[test]
    fn help_shows_over_everything_and_in_the_smallest_window() {
        for (width, height) in [(900, 500), (50, 40), (3, 2)] {
            let words = ["a status".to_owned()];
            let scene = Scene { help: true, words: &words, ..Scene::default() };
            let mut canvas = Canvas::new(width, height);
            draw(&mut canvas, &scene);
            assert!(width < 100 || count(&canvas, GRID) > 300);
        }
    }
}
