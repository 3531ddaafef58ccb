//! Timing and reporting of the stages.

use std::time::Instant;

use crate::observer::{Artifact, Event, Observer};
use crate::pipeline::Error;

/// An observer of one photo: what it is shown carries the side's name.
pub(super) struct OfSide<'a> {
    pub(super) side: &'static str,
    pub(super) observer: &'a dyn Observer,
}

impl Observer for OfSide<'_> {
    fn event(&self, event: &Event<'_>) {
        self.observer.event(event);
    }
    fn artifact(&self, stage: &str, name: &str, artifact: Artifact<'_>) {
        self.observer.artifact(stage, &format!("{}_{name}", self.side), artifact);
    }
    fn cancelled(&self) -> bool {
        self.observer.cancelled()
    }
}

/// A run of the pipeline: who watches, how long each stage took, what was noticed.
pub(super) struct Run<'a> {
    pub(super) observer: &'a dyn Observer,
    pub(super) timings_ms: Vec<(String, f64)>,
    pub(super) warnings: Vec<String>,
}

impl<'a> Run<'a> {
    pub(super) fn new(observer: &'a dyn Observer) -> Self {
        Self { observer, timings_ms: Vec::new(), warnings: Vec::new() }
    }

    /// Runs one stage; the times of stages that run twice add up.
    pub(super) fn stage<T, E: Into<Error>>(
        &mut self,
        stage: &str,
        work: impl FnOnce(&dyn Observer) -> Result<T, E>,
    ) -> Result<T, Error> {
        self.observer.event(&Event::Started { stage });
        let start = Instant::now();
        let result = work(self.observer).map_err(Into::into)?;
        let elapsed = start.elapsed();
        self.observer.event(&Event::Finished { stage, elapsed });
        let ms = elapsed.as_secs_f64() * 1000.0;
        match self.timings_ms.iter_mut().find(|(name, _)| name == stage) {
            Some((_, total)) => *total += ms,
            None => self.timings_ms.push((stage.to_owned(), ms)),
        }
        Ok(result)
    }

    pub(super) fn warn(&mut self, warnings: &[String]) {
        self.warnings.extend_from_slice(warnings);
    }
}
