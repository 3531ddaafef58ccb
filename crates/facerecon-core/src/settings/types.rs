//! What describes a parameter, and the errors of parameters.

use std::ops::RangeInclusive;

/// What a parameter can hold, for printing and for checking.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A real number.
    Number,
    /// A whole number.
    Integer,
    /// `true` or `false`.
    Switch,
    /// Free text.
    Text,
    /// One of a few named choices: `(name, meaning)`.
    Choice(Vec<(&'static str, String)>),
    /// A list of values of one kind.
    List(Box<Kind>),
    /// A value that may be absent.
    Optional(Box<Kind>),
    /// A nested group of parameters.
    Group(Vec<Field>),
}

/// One documented parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name as in TOML and Python.
    pub name: &'static str,
    /// Earlier name, which is still read.
    pub alias: Option<&'static str>,
    /// Meaning, from the field's doc comment.
    pub doc: String,
    /// Unit, where it has one.
    pub unit: Option<&'static str>,
    /// Allowed range, ends included.
    pub range: Option<RangeInclusive<f64>>,
    /// What it holds.
    pub kind: Kind,
}

/// A parameter that cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// A number outside its range.
    #[error("parameter {name} is {got}, but must be between {low} and {high}")]
    OutOfRange {
        /// Dotted name.
        name: String,
        /// Value found.
        got: f64,
        /// Least value allowed.
        low: f64,
        /// Greatest value allowed.
        high: f64,
    },
    /// A value of the wrong type, or text that is not TOML.
    #[error("parameters: {0}")]
    Malformed(String),
    /// No parameter has that name.
    #[error("unknown key {name}; {hint}")]
    Unknown {
        /// Dotted name as given.
        name: String,
        /// The nearest known name, or all known names.
        hint: String,
    },
}

/// A name that is none of the choices of a `choices!` enum.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("unknown name {got:?}; expected one of: {expected}")]
pub struct UnknownChoice {
    /// Name as given.
    pub got: String,
    /// The known names, separated by commas.
    pub expected: String,
}
