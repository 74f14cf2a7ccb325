//! Fills the screen with the window, which minifb cannot do.

use polyreel::error::Error;
#[cfg(not(all(unix, not(target_os = "macos"))))]
use polyreel::error::Result;

fn refused(why: &str) -> Error {
    Error::output("preview", format!("the window cannot fill the screen: {why}"))
}

#[cfg(all(unix, not(target_os = "macos")))]
pub(super) use x11::{enter, leave};

/// The window manager does it. Where there is none, the window is moved and resized.
#[cfg(all(unix, not(target_os = "macos")))]
mod x11 {
    use minifb::HasWindowHandle;
    use polyreel::error::Result;
    use raw_window_handle::RawWindowHandle;
    use x11rb::connection::Connection;
    use x11rb::errors::ReplyError;
    use x11rb::protocol::xproto::{
        AtomEnum, ClientMessageEvent, ConfigureWindowAux, ConnectionExt, EventMask, Window,
    };
    use x11rb::rust_connection::RustConnection;

    use super::super::window::Place;
    use super::refused;

    /// Actions and sources of requests, by the Extended Window Manager Hints.
    const REMOVE: u32 = 0;
    const ADD: u32 = 1;
    const APPLICATION: u32 = 1;

    /// Returns where the window was.
    pub(in super::super) fn enter(window: &mut minifb::Window, _title: &str) -> Result<Place> {
        let size = window.get_size();
        let (x, window) = display_of(window)?;
        let place = Place { at: (0, 0), size: x.screen };
        // minifb's own `get_position` counts the place of the window twice.
        let entered = x.corner(window).and_then(|at| {
            x.set(window, ADD, place)?;
            Ok(Place { at, size })
        });
        entered.map_err(|error| refused(&error.to_string()))
    }

    pub(in super::super) fn leave(
        window: &mut minifb::Window,
        _title: &str,
        before: Place,
    ) -> Result<()> {
        let (x, window) = display_of(window)?;
        x.set(window, REMOVE, before).map_err(|error| refused(&error.to_string()))
    }

    /// A connection of our own: the window has the same number on each.
    struct Display {
        x: RustConnection,
        root: Window,
        /// The size of the screen in pixels.
        screen: (usize, usize),
    }

    fn display_of(window: &minifb::Window) -> Result<(Display, Window)> {
        let handle = window.window_handle().map_err(|error| refused(&error.to_string()))?;
        let RawWindowHandle::Xlib(handle) = handle.as_raw() else {
            return Err(refused("it is not a window of X"));
        };
        let window =
            u32::try_from(handle.window).map_err(|_| refused("its number is too large"))?;
        let (x, screen) =
            RustConnection::connect(None).map_err(|error| refused(&error.to_string()))?;
        let screen = &x.setup().roots[screen];
        let size = (screen.width_in_pixels.into(), screen.height_in_pixels.into());
        Ok((Display { root: screen.root, screen: size, x }, window))
    }

    impl Display {
        /// The upper left corner of the window on the screen.
        fn corner(&self, window: Window) -> Result<(i32, i32), ReplyError> {
            let place = self.x.translate_coordinates(window, self.root, 0, 0)?.reply()?;
            Ok((place.dst_x.into(), place.dst_y.into()))
        }

        fn set(&self, window: Window, action: u32, place: Place) -> Result<(), ReplyError> {
            let state = self.atom("_NET_WM_STATE")?;
            let full = self.atom("_NET_WM_STATE_FULLSCREEN")?;
            if !self.is_supported(full)? {
                let (at, size) = (place.at, place.size);
                let place = ConfigureWindowAux::new().x(at.0).y(at.1);
                let place = place.width(size.0 as u32).height(size.1 as u32);
                return self.x.configure_window(window, &place)?.check();
            }
            let data = [action, full, 0, APPLICATION, 0];
            let event = ClientMessageEvent::new(32, window, state, data);
            let mask = EventMask::SUBSTRUCTURE_REDIRECT | EventMask::SUBSTRUCTURE_NOTIFY;
            self.x.send_event(false, self.root, mask, event)?.check()
        }

        fn atom(&self, name: &str) -> Result<u32, ReplyError> {
            Ok(self.x.intern_atom(false, name.as_bytes())?.reply()?.atom)
        }

        /// Whether there is a window manager that says that it knows `hint`.
        fn is_supported(&self, hint: u32) -> Result<bool, ReplyError> {
            let supported = self.atom("_NET_SUPPORTED")?;
            let most = 4096;
            let (root, kind) = (self.root, AtomEnum::ATOM);
            let reply = self.x.get_property(false, root, supported, kind, 0, most)?.reply()?;
            Ok(reply.value32().is_some_and(|mut known| known.any(|known| known == hint)))
        }
    }
}

/// A window without a border, of the size of the screen, takes the place of the other.
#[cfg(windows)]
pub(super) fn enter(window: &mut minifb::Window, title: &str) -> Result<super::window::Place> {
    use winsafe::{GetSystemMetrics, co};

    let side = |metric| usize::try_from(GetSystemMetrics(metric)).unwrap_or(0);
    let size = (side(co::SM::CXSCREEN), side(co::SM::CYSCREEN));
    if size.0 == 0 || size.1 == 0 {
        return Err(refused("its size is not known"));
    }
    let (x, y) = window.get_position();
    let before = super::window::Place { at: (x as i32, y as i32), size: window.get_size() };
    *window = super::window::open(title, size, true)?;
    window.set_position(0, 0);
    Ok(before)
}

#[cfg(windows)]
pub(super) fn leave(
    window: &mut minifb::Window,
    title: &str,
    before: super::window::Place,
) -> Result<()> {
    *window = super::window::open(title, before.size, false)?;
    window.set_position(before.at.0 as isize, before.at.1 as isize);
    Ok(())
}

#[cfg(not(any(windows, all(unix, not(target_os = "macos")))))]
pub(super) fn enter(_: &mut minifb::Window, _: &str) -> Result<super::window::Place> {
    Err(refused("use the green button of its frame"))
}

#[cfg(not(any(windows, all(unix, not(target_os = "macos")))))]
pub(super) fn leave(_: &mut minifb::Window, _: &str, _: super::window::Place) -> Result<()> {
    Ok(())
}
