//! What the check found.

use serde::Serialize;

/// Whether a rule is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Kept.
    Good,
    /// Broken: the result may suffer.
    Warning,
    /// Broken so far that a result cannot be trusted.
    Fault,
    /// Could not be measured.
    Unknown,
}

/// One rule and what was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Name of the rule: `resolution`, `luminance`, `saturation`, `dots`, `contrast`, `sharpness`,
    /// `spacing`, `subject`, `rows`, `plain`, `pairs` or `reconstruction`.
    pub rule: &'static str,
    /// Whether it is kept.
    pub verdict: Verdict,
    /// The figures found and expected.
    pub message: String,
    /// What to do; empty when the rule is kept.
    pub advice: &'static str,
}

/// All rules and what was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CheckReport {
    /// One entry for each rule (`subject`: one for each photo).
    pub findings: Vec<Finding>,
    /// Why the capture cannot be reconstructed; `None` if it can, or if that was not tried.
    pub refusal: Option<String>,
}

impl Finding {
    pub(super) fn is_broken(&self) -> bool {
        matches!(self.verdict, Verdict::Warning | Verdict::Fault)
    }
}

impl CheckReport {
    /// Whether no rule is broken.
    pub fn is_good(&self) -> bool {
        !self.findings.iter().any(Finding::is_broken)
    }

    /// Messages of the rules that are broken so far that a result cannot be trusted.
    pub fn faults(&self) -> Vec<String> {
        let faults = self.findings.iter().filter(|f| f.verdict == Verdict::Fault);
        faults.map(|f| f.message.clone()).collect()
    }

    /// The broken rules: name, message and advice in one line each.
    pub fn warnings(&self) -> Vec<String> {
        let broken = self.findings.iter().filter(|f| f.is_broken());
        broken.map(|f| format!("{}: {}; {}", f.rule, f.message, f.advice)).collect()
    }

    pub(crate) fn add(
        &mut self,
        rule: &'static str,
        good: bool,
        message: String,
        advice: &'static str,
    ) {
        let verdict = if good { Verdict::Good } else { Verdict::Warning };
        let advice = if good { "" } else { advice };
        self.findings.push(Finding { rule, verdict, message, advice });
    }

    pub(crate) fn add_fault(&mut self, rule: &'static str, message: String, advice: &'static str) {
        self.findings.push(Finding { rule, verdict: Verdict::Fault, message, advice });
    }

    pub(super) fn add_unknown(&mut self, rule: &'static str, message: String) {
        self.findings.push(Finding { rule, verdict: Verdict::Unknown, message, advice: "" });
    }
}
