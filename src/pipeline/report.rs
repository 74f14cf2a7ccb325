//! The report of a run: of every frame, in total, and as JSON.

use std::ffi::OsStr;
use std::time::{Duration, Instant};

use serde::ser::{Serialize, SerializeMap, Serializer};

use crate::error::Error;
use crate::geom::Size;
use crate::governor::Change;
use crate::options::{Detail, Options};
use crate::stage::{Percentiles, Stage, Timing};
use crate::stream::StreamInfo;

/// The figures of one frame.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct FrameReport {
    /// Number of the frame in the source, from 0. Dropped frames leave gaps.
    pub index: u64,
    /// When it is shown, in seconds.
    pub pts_s: f64,
    /// Feature points that level one found.
    pub candidates: usize,
    /// Seeds of its mesh.
    pub seeds: usize,
    /// Seeds of the last frame that have not moved.
    pub seeds_kept: usize,
    /// Seeds of the last frame that have moved with the picture.
    pub seeds_moved: usize,
    /// New seeds.
    pub seeds_born: usize,
    /// Seeds of the last frame that were removed.
    pub seeds_died: usize,
    /// Triangles of its mesh.
    pub triangles: usize,
    /// Number of refinement steps, the last perhaps in part: see [`FrameReport::orders`].
    pub refine_steps: u32,
    /// Likeness to the source in the measure of `--error`, for frames that were refined to a target.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub likeness: Option<f64>,
    /// Faces in focus, with `--focus faces`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub faces: Option<usize>,
    /// Whether that is less than the target.
    #[serde(skip)]
    pub short: bool,
    /// Share of the requested quality, 1 without a budget.
    pub detail: f64,
    /// The detail of the frame, for a replay.
    pub orders: Detail,
    /// The changes of detail by the governor at this frame, and their reasons.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<Change>,
    /// Whether a new shot begins with it.
    pub cut: bool,
    /// When it arrived from a live source.
    #[serde(skip)]
    pub(super) arrived: Option<Instant>,
    /// Milliseconds from its arrival from a live source until it was written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_ms: Option<f64>,
    /// Time at work in each stage.
    #[serde(rename = "ms", serialize_with = "milliseconds")]
    pub timing: Timing,
}

impl FrameReport {
    /// An empty report of frame `index`.
    pub(super) fn new(index: u64) -> Self {
        Self {
            index,
            pts_s: 0.0,
            candidates: 0,
            seeds: 0,
            seeds_kept: 0,
            seeds_moved: 0,
            seeds_born: 0,
            seeds_died: 0,
            triangles: 0,
            refine_steps: 0,
            likeness: None,
            faces: None,
            short: false,
            detail: 1.0,
            orders: Detail::FULL,
            changes: Vec::new(),
            cut: false,
            arrived: None,
            delay_ms: None,
            timing: Timing::default(),
        }
    }
}

fn milliseconds<S: Serializer>(timing: &Timing, to: S) -> Result<S::Ok, S::Error> {
    let mut map = to.serialize_map(Some(Stage::ALL.len()))?;
    for stage in Stage::ALL {
        map.serialize_entry(stage.name(), &(timing.get(stage).as_secs_f64() * 1e3))?;
    }
    map.end()
}

/// Median and tails of the times of every stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageTimes(pub(super) [Percentiles; Stage::ALL.len()]);

impl StageTimes {
    /// Those of `stage`.
    pub fn get(&self, stage: Stage) -> Percentiles {
        self.0[stage as usize]
    }
}

impl Serialize for StageTimes {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(Stage::ALL.len()))?;
        for stage in Stage::ALL {
            map.serialize_entry(stage.name(), &self.get(stage))?;
        }
        map.end()
    }
}

/// How a successful run ended.
#[derive(Debug)]
#[non_exhaustive]
pub enum Ending {
    /// At the end of the input.
    Complete,
    /// By a request to stop; the output is shorter.
    Stopped,
    /// The reader of the output closed it.
    Closed,
    /// At the end of a truncated input, if allowed; the output has the frames before it.
    Truncated(Error),
}

/// The figures of a run in total.
#[derive(Debug)]
#[non_exhaustive]
pub struct Summary {
    /// Frames written.
    pub frames: u64,
    /// Frames of a live source that were dropped.
    pub dropped: u64,
    /// Frames that were refined to a target and did not reach it.
    pub short: u64,
    /// Frames in which `--focus faces` found none.
    pub faceless: u64,
    /// The lowest likeness of the frames that were refined to a target.
    pub likeness: Option<f64>,
    /// How the time budget was kept.
    pub budget: BudgetReport,
    /// Time from the arrival of frames of a live source until they were written.
    pub delay: Option<Percentiles>,
    /// From start to finished output.
    pub wall: Duration,
    /// Median and tails of the stages' times, within 0.8 %.
    pub stages: StageTimes,
    /// How it ended.
    pub ending: Ending,
}

impl Summary {
    /// Frames written a second.
    pub fn fps(&self) -> f64 {
        let seconds = self.wall.as_secs_f64();
        if seconds > 0.0 { self.frames as f64 / seconds } else { 0.0 }
    }
}

/// A run as `--report` writes it.
#[derive(Debug, serde::Serialize)]
pub struct Report {
    /// What was read.
    pub input: InputReport,
    /// What was written.
    pub output: OutputReport,
    /// How it was rendered.
    pub options: Options,
    /// Frames written.
    pub frames: u64,
    /// Frames of a live source that were dropped.
    pub dropped: u64,
    /// Time from the arrival of frames of a live source until they were written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay: Option<Percentiles>,
    /// Seconds from start to finished output.
    pub wall_s: f64,
    /// Frames written a second.
    pub fps: f64,
    /// Median and tails of each stage's time.
    pub stages: StageTimes,
    /// How the time budget was kept.
    pub budget: BudgetReport,
    /// Every frame, in order.
    pub per_frame: Vec<FrameReport>,
}

impl Report {
    /// The report of a run with `summary` and its frames.
    pub fn new(
        input: InputReport,
        output: OutputReport,
        options: Options,
        summary: &Summary,
        per_frame: Vec<FrameReport>,
    ) -> Self {
        Self {
            input,
            output,
            options,
            frames: summary.frames,
            dropped: summary.dropped,
            delay: summary.delay,
            wall_s: summary.wall.as_secs_f64(),
            fps: summary.fps(),
            stages: summary.stages,
            budget: summary.budget,
            per_frame,
        }
    }
}

/// What was read.
#[derive(Debug, serde::Serialize)]
pub struct InputReport {
    /// The inputs as they were named.
    pub paths: Vec<String>,
    /// What was known of the stream before it was read.
    #[serde(flatten)]
    pub info: StreamInfo,
}

impl InputReport {
    /// The report on `inputs`, which are a stream of `info`. JSON has no place for names that are not
    /// UTF-8: their other bytes become replacement characters.
    pub fn new(inputs: &[impl AsRef<OsStr>], info: StreamInfo) -> Self {
        let name = |input: &_| AsRef::<OsStr>::as_ref(input).to_string_lossy().into_owned();
        Self { paths: inputs.iter().map(name).collect(), info }
    }
}

/// What was written.
#[derive(Debug, serde::Serialize)]
pub struct OutputReport {
    /// The output as it was named.
    pub path: String,
    /// Size of every frame.
    pub size: Size,
    /// Bytes of the file; `None` for several files and for standard output.
    pub bytes: Option<u64>,
    /// What the user should know about the output.
    pub warnings: Vec<String>,
}

/// How the time budget was kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct BudgetReport {
    /// Time for each frame; `None` when none was set.
    pub ms: Option<f64>,
    /// Frames for which one of the threads between decode and encode (level one; sample, triangulate
    /// and refine; the rasteriser) took longer. Decode and encode wait for other programs and are not
    /// counted.
    pub missed: u64,
    /// How often a part of the detail was changed.
    pub changes: u64,
}

impl BudgetReport {
    /// The report of a run with this much time for a frame, before it began.
    pub(super) fn new(time: Option<Duration>) -> Self {
        Self { ms: time.map(|time| time.as_secs_f64() * 1e3), ..Self::default() }
    }
}
