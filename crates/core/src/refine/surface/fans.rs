//! Walks around several vertices at once.

use smallvec::SmallVec;

use super::{NONE, Surface, previous};

/// Vertices that are walked around together. The next half-edge of a fan is known only after the last one was read,
/// and the end of a fan cannot be predicted: with several fans the memory accesses overlap.
pub(in crate::refine) const TOGETHER: usize = 8;

/// Half-edges of a fan for which memory is allocated at once; few fans have more.
const USUAL: usize = 12;

/// The half-edges that leave each of up to [`TOGETHER`] vertices.
#[derive(Debug, Default)]
pub(in crate::refine) struct Fans {
    /// The first half-edge of each vertex, then the second of each, and so on; a shorter fan repeats its last one.
    leaving: SmallVec<[[u32; TOGETHER]; USUAL]>,
    lengths: [usize; TOGETHER],
}

impl Fans {
    /// Walks around `vertices`, [`TOGETHER`] at most.
    pub(in crate::refine) fn walk(&mut self, surface: &Surface, vertices: &[u32]) {
        debug_assert!(vertices.len() <= TOGETHER, "{} vertices", vertices.len());
        self.leaving.clear();
        self.lengths = [0; TOGETHER];
        let Some(&last) = vertices.last() else { return };
        // The last vertex stands for missing ones.
        let vertex = |i: usize| vertices.get(i).copied().unwrap_or(last);
        let first: [u32; TOGETHER] = std::array::from_fn(|i| surface.out[vertex(i) as usize]);
        let mut at = first;
        let mut goes_on = [true; TOGETHER];
        while goes_on.contains(&true) {
            self.leaving.push(at);
            for i in 0..TOGETHER {
                let following = surface.twin[previous(at[i]) as usize];
                self.lengths[i] += usize::from(goes_on[i]);
                goes_on[i] &= following != first[i] && following != NONE;
                at[i] = if goes_on[i] { following } else { at[i] };
            }
        }
    }

    /// The half-edges that leave vertex `i` of those that were walked around, in the order of their triangles, as by
    /// [`Surface::around`].
    pub(in crate::refine) fn of(&self, i: usize) -> Fan<'_> {
        Fan { leaving: self.leaving[..self.lengths[i]].iter(), i }
    }
}

/// The half-edges that leave one of some vertices.
#[derive(Clone, Debug)]
pub(in crate::refine) struct Fan<'a> {
    leaving: std::slice::Iter<'a, [u32; TOGETHER]>,
    i: usize,
}

impl Iterator for Fan<'_> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        self.leaving.next().map(|leaving| leaving[self.i])
    }
}

/// Calls `visit` with each of `items` and the half-edges that leave its `vertex`.
pub(in crate::refine) fn around_each<T>(
    surface: &Surface,
    mut items: impl Iterator<Item = T>,
    vertex: impl Fn(&T) -> u32,
    mut visit: impl FnMut(T, Fan),
) {
    let mut fans = Fans::default();
    loop {
        let together: SmallVec<[T; TOGETHER]> = items.by_ref().take(TOGETHER).collect();
        if together.is_empty() {
            return;
        }
        let vertices: SmallVec<[u32; TOGETHER]> = together.iter().map(&vertex).collect();
        fans.walk(surface, &vertices);
        for (i, item) in together.into_iter().enumerate() {
            visit(item, fans.of(i));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;
    use crate::refine::tests::scattered;

    /// Inside, on the border and at corners, vertices of few and of many triangles.
    #[test]
    fn fans_are_what_a_walk_around_each_vertex_visits() {
        let mut surface = Surface::default();
        surface.link(&scattered(Size::new(300, 200), 400));
        let vertices: Vec<u32> = (0..surface.at.len() as u32).collect();
        let mut fans = Fans::default();
        for together in (1..=TOGETHER).flat_map(|count| vertices.chunks(count)) {
            fans.walk(&surface, together);
            for (i, &v) in together.iter().enumerate() {
                let alone = surface.around(v).collect::<Vec<_>>();
                assert_eq!(fans.of(i).collect::<Vec<_>>(), alone, "vertex {v}");
            }
        }
        let mut visited = Vec::new();
        around_each(
            &surface,
            vertices.iter(),
            |&&v| v,
            |&v, fan| {
                assert!(fan.eq(surface.around(v)), "vertex {v}");
                visited.push(v);
            },
        );
        assert_eq!(visited, vertices);
        fans.walk(&surface, &[]);
        assert_eq!(fans.of(0).count(), 0);
    }
}
