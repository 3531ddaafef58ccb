//! Parameters printed as TOML with their documentation.

use serde::Serialize;

use super::types::{Field, Kind, SettingsError};
use super::value::Value;

/// The fields of a settings struct, in the order of their declaration.
pub fn fields<T: Value>() -> Vec<Field> {
    match T::kind() {
        Kind::Group(fields) => fields,
        _ => Vec::new(),
    }
}

/// A settings struct as TOML, every field with its meaning, unit, range and choices as comments.
/// Absent values are written as commented lines.
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
