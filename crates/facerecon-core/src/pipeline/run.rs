//! A run of the pipeline: times the stages and collects their warnings.

use std::cell::RefCell;
use std::time::Instant;

use super::Error;
use crate::observer::{Artifact, Event, Observer, WarningCollector};

/// Passes everything on to an observer, with the names of artifacts prefixed by the photo's side.
pub(super) struct SideObserver<'a> {
    pub(super) side: &'static str,
    pub(super) observer: &'a dyn Observer,
}

impl Observer for SideObserver<'_> {
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

/// The observer of a run: passes everything on to the caller's observer, keeps every warning for
/// the result, and times the stages.
pub(super) struct Run<'a> {
    observer: WarningCollector<'a>,
    timings_ms: RefCell<Vec<(String, f64)>>,
}

impl<'a> Run<'a> {
    pub(super) fn new(observer: &'a dyn Observer) -> Self {
        Self { observer: WarningCollector::new(observer), timings_ms: RefCell::default() }
    }

    /// Runs one stage; the times of a stage that runs twice are added.
    pub(super) fn stage<T, E: Into<Error>>(
        &self,
        stage: &str,
        work: impl FnOnce(&dyn Observer) -> Result<T, E>,
    ) -> Result<T, Error> {
        self.observer.event(&Event::Started { stage });
        let start = Instant::now();
        let result = work(self).map_err(Into::into)?;
        let elapsed = start.elapsed();
        self.observer.event(&Event::Finished { stage, elapsed });
        let ms = elapsed.as_secs_f64() * 1000.0;
        let mut timings = self.timings_ms.borrow_mut();
        match timings.iter_mut().find(|(name, _)| name == stage) {
            Some((_, total)) => *total += ms,
            None => timings.push((stage.to_owned(), ms)),
        }
        Ok(result)
    }

    /// Milliseconds of each stage in order, and all warnings.
    pub(super) fn finish(self) -> (Vec<(String, f64)>, Vec<String>) {
        (self.timings_ms.into_inner(), self.observer.into_warnings())
    }
}

impl Observer for Run<'_> {
    fn event(&self, event: &Event<'_>) {
        self.observer.event(event);
    }
    fn artifact(&self, stage: &str, name: &str, artifact: Artifact<'_>) {
        self.observer.artifact(stage, name, artifact);
    }
    fn cancelled(&self) -> bool {
        self.observer.cancelled()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_warning_is_kept_with_its_stage_and_times_add_up() {
        let run = Run::new(&());
        for message in ["the left photo is dark", "the right photo is dark"] {
            let done: Result<(), Error> = run.stage("filter", |o| {
                o.warn("filter", message);
                Ok::<_, Error>(())
            });
            done.unwrap();
        }
        let (timings, warnings) = run.finish();
        assert_eq!(timings.len(), 1);
        assert_eq!(warnings, ["filter: the left photo is dark", "filter: the right photo is dark"]);
    }
}
