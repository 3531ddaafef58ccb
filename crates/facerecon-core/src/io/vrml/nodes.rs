//! The nodes of a VRML file, both versions: a node has fields, and in VRML 1.0 children.

use std::collections::BTreeMap;

use super::lexer::{Lexer, Token};
use crate::io::error::Fault;

/// Deepest nesting of nodes; scenes have about ten levels, and each uses stack.
const MAX_DEPTH: usize = 100;
/// Most nodes in one file; scenes with one head have a handful.
const MAX_NODES: usize = 200_000;

/// Characters of a token that an error message shows.
const MAX_SHOWN: usize = 30;

/// Index of a node in [`Scene::nodes`].
pub(super) type NodeId = usize;

#[derive(Debug, Default)]
pub(super) struct Node {
    pub kind: String,
    pub fields: Vec<(String, Value)>,
    pub children: Vec<NodeId>,
}

/// The content of a field: all numbers, strings, words and nodes in order; brackets are ignored.
#[derive(Debug, Default)]
pub(super) struct Value {
    pub numbers: Vec<f64>,
    pub texts: Vec<String>,
    pub words: Vec<String>,
    pub nodes: Vec<NodeId>,
}

impl Node {
    /// The last field of that name.
    pub(super) fn field(&self, name: &str) -> Option<&Value> {
        self.fields.iter().rev().find(|(n, _)| n == name).map(|(_, v)| v)
    }

    /// The numbers of a field; none where it is absent.
    pub(super) fn numbers(&self, name: &str) -> &[f64] {
        self.field(name).map_or(&[], |v| &v.numbers)
    }

    /// The first `N` numbers of a field.
    pub(super) fn vector<const N: usize>(&self, name: &str) -> Option<[f64; N]> {
        self.numbers(name).first_chunk().copied()
    }

    /// The nodes of a field.
    pub(super) fn nodes(&self, name: &str) -> &[NodeId] {
        self.field(name).map_or(&[], |v| &v.nodes)
    }

    /// A switch such as `ccw FALSE`.
    pub(super) fn switch(&self, name: &str, default: bool) -> bool {
        match self.field(name).and_then(|v| v.words.first()) {
            Some(word) => word == "TRUE",
            None => default,
        }
    }

    /// The first text or word of a field.
    pub(super) fn text(&self, name: &str) -> Option<&str> {
        let value = self.field(name)?;
        value.texts.first().or(value.words.first()).map(String::as_str)
    }
}

/// All nodes of a file. `USE` names a node that is defined and complete, so that no node contains
/// itself.
#[derive(Debug, Default)]
pub(super) struct Scene {
    pub nodes: Vec<Node>,
    pub roots: Vec<NodeId>,
    defined: BTreeMap<String, NodeId>,
}

impl Scene {
    /// Reads a file's text.
    pub(super) fn parse(text: &str) -> Result<Self, Fault> {
        let mut scene = Self::default();
        let mut lexer = Lexer::new(text);
        while let Some(token) = lexer.next()? {
            match token {
                Token::Word(word) => {
                    if let Some(node) = scene.statement(&word, &mut lexer, 0)? {
                        scene.roots.push(node);
                    }
                }
                other => {
                    return Err(Fault::at(
                        lexer.line(),
                        format!("expected is a node, but found is {}", shown(&other)),
                    ));
                }
            }
        }
        Ok(scene)
    }

    /// A node after its first word; `None` for a statement that is not a node.
    fn statement(
        &mut self,
        word: &str,
        lexer: &mut Lexer<'_>,
        depth: usize,
    ) -> Result<Option<NodeId>, Fault> {
        let line = lexer.line();
        if depth > MAX_DEPTH {
            return Err(Fault::at(line, format!("nodes are nested more than {MAX_DEPTH} deep")));
        }
        match word {
            "DEF" => {
                let name = self.name(lexer)?;
                let kind = self.name(lexer)?;
                let node = self.statement(&kind, lexer, depth + 1)?;
                // Defined when complete: a USE inside the node does not find it.
                if let Some(node) = node {
                    self.defined.insert(name, node);
                }
                Ok(node)
            }
            "USE" => {
                let name = self.name(lexer)?;
                match self.defined.get(&name) {
                    Some(node) => Ok(Some(*node)),
                    None => Err(Fault::at(
                        line,
                        format!(
                            "USE {name}: no node of that name is defined before (a node cannot contain itself)"
                        ),
                    )),
                }
            }
            "NULL" => Ok(None),
            "ROUTE" => {
                for _ in 0..3 {
                    self.name(lexer)?;
                }
                Ok(None)
            }
            "PROTO" | "EXTERNPROTO" => {
                self.name(lexer)?;
                skip_group(lexer, '[', ']')?;
                if word == "PROTO" {
                    skip_group(lexer, '{', '}')?;
                } else {
                    self.value(lexer, depth + 1)?;
                }
                Ok(None)
            }
            kind => {
                if !lexer.take('{')? {
                    return Err(Fault::at(
                        line,
                        format!("{kind:?} is not a node: {{ is expected after it"),
                    ));
                }
                let mut node = Node { kind: kind.to_owned(), ..Node::default() };
                self.body(&mut node, lexer, depth)?;
                if self.nodes.len() >= MAX_NODES {
                    return Err(Fault::at(line, format!("there are more than {MAX_NODES} nodes")));
                }
                self.nodes.push(node);
                Ok(Some(self.nodes.len() - 1))
            }
        }
    }

    /// Fields and children up to the closing brace.
    fn body(&mut self, node: &mut Node, lexer: &mut Lexer<'_>, depth: usize) -> Result<(), Fault> {
        let start = lexer.line();
        loop {
            match lexer.next()? {
                Some(Token::Mark('}')) => return Ok(()),
                Some(Token::Word(word)) => {
                    let is_node =
                        matches!(word.as_str(), "DEF" | "USE" | "PROTO" | "EXTERNPROTO" | "ROUTE")
                            || lexer.peek()? == Some(&Token::Mark('{'));
                    if is_node {
                        node.children.extend(self.statement(&word, lexer, depth + 1)?);
                    } else {
                        let value = self.value(lexer, depth + 1)?;
                        node.fields.push((word, value));
                    }
                }
                // Event declarations of scripts leave single values.
                Some(Token::Number(_) | Token::Text(_)) => {}
                Some(other) => {
                    return Err(Fault::at(
                        lexer.line(),
                        format!(
                            "in {}: expected is a field, but found is {}",
                            node.kind,
                            shown(&other)
                        ),
                    ));
                }
                None => {
                    return Err(Fault::at(start, format!("the file ends inside {}", node.kind)));
                }
            }
        }
    }

    /// A field's value: a word, a node, a row of numbers or strings, or a bracketed list of them.
    fn value(&mut self, lexer: &mut Lexer<'_>, depth: usize) -> Result<Value, Fault> {
        let mut value = Value::default();
        match lexer.peek()? {
            Some(Token::Mark('[')) => {
                lexer.next()?;
                self.list(&mut value, ']', lexer, depth)?;
            }
            Some(Token::Mark('(')) => {
                lexer.next()?;
                self.list(&mut value, ')', lexer, depth)?;
            }
            Some(Token::Word(_)) => self.item(&mut value, lexer, depth)?,
            _ => {
                while matches!(lexer.peek()?, Some(Token::Number(_) | Token::Text(_))) {
                    self.item(&mut value, lexer, depth)?;
                }
            }
        }
        Ok(value)
    }

    fn list(
        &mut self,
        value: &mut Value,
        end: char,
        lexer: &mut Lexer<'_>,
        depth: usize,
    ) -> Result<(), Fault> {
        let start = lexer.line();
        while !lexer.take(end)? {
            match lexer.peek()? {
                Some(Token::Mark('|')) => {
                    lexer.next()?;
                }
                Some(Token::Mark(other)) => {
                    let message = format!("a list has {other}, but {end} or a value is expected");
                    return Err(Fault::at(lexer.line(), message));
                }
                Some(_) => self.item(value, lexer, depth)?,
                None => return Err(Fault::at(start, format!("a list has no closing {end}"))),
            }
        }
        Ok(())
    }

    fn item(
        &mut self,
        value: &mut Value,
        lexer: &mut Lexer<'_>,
        depth: usize,
    ) -> Result<(), Fault> {
        match lexer.next()? {
            Some(Token::Number(n)) => value.numbers.push(n),
            Some(Token::Text(t)) => value.texts.push(t),
            Some(Token::Word(word)) => {
                let node = matches!(word.as_str(), "DEF" | "USE" | "NULL")
                    || lexer.peek()? == Some(&Token::Mark('{'));
                if node {
                    value.nodes.extend(self.statement(&word, lexer, depth + 1)?);
                } else {
                    value.words.push(word);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn name(&self, lexer: &mut Lexer<'_>) -> Result<String, Fault> {
        let line = lexer.line();
        match lexer.next()? {
            Some(Token::Word(word)) => Ok(word),
            // Some programs use numbers as names.
            Some(Token::Number(n)) => Ok(n.to_string()),
            _ => Err(Fault::at(line, "a name is expected")),
        }
    }
}

/// Skips a bracketed group.
fn skip_group(lexer: &mut Lexer<'_>, open: char, close: char) -> Result<(), Fault> {
    let line = lexer.line();
    if !lexer.take(open)? {
        return Err(Fault::at(line, format!("{open} is expected")));
    }
    let mut depth = 1;
    while depth > 0 {
        match lexer.next()? {
            Some(Token::Mark(c)) if c == open => depth += 1,
            Some(Token::Mark(c)) if c == close => depth -= 1,
            Some(_) => {}
            None => return Err(Fault::at(line, format!("a group has no closing {close}"))),
        }
    }
    Ok(())
}

fn shown(token: &Token) -> String {
    match token {
        Token::Number(n) => n.to_string(),
        Token::Word(w) => w.chars().take(MAX_SHOWN).collect(),
        Token::Text(_) => "a string".into(),
        Token::Mark(c) => c.to_string(),
    }
}
