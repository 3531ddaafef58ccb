//! Which file of a crate imports which other, read from the text of the sources.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A module's path below the crate, for example `["stages", "detect"]`.
type Module = Vec<String>;

struct Source {
    file: PathBuf,
    text: String,
    /// Names that the file defines.
    defined: BTreeSet<String>,
    /// Names that the file re-exports, with the path they come from.
    exported: BTreeMap<String, Module>,
}

/// The sources of a crate, by module.
pub struct Sources {
    modules: BTreeMap<Module, Source>,
}

impl Sources {
    /// Reads every file below a `src` folder, except tests.
    pub fn read(folder: &Path) -> Self {
        let mut modules = BTreeMap::new();
        for file in super::rust_files(folder) {
            let relative = file.strip_prefix(folder).unwrap().with_extension("");
            let module: Module =
                relative.components().map(|c| c.as_os_str().to_string_lossy().into()).collect();
            if module.last().is_some_and(|m| m == "tests") || module == ["lib"] {
                continue;
            }
            let text = without_comments(&fs::read_to_string(&file).unwrap());
            let text = text.split("#[cfg(test)]\nmod tests").next().unwrap().to_owned();
            let defined = definitions(&text);
            modules.insert(module, Source { file, text, defined, exported: BTreeMap::new() });
        }
        let mut sources = Self { modules };
        let exports: Vec<_> =
            sources.modules.keys().map(|m| (m.clone(), sources.exports(m))).collect();
        for (module, exported) in exports {
            sources.modules.get_mut(&module).unwrap().exported = exported;
        }
        sources
    }

    /// Every module with its file.
    pub fn modules(&self) -> impl Iterator<Item = (&Module, &PathBuf)> {
        self.modules.iter().map(|(module, source)| (module, &source.file))
    }

    /// Modules that define what a module imports.
    pub fn imports(&self, module: &[String]) -> BTreeSet<Module> {
        let source = &self.modules[module];
        let private = source.text.split("pub use ").enumerate();
        // what is only re-exported is not used here
        let text: String = private
            .map(|(i, part)| if i == 0 { part } else { part.split_once(';').map_or("", |p| p.1) })
            .collect();
        let mut found: BTreeSet<Module> = expand_uses(&text)
            .iter()
            .filter_map(|path| self.resolve(&absolute(module, path)?))
            .collect();
        found.remove(module);
        found
    }

    /// Types of a module's inherent `impl` blocks.
    pub fn inherent_impls(&self, module: &[String]) -> BTreeSet<String> {
        let text = &self.modules[module].text;
        text.lines()
            .filter(|line| line.starts_with("impl") && !line.contains(" for "))
            .filter_map(|line| {
                let rest = line.strip_prefix("impl")?;
                let rest = match rest.strip_prefix('<') {
                    Some(generic) => generic.split_once("> ")?.1,
                    None => rest.trim_start(),
                };
                Some(rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect())
            })
            .collect()
    }

    /// Modules that define a name.
    pub fn definitions(&self, name: &str) -> Vec<Module> {
        let defines = |s: &Source| s.defined.contains(name);
        self.modules.iter().filter(|(_, s)| defines(s)).map(|(m, _)| m.clone()).collect()
    }

    fn exports(&self, module: &[String]) -> BTreeMap<String, Module> {
        let text = &self.modules[module].text;
        let statements = text.split("pub use ").skip(1).filter_map(|s| s.split(';').next());
        statements
            .flat_map(|s| expand_tree(s.trim()))
            .filter_map(|path| Some((path.last()?.clone(), self.reexported(module, &path)?)))
            .collect()
    }

    fn reexported(&self, module: &[String], path: &[String]) -> Option<Module> {
        let first = path.first()?.as_str();
        if matches!(first, "crate" | "super" | "self") {
            return absolute(module, path);
        }
        let child = [module, &path[..1]].concat();
        self.modules.contains_key(&child).then(|| [module, path].concat())
    }

    /// The module that defines what a path names: the longest module in it, followed through
    /// re-exports.
    fn resolve(&self, path: &[String]) -> Option<Module> {
        let length = (1..=path.len()).rev().find(|n| self.modules.contains_key(&path[..*n]))?;
        let (module, rest) = path.split_at(length);
        let source = &self.modules[module];
        match rest.first() {
            Some(name) if !source.defined.contains(name) => match source.exported.get(name) {
                Some(target) if target != path => self.resolve(target),
                _ => Some(module.to_vec()),
            },
            _ => Some(module.to_vec()),
        }
    }
}

/// A path as it counts from the crate; `None` for paths of other crates.
fn absolute(module: &[String], path: &[String]) -> Option<Module> {
    let mut base: Module = match path.first()?.as_str() {
        "crate" => Vec::new(),
        "self" => module.to_vec(),
        "super" => module[..module.len().checked_sub(1)?].to_vec(),
        _ => return None,
    };
    let mut rest = &path[1..];
    while rest.first().is_some_and(|p| p == "super") {
        base.pop()?;
        rest = &rest[1..];
    }
    base.extend(rest.iter().filter(|p| *p != "self").cloned());
    Some(base)
}

fn without_comments(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.map(|line| format!("{line}\n")).collect()
}

fn definitions(text: &str) -> BTreeSet<String> {
    const KINDS: [&str; 7] = ["fn ", "struct ", "enum ", "trait ", "const ", "type ", "static "];
    text.lines()
        .filter_map(|line| {
            let line = line.trim_start();
            let line = match line.strip_prefix("pub") {
                Some(rest) if rest.starts_with('(') => rest.split_once(") ")?.1,
                Some(rest) => rest.trim_start(),
                None => line,
            };
            let rest = KINDS.iter().find_map(|kind| line.strip_prefix(kind))?;
            Some(rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect())
        })
        .collect()
}

/// All paths that begin with `crate`, `super` or `self`: those of `use` statements, and inline ones.
pub fn expand_uses(text: &str) -> Vec<Vec<String>> {
    let text = without_comments(text);
    let mut found = BTreeSet::new();
    for root in ["crate", "super", "self"] {
        let start = format!("{root}::");
        for (at, _) in text.match_indices(&start) {
            let before = text[..at].chars().next_back().unwrap_or(' ');
            let joined = before.is_alphanumeric() || matches!(before, '_' | ':' | '$');
            if !joined {
                found.extend(expand_tree(path_text(&text[at..])));
            }
        }
    }
    found.into_iter().collect()
}

/// The text of a path, with the braces of a `use` tree.
fn path_text(text: &str) -> &str {
    let mut depth = 0usize;
    let end = text.char_indices().find(|(_, c)| match c {
        '{' => {
            depth += 1;
            false
        }
        '}' => {
            depth = depth.saturating_sub(1);
            depth == 0
        }
        c => depth == 0 && !(c.is_alphanumeric() || matches!(c, '_' | ':')),
    });
    match end {
        Some((at, '}')) => &text[..=at],
        Some((at, _)) => &text[..at],
        None => text,
    }
}

/// The paths of a `use` tree: `a::{b, c::D as E}` is `a::b` and `a::c::D`.
fn expand_tree(text: &str) -> Vec<Vec<String>> {
    let segments = |path: &str| -> Vec<String> {
        let name = path.trim().split(" as ").next().unwrap_or_default();
        name.split("::").map(str::trim).filter(|p| !p.is_empty()).map(str::to_owned).collect()
    };
    let Some((prefix, inner)) = text.split_once('{') else { return vec![segments(text)] };
    let prefix = segments(prefix);
    let inner = inner.strip_suffix('}').unwrap_or(inner);
    let mut parts = vec![String::new()];
    let mut depth = 0usize;
    for c in inner.chars() {
        match c {
            '{' => depth += 1,
            '}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if c == ',' && depth == 0 {
            parts.push(String::new());
        } else if let Some(part) = parts.last_mut() {
            part.push(c);
        }
    }
    let trees = parts.iter().map(|p| p.trim()).filter(|p| !p.is_empty());
    trees.flat_map(expand_tree).map(|path| [prefix.as_slice(), &path].concat()).collect()
}

/// The strongly connected components of more than one module.
pub fn circles(graph: &BTreeMap<Module, BTreeSet<Module>>) -> Vec<Vec<Module>> {
    let reach = |from: &Module| -> BTreeSet<Module> {
        let mut seen = BTreeSet::new();
        let mut open = vec![from.clone()];
        while let Some(module) = open.pop() {
            for next in graph.get(&module).into_iter().flatten() {
                if seen.insert(next.clone()) {
                    open.push(next.clone());
                }
            }
        }
        seen
    };
    let reached: BTreeMap<&Module, BTreeSet<Module>> =
        graph.keys().map(|m| (m, reach(m))).collect();
    let mut done = BTreeSet::new();
    let mut found = Vec::new();
    for module in graph.keys() {
        if done.contains(module) || !reached[module].contains(module) {
            continue;
        }
        let circle: Vec<Module> = reached[module]
            .iter()
            .filter(|other| reached.get(other).is_some_and(|r| r.contains(module)))
            .cloned()
            .collect();
        done.extend(circle.iter().cloned());
        found.push(circle);
    }
    found
}
