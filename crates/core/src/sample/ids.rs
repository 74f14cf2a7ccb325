//! Lasting ids of vertices.

use crate::mesh::{CORNERS, Mesh};

/// Gives vertices their lasting ids, see [`Mesh::ids`].
#[derive(Clone, Debug)]
pub(super) struct Ids {
    /// The first id that no vertex has had.
    next: u64,
}

impl Default for Ids {
    fn default() -> Self {
        Self { next: CORNERS as u64 }
    }
}

impl Ids {
    /// Gives ids to the vertices of a new `mesh`. The corners have 0 to 3; the first seeds keep the ids of the
    /// `survivors`; the others get new ones.
    pub(super) fn number(&mut self, mesh: &mut Mesh, survivors: &[u64]) {
        let born = (mesh.seeds().len() - survivors.len()) as u64;
        mesh.ids.clear();
        mesh.ids.extend(0..CORNERS as u64);
        mesh.ids.extend_from_slice(survivors);
        mesh.ids.extend(self.next..self.next + born);
        self.next += born;
    }

    /// Gives new ids to the vertices that were `replaced`.
    pub(super) fn renew(&mut self, mesh: &mut Mesh, replaced: &[u32]) {
        for &v in replaced {
            mesh.ids[v as usize] = self.next;
            self.next += 1;
        }
    }
}
