//! Draws faces of ellipses. The tests of the whole chain have it, too.

/// Parts of a face, drawn one over the other: where its middle is from the face's, and its radii, in the face's own, and
/// its colour.
const PARTS: [([f64; 4], [u8; 3]); 13] = [
    ([0.0, -0.25, 1.08, 1.3], [60, 40, 30]),
    ([0.0, 1.6, 1.3, 0.6], [40, 60, 120]),
    ([0.0, 1.2, 0.35, 0.5], [200, 150, 120]),
    ([0.0, 0.05, 0.85, 1.15], [225, 180, 150]),
    ([-0.36, -0.12, 0.2, 0.1], [245, 240, 235]),
    ([0.36, -0.12, 0.2, 0.1], [245, 240, 235]),
    ([-0.36, -0.12, 0.09, 0.1], [50, 30, 20]),
    ([0.36, -0.12, 0.09, 0.1], [50, 30, 20]),
    ([-0.36, -0.34, 0.24, 0.05], [70, 45, 30]),
    ([0.36, -0.34, 0.24, 0.05], [70, 45, 30]),
    ([0.03, 0.25, 0.12, 0.22], [205, 155, 125]),
    ([0.0, 0.42, 0.15, 0.05], [170, 110, 90]),
    ([0.0, 0.68, 0.3, 0.09], [180, 70, 70]),
];

/// A place in pixels, and a radius.
pub(crate) type Place = [f64; 3];

/// What is seen at `x`, `y` of faces at these places; `None` outside them.
pub(crate) fn faces_at(places: &[Place], x: f64, y: f64) -> Option<[u8; 4]> {
    let part = |[mid_x, mid_y, radius]: &Place| {
        let (x, y) = ((x - mid_x) / radius, (y - mid_y) / radius);
        let inside =
            |[dx, dy, rx, ry]: [f64; 4]| ((x - dx) / rx).powi(2) + ((y - dy) / ry).powi(2) < 1.0;
        PARTS.iter().rev().find(|(ellipse, _)| inside(*ellipse))
    };
    places.iter().rev().find_map(part).map(|(_, [r, g, b])| [*r, *g, *b, 255])
}
