//! The values of a calibration file, independent of its format.

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};

/// A value of a calibration file.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Tree {
    Nothing,
    Number(f64),
    Text(String),
    List(Vec<Tree>),
    Map(Vec<(String, Tree)>),
}

impl Tree {
    /// All numbers of a matrix (`rows`, `cols`, `data`), of nested lists, or of one number.
    pub(super) fn numbers(&self) -> Result<Vec<f64>, String> {
        let mut out = Vec::new();
        match self {
            Self::Map(entries) => {
                let get = |name: &str| entries.iter().find(|(k, _)| k == name).map(|(_, v)| v);
                let data =
                    get("data").ok_or("it is not a matrix: rows, cols and data are expected")?;
                data.collect(&mut out)?;
                let side = |name: &str| match get(name) {
                    Some(Self::Number(n)) => Some(*n),
                    _ => None,
                };
                if let (Some(rows), Some(columns)) = (side("rows"), side("cols"))
                    && rows * columns != out.len() as f64
                {
                    return Err(format!(
                        "a matrix of {rows} x {columns} is declared, but it has {} numbers",
                        out.len()
                    ));
                }
            }
            other => other.collect(&mut out)?,
        }
        match out.iter().find(|v| !v.is_finite()) {
            Some(v) => Err(format!("it contains {v}; all numbers must be finite")),
            None => Ok(out),
        }
    }

    fn collect(&self, out: &mut Vec<f64>) -> Result<(), String> {
        match self {
            Self::Number(n) => out.push(*n),
            Self::List(items) => items.iter().try_for_each(|i| i.collect(out))?,
            Self::Text(text) => {
                for word in text.split_whitespace() {
                    // OpenCV writes .Nan and .Inf; `numbers` refuses both.
                    let not_finite =
                        ["nan", "inf"].contains(&&*word.to_lowercase().replace(['.', '-'], ""));
                    let value = if not_finite { Ok(f64::NAN) } else { word.parse() };
                    out.push(value.map_err(|_| format!("{word:?} is not a number"))?);
                }
            }
            Self::Nothing => {}
            Self::Map(_) => {
                return Err("it contains named entries, but numbers are expected".into());
            }
        }
        Ok(())
    }

    /// The text of a text entry.
    pub(super) fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text.trim()),
            _ => None,
        }
    }
}

impl<'de> Deserialize<'de> for Tree {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TreeVisitor)
    }
}

struct TreeVisitor;

impl<'de> Visitor<'de> for TreeVisitor {
    type Value = Tree;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, text, list or map")
    }
    fn visit_unit<E: Error>(self) -> Result<Tree, E> {
        Ok(Tree::Nothing)
    }
    fn visit_none<E: Error>(self) -> Result<Tree, E> {
        Ok(Tree::Nothing)
    }
    fn visit_some<D: Deserializer<'de>>(self, d: D) -> Result<Tree, D::Error> {
        Tree::deserialize(d)
    }
    fn visit_newtype_struct<D: Deserializer<'de>>(self, d: D) -> Result<Tree, D::Error> {
        Tree::deserialize(d)
    }
    fn visit_bool<E: Error>(self, v: bool) -> Result<Tree, E> {
        Ok(Tree::Text(v.to_string()))
    }
    fn visit_i64<E: Error>(self, v: i64) -> Result<Tree, E> {
        Ok(Tree::Number(v as f64))
    }
    fn visit_u64<E: Error>(self, v: u64) -> Result<Tree, E> {
        Ok(Tree::Number(v as f64))
    }
    fn visit_f64<E: Error>(self, v: f64) -> Result<Tree, E> {
        Ok(Tree::Number(v))
    }
    fn visit_str<E: Error>(self, v: &str) -> Result<Tree, E> {
        Ok(Tree::Text(v.to_owned()))
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Tree, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = seq.next_element()? {
            items.push(item);
        }
        Ok(Tree::List(items))
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Tree, A::Error> {
        let mut entries = Vec::new();
        while let Some(entry) = map.next_entry::<String, Tree>()? {
            entries.push(entry);
        }
        Ok(Tree::Map(entries))
    }
}
