//! Python watching and stopping a run: signals, callbacks.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use facerecon_core::observer::{Artifact, Event, Observer};
use facerecon_core::pipeline::Error;
use pyo3::prelude::*;

use crate::errors::to_py;

/// Signals are looked for this often: rarely enough to leave other Python threads alone.
const PATIENCE: Duration = Duration::from_millis(50);

/// An observer that calls back and lets Ctrl-C through.
struct Watch {
    callback: Option<Py<PyAny>>,
    /// What a callback or a signal handler raised.
    raised: Mutex<Option<PyErr>>,
    looked: Mutex<Instant>,
}

impl Watch {
    fn keep(&self, result: PyResult<()>) {
        if let (Err(error), Ok(mut raised)) = (result, self.raised.lock()) {
            raised.get_or_insert(error);
        }
    }

    fn has_raised(&self) -> bool {
        self.raised.lock().is_ok_and(|raised| raised.is_some())
    }

    fn is_due(&self) -> bool {
        let Ok(mut looked) = self.looked.lock() else { return false };
        let due = looked.elapsed() >= PATIENCE;
        if due {
            *looked = Instant::now();
        }
        due
    }
}

impl Observer for Watch {
    fn event(&self, event: &Event<'_>) {
        let Some(callback) = &self.callback else { return };
        if self.has_raised() {
            return;
        }
        // (stage, kind, number, value, text)
        let facts = match event {
            Event::Started { stage } => (*stage, "started", 0, 0.0, ""),
            Event::Finished { stage, elapsed } => {
                (*stage, "finished", 0, elapsed.as_secs_f64(), "")
            }
            Event::Iteration { stage, step, error } => (*stage, "iteration", *step, *error, ""),
            Event::Count { stage, what, count } => (*stage, "count", *count, 0.0, *what),
            Event::Warning { stage, message } => (*stage, "warning", 0, 0.0, *message),
        };
        self.keep(Python::attach(|py| callback.call1(py, facts).map(drop)));
    }

    fn artifact(&self, _stage: &str, _name: &str, _artifact: Artifact<'_>) {}

    fn cancelled(&self) -> bool {
        if !self.has_raised() && self.is_due() {
            self.keep(Python::attach(|py| py.check_signals()));
        }
        self.has_raised()
    }
}

/// [`watched`] work of one stage, whose begin and end are told.
pub(crate) fn staged<T: Send>(
    py: Python<'_>,
    callback: Option<Py<PyAny>>,
    stage: &str,
    work: impl FnOnce(&dyn Observer) -> Result<T, Error> + Send,
) -> PyResult<T> {
    watched(py, callback, |watch| {
        watch.event(&Event::Started { stage });
        let start = Instant::now();
        let done = work(watch)?;
        watch.event(&Event::Finished { stage, elapsed: start.elapsed() });
        Ok(done)
    })
}

/// Does work without the GIL, watched; what a callback or Ctrl-C raised comes first.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    callback: Option<Py<PyAny>>,
    work: impl FnOnce(&dyn Observer) -> Result<T, Error> + Send,
) -> PyResult<T> {
    let watch = Watch { callback, raised: Mutex::new(None), looked: Mutex::new(Instant::now()) };
    let result = py.detach(|| work(&watch));
    // a signal that came after the last look
    watch.keep(py.check_signals());
    match watch.raised.into_inner() {
        Ok(Some(raised)) => Err(raised),
        _ => result.map_err(|error| to_py(py, error)),
    }
}
