//! Parameters by name: keys of a TOML table, and dotted names of the command line and Python.

use serde::de::DeserializeOwned;

use super::nearest::nearest_name;
use super::text::fields;
use super::types::{Field, Kind, SettingsError};
use super::value::Value;

/// A settings struct from a TOML table, checked: names (earlier names are accepted), types, ranges.
///
/// # Errors
/// [`SettingsError`] naming the parameter.
pub fn from_table<T: Value + DeserializeOwned>(mut table: toml::Table) -> Result<T, SettingsError> {
    resolve_keys::<T>(&mut table)?;
    let settings: T = table
        .try_into()
        .map_err(|e: toml::de::Error| SettingsError::Malformed(e.message().to_owned()))?;
    settings.check("", None)?;
    Ok(settings)
}

/// A settings struct from its defaults and single settings `(dotted name, value as text)`.
///
/// # Errors
/// [`SettingsError`] naming the parameter.
pub fn from_sets<T: Value + DeserializeOwned>(
    sets: &[(String, String)],
) -> Result<T, SettingsError> {
    let mut table = toml::Table::new();
    for (name, value) in sets {
        set::<T>(&mut table, name, value)?;
    }
    from_table(table)
}

/// Replaces earlier names of parameters by the current ones, and checks names and types of all
/// entries.
///
/// # Errors
/// [`SettingsError::Unknown`] for a name that does not exist, with the nearest one;
/// [`SettingsError::Malformed`] for a value of the wrong type, or a parameter given by its earlier
/// and its current name.
pub fn resolve_keys<T: Value>(table: &mut toml::Table) -> Result<(), SettingsError> {
    resolve(&fields::<T>(), table, "")
}

fn resolve(fields: &[Field], table: &mut toml::Table, prefix: &str) -> Result<(), SettingsError> {
    for field in fields {
        rename_alias(field, table, prefix)?;
    }
    for (key, value) in table.iter_mut() {
        let Some(field) = fields.iter().find(|f| f.name == *key) else {
            return Err(unknown(fields, prefix, key, ""));
        };
        let name = format!("{prefix}{key}");
        check_kind(&name, &field.kind, value)?;
        if let (Kind::Group(inner), Some(group)) = (&field.kind, value.as_table_mut()) {
            resolve(inner, group, &format!("{name}."))?;
        }
    }
    Ok(())
}

/// Moves the value of a field's earlier name to the current one.
fn rename_alias(field: &Field, table: &mut toml::Table, prefix: &str) -> Result<(), SettingsError> {
    let Some(alias) = field.alias else { return Ok(()) };
    let Some(value) = table.remove(alias) else { return Ok(()) };
    if table.contains_key(field.name) {
        return Err(SettingsError::Malformed(format!(
            "{prefix}{alias} is the earlier name of {prefix}{}; give only one of them",
            field.name
        )));
    }
    table.insert(field.name.to_owned(), value);
    Ok(())
}

/// The error for a key that no field has; `rest` is what follows the key in a dotted name.
fn unknown(fields: &[Field], prefix: &str, key: &str, rest: &str) -> SettingsError {
    let known = || fields.iter().map(|f| f.name);
    let hint = match nearest_name(key, known()) {
        Some(near) => format!("did you mean {prefix}{near}{rest}?"),
        None => format!("the keys are: {}", known().collect::<Vec<_>>().join(", ")),
    };
    SettingsError::Unknown { name: format!("{prefix}{key}{rest}"), hint }
}

/// Sets one parameter by its dotted name from text as written on a command line; text that is not
/// a TOML value is taken as a string. Earlier names are accepted.
///
/// # Errors
/// [`SettingsError::Unknown`] for a name that does not exist, with the nearest one;
/// [`SettingsError::Malformed`] for a value of the wrong type, or the name of a group.
pub fn set<T: Value>(table: &mut toml::Table, name: &str, text: &str) -> Result<(), SettingsError> {
    set_in(&fields::<T>(), table, "", name, text)
}

/// Sets `name`, which is relative to the group whose dotted name is `prefix`.
fn set_in(
    fields: &[Field],
    table: &mut toml::Table,
    prefix: &str,
    name: &str,
    text: &str,
) -> Result<(), SettingsError> {
    let (key, rest) = match name.split_once('.') {
        Some((key, rest)) => (key, Some(rest)),
        None => (name, None),
    };
    let Some(field) = fields.iter().find(|f| f.name == key || f.alias == Some(key)) else {
        let rest = rest.map_or(String::new(), |r| format!(".{r}"));
        return Err(unknown(fields, prefix, key, &rest));
    };
    rename_alias(field, table, prefix)?;
    let full = format!("{prefix}{key}");
    match (&field.kind, rest) {
        (Kind::Group(inner), Some(rest)) => {
            let entry = table
                .entry(field.name.to_owned())
                .or_insert_with(|| toml::Value::Table(toml::Table::new()));
            let Some(group) = entry.as_table_mut() else {
                return Err(SettingsError::Malformed(format!(
                    "{full} is {entry}, but must be a table of parameters"
                )));
            };
            set_in(inner, group, &format!("{full}."), rest, text)
        }
        (Kind::Group(inner), None) => {
            let names: Vec<_> = inner.iter().map(|f| format!("{full}.{}", f.name)).collect();
            Err(SettingsError::Malformed(format!(
                "{full} is a group of parameters; set one of: {}",
                names.join(", ")
            )))
        }
        (_, Some(rest)) => Err(SettingsError::Unknown {
            name: format!("{full}.{rest}"),
            hint: format!("{full} is a single parameter"),
        }),
        (kind, None) => {
            let value = parse_value(kind, text);
            check_kind(&full, kind, &value)?;
            table.insert(field.name.to_owned(), value);
            Ok(())
        }
    }
}

/// Checks the type of a value. The message names the parameter and the expected type, which that of
/// the TOML reader does not.
fn check_kind(name: &str, kind: &Kind, value: &toml::Value) -> Result<(), SettingsError> {
    let (fits, expected) = match kind {
        Kind::Number => (value.is_float() || value.is_integer(), "a number".to_owned()),
        Kind::Integer => (value.is_integer(), "a whole number".to_owned()),
        Kind::Switch => (value.is_bool(), "true or false".to_owned()),
        Kind::Choice(choices) => {
            let names: Vec<_> = choices.iter().map(|c| c.0).collect();
            let fits = value.as_str().is_none_or(|given| names.contains(&given));
            (fits, format!("one of {}", names.join(", ")))
        }
        Kind::List(inner) => match value.as_array() {
            Some(items) => return items.iter().try_for_each(|i| check_kind(name, inner, i)),
            None => (false, "a list, as [1, 2, 3]".to_owned()),
        },
        Kind::Optional(inner) => return check_kind(name, inner, value),
        Kind::Group(_) => (value.is_table(), "a table of parameters".to_owned()),
        Kind::Text => return Ok(()),
    };
    if fits {
        return Ok(());
    }
    Err(SettingsError::Malformed(format!("{name} is {value}, but must be {expected}")))
}

fn parse_value(kind: &Kind, text: &str) -> toml::Value {
    let parsed = format!("v = {text}").parse::<toml::Table>().ok().and_then(|mut t| t.remove("v"));
    match (kind, parsed) {
        (Kind::Text | Kind::Choice(_), Some(toml::Value::String(s))) => toml::Value::String(s),
        (Kind::Text | Kind::Choice(_), _) | (_, None) => toml::Value::String(text.to_owned()),
        // "5" is accepted as a real number on the command line
        (Kind::Number, Some(toml::Value::Integer(i))) => toml::Value::Float(i as f64),
        (Kind::Optional(inner), Some(_)) => parse_value(inner, text),
        (_, Some(value)) => value,
    }
}
