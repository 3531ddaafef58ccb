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
    /// Could not be measured.
    Unknown,
}

/// One rule and what was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Name of the rule: `resolution`, `luminance`, `saturation`, `dots`, `contrast`, `sharpness`,
    /// `spacing`, `subject`, `rows` or `plain`.
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
}

impl CheckReport {
    /// Whether no rule is broken.
    pub fn is_good(&self) -> bool {
        self.findings.iter().all(|f| f.verdict != Verdict::Warning)
    }

    /// The broken rules: name, message and advice in one line each.
    pub fn warnings(&self) -> Vec<String> {
        let broken = self.findings.iter().filter(|f| f.verdict == Verdict::Warning);
        broken.map(|f| format!("{}: {}; {}", f.rule, f.message, f.advice)).collect()
    }

    pub(super) fn add(
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

    pub(super) fn add_unknown(&mut self, rule: &'static str, message: String) {
        self.findings.push(Finding { rule, verdict: Verdict::Unknown, message, advice: "" });
    }
}
