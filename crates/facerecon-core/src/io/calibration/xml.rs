//! The subset of XML that OpenCV's FileStorage writes: elements and text; attributes are ignored.

use super::tree::Tree;
use crate::io::error::Fault;
use crate::io::source::line_of;

/// Deepest nesting of elements; a FileStorage has three levels.
const MAX_DEPTH: usize = 32;

/// Reads `<opencv_storage>` and returns its children as a map.
pub(super) fn parse(source: &str) -> Result<Tree, Fault> {
    let mut parser = Parser { source, at: 0, open: vec![Element::new("")] };
    while parser.at < source.len() {
        parser.next()?;
    }
    parser.finish()
}

/// An element that is not closed yet.
struct Element<'a> {
    name: &'a str,
    children: Vec<(String, Tree)>,
    text: String,
}

impl<'a> Element<'a> {
    fn new(name: &'a str) -> Self {
        Self { name, children: Vec::new(), text: String::new() }
    }

    fn into_tree(self) -> Tree {
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

struct Parser<'a> {
    source: &'a str,
    /// Byte offset of what comes next.
    at: usize,
    /// The open elements, outermost first; the first one stands for the whole file.
    open: Vec<Element<'a>>,
}

impl<'a> Parser<'a> {
    fn fault(&self, at: usize, message: impl Into<String>) -> Fault {
        Fault::at(line_of(self.source, at), message)
    }

    /// Reads the next text or tag.
    fn next(&mut self) -> Result<(), Fault> {
        let source = self.source;
        let rest = source.get(self.at..).unwrap_or_default();
        if !rest.starts_with('<') {
            let end = rest.find('<').unwrap_or(rest.len());
            if let Some(top) = self.open.last_mut() {
                top.text.push_str(&rest[..end]);
            }
            self.at += end;
            return Ok(());
        }
        let (terminator, ignored) = match rest {
            r if r.starts_with("<!--") => ("-->", true),
            r if r.starts_with("<?") => ("?>", true),
            r if r.starts_with("<!") => (">", true),
            _ => (">", false),
        };
        let Some(length) = rest.find(terminator) else {
            return Err(self.fault(self.at, "the XML ends inside a tag"));
        };
        let (tag, start) = (&rest[..length], self.at);
        self.at += length + terminator.len();
        match tag.strip_prefix("</") {
            _ if ignored => Ok(()),
            Some(name) => self.close(name.trim(), start),
            None => self.open(&tag[1..], start),
        }
    }

    fn close(&mut self, name: &str, start: usize) -> Result<(), Fault> {
        let top = self.open.pop();
        let Some(closed) = top.filter(|e| e.name == name && !self.open.is_empty()) else {
            return Err(self.fault(start, format!("</{name}> closes no open element")));
        };
        self.add(name, closed.into_tree());
        Ok(())
    }

    fn open(&mut self, inner: &'a str, start: usize) -> Result<(), Fault> {
        let inner = inner.trim_end();
        let (inner, empty) = match inner.strip_suffix('/') {
            Some(inner) => (inner, true),
            None => (inner, false),
        };
        let name = inner.split_whitespace().next().unwrap_or_default();
        if name.is_empty() {
            return Err(self.fault(start, "the XML has a tag without a name"));
        }
        if self.open.len() > MAX_DEPTH {
            return Err(
                self.fault(start, format!("elements are nested more than {MAX_DEPTH} deep"))
            );
        }
        if empty {
            self.add(name, Tree::Nothing);
        } else {
            self.open.push(Element::new(name));
        }
        Ok(())
    }

    /// Adds a child to the innermost open element.
    fn add(&mut self, name: &str, value: Tree) {
        if let Some(top) = self.open.last_mut() {
            top.children.push((name.to_owned(), value));
        }
    }

    fn finish(mut self) -> Result<Tree, Fault> {
        match (self.open.pop(), self.open.is_empty()) {
            (Some(file), true) => file
                .children
                .into_iter()
                .find(|(name, _)| name == "opencv_storage")
                .map(|(_, tree)| tree)
                .ok_or_else(|| {
                    Fault::new("the XML has no <opencv_storage>; it is not an OpenCV FileStorage")
                }),
            (Some(element), false) => {
                Err(self.fault(self.source.len(), format!("<{}> is never closed", element.name)))
            }
            (None, _) => Err(Fault::new("the XML is empty")),
        }
    }
}
