//! Everything that is printed.
#![allow(clippy::print_stdout, clippy::print_stderr)] // the one place that may print

use std::error::Error as _;
use std::io::{self, Write};
use std::path::Path;

use serde_json::{Value, json};

use crate::failure::Failure;

/// The terminal as the user wants it.
pub(crate) struct Terminal {
    /// No progress and no words, only results and errors.
    pub(crate) quiet: bool,
    /// Results as JSON.
    pub(crate) json: bool,
}

impl Terminal {
    /// A result: to stdout. A closed pipe is the reader's business, not an error.
    pub(crate) fn result(&self, text: &str) {
        let mut out = io::stdout().lock();
        let _ = out.write_all(text.as_bytes());
        if !text.ends_with('\n') {
            let _ = out.write_all(b"\n");
        }
        let _ = out.flush();
    }

    /// The files a command wrote: a word on the way, and with `--json` the result, together with
    /// further `facts`.
    pub(crate) fn wrote(&self, files: &[&Path], facts: Value) {
        let names: Vec<_> = files.iter().map(|f| f.display().to_string()).collect();
        self.say(format!("wrote {}", names.join(" and ")));
        if self.json {
            let mut all = json!({ "wrote": names });
            if let (Some(all), Value::Object(facts)) = (all.as_object_mut(), facts) {
                all.extend(facts);
            }
            self.result(&format!("{all:#}"));
        }
    }

    /// A word on the way: to stderr, unless quiet.
    pub(crate) fn say(&self, text: impl AsRef<str>) {
        if !self.quiet {
            eprintln!("{}", text.as_ref());
        }
    }

    /// Something the user should know about the result.
    pub(crate) fn warning(&self, text: &str) {
        self.say(format!("{} {text}", self.paint("33;1", "warning:")));
    }

    /// Why the command failed: message, causes, what to do.
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
