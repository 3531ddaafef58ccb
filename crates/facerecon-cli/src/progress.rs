//! Progress on the terminal: one line a stage, with its time and what it counted.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::Duration;

use facerecon_core::observer::{Event, Observer};
use indicatif::{ProgressBar, ProgressStyle};

/// Shows the stages of a run on stderr.
pub(crate) struct Progress {
    quiet: bool,
    /// The moving part, where stderr is a terminal.
    spinner: Option<ProgressBar>,
    counts: Mutex<Vec<String>>,
}

impl Progress {
    /// A progress display that shows nothing when `quiet`.
    pub(crate) fn new(quiet: bool) -> Self {
        let spinner = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::new_spinner();
            if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}") {
                bar.set_style(style);
            }
            bar.enable_steady_tick(Duration::from_millis(120));
            bar
        });
        Self { quiet, spinner, counts: Mutex::default() }
    }

    #[allow(clippy::print_stderr)] // progress belongs on stderr, also when that is a log file
    fn line(&self, text: String) {
        match &self.spinner {
            Some(bar) => bar.println(text),
            None if !self.quiet => eprintln!("{text}"),
            None => {}
        }
    }

    fn message(&self, text: String) {
        if let Some(bar) = &self.spinner {
            bar.set_message(text);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.spinner {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Progress {
    fn event(&self, event: &Event<'_>) {
        match event {
            Event::Started { stage } => self.message((*stage).to_owned()),
            Event::Count { what, count, .. } => {
                if let Ok(mut counts) = self.counts.lock() {
                    counts.push(format!("{count} {what}"));
                }
            }
            Event::Finished { stage, elapsed } => {
                let counts = self.counts.lock().map(|mut c| c.split_off(0)).unwrap_or_default();
                let ms = elapsed.as_secs_f64() * 1000.0;
                self.line(format!("  {stage:<12} {ms:>7.0} ms  {}", counts.join(", ")));
            }
            Event::Iteration { stage, step, error } => {
                self.message(format!("{stage}: step {step}, error {error:.4}"));
            }
            Event::Warning { .. } => {}
        }
    }
}
