//! Signals. The first Ctrl-C asks for a shorter output, the second ends the program at once. Before there
//! is anything to shorten, the first does.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use polyreel::ffmpeg::Processes;
use polyreel::pipeline::Stop;
use polyreel::sink::Unfinished;

/// Makes the system's limits errors in place of signals: a file that grows beyond `ulimit -f` can no longer be
/// written to, and without memory (`ulimit -v`) the exit code is 1. Programs that this one starts are not
/// affected.
#[cfg(unix)]
pub(crate) fn survive_limits() {
    let nobody_asks = Arc::new(AtomicBool::new(false));
    // Without a handler the program ends at the limit, as the system has it.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, nobody_asks);
    // Memory that cannot be had aborts the program, after a message. That is a failure like any other.
    let always = Arc::new(AtomicBool::new(true));
    let _ =
        signal_hook::flag::register_conditional_shutdown(signal_hook::consts::SIGABRT, 1, always);
}

#[cfg(not(unix))]
pub(crate) fn survive_limits() {}

/// Whether Ctrl-C was pressed, and whether that is enough to end the program.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interrupt(Arc<State>);

#[derive(Debug, Default)]
struct State {
    pressed: AtomicBool,
    begun: AtomicBool,
    processes: Processes,
    unfinished: Unfinished,
}

/// Whether a thread is about to end the program: its exit code is the one that counts.
static ENDING: AtomicBool = AtomicBool::new(false);

/// Does not return while another thread ends the program. What fails because its processes were ended is no
/// error to tell of.
pub(crate) fn let_it_end() {
    while ENDING.load(Ordering::SeqCst) {
        std::thread::park();
    }
}

impl State {
    fn end_at_once(&self) -> ! {
        ENDING.store(true, Ordering::SeqCst);
        self.processes.end_all();
        self.unfinished.remove_all();
        std::process::exit(130);
    }
}

impl Interrupt {
    /// Listens from now on. Once the run has [begun](Self::begin), the first Ctrl-C (or a request to
    /// terminate) makes `stop` ask for the end.
    pub(crate) fn listen(stop: &Stop) -> Self {
        let interrupt = Self::default();
        let (state, stop) = (interrupt.0.clone(), stop.clone());
        // Without a handler Ctrl-C still ends the program, as the system has it.
        let _ = ctrlc::set_handler(move || {
            let again = state.pressed.swap(true, Ordering::SeqCst);
            if again || !state.begun.load(Ordering::SeqCst) {
                state.end_at_once();
            }
            stop.request();
            state.processes.end_readers();
        });
        interrupt
    }

    /// One that listens to nothing, for a run whose processes and temporary files are entered in these lists.
    pub(crate) fn with(processes: Processes, unfinished: Unfinished) -> Self {
        Self(Arc::new(State { processes, unfinished, ..State::default() }))
    }

    /// The list that all processes must be entered in, so that none outlives the program.
    pub(crate) fn processes(&self) -> Processes {
        self.0.processes.clone()
    }

    /// The list that temporary files of outputs must be entered in, so that none is left behind.
    pub(crate) fn unfinished(&self) -> Unfinished {
        self.0.unfinished.clone()
    }

    /// From here on there is an output that can be finished early.
    pub(crate) fn begin(&self) {
        self.0.begun.store(true, Ordering::SeqCst);
    }

    /// Ends all processes, removes what is unfinished, and ends the program with exit code 130.
    pub(crate) fn end_at_once(&self) -> ! {
        self.0.end_at_once()
    }

    /// Whether it was pressed.
    pub(crate) fn happened(&self) -> bool {
        self.0.pressed.load(Ordering::SeqCst)
    }
}
