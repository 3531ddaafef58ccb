//! Running work without the GIL, under observation: callbacks, warnings, signals.

use std::ffi::CString;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use facerecon_core::Error;
use facerecon_core::observer::{Artifact, Event, Observer};
use pyo3::prelude::*;

use crate::errors::to_py;

/// Interval between two checks for signals. Each check takes the GIL: 50 ms leaves it to other
/// Python threads and still stops a run well within a second of Ctrl-C.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(50);

/// An observer that calls back, collects warnings and stops the run on Ctrl-C.
struct Watch {
    callback: Option<Py<PyAny>>,
    warnings: Mutex<Vec<String>>,
    /// The exception of a callback or of a signal handler.
    raised: Mutex<Option<PyErr>>,
    last_check: Mutex<Instant>,
}

impl Watch {
    /// Keeps the first exception.
    fn keep(&self, result: PyResult<()>) {
        if let (Err(error), Ok(mut raised)) = (result, self.raised.lock()) {
            raised.get_or_insert(error);
        }
    }

    fn has_raised(&self) -> bool {
        self.raised.lock().is_ok_and(|raised| raised.is_some())
    }

    fn check_is_due(&self) -> bool {
        let Ok(mut last) = self.last_check.lock() else { return false };
        let due = last.elapsed() >= SIGNAL_INTERVAL;
        if due {
            *last = Instant::now();
        }
        due
    }
}

impl Observer for Watch {
    fn event(&self, event: &Event<'_>) {
        if let (Event::Warning { stage, message }, Ok(mut known)) = (event, self.warnings.lock()) {
            let text = format!("{stage}: {message}");
            if !known.contains(&text) {
                known.push(text);
            }
        }
        let Some(callback) = &self.callback else { return };
        if self.has_raised() {
            return;
        }
        // (stage, kind, number, value, text)
        let fields = match event {
            Event::Started { stage } => (*stage, "started", 0, 0.0, ""),
            Event::Finished { stage, elapsed } => {
                (*stage, "finished", 0, elapsed.as_secs_f64(), "")
            }
            Event::Iteration { stage, step, error } => (*stage, "iteration", *step, *error, ""),
            Event::Count { stage, what, count } => (*stage, "count", *count, 0.0, *what),
            Event::Warning { stage, message } => (*stage, "warning", 0, 0.0, *message),
        };
        self.keep(Python::attach(|py| callback.call1(py, fields).map(drop)));
    }

    fn artifact(&self, _stage: &str, _name: &str, _artifact: Artifact<'_>) {}

    fn cancelled(&self) -> bool {
        if !self.has_raised() && self.check_is_due() {
            self.keep(Python::attach(|py| py.check_signals()));
        }
        self.has_raised()
    }
}

/// [`watched`] work of one stage, with events for its start and end.
pub(crate) fn staged<T: Send>(
    py: Python<'_>,
    callback: Option<Py<PyAny>>,
    stage: &str,
    work: impl FnOnce(&dyn Observer) -> Result<T, Error> + Send,
) -> PyResult<T> {
    watched(py, callback, |watch| {
        watch.event(&Event::Started { stage });
        let start = Instant::now();
        let result = work(watch)?;
        watch.event(&Event::Finished { stage, elapsed: start.elapsed() });
        Ok(result)
    })
}

/// Runs work without the GIL; its warnings become Python warnings of the facade's caller.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    callback: Option<Py<PyAny>>,
    work: impl FnOnce(&dyn Observer) -> Result<T, Error> + Send,
) -> PyResult<T> {
    let (result, warnings) = with_warnings(py, callback, work)?;
    warn(py, warnings)?;
    Ok(result)
}

/// Issues Python warnings of the category `FaceReconWarning`.
pub(crate) fn warn(py: Python<'_>, warnings: Vec<String>) -> PyResult<()> {
    if warnings.is_empty() {
        return Ok(());
    }
    let category = py.import("facerecon.errors")?.getattr("FaceReconWarning")?;
    for text in warnings {
        // level 1 is the facade's function, 2 its caller
        PyErr::warn(py, &category, &CString::new(text)?, 2)?;
    }
    Ok(())
}

/// Runs work without the GIL and returns its warnings with its result. An exception of the
/// callback or of Ctrl-C takes precedence over the error of the work.
pub(crate) fn with_warnings<T: Send>(
    py: Python<'_>,
    callback: Option<Py<PyAny>>,
    work: impl FnOnce(&dyn Observer) -> Result<T, Error> + Send,
) -> PyResult<(T, Vec<String>)> {
    let watch = Watch {
        callback,
        warnings: Mutex::default(),
        raised: Mutex::new(None),
        last_check: Mutex::new(Instant::now()),
    };
    let result = py.detach(|| work(&watch));
    // a signal after the last check
    watch.keep(py.check_signals());
    match watch.raised.into_inner() {
        Ok(Some(raised)) => Err(raised),
        _ => {
            let result = result.map_err(|error| to_py(py, error))?;
            Ok((result, watch.warnings.into_inner().unwrap_or_default()))
        }
    }
}
