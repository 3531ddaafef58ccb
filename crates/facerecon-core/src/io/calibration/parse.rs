//! A calibration file of any format as a tree.

use super::tree::Tree;
use super::xml;
use crate::io::error::Fault;

/// Reads the top entries of a file in any of the formats.
pub(super) fn parse(text: &str) -> Result<Vec<(String, Tree)>, Fault> {
    let start = text.trim_start();
    let tree = if start.starts_with('<') {
        xml::parse(text)?
    } else if start.starts_with('{') {
        let tree = serde_json::from_str(text)
            .map_err(|e| Fault::at(e.line(), format!("malformed JSON ({e})")))?;
        unwrap_storage(tree)
    } else {
        yaml(text)?
    };
    match tree {
        Tree::Map(entries) => Ok(entries),
        _ => Err(Fault::new(
            "this is not a calibration; expected is an OpenCV FileStorage (YAML, XML or JSON) with \
             K1 D1 K2 D2 R T",
        )),
    }
}

/// FileStorage JSON may have all entries inside one `opencv_storage`.
fn unwrap_storage(tree: Tree) -> Tree {
    match tree {
        Tree::Map(mut entries) if entries.len() == 1 && entries[0].0 == "opencv_storage" => {
            entries.remove(0).1
        }
        other => other,
    }
}

fn yaml(text: &str) -> Result<Tree, Fault> {
    // OpenCV's `%YAML:1.0` is not a directive of any YAML version.
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
        Fault { line, message: format!("this is not OpenCV YAML, XML or JSON ({first})") }
    })
}
