//! Remarks about options that can be had, but hardly mean what their user hopes for.

use polyreel::geom::Size;
use polyreel::options::{Edges, Points};

use crate::program::look::LookArgs;

/// Pixels a point needs, if triangles are to be seen.
const PIXELS_A_POINT: usize = 4;

/// What there is to say of `look` for frames of `size` that go to a GIF if `to_gif`.
pub(crate) fn remarks(look: &LookArgs, size: Size, to_gif: bool) -> Vec<String> {
    let remarks = [look.points.and_then(|points| too_many(points, size)), smooth_gif(look, to_gif)];
    remarks.into_iter().flatten().collect()
}

fn too_many(points: Points, size: Size) -> Option<String> {
    let most = size.pixels() / PIXELS_A_POINT;
    let is_given = matches!(points, Points::Count(_) | Points::Share(_));
    (is_given && points.target(size) > most).then(|| {
        format!(
            "--points {points} is more than one for {PIXELS_A_POINT} pixels of {size}: it takes long and looks like \
             the source; a few thousand at most look low-poly"
        )
    })
}

fn smooth_gif(look: &LookArgs, to_gif: bool) -> Option<String> {
    let in_vain = to_gif && look.edges == Some(Edges::Smooth);
    in_vain.then(|| "--edges smooth has no effect on a GIF: its edges are always hard".to_owned())
}
