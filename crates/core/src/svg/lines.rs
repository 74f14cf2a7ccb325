//! Edges as few long lines.

use super::path::PathData;

/// A path that draws each of `edges` once, going on from edge to edge as far as it can.
pub(super) fn path(vertices: &[(i32, i32)], edges: &[[u32; 2]]) -> PathData {
    let mut around = vec![Vec::new(); vertices.len()];
    for (e, &[a, b]) in edges.iter().enumerate() {
        around[a as usize].push((e, b));
        around[b as usize].push((e, a));
    }
    let mut drawn = vec![false; edges.len()];
    let mut data = PathData::default();
    for (e, &[a, _]) in edges.iter().enumerate() {
        if drawn[e] {
            continue;
        }
        let mut at = a as usize;
        data.jump(vertices[at]);
        while let Some((e, next)) = next_edge(&mut around[at], &drawn) {
            drawn[e] = true;
            at = next as usize;
            data.line(vertices[at]);
        }
    }
    data
}

/// An edge that is not drawn yet; those that are drawn are let go.
fn next_edge(around: &mut Vec<(usize, u32)>, drawn: &[bool]) -> Option<(usize, u32)> {
    while let Some(edge) = around.pop() {
        if !drawn[edge.0] {
            return Some(edge);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_edge_is_drawn_once() {
        let vertices = [(0, 0), (10, 0), (10, 10), (0, 10)];
        let edges = [[0, 1], [1, 2], [2, 3], [0, 3], [0, 2]];
        let text = path(&vertices, &edges).text().to_owned();
        let numbers = text
            .replace(['m', 'z'], " ")
            .replace('-', " -")
            .split_whitespace()
            .filter_map(|n| n.parse::<i32>().ok())
            .count();
        let starts = text.matches('m').count();
        assert_eq!(numbers / 2 - starts, edges.len(), "{text}");
        assert_eq!(starts, 1, "{text}");
    }
}
