//! The meshes of all parts, one after another.

use std::path::{Path, PathBuf};

use super::part;
use super::plan::Plan;
use crate::error::{Error, Result};
use crate::mesh_stream::MeshFrame;
use crate::source::mesh_stream::{MeshSource, Meshes};

/// Parts that are read in order.
pub struct Parts {
    /// Those that are still to be opened, the first last, and how many frames they hold.
    waiting: Vec<(PathBuf, u64)>,
    open: Option<Open>,
}

struct Open {
    source: MeshSource,
    path: PathBuf,
    left: u64,
}

impl Parts {
    /// Those of `plan` in `folder`, which have been checked.
    pub fn of(plan: &Plan, folder: &Path) -> Self {
        let part = |chunk: &super::plan::Chunk| (part::meshes(folder, chunk.chunk), chunk.frames);
        Self { waiting: plan.chunks.iter().rev().map(part).collect(), open: None }
    }
}

impl Meshes for Parts {
    fn next_mesh(&mut self) -> Result<Option<MeshFrame>> {
        loop {
            if let Some(open) = &mut self.open {
                match (open.source.next_mesh()?, open.left) {
                    (Some(frame), 1..) => {
                        open.left -= 1;
                        return Ok(Some(frame));
                    }
                    (None, 0) => {}
                    _ => {
                        return Err(Error::input(
                            &open.path,
                            "holds more or fewer frames than planned",
                        ));
                    }
                }
            }
            let Some((path, left)) = self.waiting.pop() else { return Ok(None) };
            self.open = Some(Open { source: MeshSource::open(&path)?, path, left });
        }
    }
}
