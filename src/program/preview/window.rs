//! The window itself: this file and [full_screen] know minifb.

use std::cell::RefCell;
use std::rc::Rc;

use minifb::{InputCallback, Key, MouseButton, MouseMode, ScaleMode, WindowOptions};
use polyreel::error::{Error, Result};

use super::canvas::Canvas;
use super::full_screen;
use super::keys::Stroke;

/// A pressed key, and whether it repeats because it is held down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Press {
    pub(super) stroke: Stroke,
    pub(super) again: bool,
}

/// The mouse over the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mouse {
    /// Its place in pixels.
    pub(super) at: (f64, f64),
    /// Whether its left button is down.
    pub(super) is_down: bool,
    /// Notches that its wheel was turned since the last call, away from the user.
    pub(super) notches: f64,
}

/// A window that shows a canvas. It belongs to the main thread.
pub(super) struct Window {
    inner: minifb::Window,
    title: String,
    keyboard: Rc<RefCell<Keyboard>>,
    /// Its place before it filled the screen.
    before: Option<Place>,
}

/// A place on the screen in pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) at: (i32, i32),
    pub(super) size: (usize, usize),
}

impl Window {
    /// A window of `width` by `height` pixels.
    ///
    /// # Errors
    /// When there is no display.
    pub(super) fn open(title: &str, size: (usize, usize)) -> Result<Self> {
        // A NUL byte would end the title.
        let title = title.replace('\0', "");
        let inner = open(&title, size, false)?;
        let mut window = Self { inner, title, keyboard: Rc::default(), before: None };
        window.listen();
        Ok(window)
    }

    fn listen(&mut self) {
        self.inner.set_input_callback(Box::new(Listener(self.keyboard.clone())));
    }

    /// Processes events, and returns the pressed keys in order.
    pub(super) fn poll(&mut self) -> Vec<Press> {
        self.inner.update();
        std::mem::take(&mut self.keyboard.borrow_mut().presses)
    }

    /// Whether it fills the screen.
    pub(super) fn is_full_screen(&self) -> bool {
        self.before.is_some()
    }

    /// Fills the screen, or goes back to where it was.
    ///
    /// # Errors
    /// When the system has no such thing.
    pub(super) fn toggle_full_screen(&mut self) -> Result<()> {
        match self.before {
            Some(before) => {
                full_screen::leave(&mut self.inner, &self.title, before)?;
                self.before = None;
            }
            None => self.before = Some(full_screen::enter(&mut self.inner, &self.title)?),
        }
        // It may be another window now.
        self.listen();
        Ok(())
    }

    /// Whether it is open.
    pub(super) fn is_open(&self) -> bool {
        self.inner.is_open()
    }

    /// Its size in pixels, at least 1 by 1.
    pub(super) fn size(&self) -> (usize, usize) {
        let (width, height) = self.inner.get_size();
        (width.max(1), height.max(1))
    }

    /// The mouse, if it is known where it is.
    pub(super) fn mouse(&self) -> Option<Mouse> {
        let (x, y) = self.inner.get_unscaled_mouse_pos(MouseMode::Clamp)?;
        let turned = self.inner.get_scroll_wheel().map_or(0.0, |(_, turned)| f64::from(turned));
        Some(Mouse {
            at: (x.into(), y.into()),
            is_down: self.inner.get_mouse_down(MouseButton::Left),
            // Systems count differently: one notch at a time.
            notches: if turned == 0.0 { 0.0 } else { turned.signum() },
        })
    }

    /// Shows `canvas`.
    ///
    /// # Errors
    /// When the window does not take it.
    pub(super) fn show(&mut self, canvas: &Canvas) -> Result<()> {
        let Canvas { width, height, pixels } = canvas;
        let shown = self.inner.update_with_buffer(pixels, *width, *height);
        shown.map_err(|error| {
            Error::output("preview", format!("the window cannot be drawn: {error}"))
        })
    }
}

/// A window of minifb; a `bare` one has nothing around its picture.
///
/// # Errors
/// When there is no display.
pub(super) fn open(
    title: &str,
    (width, height): (usize, usize),
    bare: bool,
) -> Result<minifb::Window> {
    let options = WindowOptions {
        borderless: bare,
        none: bare,
        resize: !bare,
        // The canvas is always of the window's size.
        scale_mode: ScaleMode::UpperLeft,
        ..WindowOptions::default()
    };
    let mut window = minifb::Window::new(title, width, height, options).map_err(no_window)?;
    // Without this minifb would sleep; we wait for pictures ourselves.
    window.set_target_fps(0);
    Ok(window)
}

fn no_window(error: minifb::Error) -> Error {
    let what = error.to_string();
    let what = what.trim_end_matches('.');
    Error::output(
        "preview",
        format!(
            "there is no display to open a window on ({what}); run it in a graphical session, or use \
             'polyreel render'"
        ),
    )
}

/// The keys that are down, and those pressed since the last poll.
#[derive(Default)]
struct Keyboard {
    presses: Vec<Press>,
    down: Vec<Key>,
    /// The key that speaks was down already.
    again: bool,
}

impl Keyboard {
    fn press(&mut self, stroke: Stroke) {
        let again = std::mem::take(&mut self.again);
        self.presses.push(Press { stroke, again });
    }

    fn set(&mut self, key: Key, down: bool) {
        self.again = down && self.down.contains(&key);
        if !down {
            self.down.retain(|&other| other != key);
            return;
        }
        if !self.again {
            self.down.push(key);
        }
        match key {
            Key::Left => self.press(Stroke::Left),
            Key::Right => self.press(Stroke::Right),
            Key::F11 => self.press(Stroke::F11),
            _ => {}
        }
    }
}

/// Gets every key, also those that are released between two updates.
struct Listener(Rc<RefCell<Keyboard>>);

impl InputCallback for Listener {
    fn add_char(&mut self, character: u32) {
        if let Some(character) = char::from_u32(character) {
            self.0.borrow_mut().press(Stroke::Char(character));
        }
    }

    fn set_key_state(&mut self, key: Key, down: bool) {
        self.0.borrow_mut().set(key, down);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_that_is_held_says_so() {
        let keyboard = Rc::<RefCell<Keyboard>>::default();
        let mut listener = Listener(keyboard.clone());
        let mut say = |key, down, character: Option<char>| {
            listener.set_key_state(key, down);
            character.into_iter().for_each(|c| listener.add_char(c.into()));
        };
        say(Key::H, true, Some('h'));
        say(Key::H, true, Some('h'));
        say(Key::H, false, None);
        say(Key::Left, true, None);
        say(Key::H, true, Some('h'));
        let char = |again| Press { stroke: Stroke::Char('h'), again };
        let left = Press { stroke: Stroke::Left, again: false };
        assert_eq!(keyboard.borrow().presses, [char(false), char(true), left, char(false)]);
    }
}
