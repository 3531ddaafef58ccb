//! Everything that is printed, apart from the progress display.
#![allow(clippy::print_stdout, clippy::print_stderr)] // this file may print

use std::error::Error as _;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Mutex;

use serde_json::{Value, json};

use crate::failure::Failure;

/// The terminal, with the user's choices.
pub(crate) struct Terminal {
    /// Print neither progress nor messages, only results and errors.
    pub(crate) quiet: bool,
    /// Print results as JSON.
    pub(crate) json: bool,
    /// Warnings printed so far.
    warned: Mutex<Vec<String>>,
}

impl Terminal {
    pub(crate) fn new(quiet: bool, json: bool) -> Self {
        Self { quiet, json, warned: Mutex::default() }
    }

    /// Prints a result to stdout. A closed pipe is not an error.
    pub(crate) fn result(&self, text: &str) {
        let mut out = io::stdout().lock();
        let _ = out.write_all(text.as_bytes());
        if !text.ends_with('\n') {
            let _ = out.write_all(b"\n");
        }
        let _ = out.flush();
    }

    /// Reports the files a command wrote: as a message, and with `--json` as the result, together
    /// with further `facts`.
    pub(crate) fn wrote(&self, files: &[&Path], facts: Value) {
        let names: Vec<_> = files.iter().map(|f| f.display().to_string()).collect();
        self.message(format!("wrote {}", names.join(" and ")));
        if self.json {
            let mut all = json!({ "wrote": names });
            if let (Some(all), Value::Object(facts)) = (all.as_object_mut(), facts) {
                all.extend(facts);
            }
            self.result(&format!("{all:#}"));
        }
    }

    /// Prints a message to stderr, unless quiet.
    pub(crate) fn message(&self, text: impl AsRef<str>) {
        if !self.quiet {
            eprintln!("{}", text.as_ref());
        }
    }

    /// Prints a warning to stderr, unless quiet or printed before.
    pub(crate) fn warning(&self, text: &str) {
        if let Some(line) = self.new_warning(text) {
            self.message(line);
        }
    }

    /// The line of a warning that was not printed before. A run reports its warnings as events
    /// and again in its result: each is printed once.
    pub(crate) fn new_warning(&self, text: &str) -> Option<String> {
        let mut warned = self.warned.lock().ok()?;
        if warned.iter().any(|known| known == text) {
            return None;
        }
        warned.push(text.to_owned());
        Some(format!("{} {text}", self.paint("33;1", "warning:")))
    }

    /// Prints why the command failed: message, causes, what to do.
    pub(crate) fn failure(&self, failure: &Failure) {
        eprintln!("{} {}", self.paint("31;1", "error:"), message(failure));
        if let Failure::Input(error) = failure {
            let mut shown = error.to_string();
            let mut cause = error.source();
            while let Some(inner) = cause {
                let text = inner.to_string();
                if !shown.contains(&text) {
                    eprintln!("  {} {text}", self.paint("2", "because:"));
                }
                shown = text;
                cause = inner.source();
            }
            if let Some(hint) = error.hint() {
                eprintln!("  {} {hint}", self.paint("36;1", "hint:"));
            }
        }
    }

    fn paint(&self, code: &str, text: &str) -> String {
        let plain =
            std::env::var_os("NO_COLOR").is_some() || !io::IsTerminal::is_terminal(&io::stderr());
        if plain { text.to_owned() } else { format!("\x1b[{code}m{text}\x1b[0m") }
    }
}

fn message(failure: &Failure) -> String {
    match failure {
        Failure::Input(error) => error.to_string(),
        Failure::Usage(text) => text.clone(),
    }
}
