//! The subset of XML that OpenCV's FileStorage writes: elements, attributes (ignored), text.

use super::tree::Tree;
use crate::io::Fault;
use crate::io::source::line_of;

const MAX_DEPTH: usize = 32;

struct Open<'a> {
    name: &'a str,
    children: Vec<(String, Tree)>,
    text: String,
}

/// Reads `<opencv_storage>` and returns its children as a map.
pub(super) fn parse(source: &str) -> Result<Tree, Fault> {
    let fault = |at: usize, message: String| Err(Fault::at(line_of(source, at), message));
    let mut stack = vec![Open { name: "", children: Vec::new(), text: String::new() }];
    let mut at = 0;
    while let Some(rest) = source.get(at..).filter(|r| !r.is_empty()) {
        if !rest.starts_with('<') {
            let end = rest.find('<').unwrap_or(rest.len());
            if let Some(top) = stack.last_mut() {
                top.text.push_str(&rest[..end]);
            }
            at += end;
            continue;
        }
        let (terminator, skip) = match rest {
            r if r.starts_with("<!--") => ("-->", true),
            r if r.starts_with("<?") => ("?>", true),
            r if r.starts_with("<!") => (">", true),
            _ => (">", false),
        };
        let Some(length) = rest.find(terminator) else {
            return fault(at, "this XML breaks off inside a tag".into());
        };
        let tag = &rest[..length];
        let here = at;
        at += length + terminator.len();
        if skip {
            continue;
        }
        if let Some(name) = tag.strip_prefix("</") {
            let name = name.trim();
            let Some(closed) = stack.pop().filter(|open| open.name == name && !stack.is_empty())
            else {
                return fault(here, format!("</{name}> closes nothing that is open"));
            };
            let value = closed.value();
            if let Some(top) = stack.last_mut() {
                top.children.push((name.to_owned(), value));
            }
            continue;
        }
        let inner = tag[1..].trim_end();
        let (inner, empty) = match inner.strip_suffix('/') {
            Some(inner) => (inner, true),
            None => (inner, false),
        };
        let name = inner.split_whitespace().next().unwrap_or_default();
        if name.is_empty() {
            return fault(here, "this XML has a tag without a name".into());
        }
        if stack.len() > MAX_DEPTH {
            return fault(here, "the tags are nested too deeply".into());
        }
        if empty {
            if let Some(top) = stack.last_mut() {
                top.children.push((name.to_owned(), Tree::Nothing));
            }
        } else {
            stack.push(Open { name, children: Vec::new(), text: String::new() });
        }
    }
    match (stack.pop(), stack.last()) {
        (Some(root), None) => {
            match root.children.into_iter().find(|(n, _)| n == "opencv_storage") {
                Some((_, tree)) => Ok(tree),
                None => {
                    Err(Fault::new("this XML has no <opencv_storage>; it is no OpenCV FileStorage"))
                }
            }
        }
        (Some(open), _) => fault(source.len(), format!("<{}> is never closed", open.name)),
        (None, _) => Err(Fault::new("this XML is empty")),
    }
}

impl Open<'_> {
    fn value(self) -> Tree {
        if !self.children.is_empty() {
            return Tree::Map(self.children);
        }
        let text = self.text.trim().trim_matches('"');
        match text.parse::<f64>() {
            Ok(number) => Tree::Number(number),
            Err(_) if text.is_empty() => Tree::Nothing,
            Err(_) => Tree::Text(text.to_owned()),
        }
    }
}
