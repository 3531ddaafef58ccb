//! YAML, JSON and XML as one small tree.

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};

use super::xml;
use crate::io::Fault;

/// A value of a calibration file.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Tree {
    Nothing,
    Number(f64),
    Text(String),
    List(Vec<Tree>),
    Map(Vec<(String, Tree)>),
}

/// Reads the top entries of a file in any of the formats.
pub(super) fn parse(text: &str) -> Result<Vec<(String, Tree)>, Fault> {
    let start = text.trim_start();
    let tree = if start.starts_with('<') {
        xml::parse(text)?
    } else if start.starts_with('{') {
        let tree = serde_json::from_str(text)
            .map_err(|e| Fault::at(e.line(), format!("this is no JSON ({e})")))?;
        unwrap_storage(tree)
    } else {
        yaml(text)?
    };
    match tree {
        Tree::Map(entries) => Ok(entries),
        _ => Err(Fault::new(
            "this is no calibration; an OpenCV FileStorage (YAML, XML or JSON) with K1 D1 K2 D2 R T \
             is wanted",
        )),
    }
}

/// FileStorage XML and some JSON hold everything in one `opencv_storage`.
fn unwrap_storage(tree: Tree) -> Tree {
    match tree {
        Tree::Map(mut entries) if entries.len() == 1 && entries[0].0 == "opencv_storage" => {
            entries.remove(0).1
        }
        other => other,
    }
}

fn yaml(text: &str) -> Result<Tree, Fault> {
    // OpenCV's `%YAML:1.0` is no directive of any YAML version.
    let body: String = text
        .lines()
        .enumerate()
        .map(|(i, line)| if i == 0 && line.starts_with("%YAML") { "" } else { line })
        .flat_map(|line| [line, "\n"])
        .collect();
    serde_saphyr::from_str(&body).map_err(|e| {
        let line = e.location().and_then(|l| usize::try_from(l.line()).ok()).filter(|l| *l > 0);
        let message = e.to_string();
        let first = message.lines().next().unwrap_or_default();
        Fault { line, message: format!("this is no OpenCV YAML, XML or JSON ({first})") }
    })
}

impl Tree {
    /// All numbers of a matrix (`rows`, `cols`, `data`), of nested lists, or of one number.
    pub(super) fn numbers(&self) -> Result<Vec<f64>, String> {
        let mut out = Vec::new();
        match self {
            Self::Map(entries) => {
                let get = |name: &str| entries.iter().find(|(k, _)| k == name).map(|(_, v)| v);
                let data =
                    get("data").ok_or("it is no matrix: rows, cols and data are expected")?;
                data.collect(&mut out)?;
                let side = |name: &str| match get(name) {
                    Some(Self::Number(n)) => Some(*n),
                    _ => None,
                };
                if let (Some(rows), Some(columns)) = (side("rows"), side("cols"))
                    && rows * columns != out.len() as f64
                {
                    return Err(format!(
                        "it says {rows} x {columns}, but has {} numbers",
                        out.len()
                    ));
                }
            }
            other => other.collect(&mut out)?,
        }
        match out.iter().find(|v| !v.is_finite()) {
            Some(v) => Err(format!("it holds {v}; all numbers must be finite")),
            None => Ok(out),
        }
    }

    fn collect(&self, out: &mut Vec<f64>) -> Result<(), String> {
        match self {
            Self::Number(n) => out.push(*n),
            Self::List(items) => items.iter().try_for_each(|i| i.collect(out))?,
            Self::Text(text) => {
                for word in text.split_whitespace() {
                    // OpenCV writes .Nan and .Inf; both are refused with all that is not finite.
                    let odd =
                        ["nan", "inf"].contains(&&*word.to_lowercase().replace(['.', '-'], ""));
                    let value = if odd { Ok(f64::NAN) } else { word.parse() };
                    out.push(value.map_err(|_| format!("{word:?} is no number"))?);
                }
            }
            Self::Nothing => {}
            Self::Map(_) => return Err("it holds names where numbers are expected".into()),
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
