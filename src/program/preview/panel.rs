//! The bar below the picture, and what is written over it: messages, figures, help.

use super::canvas::{Area, Canvas};
use super::keys::HELP;
use crate::program::letters::Letters;

const TEXT: u32 = 0xee_eeee;
const FAINT: u32 = 0x9a_9aa0;
const BAR: u32 = 0x18_181b;
const TRACK: u32 = 0x3a_3a40;
const ACCENT: u32 = 0xff_c83c;
const PLAYED: u32 = 0x6c_b6ff;

/// The smallest and largest height of a line of letters in pixels, and the share of the window that it is.
const LETTERS: (usize, usize, usize) = (15, 48, 44);

/// The bar is left out of windows that are less than this many lines high.
const LEAST_LINES: usize = 9;

/// Between two words of the bar.
const GAP: &str = "   \u{b7}   ";

/// What is said in the window.
#[derive(Clone, Debug, Default)]
pub(super) struct Panel {
    /// The look, the most important word first.
    pub(super) look: Vec<String>,
    /// What the user should know of the picture.
    pub(super) alert: Option<String>,
    /// The second line of the bar, from left to right.
    pub(super) state: String,
    /// The share of the stream that has been played, 0 to 1, where its length is known.
    pub(super) played: Option<f64>,
    pub(super) clock: String,
    /// A message, for some seconds.
    pub(super) note: Option<String>,
    /// Times and counts, if they are shown.
    pub(super) figures: Vec<String>,
    pub(super) help: bool,
    /// Whether the bar is hidden.
    pub(super) is_hidden: bool,
}

/// The height of a line in a window of `height` pixels.
fn line_of(height: usize) -> usize {
    let (least, most, share) = LETTERS;
    (height / share).clamp(least, most)
}

/// The letters of a window of `height` pixels.
fn letters(height: usize) -> Letters {
    Letters::new(line_of(height) as u32)
}

/// The area of the bar: two lines, whatever is written there.
pub(super) fn bar((width, height): (usize, usize), panel: &Panel) -> Area {
    let line = line_of(height);
    let bar = if panel.is_hidden || height < LEAST_LINES * line { 0 } else { 3 * line };
    Area { x: 0, y: height - bar, width, height: bar }
}

/// The height of a bar below a picture of `height` pixels.
pub(super) fn bar_below(height: usize) -> usize {
    3 * line_of(height)
}

/// Writes `text` in a corner of `room`, at its `right` or left end, if it fits.
pub(super) fn label(canvas: &mut Canvas, text: &str, room: Area, right: bool) {
    let letters = letters(canvas.height);
    let (width, height) = (letters.width(text) as usize, line_of(canvas.height));
    let margin = height / 2;
    if room.width < width + 4 * margin {
        return;
    }
    let x = if right { room.x + room.width - width - 2 * margin } else { room.x + 2 * margin };
    let back = Area { x: x - margin / 2, y: room.y + margin, width: width + margin, height };
    canvas.darken(back);
    canvas.write(text, (x, back.y), &letters, TEXT);
}

impl Panel {
    /// Draws all of it, the bar on `bar`. Returns the area of the timeline.
    pub(super) fn draw(&self, canvas: &mut Canvas, bar: Area) -> Option<Area> {
        let letters = letters(canvas.height);
        let timeline = if bar.height > 0 { self.draw_bar(canvas, bar, &letters) } else { None };
        self.draw_figures(canvas, &letters);
        self.draw_note(canvas, bar.y, &letters);
        if self.help {
            draw_help(canvas);
        }
        timeline
    }

    fn draw_bar(&self, canvas: &mut Canvas, bar: Area, letters: &Letters) -> Option<Area> {
        canvas.fill(bar, BAR);
        let line = line_of(canvas.height);
        let (left, right) = (bar.x + line, (bar.x + bar.width).saturating_sub(line));
        let first = bar.y + line * 3 / 8;
        let mut end = right;
        if let Some(alert) = &self.alert {
            let width = letters.width(alert) as usize;
            end = right.saturating_sub(width);
            if end > left + line {
                canvas.write(alert, (end, first), letters, ACCENT);
                let dot = Area {
                    x: end - line * 3 / 4,
                    y: first + line / 4,
                    width: line / 2,
                    height: line / 2,
                };
                canvas.fill(dot, ACCENT);
            }
            end = end.saturating_sub(2 * line);
        }
        let look = fitting(&self.look, end.saturating_sub(left), letters);
        canvas.write(&look, (left, first), letters, TEXT);
        let second = bar.y + line * 13 / 8;
        canvas.write(&self.state, (left, second), letters, FAINT);
        let clock = right.saturating_sub(letters.width(&self.clock) as usize);
        let start = left + letters.width(&self.state) as usize + line;
        if clock > start {
            canvas.write(&self.clock, (clock, second), letters, FAINT);
        }
        let played = self.played?;
        let width = clock.saturating_sub(line).checked_sub(start).filter(|&width| width > line)?;
        // A click need not hit the thin line.
        let timeline = Area { x: start, y: second, width, height: line };
        let track = Area { y: second + line / 2 - line / 8, height: line / 4, ..timeline };
        canvas.fill(track, TRACK);
        let done = (played.clamp(0.0, 1.0) * width as f64) as usize;
        canvas.fill(Area { width: done, ..track }, PLAYED);
        Some(timeline)
    }

    /// Over the lower end of the picture, so that nothing moves.
    fn draw_note(&self, canvas: &mut Canvas, bottom: usize, letters: &Letters) {
        let Some(note) = &self.note else { return };
        let line = line_of(canvas.height);
        let text = letters.fitted(note, canvas.width.saturating_sub(3 * line) as u32);
        let width = letters.width(&text) as usize + 2 * line;
        let x = canvas.width.saturating_sub(width) / 2;
        let y = bottom.saturating_sub(3 * line);
        canvas.darken(Area { x, y, width, height: 2 * line });
        canvas.write(&text, (x + line, y + line / 2), letters, TEXT);
    }

    /// In the upper left corner.
    fn draw_figures(&self, canvas: &mut Canvas, letters: &Letters) {
        let Some(width) = self.figures.iter().map(|text| letters.width(text)).max() else { return };
        let line = line_of(canvas.height);
        let height = (self.figures.len() + 1) * line;
        canvas.darken(Area { x: 0, y: 0, width: width as usize + 2 * line, height });
        for (i, text) in self.figures.iter().enumerate() {
            canvas.write(text, (line, line / 2 + i * line), letters, TEXT);
        }
    }
}

/// As many of `words` as are no wider than `width`.
fn fitting(words: &[String], width: usize, letters: &Letters) -> String {
    let fits = |count: &usize| letters.width(&words[..*count].join(GAP)) as usize <= width;
    let count = (1..=words.len()).rev().find(fits).unwrap_or(0);
    words[..count].join(GAP)
}

/// The help, in letters that are small enough for the window.
fn draw_help(canvas: &mut Canvas) {
    let rows = HELP.iter().map(|column| column.len()).max().unwrap_or(0);
    let mut line = line_of(canvas.height);
    let widths = |line: usize| {
        let letters = Letters::new(line as u32);
        HELP.map(|column| {
            let texts = column.iter().map(|(_, text)| letters.width(text) as usize);
            6 * line + texts.max().unwrap_or(0)
        })
    };
    let width = |line: usize| widths(line).iter().sum::<usize>() + 3 * line;
    let height = |line: usize| (rows + 2) * line * 5 / 4;
    while line > 6 && (width(line) > canvas.width || height(line) > canvas.height) {
        line -= 1;
    }
    let (letters, step) = (Letters::new(line as u32), line * 5 / 4);
    let size = (width(line).min(canvas.width), height(line).min(canvas.height));
    let (x, y) = ((canvas.width - size.0) / 2, (canvas.height - size.1) / 2);
    let back = Area { x, y, width: size.0, height: size.1 };
    canvas.darken(back);
    canvas.darken(back);
    canvas.fill(Area { width: (line / 5).max(2).min(size.0), ..back }, ACCENT);
    let mut left = x + line;
    for (column, width) in HELP.iter().zip(widths(line)) {
        for (i, (key, text)) in column.iter().enumerate() {
            let y = y + step + i * step;
            canvas.write(key, (left, y), &letters, ACCENT);
            canvas.write(text, (left + 6 * line, y), &letters, TEXT);
        }
        left += width + line;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(canvas: &Canvas, colour: u32) -> usize {
        canvas.pixels.iter().filter(|&&pixel| pixel == colour).count()
    }

    #[test]
    fn the_timeline_shows_what_was_played() {
        let mut canvas = Canvas::new(800, 600);
        let panel =
            Panel { played: Some(0.25), clock: "0:01.0 / 0:04.0".to_owned(), ..Panel::default() };
        let bar = bar((800, 600), &panel);
        let timeline = panel.draw(&mut canvas, bar).expect("a timeline");
        let (done, rest) = (count(&canvas, PLAYED), count(&canvas, TRACK));
        let share = done as f64 / (done + rest) as f64;
        assert!((share - 0.25).abs() < 0.01, "{share}");
        assert!(timeline.y >= bar.y && timeline.x + timeline.width < 800);
        let none = Panel { played: None, ..panel };
        assert_eq!(none.draw(&mut canvas, bar), None);
    }

    #[test]
    fn the_look_gives_way_to_an_alert() {
        let words: Vec<_> = ["bold", "2469 points", "quality best"].map(str::to_owned).into();
        let letters = Letters::new(16);
        assert_eq!(fitting(&words, 1000, &letters), words.join(GAP));
        assert_eq!(fitting(&words, 60, &letters), "bold");
        assert_eq!(fitting(&words, 3, &letters), "");
        let mut canvas = Canvas::new(500, 300);
        let alert = Some("618 of 2469 points (budget)".to_owned());
        let panel = Panel { look: words, alert, ..Panel::default() };
        panel.draw(&mut canvas, bar((500, 300), &panel));
        assert!(count(&canvas, ACCENT) > 20);
    }

    #[test]
    fn everything_is_drawn_in_the_smallest_window() {
        for (width, height) in [(900, 500), (320, 240), (50, 40), (3, 2), (1, 1)] {
            let panel = Panel {
                look: vec!["bold".to_owned()],
                note: Some("saved a-file.png".to_owned()),
                figures: vec!["12 seeds".to_owned(); 40],
                played: Some(1.0),
                help: true,
                ..Panel::default()
            };
            let mut canvas = Canvas::new(width, height);
            panel.draw(&mut canvas, bar((width, height), &panel));
            label(&mut canvas, "source", Area { x: 0, y: 0, width, height }, true);
            assert!(width < 320 || count(&canvas, ACCENT) > 100, "{width}x{height}");
        }
    }
}
