//! The details of a former run, from its report.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::error::{Error, Result};
use crate::options::{Detail, Options};

/// The largest report that is read: a million frames.
const MOST_BYTES: u64 = 1 << 30;

/// What the frames of a former run cost, and the options that it ran with. With the same input and the
/// same options it gives the same bytes again.
#[derive(Clone, Debug)]
pub struct Script {
    path: PathBuf,
    options: Value,
    details: Vec<Detail>,
}

impl Script {
    /// Reads the report at `path`, one that `--report` wrote.
    ///
    /// # Errors
    /// When it cannot be read, or is not such a report: names the key, and the frame.
    pub fn read(path: &Path) -> Result<Self> {
        let wrong = |error: std::io::Error| Error::input(path, format!("cannot be read: {error}"));
        if std::fs::metadata(path).map_err(wrong)?.len() > MOST_BYTES {
            return Err(Error::input(path, "is too large for a report"));
        }
        Self::parse(path, &std::fs::read(path).map_err(wrong)?)
    }

    fn parse(path: &Path, bytes: &[u8]) -> Result<Self> {
        let mut report: Value = serde_json::from_slice(bytes)
            .map_err(|error| Error::input(path, format!("is no report (JSON): {error}")))?;
        let missing = |key: &str| {
            Error::input(path, format!("'{key}' is missing or damaged: name a file of --report"))
        };
        let options = report["options"].take();
        if !options.is_object() {
            return Err(missing("options"));
        }
        let Value::Array(frames) = report["per_frame"].take() else {
            return Err(missing("per_frame"));
        };
        let details = frames.into_iter().zip(0..).map(|(frame, index)| detail(path, frame, index));
        Ok(Self { path: path.to_owned(), options, details: details.collect::<Result<_>>()? })
    }

    /// Checks that the run had the same `options`.
    ///
    /// # Errors
    /// Names the first option that differs, and both values.
    pub fn check(&self, options: &Options) -> Result<()> {
        // Through text and back, as the report went: a float's last digit may change on that way.
        let text = serde_json::to_string(options).expect("options are plain data");
        let mine: Value = serde_json::from_str(&text).expect("what was written is JSON");
        let keys = mine.as_object().into_iter().chain(self.options.as_object());
        let mut keys = keys.flat_map(|map| map.keys());
        let Some(key) = keys.find(|key| mine.get(key.as_str()) != self.options.get(key.as_str()))
        else {
            return Ok(());
        };
        let told = |options: &Value| match options.get(key.as_str()) {
            None => "unknown".to_owned(),
            Some(Value::String(text)) => text.clone(),
            Some(value) => value.to_string(),
        };
        Err(Error::input(
            &self.path,
            format!("{key} was {} in that run and is {} now", told(&self.options), told(&mine)),
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

    /// The input has ended before frame `index`.
    pub(super) fn end(&self, index: u64) -> Result<()> {
        let held = self.frames();
        if index == held {
            return Ok(());
        }
        let what = format!("it holds {held} frames, and the input only {index}");
        Err(Error::input(&self.path, what))
    }
}

/// The detail in the report of frame `index`.
fn detail(path: &Path, mut frame: Value, index: u64) -> Result<Detail> {
    let wrong = |what: String| Error::input_frame(path, index, what);
    match frame["index"].as_u64() {
        Some(found) if found == index => {}
        Some(found) => {
            return Err(wrong(format!(
                "'index' is {found}: frames were dropped, or the report is damaged"
            )));
        }
        None => return Err(wrong("'index' is missing".to_owned())),
    }
    let orders = frame.get_mut("orders").map(Value::take);
    let orders = orders.ok_or_else(|| wrong("'orders' is missing".to_owned()))?;
    let detail: Detail =
        serde_json::from_value(orders).map_err(|error| wrong(format!("'orders': {error}")))?;
    detail.validate().map_err(|error| wrong(format!("'orders': {error}")))?;
    Ok(detail)
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
        script.end(2).expect("as many frames");
        let few = script.end(1).expect_err("one frame less").to_string();
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
        let cut = Script::parse(Path::new("r.json"), b"{\"options\": ").expect_err("cut short");
        assert!(cut.to_string().contains("is no report (JSON)"), "{cut}");
    }

    #[test]
    fn other_options_are_named() {
        let script = parse(&report()).expect("a report");
        let other = Options { clusters: 9, ..Options::default() };
        let said = script.check(&other).expect_err("other options").to_string();
        assert_eq!(said, "r.json: clusters was 8 in that run and is 9 now");
    }
}
