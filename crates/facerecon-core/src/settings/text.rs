//! Settings as TOML: printed with their documentation, and set by dotted names.

use serde::Serialize;

use super::{Field, Kind, SettingsError, Value};

/// The fields of a settings struct, in the order of their declaration.
pub fn fields<T: Value>() -> Vec<Field> {
    match T::kind() {
        Kind::Group(fields) => fields,
        _ => Vec::new(),
    }
}

/// A settings struct as TOML, every field with its meaning, unit, range and choices as comments.
/// Values that are left out stand as commented lines.
///
/// # Errors
/// [`SettingsError::Malformed`] when the value cannot be written as TOML.
pub fn commented_toml<T: Value + Serialize>(value: &T) -> Result<String, SettingsError> {
    let table =
        toml::Table::try_from(value).map_err(|e| SettingsError::Malformed(e.to_string()))?;
    let mut out = String::new();
    write_group(&mut out, "", &fields::<T>(), &table);
    Ok(out.trim_start().to_owned())
}

fn write_group(out: &mut String, path: &str, fields: &[Field], table: &toml::Table) {
    let (groups, plain): (Vec<_>, Vec<_>) =
        fields.iter().partition(|f| matches!(f.kind, Kind::Group(_)));
    for field in plain {
        for line in comment(field).lines() {
            out.push_str(&format!("# {line}\n"));
        }
        match table.get(field.name) {
            Some(value) => out.push_str(&format!("{} = {value}\n", field.name)),
            None => out.push_str(&format!("# {} =\n", field.name)),
        }
    }
    for field in groups {
        let Kind::Group(inner) = &field.kind else {
            continue;
        };
        let name =
            if path.is_empty() { field.name.to_owned() } else { format!("{path}.{}", field.name) };
        out.push('\n');
        for line in field.doc.lines() {
            out.push_str(&format!("# {line}\n"));
        }
        out.push_str(&format!("[{name}]\n"));
        let empty = toml::Table::new();
        let sub = table.get(field.name).and_then(toml::Value::as_table).unwrap_or(&empty);
        write_group(out, &name, inner, sub);
    }
}

fn comment(field: &Field) -> String {
    let mut text = field.doc.clone();
    let mut facts = Vec::new();
    if let Some(unit) = field.unit {
        facts.push(unit.to_owned());
    }
    if let Some(range) = &field.range {
        facts.push(format!("{} to {}", range.start(), range.end()));
    }
    if !facts.is_empty() {
        text.push_str(&format!(" [{}]", facts.join(", ")));
    }
    if let Kind::Choice(choices) = &field.kind {
        for (name, meaning) in choices {
            text.push_str(&format!("\n  \"{name}\": {meaning}"));
        }
    }
    text
}

/// Sets one parameter by its dotted name from text as written on a command line; text that is not
/// a TOML value counts as a string.
///
/// # Errors
/// [`SettingsError::Unknown`] for a name that is not there, naming the nearest ones.
pub fn set<T: Value>(table: &mut toml::Table, name: &str, text: &str) -> Result<(), SettingsError> {
    let parts: Vec<&str> = name.split('.').collect();
    let mut level = fields::<T>();
    let mut target = table;
    for (depth, part) in parts.iter().enumerate() {
        let Some(field) = level.iter().find(|f| f.name == *part) else {
            let names: Vec<_> = level.iter().map(|f| f.name).collect();
            let hint = format!("here there are: {}", names.join(", "));
            return Err(SettingsError::Unknown { name: name.to_owned(), hint });
        };
        let last = depth + 1 == parts.len();
        match (&field.kind, last) {
            (Kind::Group(inner), false) => {
                let entry = target
                    .entry((*part).to_owned())
                    .or_insert_with(|| toml::Value::Table(toml::Table::new()));
                let Some(sub) = entry.as_table_mut() else {
                    return Err(SettingsError::Malformed(format!("{part} is not a table")));
                };
                target = sub;
                level = inner.clone();
            }
            (Kind::Group(inner), true) => {
                let names: Vec<_> = inner.iter().map(|f| format!("{name}.{}", f.name)).collect();
                let hint = format!("it is a group of: {}", names.join(", "));
                return Err(SettingsError::Unknown { name: name.to_owned(), hint });
            }
            (_, false) => {
                let hint = format!("{} has no parts", parts[..=depth].join("."));
                return Err(SettingsError::Unknown { name: name.to_owned(), hint });
            }
            (kind, true) => {
                let value = parse_value(kind, text);
                check_kind(name, kind, &value)?;
                target.insert((*part).to_owned(), value);
            }
        }
    }
    Ok(())
}

/// Names the parameter and what it must be, which the TOML reader's own message does not.
fn check_kind(name: &str, kind: &Kind, value: &toml::Value) -> Result<(), SettingsError> {
    let (fits, wanted) = match kind {
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
        Kind::Text | Kind::Group(_) => return Ok(()),
    };
    if fits {
        return Ok(());
    }
    Err(SettingsError::Malformed(format!("{name} is {value}, but must be {wanted}")))
}

fn parse_value(kind: &Kind, text: &str) -> toml::Value {
    let parsed = format!("v = {text}").parse::<toml::Table>().ok().and_then(|mut t| t.remove("v"));
    match (kind, parsed) {
        (Kind::Text | Kind::Choice(_), Some(toml::Value::String(s))) => toml::Value::String(s),
        (Kind::Text | Kind::Choice(_), _) | (_, None) => toml::Value::String(text.to_owned()),
        // "5" is a fine real number on a command line
        (Kind::Number, Some(toml::Value::Integer(i))) => toml::Value::Float(i as f64),
        (Kind::Optional(inner), Some(_)) => parse_value(inner, text),
        (_, Some(value)) => value,
    }
}
