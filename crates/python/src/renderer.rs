//! The renderer of a stream of frames, one frame at a time.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Sender, bounded};
use polyreel::{Controls, FrameReport, Life, Options, Rgba, Size};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator};

use crate::error::{fault, raise};
use crate::picture::{self, Kind, Packed};
use crate::stream::FrameStream;
use crate::work::{wait, work};

/// Renders `picture` by itself, as the program renders a still.
#[pyfunction]
#[pyo3(signature = (picture, **options))]
pub(crate) fn render<'py>(
    picture: &Bound<'py, PyAny>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let mut options = crate::options::look(options)?;
    // Nothing comes after it.
    options.coherence = 0.0;
    let py = picture.py();
    let (frame, kind) = picture::frame(picture, Vec::new())?;
    let rendered: polyreel::Result<_> = work(py, move || {
        let rendered = polyreel::Renderer::new(&options)?.render(&frame)?;
        Ok(Packed::of(&rendered.picture, kind))
    })?;
    Ok(rendered.map_err(raise)?.array(py))
}

/// One stream of frames. Its mesh lives on from frame to frame. Calls from several threads take turns.
#[pyclass(frozen, module = "polyreel._polyreel")]
pub(crate) struct Renderer {
    /// Who renders takes the state out, and puts it back.
    take: Receiver<State>,
    put: Sender<State>,
    /// Options of the streams that are under way, too.
    controls: Controls,
    stats: LastStats,
}

/// The figures of the last frame, where one was rendered.
pub(crate) type LastStats = Arc<Mutex<Option<Stats>>>;

struct State {
    options: Options,
    /// Made at the first frame, with the size of the frames.
    renderer: Option<(polyreel::Renderer, Size)>,
    /// Memory of the last frame, for the next one.
    room: Vec<Rgba>,
}

/// How a frame came to be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stats {
    life: Life,
    seeds: usize,
    triangles: usize,
    refine_steps: u32,
    time: Duration,
}

impl Stats {
    pub(crate) fn of(report: &FrameReport) -> Self {
        let mut life = Life::default();
        life.cut = report.cut;
        (life.kept, life.moved) = (report.seeds_kept, report.seeds_moved);
        (life.born, life.died) = (report.seeds_born, report.seeds_died);
        let stages = polyreel::Stage::ALL.map(|stage| report.timing.get(stage));
        Self {
            life,
            seeds: report.seeds,
            triangles: report.triangles,
            refine_steps: report.refine_steps,
            time: stages.iter().sum(),
        }
    }
}

impl State {
    fn new(options: Options) -> Self {
        Self { options, renderer: None, room: Vec::new() }
    }

    fn render(&mut self, frame: &polyreel::Frame, kind: Kind) -> polyreel::Result<(Packed, Stats)> {
        let began = Instant::now();
        let size = frame.size();
        // Frames of another size are another stream.
        let mut renderer = match self.renderer.take() {
            Some((renderer, last)) if last == size => renderer,
            _ => polyreel::Renderer::new(&self.options)?,
        };
        let rendered = renderer.render(frame)?;
        let time = began.elapsed();
        self.renderer = Some((renderer, size));
        let stats = Stats {
            life: rendered.life,
            seeds: rendered.mesh.seed_ids().count(),
            triangles: rendered.mesh.triangles.len(),
            refine_steps: rendered.refine_steps,
            time,
        };
        Ok((Packed::of(&rendered.picture, kind), stats))
    }
}

impl Renderer {
    /// Takes the state; [`Renderer::put`] gives it back in any case.
    fn take(&self, py: Python<'_>) -> PyResult<State> {
        wait(py, &self.take)?.ok_or_else(fault)
    }

    fn put(&self, state: State) {
        // There is one state, and room for it.
        let _ = self.put.try_send(state);
    }

    fn note(&self, stats: Option<Stats>) {
        *self.stats.lock().unwrap_or_else(PoisonError::into_inner) = stats;
    }
}

#[pymethods]
impl Renderer {
    #[new]
    #[pyo3(signature = (**options))]
    fn new(options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let options = crate::options::look(options)?;
        let controls = Controls::new(options.clone()).map_err(raise)?;
        let (put, take) = bounded(1);
        let this = Self { take, put, controls, stats: Arc::default() };
        this.put(State::new(options));
        Ok(this)
    }

    /// The next frame of the stream. One of another size begins a new stream.
    fn render<'py>(&self, frame: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let py = frame.py();
        let mut state = self.take(py)?;
        let (frame, kind) = match picture::frame(frame, std::mem::take(&mut state.room)) {
            Ok(frame) => frame,
            Err(error) => {
                self.put(state);
                return Err(error);
            }
        };
        let options = state.options.clone();
        let rendered = work(py, move || {
            let rendered = state.render(&frame, kind);
            state.room = frame.into_pixels();
            (state, rendered)
        });
        match rendered {
            Ok((state, rendered)) => {
                self.put(state);
                let (packed, stats) = rendered.map_err(raise)?;
                self.note(Some(stats));
                Ok(packed.array(py))
            }
            Err(error) => {
                // The state is still at work, or gone.
                self.put(State::new(options));
                Err(error)
            }
        }
    }

    /// Renders the frames of an iterable on threads, some frames ahead; see `polyreel.Renderer.stream`.
    fn stream(&self, frames: &Bound<'_, PyAny>) -> PyResult<FrameStream> {
        let iterator = PyIterator::from_object(frames)?.unbind();
        Ok(FrameStream::new(iterator, self.controls.clone(), self.stats.clone()))
    }

    /// Forgets all frames: the next one begins a new stream.
    fn reset(&self, py: Python<'_>) -> PyResult<()> {
        let state = self.take(py)?;
        self.put(State::new(state.options));
        self.note(None);
        Ok(())
    }

    /// Changes options from the next frame on. Others return to their defaults.
    #[pyo3(signature = (**options))]
    fn retune(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
        let options = crate::options::look(options)?;
        let mut state = self.take(py)?;
        let done = match &mut state.renderer {
            Some((renderer, _)) => renderer.retune(&options),
            None => Ok(()),
        };
        if done.is_ok() {
            state.options.clone_from(&options);
        }
        self.put(state);
        done.map_err(raise)?;
        self.controls.set(options).map_err(raise)
    }

    /// How the last frame came to be; `None` before the first one.
    #[getter]
    fn stats<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let last = *self.stats.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(stats) = last else { return Ok(None) };
        let dict = PyDict::new(py);
        dict.set_item("cut", stats.life.cut)?;
        dict.set_item("kept", stats.life.kept)?;
        dict.set_item("moved", stats.life.moved)?;
        dict.set_item("born", stats.life.born)?;
        dict.set_item("died", stats.life.died)?;
        dict.set_item("seeds", stats.seeds)?;
        dict.set_item("triangles", stats.triangles)?;
        dict.set_item("refine_steps", stats.refine_steps)?;
        dict.set_item("milliseconds", stats.time.as_secs_f64() * 1e3)?;
        Ok(Some(dict))
    }
}
