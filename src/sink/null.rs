//! Discards pictures: for measurements without writing.

use super::{Needs, Origin, Picture, Sink};
use crate::colour::{Coding, Form, Layout};
use crate::error::Result;
use crate::frame::Buffers;
use crate::stream::StreamInfo;

/// Discards pictures. Those of a video are taken as planes, as by a video file.
#[derive(Debug)]
pub(crate) struct Null {
    form: Option<Form>,
}

impl Null {
    /// For pictures made from the stream `info`.
    pub(crate) fn of(info: &StreamInfo) -> Self {
        let layout = Layout::of_video(info.size);
        let coding = info.colour.as_ref().map(|tags| Coding::of(tags, info.size));
        let form = coding.map(|coding| Form { layout, coding });
        Self { form: form.filter(|form| form.layout.is_squared()) }
    }
}

impl Sink for Null {
    fn needs(&self) -> Needs {
        Needs { form: self.form, ..Needs::default() }
    }

    fn write(&mut self, picture: Picture, _: Option<Origin>) -> Result<Buffers> {
        Ok(picture.frame.into_buffers())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}
