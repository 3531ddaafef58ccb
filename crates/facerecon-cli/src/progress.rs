//! Progress on the terminal: one line per stage, with its time and counts, and its warnings.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::Duration;

use facerecon_core::observer::{Event, Observer};
use indicatif::{ProgressBar, ProgressStyle};

use crate::output::Terminal;

/// Shows the stages of a run on stderr.
pub(crate) struct Progress<'a> {
    terminal: &'a Terminal,
    /// The animated line, where stderr is a terminal.
    spinner: Option<ProgressBar>,
    counts: Mutex<Vec<String>>,
}

impl<'a> Progress<'a> {
    /// A progress display; it shows nothing when the terminal is quiet.
    pub(crate) fn new(terminal: &'a Terminal) -> Self {
        let spinner = (!terminal.quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::new_spinner();
            if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}") {
                bar.set_style(style);
            }
            bar.enable_steady_tick(Duration::from_millis(120));
            bar
        });
        Self { terminal, spinner, counts: Mutex::default() }
    }

    fn line(&self, text: String) {
        match &self.spinner {
            Some(bar) => bar.println(text),
            // progress goes to stderr, also when that is a log file
            None => self.terminal.message(text),
        }
    }

    fn status(&self, text: String) {
        if let Some(bar) = &self.spinner {
            bar.set_message(text);
        }
    }
}

impl Drop for Progress<'_> {
    fn drop(&mut self) {
        if let Some(bar) = &self.spinner {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Progress<'_> {
    fn event(&self, event: &Event<'_>) {
        match event {
            Event::Started { stage } => self.status((*stage).to_owned()),
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
                self.status(format!("{stage}: step {step}, error {error:.4}"));
            }
            Event::Warning { stage, message } => {
                // as in the warnings of a result
                if let Some(line) = self.terminal.new_warning(&format!("{stage}: {message}")) {
                    self.line(line);
                }
            }
        }
    }
}
