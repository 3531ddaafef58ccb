//! Many captures: one outcome a capture, finished ones are not done again.

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
    /// Reconstructed before from the same input with the same parameters.
    Kept,
    /// Could not be reconstructed.
    Failed,
}

/// What came of one capture.
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

/// File beside a result that says from what it was made and, on a second line, by which batch.
const FINGERPRINT: &str = "fingerprint.txt";

/// Reconstructs one capture of a batch into `output/NAME`, unless the result is there already,
/// made from the same files with the same parameters, template and version.
///
/// `batch` names this run where a capture may be given again, its worker having died before it
/// could tell: what this same run finished is [`Status::Done`], not [`Status::Kept`].
pub fn run(
    capture: &Path,
    output: &Path,
    head: &Template,
    params: &Params,
    frame: Frame,
    batch: Option<&str>,
) -> Outcome {
    let name = name_of(capture);
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

/// Names that several captures share: their results would overwrite each other.
pub fn shared_names(captures: &[PathBuf]) -> Vec<String> {
    let mut names: Vec<String> = captures.iter().map(|c| name_of(c)).collect();
    names.sort();
    let mut shared: Vec<String> =
        names.windows(2).filter(|w| w[0] == w[1]).map(|w| w[0].clone()).collect();
    shared.dedup();
    shared
}

fn name_of(capture: &Path) -> String {
    let folder = if capture.is_file() { capture.parent().unwrap_or(capture) } else { capture };
    let whole = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    whole.file_name().map_or_else(|| "capture".into(), |n| n.to_string_lossy().into_owned())
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
    let print = fingerprint(&loaded.sources, head, params, frame)?;
    let beside = folder.join(FINGERPRINT);
    let old = std::fs::read_to_string(&beside).unwrap_or_default();
    let mut old = old.lines();
    let (same, by) = (old.next() == Some(&print), old.next());
    let whole = ["result.json", "face.obj", "face.glb"].iter().all(|f| folder.join(f).is_file());
    if same && whole {
        return Ok(if by.is_some() && by == batch { Status::Done } else { Status::Kept });
    }
    // a stale mark must not outlive the files it spoke of
    if beside.exists() {
        std::fs::remove_file(&beside)
            .map_err(|source| IoError::Write { path: beside.clone(), source })?;
    }
    let recorder = Recorder::default();
    let mut found = reconstruct(&loaded.capture, head, params, &recorder)?;
    found.warnings.splice(0..0, loaded.warnings);
    write_result(folder, &loaded.capture, &found, &recorder.take(), frame, false)?;
    let by = batch.map_or(String::new(), |b| format!("{b}\n"));
    io::atomic::write(&beside, format!("{print}\n{by}").as_bytes())?;
    Ok(Status::Done)
}

/// A digest of everything a result follows from.
///
/// # Errors
/// [`IoError::Read`] naming a source that cannot be read.
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
