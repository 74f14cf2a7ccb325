//! Numbers of vertices that last as long as the vertices.

use crate::mesh::{CORNERS, Mesh};

/// Gives vertices their numbers, see [`Mesh::ids`].
#[derive(Clone, Debug)]
pub(super) struct Ids {
    /// The first number that no vertex has had.
    next: u64,
}

impl Default for Ids {
    fn default() -> Self {
        Self { next: CORNERS as u64 }
    }
}

impl Ids {
    /// Numbers the vertices of a new `mesh`: its corners, the first seeds as `survivors` were numbered before,
    /// and the other seeds anew.
    pub(super) fn number(&mut self, mesh: &mut Mesh, survivors: &[u64]) {
        let born = (mesh.seeds().len() - survivors.len()) as u64;
        mesh.ids.clear();
        mesh.ids.extend(0..CORNERS as u64);
        mesh.ids.extend_from_slice(survivors);
        mesh.ids.extend(self.next..self.next + born);
        self.next += born;
    }

    /// Numbers the vertices anew that were `replaced`: taken from one place and put in at another.
    pub(super) fn renew(&mut self, mesh: &mut Mesh, replaced: &[u32]) {
        for &v in replaced {
            mesh.ids[v as usize] = self.next;
            self.next += 1;
        }
    }
}
