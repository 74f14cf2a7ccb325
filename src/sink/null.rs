//! Nowhere: for measuring everything but the writing.

use super::{Picture, Sink};
use crate::error::Result;
use crate::frame::Rgba;

/// Discards pictures.
#[derive(Debug, Default)]
pub(crate) struct Null {
    spent: Vec<Rgba>,
}

impl Sink for Null {
    fn write(&mut self, picture: Picture) -> Result<()> {
        self.spent = picture.frame.into_pixels();
        Ok(())
    }

    fn spent(&mut self) -> Vec<Rgba> {
        std::mem::take(&mut self.spent)
    }

    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}
