//! Types of parameters and their range checks.

use std::ops::RangeInclusive;

use super::types::{Kind, SettingsError};

/// A type of a field of a `settings!` struct.
pub trait Value {
    /// Description of the type.
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
