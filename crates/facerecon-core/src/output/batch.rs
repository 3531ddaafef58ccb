//! Many captures: one outcome per capture; finished ones are skipped.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::report::render_page;
use super::{Recorder, write_result};
use crate::io::{self, IoError};
use crate::pipeline::Error;
use crate::pipeline::Params;
use crate::pipeline::reconstruct;
use crate::render::Frame;
use crate::template::Template;

/// How a capture of a batch ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Reconstructed now.
    Done,
    /// Skipped: an earlier run made the result from the same input with the same parameters.
    Kept,
    /// Could not be reconstructed.
    Failed,
}

/// The outcome of one capture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Name of the capture and of its result folder.
    pub name: String,
    /// How it ended.
    pub status: Status,
    /// Matches found.
    pub matches: Option<u64>,
    /// Width of the face, mm.
    pub face_width_mm: Option<f64>,
    /// Height of the face, mm.
    pub face_height_mm: Option<f64>,
    /// Time of the run, ms.
    pub total_ms: Option<f64>,
    /// Number of warnings.
    pub warnings: usize,
    /// Why it failed.
    pub error: Option<String>,
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (&self.error, self.status) {
            (Some(error), _) => write!(f, "{}: {error}", self.name),
            (None, Status::Kept) => write!(f, "{}: kept from an earlier run", self.name),
            (None, _) => write!(f, "{}: {} matches", self.name, self.matches.unwrap_or(0)),
        }
    }
}

/// File in a result folder: on the first line a digest of the input of the run, on the second
/// line the name of the batch.
const FINGERPRINT: &str = "fingerprint.txt";

/// Reconstructs one capture of a batch into `output/NAME`, unless that folder holds the result of
/// the same files, parameters, template, frame and version. An error becomes [`Status::Failed`].
///
/// `batch` names this run if it may submit a capture twice (its first worker died after the work):
/// a result that the same run finished is [`Status::Done`], not [`Status::Kept`].
pub fn run(
    capture: &Path,
    output: &Path,
    head: &Template,
    params: &Params,
    frame: Frame,
    batch: Option<&str>,
) -> Outcome {
    let name = capture_name(capture);
    let folder = output.join(&name);
    match reconstruct_or_keep(capture, &folder, head, params, frame, batch) {
        Ok(status) => read_outcome(name, status, &folder),
        Err(error) => Outcome {
            name,
            status: Status::Failed,
            matches: None,
            face_width_mm: None,
            face_height_mm: None,
            total_ms: None,
            warnings: 0,
            error: Some(error.to_string()),
        },
    }
}

/// The captures at these paths, in their order: a capture folder or its `capture.toml` stands for
/// itself, another folder for the captures directly inside, sorted by path. A path that is neither
/// is kept, so that [`run`] reports what is wrong with it.
pub fn find_captures(paths: &[PathBuf]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for path in paths {
        let mut inside = if is_capture(path) { Vec::new() } else { captures_inside(path) };
        inside.sort();
        if inside.is_empty() {
            inside.push(path.clone());
        }
        found.append(&mut inside);
    }
    found
}

fn is_capture(path: &Path) -> bool {
    path.is_file() || path.join("capture.toml").is_file()
}

fn captures_inside(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let paths = entries.filter_map(Result::ok).map(|entry| entry.path());
    paths.filter(|path| path.join("capture.toml").is_file()).collect()
}

/// Names shared by several captures, whose results would overwrite each other; sorted.
pub fn shared_names(captures: &[PathBuf]) -> Vec<String> {
    let mut names: Vec<String> = captures.iter().map(|c| capture_name(c)).collect();
    names.sort();
    let mut shared: Vec<String> =
        names.windows(2).filter(|w| w[0] == w[1]).map(|w| w[0].clone()).collect();
    shared.dedup();
    shared
}

/// Name of a capture and of its result folder: the name of the capture folder.
pub fn capture_name(capture: &Path) -> String {
    let folder = if capture.is_file() { capture.parent().unwrap_or(capture) } else { capture };
    let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    absolute.file_name().map_or_else(|| "capture".into(), |n| n.to_string_lossy().into_owned())
}

fn reconstruct_or_keep(
    capture: &Path,
    folder: &Path,
    head: &Template,
    params: &Params,
    frame: Frame,
    batch: Option<&str>,
) -> Result<Status, Error> {
    let loaded = io::capture::read_capture(capture)?;
    let digest = fingerprint(&loaded.sources, head, params, frame)?;
    let beside = folder.join(FINGERPRINT);
    let old = std::fs::read_to_string(&beside).unwrap_or_default();
    let mut old = old.lines();
    let (same, old_batch) = (old.next() == Some(&digest), old.next());
    let complete = ["result.json", "face.obj", "face.glb"].iter().all(|f| folder.join(f).is_file());
    if same && complete {
        let by_this_run = old_batch.is_some() && old_batch == batch;
        return Ok(if by_this_run { Status::Done } else { Status::Kept });
    }
    // an interrupted run must not leave the old digest beside new files
    if beside.exists() {
        std::fs::remove_file(&beside)
            .map_err(|source| IoError::Write { path: beside.clone(), source })?;
    }
    let recorder = Recorder::default();
    let mut found = reconstruct(&loaded.capture, head, params, &recorder)?;
    found.warnings.splice(0..0, loaded.warnings);
    write_result(folder, &loaded.capture, &found, &recorder.take(), frame, false)?;
    let batch_line = batch.map_or(String::new(), |b| format!("{b}\n"));
    io::atomic::write(&beside, format!("{digest}\n{batch_line}").as_bytes())?;
    Ok(Status::Done)
}

/// SHA-256, in hexadecimal, of everything that a result depends on: version, frame, parameters,
/// template and the bytes of the source files.
///
/// # Errors
/// [`IoError::Read`] naming a source file that cannot be read.
pub fn fingerprint(
    sources: &[PathBuf],
    head: &Template,
    params: &Params,
    frame: Frame,
) -> Result<String, Error> {
    let mut digest = Sha256::new();
    let mut part = |bytes: &[u8]| {
        digest.update((bytes.len() as u64).to_le_bytes());
        digest.update(bytes);
    };
    part(env!("CARGO_PKG_VERSION").as_bytes());
    part(frame.to_string().as_bytes());
    part(params.to_toml()?.as_bytes());
    for mesh in std::iter::once(&head.mesh).chain(&head.coarse) {
        mesh.vertices.iter().flat_map(|v| v.iter()).for_each(|c| part(&c.to_le_bytes()));
        mesh.uvs.iter().flatten().for_each(|c| part(&c.to_le_bytes()));
        mesh.faces.iter().chain(&mesh.face_uvs).flatten().for_each(|i| part(&i.to_le_bytes()));
    }
    for (name, vertex) in &head.landmarks {
        part(name.as_bytes());
        part(&vertex.to_le_bytes());
    }
    if let Some(texture) = &head.texture {
        part(texture.data().as_flattened());
    }
    for source in sources {
        let bytes =
            std::fs::read(source).map_err(|e| IoError::Read { path: source.clone(), source: e })?;
        part(&bytes);
    }
    Ok(digest.finalize().iter().map(|b| format!("{b:02x}")).collect())
}

fn read_outcome(name: String, status: Status, folder: &Path) -> Outcome {
    let facts: serde_json::Value = std::fs::read_to_string(folder.join("result.json"))
        .ok()
        .and_then(|text| serde_json::from_str(&text).ok())
        .unwrap_or_default();
    Outcome {
        name,
        status,
        matches: facts["matches"].as_u64(),
        face_width_mm: facts["face_width_mm"].as_f64(),
        face_height_mm: facts["face_height_mm"].as_f64(),
        total_ms: facts["timings_ms"]["total"].as_f64(),
        warnings: facts["warnings"].as_array().map_or(0, Vec::len),
        error: None,
    }
}

const COLUMNS: [&str; 8] = [
    "name",
    "status",
    "matches",
    "face_width_mm",
    "face_height_mm",
    "total_ms",
    "warnings",
    "error",
];

fn cells(outcome: &Outcome) -> [String; 8] {
    let number = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v:.2}"));
    let status = match outcome.status {
        Status::Done => "done",
        Status::Kept => "kept",
        Status::Failed => "failed",
    };
    [
        outcome.name.clone(),
        status.to_owned(),
        outcome.matches.map_or(String::new(), |m| m.to_string()),
        number(outcome.face_width_mm),
        number(outcome.face_height_mm),
        number(outcome.total_ms),
        outcome.warnings.to_string(),
        outcome.error.clone().unwrap_or_default(),
    ]
}

/// The outcomes as a CSV table.
pub fn to_csv(outcomes: &[Outcome]) -> String {
    let quote = |cell: &String| {
        if cell.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", cell.replace('"', "\"\""))
        } else {
            cell.clone()
        }
    };
    let mut text = format!("{}\n", COLUMNS.join(","));
    for outcome in outcomes {
        text.push_str(&cells(outcome).iter().map(quote).collect::<Vec<_>>().join(","));
        text.push('\n');
    }
    text
}

/// What the template `batch.html` is filled with.
#[derive(askama::Template)]
#[template(path = "batch.html")]
struct Page {
    columns: [&'static str; 8],
    rows: Vec<Row>,
}

struct Row {
    cells: [String; 8],
    has_report: bool,
}

/// The outcomes as an HTML table with links to the reports.
///
/// # Errors
/// [`Error::Input`] where the page cannot be written, which a valid template excludes.
pub fn to_html(outcomes: &[Outcome]) -> Result<String, Error> {
    let row =
        |outcome: &Outcome| Row { cells: cells(outcome), has_report: outcome.error.is_none() };
    let page = Page { columns: COLUMNS, rows: outcomes.iter().map(row).collect() };
    render_page(&page, "batch.html")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn captures_are_found_in_folders_and_other_paths_are_kept() {
        let home = tempfile::tempdir().unwrap();
        let at = |name: &str| home.path().join(name);
        for name in ["many/b", "many/a", "many/empty", "alone"] {
            std::fs::create_dir_all(at(name)).unwrap();
        }
        for name in ["many/b", "many/a", "alone"] {
            std::fs::write(at(name).join("capture.toml"), "").unwrap();
        }
        let file = at("alone").join("capture.toml");
        let given = [at("many"), at("alone"), file.clone(), at("many/empty"), at("missing")];
        let found = find_captures(&given);
        let expected =
            [at("many/a"), at("many/b"), at("alone"), file, at("many/empty"), at("missing")];
        assert_eq!(found, expected);
        assert_eq!(shared_names(&found), ["alone"]);
        assert_eq!(capture_name(&at("alone").join("capture.toml")), "alone");
    }
}
