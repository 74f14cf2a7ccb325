//! The details of an earlier run, from its report.

use std::fmt;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::{
    DeserializeSeed, Deserializer, Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor,
};
use serde_json::Value;

use crate::error::{Error, Result};
use crate::options::{Detail, Options};

/// The largest report that is read, in bytes: a million frames. Some 20 bytes are kept for each frame.
const MAX_BYTES: u64 = 512 << 20;

/// The details of the frames of an earlier run, and its options. With the same input and options they give the same
/// bytes.
#[derive(Clone, Debug)]
pub struct Script {
    path: PathBuf,
    options: Options,
    details: Vec<Detail>,
}

impl Script {
    /// Reads the report at `path`, written by `--report`.
    ///
    /// # Errors
    /// When it cannot be read, or is not a report: the error names the key and the frame.
    pub fn read(path: &Path) -> Result<Self> {
        let wrong = |error: std::io::Error| {
            Error::input(path, format!("cannot be read: {error}")).caused_by(error)
        };
        let file = File::open(path).map_err(wrong)?;
        if file.metadata().map_err(wrong)?.len() > MAX_BYTES {
            let most = MAX_BYTES >> 20;
            return Err(Error::input(
                path,
                format!("is too large for a report: {most} MiB at most"),
            ));
        }
        Self::parse(path, BufReader::new(file.take(MAX_BYTES)))
    }

    /// Reads a report as a stream: only the data for a replay is kept.
    #[doc(hidden)]
    pub fn parse(path: &Path, text: impl Read) -> Result<Self> {
        let mut found = Found::default();
        let mut json = serde_json::Deserializer::from_reader(text);
        let read = found.deserialize(&mut json).and_then(|()| json.end());
        let missing = |key: &str, why: String| {
            let what = format!("'{key}' is missing or damaged{why}: name a file of --report");
            Error::input(path, what)
        };
        if let Err(error) = read {
            return Err(match found.at {
                At::Report => Error::input(path, format!("is no report (JSON): {error}")),
                At::Options => missing("options", format!(" ({error})")),
                At::Frames => missing("per_frame", format!(" ({error})")),
                At::Frame => {
                    let what = found.fault.unwrap_or_else(|| error.to_string());
                    Error::input_frame(path, found.details.len() as u64, what)
                }
            }
            .caused_by(error));
        }
        let options = found.options.ok_or_else(|| missing("options", String::new()))?;
        if !found.frames {
            return Err(missing("per_frame", String::new()));
        }
        Ok(Self { path: path.to_owned(), options, details: found.details })
    }

    /// Checks that the run had the same `options`.
    ///
    /// # Errors
    /// When an option differs: the error names the first one and both values.
    pub fn check(&self, options: &Options) -> Result<()> {
        // By way of text, as in the report: the last digit of a float may change.
        let text = serde_json::to_string(options).expect("options are plain data");
        let options: Options = serde_json::from_str(&text).expect("what was written is JSON");
        let [then, now] = [&self.options, &options]
            .map(|options| serde_json::to_value(options).expect("options are plain data"));
        let mut keys = now.as_object().into_iter().flat_map(|map| map.keys());
        let Some(key) = keys.find(|key| now.get(key.as_str()) != then.get(key.as_str())) else {
            return Ok(());
        };
        let written = |options: &Value| match options.get(key.as_str()) {
            None => "unknown".to_owned(),
            Some(Value::String(text)) => text.clone(),
            Some(value) => value.to_string(),
        };
        Err(Error::input(
            &self.path,
            format!("{key} was {} in that run and is {} now", written(&then), written(&now)),
        ))
    }

    /// The number of frames.
    pub fn frames(&self) -> u64 {
        self.details.len() as u64
    }

    /// The detail of frame `index`.
    pub(super) fn detail(&self, index: u64) -> Result<Detail> {
        let found = usize::try_from(index).ok().and_then(|index| self.details.get(index));
        found.copied().ok_or_else(|| {
            let held = self.frames();
            Error::input(&self.path, format!("the input has more than its {held} frames"))
        })
    }

    /// Checks that the input may end before frame `index`.
    pub(super) fn check_end(&self, index: u64) -> Result<()> {
        let held = self.frames();
        if index == held {
            return Ok(());
        }
        let what = format!("it holds {held} frames, and the input only {index}");
        Err(Error::input(&self.path, what))
    }
}

/// The part of a report that was read.
#[derive(Default)]
struct Found {
    options: Option<Options>,
    /// Whether there is a list of frames.
    frames: bool,
    details: Vec<Detail>,
    /// The current position in the report, for messages.
    at: At,
    /// The error of a frame that is valid JSON.
    fault: Option<String>,
}

/// A position in a report.
#[derive(Default)]
enum At {
    #[default]
    Report,
    Options,
    Frames,
    Frame,
}

impl<'de> DeserializeSeed<'de> for &mut Found {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> std::result::Result<(), D::Error> {
        from.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for &mut Found {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a report")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<(), A::Error> {
        while let Some(key) = map.next_key::<Key>()? {
            match key {
                Key::Options => {
                    self.at = At::Options;
                    self.options = Some(map.next_value()?);
                }
                Key::PerFrame => {
                    self.at = At::Frames;
                    map.next_value_seed(Frames(self))?;
                    self.frames = true;
                }
                Key::Other => {
                    map.next_value::<IgnoredAny>()?;
                }
            }
            self.at = At::Report;
        }
        Ok(())
    }
}

/// The keys of a report that a replay needs.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum Key {
    Options,
    PerFrame,
    #[serde(other)]
    Other,
}

/// The list of frames.
struct Frames<'a>(&'a mut Found);

impl<'de> DeserializeSeed<'de> for Frames<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> std::result::Result<(), D::Error> {
        from.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Frames<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list of frames")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut frames: A) -> std::result::Result<(), A::Error> {
        self.0.at = At::Frame;
        while let Some(frame) = frames.next_element::<FrameLine>()? {
            match frame.detail(self.0.details.len() as u64) {
                Ok(detail) => self.0.details.push(detail),
                Err(fault) => {
                    self.0.fault = Some(fault);
                    return Err(A::Error::custom("a frame is wrong"));
                }
            }
        }
        Ok(())
    }
}

/// The fields of a frame that are read.
#[derive(Deserialize)]
struct FrameLine {
    index: Option<u64>,
    #[serde(default, deserialize_with = "orders")]
    orders: Option<Detail>,
}

/// A frame's detail; an error names the key.
fn orders<'de, D: Deserializer<'de>>(from: D) -> std::result::Result<Option<Detail>, D::Error> {
    Detail::deserialize(from).map(Some).map_err(|e| D::Error::custom(format!("'orders': {e}")))
}

impl FrameLine {
    /// The detail of frame `index`, or the error.
    fn detail(self, index: u64) -> std::result::Result<Detail, String> {
        match self.index {
            Some(found) if found == index => {}
            Some(found) => {
                return Err(format!(
                    "'index' is {found}: frames were dropped, or the report is damaged"
                ));
            }
            None => return Err("'index' is missing".to_owned()),
        }
        let detail = self.orders.ok_or("'orders' is missing")?;
        detail.validate().map_err(|error| format!("'orders': {error}"))?;
        Ok(detail)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Steps;
    use serde_json::json;

    fn parse(report: &Value) -> Result<Script> {
        Script::parse(Path::new("r.json"), report.to_string().as_bytes())
    }

    fn report() -> Value {
        let detail = Detail { steps: Some(Steps::from_eighths(11)), seeds: 70, ..Detail::FULL };
        json!({
            "options": Options::default(),
            "per_frame": [
                {"index": 0, "orders": Detail::FULL, "detail": 1.0},
                {"index": 1, "orders": detail, "detail": 0.9},
            ],
        })
    }

    #[test]
    fn details_come_back() {
        let script = parse(&report()).expect("a report");
        script.check(&Options::default()).expect("the same options");
        assert_eq!(script.detail(0).expect("there"), Detail::FULL);
        assert_eq!(script.detail(1).expect("there").steps, Some(Steps::from_eighths(11)));
        script.check_end(2).expect("as many frames");
        let few = script.check_end(1).expect_err("one frame less").to_string();
        assert_eq!(few, "r.json: it holds 2 frames, and the input only 1");
        let many = script.detail(2).expect_err("one frame more").to_string();
        assert_eq!(many, "r.json: the input has more than its 2 frames");
    }

    #[test]
    fn damage_is_named() {
        let said = |change: &dyn Fn(&mut Value)| {
            let mut report = report();
            change(&mut report);
            parse(&report).expect_err("damaged").to_string()
        };
        assert!(said(&|r| r["options"] = json!(null)).contains("'options'"));
        assert!(said(&|r| r["per_frame"] = json!(3)).contains("'per_frame'"));
        let frame = said(&|r| r["per_frame"][1]["index"] = json!(4));
        assert!(frame.starts_with("r.json, frame 1: 'index' is 4"), "{frame}");
        let key = said(&|r| r["per_frame"][1]["orders"]["stpes"] = json!(4));
        assert!(key.starts_with("r.json, frame 1: 'orders': unknown field `stpes`"), "{key}");
        let range = said(&|r| r["per_frame"][0]["orders"]["rows"] = json!(9));
        assert_eq!(range, "r.json, frame 0: 'orders': rows is 9; it can be 1 to 4");
        let gone = said(&|r| {
            r["per_frame"][0].as_object_mut().expect("an object").remove("orders");
        });
        assert_eq!(gone, "r.json, frame 0: 'orders' is missing");
        let parse = |text: &str| Script::parse(Path::new("r.json"), text.as_bytes());
        let cut = parse("{\"options\": ").expect_err("cut short").to_string();
        assert!(cut.starts_with("r.json: 'options' is missing or damaged (EOF"), "{cut}");
        for text in ["", "3", "[1, 2]", "null", "\"report\"", "{", "{} {}", "nonsense"] {
            let said = parse(text).expect_err("no report").to_string();
            assert!(said.starts_with("r.json: is no report (JSON)"), "{text}: {said}");
        }
        assert!(parse("{}").expect_err("nothing in it").to_string().contains("'options'"));
    }

    #[test]
    fn other_options_are_named() {
        let script = parse(&report()).expect("a report");
        let other = Options { clusters: 9, ..Options::default() };
        let said = script.check(&other).expect_err("other options").to_string();
        assert_eq!(said, "r.json: clusters was 8 in that run and is 9 now");
    }
}
