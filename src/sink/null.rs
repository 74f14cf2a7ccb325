//! Nowhere: for measuring everything but the writing.

use super::{Picture, Sink};
use crate::colour::{Coding, Form, Layout};
use crate::error::Result;
use crate::frame::Memory;
use crate::stream::StreamInfo;

/// Discards pictures. Those of a video are taken as a video would take them.
#[derive(Debug)]
pub(crate) struct Null {
    form: Option<Form>,
    spent: Memory,
}

impl Null {
    /// For pictures made from the stream `info`.
    pub(crate) fn of(info: &StreamInfo) -> Self {
        let layout = Layout::of_video(info.size);
        let coding = info.colour.as_ref().map(|tags| Coding::of(tags, info.size));
        let form = coding.map(|coding| Form { layout, coding });
        Self { form: form.filter(|form| form.layout.is_squared()), spent: Memory::default() }
    }
}

impl Sink for Null {
    fn write(&mut self, picture: Picture) -> Result<()> {
        self.spent = picture.frame.into_memory();
        Ok(())
    }

    fn form(&self) -> Option<Form> {
        self.form
    }

    fn spent(&mut self) -> Memory {
        std::mem::take(&mut self.spent)
    }

    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}
