//! The flatness of a triangle.

use crate::geom::Point;

/// 0 for an equilateral triangle; it grows without bound as the triangle flattens. It is the cube of the excess over
/// 1 of the inverse mean ratio quality, (a^2 + b^2 + c^2) / (4 sqrt(3) area) (Bhatia and Lawrence 1990; Shewchuk
/// 2002). The cube hardly penalises moderate triangles but prevents needles: at equal error, 14 stills have six
/// tenths of the angles below 5 degrees that they have with the square, and with the square half of those with the
/// plain excess. Independent of size. Infinite when the triangle is folded or has no area.
///
/// A needle with a least angle of 5 degrees has about 180, one of 20 degrees 0.5.
///
/// `doubled` is the triangle's `orient`, twice its area.
pub(super) fn flatness(doubled: i64, [a, b, c]: [Point; 3]) -> f64 {
    if doubled <= 0 {
        return f64::INFINITY;
    }
    let squared = |p: Point, q: Point| {
        let (x, y) = (f64::from(p.x - q.x), f64::from(p.y - q.y));
        x * x + y * y
    };
    let squares = squared(a, b) + squared(b, c) + squared(c, a);
    let excess = squares / (TWO_ROOT_3 * doubled as f64) - 1.0;
    excess * excess * excess
}

const TWO_ROOT_3: f64 = 3.464_101_615_137_754_6;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::orient;

    fn flatness(a: Point, b: Point, c: Point) -> f64 {
        super::flatness(orient(a, b, c), [a, b, c])
    }

    #[test]
    fn flatness_grows_from_equilateral_to_flat() {
        let p = Point::new;
        let equilateral = flatness(p(0, 0), p(100_000, 0), p(50_000, 86_603));
        assert!(equilateral.abs() < 1e-4, "{equilateral}");
        let needle = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            flatness(p(0, 0), p(1_000_000, 0), Point::new((cos * 1e6) as i32, (sin * 1e6) as i32))
        };
        let (thin, fair) = (needle(5.0), needle(20.0));
        assert!((thin - 180.0).abs() < 2.0 && (fair - 0.5).abs() < 0.02, "{thin} {fair}");
        assert_eq!(flatness(p(0, 0), p(5, 5), p(9, 9)), f64::INFINITY);
        assert_eq!(flatness(p(0, 0), p(0, 9), p(9, 0)), f64::INFINITY);
    }
}
