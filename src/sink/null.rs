//! Nowhere: for measuring everything but the writing.

use super::{Picture, Sink};
use crate::error::Result;

/// Discards pictures.
#[derive(Debug)]
pub(crate) struct Null;

impl Sink for Null {
    fn write(&mut self, _: Picture) -> Result<()> {
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}
