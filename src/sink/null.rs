//! Nowhere: for measuring everything but the writing.

use super::{Picture, Sink};
use crate::error::Result;
use crate::frame::Memory;

/// Discards pictures.
#[derive(Debug, Default)]
pub(crate) struct Null {
    spent: Memory,
}

impl Sink for Null {
    fn write(&mut self, picture: Picture) -> Result<()> {
        self.spent = picture.frame.into_memory();
        Ok(())
    }

    fn spent(&mut self) -> Memory {
        std::mem::take(&mut self.spent)
    }

    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}
