//! An X display: windows found, looked at, pressed and resized.

use std::io::Write as _;

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    AtomEnum, BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ClientMessageEvent, ConfigureWindowAux,
    ConnectionExt, EventMask, ImageFormat, InputFocus, KEY_PRESS_EVENT, KEY_RELEASE_EVENT,
    MOTION_NOTIFY_EVENT, Window,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

use crate::wait::until;

/// The largest window of the tests.
pub(crate) const ROOM: (u16, u16) = (1024, 768);

pub(crate) struct Display {
    x: RustConnection,
    root: Window,
}

/// A screenshot: `0RGB`, row by row.
#[derive(Clone, PartialEq)]
pub(crate) struct Shot {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) pixels: Vec<u32>,
}

impl Shot {
    pub(crate) fn count(&self, colour: u32) -> usize {
        self.pixels.iter().filter(|&&pixel| pixel == colour).count()
    }

    /// The upper three quarters, where no status line is.
    pub(crate) fn picture(&self) -> &[u32] {
        &self.pixels[..self.width * (self.height * 3 / 4)]
    }
}

impl Display {
    /// The display of the environment; `None`, with a message, if there is no display that is large enough.
    pub(crate) fn open() -> Option<Self> {
        match Self::connect() {
            Ok(display) => Some(display),
            Err(error) => {
                assert_ne!(std::env::var("REQUIRE_DISPLAY").as_deref(), Ok("1"), "{error}");
                // Not by `eprintln`: of a test that passes nobody would see it.
                let _ = writeln!(std::io::stderr(), "SKIPPED: {error}");
                None
            }
        }
    }

    fn connect() -> Result<Self, String> {
        let connected = RustConnection::connect(None);
        let (x, screen) = connected.map_err(|error| format!("there is no X display: {error}"))?;
        let screen = &x.setup().roots[screen];
        let (size, root) = ((screen.width_in_pixels, screen.height_in_pixels), screen.root);
        // What sticks out of the screen cannot be looked at.
        if size.0 < ROOM.0 || size.1 < ROOM.1 {
            return Err(format!("the display has {size:?} pixels, the tests need {ROOM:?}"));
        }
        Ok(Self { x, root })
    }

    /// The window whose title begins with `title`, once it is there, with the keyboard.
    pub(crate) fn window(&self, title: &str) -> Window {
        let window = until("the window", || self.find(self.root, title));
        until("the keyboard", || {
            let focus = self.x.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME);
            focus.ok()?.check().ok()
        });
        window
    }

    fn find(&self, window: Window, title: &str) -> Option<Window> {
        let (kind, any) = (AtomEnum::WM_NAME, AtomEnum::ANY);
        let name = self.x.get_property(false, window, kind, any, 0, 1024).ok()?.reply().ok()?;
        if name.value.starts_with(title.as_bytes()) {
            return Some(window);
        }
        let children = self.x.query_tree(window).ok()?.reply().ok()?.children;
        children.into_iter().find_map(|child| self.find(child, title))
    }

    pub(crate) fn shot(&self, window: Window) -> Option<Shot> {
        let place = self.x.get_geometry(window).ok()?.reply().ok()?;
        let (width, height) = (place.width, place.height);
        let image = self.x.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, width, height, !0);
        let data = image.ok()?.reply().ok()?.data;
        let (pixels, _) = data.as_chunks::<4>();
        let pixels = pixels.iter().map(|&p| u32::from_le_bytes(p) & 0xff_ffff).collect();
        Some(Shot { width: width.into(), height: height.into(), pixels })
    }

    /// A screenshot for which `is_right`, once there is one.
    pub(crate) fn shot_where(
        &self,
        window: Window,
        what: &str,
        is_right: impl Fn(&Shot) -> bool,
    ) -> Shot {
        until(what, || self.shot(window).filter(&is_right))
    }

    /// Presses the key that is engraved with the keysym `key` (for Latin characters their code).
    pub(crate) fn press(&self, key: u32) {
        let setup = self.x.setup();
        let (first, last) = (setup.min_keycode, setup.max_keycode);
        let map = self.x.get_keyboard_mapping(first, last - first + 1).expect("a keyboard");
        let map = map.reply().expect("a keyboard");
        let each = usize::from(map.keysyms_per_keycode);
        let place = map.keysyms.chunks(each).position(|keys| keys[0] == key);
        let code = first + place.expect("the key is on the keyboard") as u8;
        for event in [KEY_PRESS_EVENT, KEY_RELEASE_EVENT] {
            self.fake(event, code, (0, 0));
        }
    }

    /// Moves the mouse to a place of `window`, which is in the corner of the screen.
    pub(crate) fn point(&self, window: Window, (x, y): (i16, i16)) {
        let place = self.x.translate_coordinates(window, self.root, x, y).expect("a window");
        let place = place.reply().expect("a place");
        self.fake(MOTION_NOTIFY_EVENT, 0, (place.dst_x, place.dst_y));
    }

    /// Presses or releases a button of the mouse: 1 is the left one, 4 and 5 are the wheel.
    pub(crate) fn button(&self, button: u8, down: bool) {
        let event = if down { BUTTON_PRESS_EVENT } else { BUTTON_RELEASE_EVENT };
        self.fake(event, button, (0, 0));
    }

    fn fake(&self, event: u8, detail: u8, (x, y): (i16, i16)) {
        let sent = self.x.xtest_fake_input(event, detail, 0, self.root, x, y, 0);
        sent.expect("XTEST").check().expect("the event is made");
    }

    /// The size of the screen in pixels.
    pub(crate) fn size(&self) -> (usize, usize) {
        let place = self.x.get_geometry(self.root).expect("X").reply().expect("a screen");
        (place.width.into(), place.height.into())
    }

    /// In the corner of the screen, so that all of it can be seen.
    pub(crate) fn resize(&self, window: Window, width: u32, height: u32) {
        let size = ConfigureWindowAux::new().x(0).y(0).width(width).height(height);
        let sent = self.x.configure_window(window, &size).expect("a window");
        sent.check().expect("it is resized");
    }

    /// Closes the window as a window manager does.
    pub(crate) fn close(&self, window: Window) {
        let atom = |name: &[u8]| {
            self.x.intern_atom(false, name).expect("X").reply().expect("an atom").atom
        };
        let (protocols, delete) = (atom(b"WM_PROTOCOLS"), atom(b"WM_DELETE_WINDOW"));
        let event = ClientMessageEvent::new(32, window, protocols, [delete, 0, 0, 0, 0]);
        let sent = self.x.send_event(false, window, EventMask::NO_EVENT, event).expect("X");
        sent.check().expect("the message is sent");
    }
}
