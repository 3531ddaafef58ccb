//! Parameters that are written once: a struct declared with [`settings!`] carries its defaults,
//! ranges, units and documentation; the TOML file, the command line and Python are derived from it.

mod text;

use std::ops::RangeInclusive;

pub use text::{commented_toml, fields, set};

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
    /// A value that may be left out.
    Optional(Box<Kind>),
    /// A nested group of parameters.
    Group(Vec<Field>),
}

/// One documented parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name as in TOML and Python.
    pub name: &'static str,
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
    #[error("parameter {name} is {got}, but must lie in {low} to {high}")]
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
    /// A value of the wrong type, an unknown name, or text that is not TOML.
    #[error("parameters: {0}")]
    Malformed(String),
    /// No parameter of that name.
    #[error("there is no parameter {name}; {hint}")]
    Unknown {
        /// Dotted name as given.
        name: String,
        /// The nearest names there are.
        hint: String,
    },
}

/// A type that can stand in a [`settings!`] struct.
pub trait Value {
    /// What it holds.
    fn kind() -> Kind;
    /// Checks the value (and what is nested in it) against its range.
    ///
    /// # Errors
    /// [`SettingsError::OutOfRange`] with the dotted `name`.
    fn check(&self, name: &str, range: Option<&RangeInclusive<f64>>) -> Result<(), SettingsError>;
}

fn check_number(
    value: f64,
    name: &str,
    range: Option<&RangeInclusive<f64>>,
) -> Result<(), SettingsError> {
    match range {
        Some(r) if !r.contains(&value) => Err(SettingsError::OutOfRange {
            name: name.to_owned(),
            got: value,
            low: *r.start(),
            high: *r.end(),
        }),
        None if !value.is_finite() => Err(SettingsError::Malformed(format!(
            "parameter {name} is {value}, but must be a finite number"
        ))),
        _ => Ok(()),
    }
}

macro_rules! number_value {
    ($($ty:ty => $kind:ident),*) => {$(
        impl Value for $ty {
            fn kind() -> Kind {
                Kind::$kind
            }
            fn check(&self, name: &str, range: Option<&RangeInclusive<f64>>) -> Result<(), SettingsError> {
                check_number(*self as f64, name, range)
            }
        }
    )*};
}
number_value!(f64 => Number, f32 => Number, usize => Integer, u32 => Integer, u64 => Integer, i32 => Integer);

macro_rules! plain_value {
    ($($ty:ty => $kind:ident),*) => {$(
        impl Value for $ty {
            fn kind() -> Kind {
                Kind::$kind
            }
            fn check(&self, _: &str, _: Option<&RangeInclusive<f64>>) -> Result<(), SettingsError> {
                Ok(())
            }
        }
    )*};
}
plain_value!(bool => Switch, String => Text);

impl<T: Value> Value for Option<T> {
    fn kind() -> Kind {
        Kind::Optional(Box::new(T::kind()))
    }
    fn check(&self, name: &str, range: Option<&RangeInclusive<f64>>) -> Result<(), SettingsError> {
        self.as_ref().map_or(Ok(()), |v| v.check(name, range))
    }
}

impl<T: Value> Value for Vec<T> {
    fn kind() -> Kind {
        Kind::List(Box::new(T::kind()))
    }
    fn check(&self, name: &str, range: Option<&RangeInclusive<f64>>) -> Result<(), SettingsError> {
        self.iter().try_for_each(|v| v.check(name, range))
    }
}

/// Declares a parameter struct: `name: type = default, range low..=high, unit "px";` with doc
/// comments. It derives serde (missing fields take their default, unknown ones are refused),
/// `Default`, and the documentation and range checks of [`Value`].
#[macro_export]
macro_rules! settings {
    (
        $(#[doc = $doc:literal])*
        $vis:vis struct $name:ident {
            $(
                $(#[doc = $fdoc:literal])*
                $field:ident : $ty:ty = $default:expr
                $(, range $range:expr)? $(, unit $unit:literal)? ;
            )*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Clone, Debug, PartialEq, ::serde::Serialize, ::serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        $vis struct $name {
            $(
                $(#[doc = $fdoc])*
                pub $field: $ty,
            )*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl $crate::settings::Value for $name {
            fn kind() -> $crate::settings::Kind {
                $crate::settings::Kind::Group(vec![$(
                    $crate::settings::Field {
                        name: stringify!($field),
                        doc: [$($fdoc),*].map(str::trim).join("\n"),
                        unit: $crate::settings!(@unit $($unit)?),
                        range: $crate::settings!(@range $($range)?),
                        kind: <$ty as $crate::settings::Value>::kind(),
                    },
                )*])
            }
            fn check(
                &self,
                name: &str,
                _: Option<&std::ops::RangeInclusive<f64>>,
            ) -> Result<(), $crate::settings::SettingsError> {
                let prefix = if name.is_empty() { String::new() } else { format!("{name}.") };
                $(
                    let range: Option<std::ops::RangeInclusive<f64>> = $crate::settings!(@range $($range)?);
                    $crate::settings::Value::check(
                        &self.$field, &format!("{prefix}{}", stringify!($field)), range.as_ref())?;
                )*
                Ok(())
            }
        }
    };
    (@unit) => { None };
    (@unit $unit:literal) => { Some($unit) };
    (@range) => { None };
    (@range $range:expr) => { Some($range) };
}

/// Declares an enum of named choices for a [`settings!`] field: `Variant = "name",` with doc
/// comments that say what the choice means.
#[macro_export]
macro_rules! choices {
    (
        $(#[doc = $doc:literal])*
        $vis:vis enum $name:ident {
            $( $(#[doc = $vdoc:literal])* $variant:ident = $text:literal, )*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, ::serde::Serialize, ::serde::Deserialize)]
        $vis enum $name {
            $( $(#[doc = $vdoc])* #[serde(rename = $text)] $variant, )*
        }

        impl $crate::settings::Value for $name {
            fn kind() -> $crate::settings::Kind {
                $crate::settings::Kind::Choice(vec![
                    $( ($text, [$($vdoc),*].map(str::trim).join(" ")), )*
                ])
            }
            fn check(
                &self,
                _: &str,
                _: Option<&std::ops::RangeInclusive<f64>>,
            ) -> Result<(), $crate::settings::SettingsError> {
                Ok(())
            }
        }

        impl $name {
            /// Every choice by its name.
            pub const NAMED: &'static [(&'static str, Self)] = &[$( ($text, Self::$variant), )*];

            /// The choice of a name.
            pub fn named(name: &str) -> Option<Self> {
                Self::NAMED.iter().find(|(n, _)| *n == name).map(|(_, v)| *v)
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(match self { $( Self::$variant => $text, )* })
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    choices! {
        /// A choice.
        pub enum Way {
            /// The one.
            One = "one",
            /// The other.
            Two = "two",
        }
    }
    settings! {
        /// Inner.
        pub struct Inner {
            /// A length.
            length_px: f64 = 2.0, range 0.0..=10.0, unit "px";
        }
    }
    settings! {
        /// Outer.
        pub struct Outer {
            /// How.
            way: Way = Way::One;
            /// Maybe.
            maybe: Option<usize> = None;
            /// The inner group.
            inner: Inner = Inner::default();
        }
    }

    #[test]
    fn printed_toml_reads_back_and_carries_the_documentation() {
        let text = commented_toml(&Outer::default()).unwrap();
        assert!(text.contains("# A length. [px, 0 to 10]"), "{text}");
        assert!(text.contains("\"two\": The other."), "{text}");
        assert_eq!(toml::from_str::<Outer>(&text).unwrap(), Outer::default());
    }

    #[test]
    fn ranges_unknown_names_and_choices_are_refused() {
        let mut table = toml::Table::new();
        set::<Outer>(&mut table, "inner.length_px", "11").unwrap();
        set::<Outer>(&mut table, "way", "two").unwrap();
        let outer: Outer = table.try_into().unwrap();
        assert_eq!(outer.way, Way::Two);
        assert_eq!((Way::named("two"), Way::named("three")), (Some(Way::Two), None));
        assert_eq!(Way::NAMED[0].0, "one");
        let error = outer.check("", None).unwrap_err().to_string();
        assert!(error.contains("inner.length_px is 11"), "{error}");
        let error = set::<Outer>(&mut toml::Table::new(), "inner.size", "1").unwrap_err();
        assert!(error.to_string().contains("length_px"), "{error}");
        assert!(toml::from_str::<Outer>("surprise = 1").is_err());
        assert!(toml::from_str::<Outer>("way = \"three\"").is_err());
    }
}
