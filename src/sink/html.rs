//! A page that plays: the mesh stream, and a script that reads and paints it, in one file.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use base64::engine::general_purpose::{GeneralPurpose, STANDARD};
use base64::write::EncoderWriter;

use super::SinkOptions;
use super::mesh_stream::Body;
use crate::stream::StreamInfo;

/// Reads the stream and paints its frames: needs no page.
const STREAM: &str = include_str!("html/stream.js");
/// Plays it.
const PAGE: &str = include_str!("html/page.js");

/// The page around a stream that is being written.
pub(super) struct Page(EncoderWriter<'static, GeneralPurpose, BufWriter<File>>);

impl Page {
    /// A page in `file`, for a stream made from `info`; what comes before the stream is written.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(super) fn begin(file: File, info: &StreamInfo, options: &SinkOptions) -> io::Result<Self> {
        let mut out = BufWriter::new(file);
        out.write_all(head(info, options).as_bytes())?;
        Ok(Self(EncoderWriter::new(out, &STANDARD)))
    }
}

impl Write for Page {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

impl Body for Page {
    fn end(mut self) -> io::Result<()> {
        let mut out = self.0.finish()?;
        write!(out, "</script>\n<script>\n{}{}</script>\n", compact(STREAM), compact(PAGE))?;
        out.flush()
    }
}

fn head(info: &StreamInfo, options: &SinkOptions) -> String {
    let stem = options.inputs.first().and_then(|input| Path::file_stem(input));
    let title = stem.map_or_else(|| "polyreel".to_owned(), |stem| escaped(&stem.to_string_lossy()));
    // What is transparent shows the page that this one stands in; around what is opaque it is dark.
    let ground = if info.alpha { "" } else { ";background:#111" };
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <meta name=\"generator\" content=\"polyreel {}\">\n<title>{title}</title>\n\
         <style>body{{margin:0;height:100vh;display:flex;align-items:center;justify-content:center;\
         overflow:hidden{ground}}}canvas{{cursor:pointer}}</style>\n\
         <canvas role=\"img\" aria-label=\"{title}\"></canvas>\n<script type=\"text/plain\" id=\"stream\">",
        env!("CARGO_PKG_VERSION")
    )
}

/// `script` without comments and indentation.
fn compact(script: &str) -> String {
    let lines = script.lines().map(str::trim_start);
    let lines = lines.filter(|line| !line.is_empty() && !line.starts_with("//"));
    lines.fold(String::new(), |text, line| text + line + "\n")
}

/// `text` as HTML, also between quotes.
fn escaped(text: &str) -> String {
    let escape = |c: char| match c {
        '&' => "&amp;".to_owned(),
        '<' => "&lt;".to_owned(),
        '>' => "&gt;".to_owned(),
        '"' => "&quot;".to_owned(),
        c => c.to_string(),
    };
    text.chars().map(escape).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_script_is_a_few_kilobytes() {
        let script = compact(STREAM) + &compact(PAGE);
        assert!(script.len() < 26 << 10, "{} bytes", script.len());
        assert!(
            !script.contains("//") && !script.contains("</"),
            "it would end or hide in the page"
        );
    }

    #[test]
    fn names_are_escaped() {
        assert_eq!(escaped("a<b>&\"c\""), "a&lt;b&gt;&amp;&quot;c&quot;");
    }
}
