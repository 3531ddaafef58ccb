//! The house keeps its floors: dependencies point down only, stages do not know each other, and
//! no file is longer than one sitting.
#![allow(clippy::unwrap_used)] // also the helpers of tests may stop a test

use std::fs;
use std::path::{Path, PathBuf};

const LONGEST_FILE: usize = 400;

/// Floors of the core's modules, lowest first (docs/architecture.md).
const FLOORS: &[&[&str]] = &[
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

/// The top-level modules of the core that a source text names as `crate::NAME`.
fn named_modules(text: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for part in text.split("crate::").skip(1) {
        if let Some(inner) = part.strip_prefix('{') {
            let inner = &inner[..inner.find('}').unwrap_or(inner.len())];
            names.extend(inner.split(',').map(|n| n.trim().split("::").next().unwrap().to_owned()));
        } else {
            names.push(part.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect());
        }
    }
    names.sort();
    names.dedup();
    names
}

fn floor_of(module: &str) -> Option<usize> {
    FLOORS.iter().position(|floor| floor.contains(&module))
}

#[test]
fn dependencies_point_down_only() {
    let source = root().join("crates/facerecon-core/src");
    let mut faults = Vec::new();
    for file in rust_files(&source) {
        let relative = file.strip_prefix(&source).unwrap().to_owned();
        let parts: Vec<_> =
            relative.components().map(|c| c.as_os_str().to_string_lossy()).collect();
        let module = parts[0].trim_end_matches(".rs").to_owned();
        if module == "lib" {
            continue;
        }
        let Some(own) = floor_of(&module) else {
            faults.push(format!("{}: module {module} stands on no floor", relative.display()));
            continue;
        };
        let text = fs::read_to_string(&file).unwrap();
        for name in named_modules(&text) {
            if floor_of(&name).is_some_and(|floor| floor > own) {
                faults.push(format!("{}: floor {own} names crate::{name}", relative.display()));
            }
        }
        if module == "stages" && parts.len() > 1 {
            let own_stage = parts[1].trim_end_matches(".rs");
            for other in text.split("stages::").skip(1) {
                let name: String =
                    other.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                if name != own_stage {
                    faults.push(format!("{}: a stage names stage {name}", relative.display()));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn no_file_is_longer_than_one_sitting() {
    let root = root();
    let long: Vec<String> = [root.join("crates"), root.join("tests")]
        .iter()
        .flat_map(|folder| rust_files(folder))
        .filter_map(|file| {
            let lines = fs::read_to_string(&file).unwrap().lines().count();
            (lines > LONGEST_FILE).then(|| format!("{}: {lines} lines", file.display()))
        })
        .collect();
    assert!(long.is_empty(), "longer than {LONGEST_FILE} lines:\n{}", long.join("\n"));
}

#[test]
fn only_one_file_names_the_search_tree() {
    let source = root().join("crates/facerecon-core/src");
    let naming: Vec<_> = rust_files(&source)
        .into_iter()
        .filter(|f| fs::read_to_string(f).unwrap().contains("kiddo::"))
        .map(|f| f.strip_prefix(&source).unwrap().to_owned())
        .collect();
    assert_eq!(naming, [Path::new("spatial/points.rs")]);
}

#[test]
fn the_reader_of_imports_sees_what_is_there() {
    let text = "use crate::math::Vec3;\nuse crate::{data::Mesh, io};\nfn f(m: crate::render::X) {}";
    assert_eq!(named_modules(text), ["data", "io", "math", "render"]);
    assert!(floor_of("io") > floor_of("data"));
}
