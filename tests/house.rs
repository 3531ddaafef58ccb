//! The structure of the core: dependencies point down only, no two files import each other, stages
//! do not import each other, methods stay with their types, and files stay short.
#![allow(clippy::unwrap_used)] // a test may stop

#[path = "support/imports.rs"]
mod imports;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use imports::{Sources, expand_uses};

/// Longest file that can be read in one sitting, lines.
const MAX_FILE_LINES: usize = 400;

/// Layers of the core's modules, lowest first (docs/architecture.md).
const LAYERS: &[&[&str]] = &[
    &["settings", "math", "camera"],
    &["data", "spatial", "observer"],
    &["io", "template", "render"],
    &["stages"],
    &["pipeline"],
    &["output", "evaluate"],
    &["synthetic"],
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

fn core() -> Sources {
    Sources::read(&root().join("crates/facerecon-core/src"))
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

fn layer_of(module: &str) -> Option<usize> {
    LAYERS.iter().position(|layer| layer.contains(&module))
}

fn assert_none(faults: &[String]) {
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn dependencies_point_down_only() {
    let core = core();
    let mut faults = Vec::new();
    for (module, file) in core.modules() {
        let Some(top) = module.first() else { continue };
        let Some(own) = layer_of(top) else {
            faults.push(format!("{}: module {top} is in no layer", file.display()));
            continue;
        };
        for target in core.imports(module) {
            let other = &target[0];
            if layer_of(other).is_some_and(|layer| layer > own) {
                faults.push(format!("{}: layer {own} imports {other}", file.display()));
            }
            let is_stage = top == "stages" && module.len() > 1;
            if is_stage && other == "stages" && target.len() > 1 && target[1] != module[1] {
                let allowed = target[1] == "error";
                if !allowed {
                    faults.push(format!("{}: imports the stage {}", file.display(), target[1]));
                }
            }
        }
    }
    assert_none(&faults);
}

#[test]
fn no_files_import_each_other() {
    let core = core();
    let graph: BTreeMap<Vec<String>, BTreeSet<Vec<String>>> = core
        .modules()
        .map(|(module, _)| {
            // the entry file of a folder declares what the folder's files share
            let imports = core.imports(module);
            (module.clone(), imports.into_iter().filter(|t| !module.starts_with(t)).collect())
        })
        .collect();
    let circles = imports::circles(&graph);
    let text = |circle: &Vec<Vec<String>>| {
        circle.iter().map(|m| m.join("::")).collect::<Vec<_>>().join(", ")
    };
    assert_none(&circles.iter().map(text).collect::<Vec<_>>());
}

#[test]
fn methods_stay_in_the_module_of_their_type() {
    let core = core();
    let mut faults = Vec::new();
    for (module, file) in core.modules() {
        for name in core.inherent_impls(module) {
            let homes = core.definitions(&name);
            let top = module.first();
            if !homes.is_empty() && !homes.iter().any(|home| home.first() == top) {
                faults.push(format!(
                    "{}: impl {name}, which is defined in {}",
                    file.display(),
                    homes[0].join("::")
                ));
            }
        }
    }
    assert_none(&faults);
}

#[test]
fn no_file_is_too_long() {
    let root = root();
    let long: Vec<String> = ["crates", "tests", "tools"]
        .iter()
        .map(|folder| root.join(folder))
        .filter(|folder| folder.is_dir())
        .flat_map(|folder| rust_files(&folder))
        .filter_map(|file| {
            let lines = fs::read_to_string(&file).unwrap().lines().count();
            (lines > MAX_FILE_LINES)
                .then(|| format!("{}: {lines} lines, at most {MAX_FILE_LINES}", file.display()))
        })
        .collect();
    assert_none(&long);
}

#[test]
fn only_one_file_uses_the_search_tree() {
    let source = root().join("crates/facerecon-core/src");
    let users: Vec<_> = rust_files(&source)
        .into_iter()
        .filter(|f| fs::read_to_string(f).unwrap().contains("kiddo::"))
        .map(|f| f.strip_prefix(&source).unwrap().to_owned())
        .collect();
    assert_eq!(users, [Path::new("spatial/points.rs")]);
}

#[test]
fn imports_are_read_from_every_form_of_use() {
    let text = "use crate::math::Vec3;\npub use super::{a::B, c::{self, D as E}};\n\
                fn f(m: crate::render::X) { super::g::h() }\n// use crate::not::This;";
    let found: Vec<String> = expand_uses(text).iter().map(|p| p.join("::")).collect();
    let expected = [
        "crate::math::Vec3",
        "crate::render::X",
        "super::a::B",
        "super::c::D",
        "super::c::self",
        "super::g::h",
    ];
    assert_eq!(found, expected);
}

#[test]
fn a_circle_of_files_is_found() {
    let module = |name: &str| vec![name.to_owned()];
    let edges = |names: &[&str]| names.iter().map(|n| module(n)).collect::<BTreeSet<_>>();
    let mut graph = BTreeMap::from([
        (module("a"), edges(&["b"])),
        (module("b"), edges(&["c"])),
        (module("c"), edges(&[])),
    ]);
    assert!(imports::circles(&graph).is_empty());
    graph.insert(module("c"), edges(&["a"]));
    assert_eq!(imports::circles(&graph), [vec![module("a"), module("b"), module("c")]]);
}
