//! Watching and stopping a run: progress bars, kept stages, plots and Python callbacks are observers.

use std::cell::RefCell;
use std::time::Duration;

use crate::data::{Gray, Mesh, Rgb};
use crate::math::Vec3;

/// Something that happened in a stage.
#[derive(Clone, Debug, PartialEq)]
pub enum Event<'a> {
    /// A stage of the pipeline begins.
    Started {
        /// Name of the stage.
        stage: &'a str,
    },
    /// A stage of the pipeline is done.
    Finished {
        /// Name of the stage.
        stage: &'a str,
        /// Time it took.
        elapsed: Duration,
    },
    /// One step of an iterative method.
    Iteration {
        /// Name of the stage.
        stage: &'a str,
        /// Number of the step, from 1.
        step: usize,
        /// Error after the step, in the stage's own measure.
        error: f64,
    },
    /// Something was counted.
    Count {
        /// Name of the stage.
        stage: &'a str,
        /// What was counted.
        what: &'a str,
        /// How many.
        count: usize,
    },
    /// Something the user should know.
    Warning {
        /// Name of the stage.
        stage: &'a str,
        /// In words, with figures.
        message: &'a str,
    },
}

/// An intermediate result of a stage.
#[derive(Clone, Copy, Debug)]
pub enum Artifact<'a> {
    /// A grey image, 0 to 255.
    Gray(&'a Gray),
    /// A colour image.
    Rgb(&'a Rgb),
    /// Points in space.
    Points(&'a [Vec3]),
    /// A mesh.
    Mesh(&'a Mesh),
}

/// The observer asked to stop the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the run was cancelled")]
pub struct Cancelled;

/// Receives what the stages report; every method has an empty default, and `()` observes nothing.
/// Stages call it on the calling thread only.
pub trait Observer {
    /// Something happened.
    fn event(&self, _event: &Event<'_>) {}
    /// An intermediate result, by stage and name (`"filter"`, `"left_sharpened"`).
    fn artifact(&self, _stage: &str, _name: &str, _artifact: Artifact<'_>) {}
    /// Whether the run should stop; polled in outer loops.
    fn cancelled(&self) -> bool {
        false
    }
    /// Ends the caller when the run should stop: `observer.check()?`.
    ///
    /// # Errors
    /// [`Cancelled`] when [`Observer::cancelled`] is true.
    fn check(&self) -> Result<(), Cancelled> {
        if self.cancelled() { Err(Cancelled) } else { Ok(()) }
    }
    /// Reports something the user should know, with figures and what to do.
    fn warn(&self, stage: &str, message: &str) {
        self.event(&Event::Warning { stage, message });
    }
}

impl Observer for () {}

/// Several observers are one: all see everything, any may stop the run.
impl Observer for [&dyn Observer] {
    fn event(&self, event: &Event<'_>) {
        self.iter().for_each(|o| o.event(event));
    }
    fn artifact(&self, stage: &str, name: &str, artifact: Artifact<'_>) {
        self.iter().for_each(|o| o.artifact(stage, name, artifact));
    }
    fn cancelled(&self) -> bool {
        self.iter().any(|o| o.cancelled())
    }
}

impl<const N: usize> Observer for [&dyn Observer; N] {
    fn event(&self, event: &Event<'_>) {
        self.as_slice().event(event);
    }
    fn artifact(&self, stage: &str, name: &str, artifact: Artifact<'_>) {
        self.as_slice().artifact(stage, name, artifact);
    }
    fn cancelled(&self) -> bool {
        self.as_slice().cancelled()
    }
}

/// Passes everything on to another observer, and keeps every warning as `stage: message`.
pub struct WarningCollector<'a> {
    observer: &'a dyn Observer,
    warnings: RefCell<Vec<String>>,
}

impl<'a> WarningCollector<'a> {
    /// Collects the warnings that `observer` receives.
    pub fn new(observer: &'a dyn Observer) -> Self {
        Self { observer, warnings: RefCell::default() }
    }

    /// The warnings in order.
    pub fn into_warnings(self) -> Vec<String> {
        self.warnings.into_inner()
    }
}

impl Observer for WarningCollector<'_> {
    fn event(&self, event: &Event<'_>) {
        if let Event::Warning { stage, message } = event {
            self.warnings.borrow_mut().push(format!("{stage}: {message}"));
        }
        self.observer.event(event);
    }
    fn artifact(&self, stage: &str, name: &str, artifact: Artifact<'_>) {
        self.observer.artifact(stage, name, artifact);
    }
    fn cancelled(&self) -> bool {
        self.observer.cancelled()
    }
}
