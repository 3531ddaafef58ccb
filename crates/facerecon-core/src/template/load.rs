//! Mesh files as templates: with a sidecar `NAME.landmarks.toml`, or with a preset.

mod crop;
mod error;
mod sidecar;

use std::path::{Path, PathBuf};

use super::assemble::Template;
use super::built_in::{head, head_coarse};
use super::presets::{PRESETS, Preset, preset, presets_with};
use crate::data::{LANDMARKS, Landmarks, Mesh, Rgb};
use crate::io::{IoError, LengthUnit, read_mesh};
pub use error::TemplateError;
use sidecar::Sidecar;
pub use sidecar::{landmarks_toml, sidecar_path, write_landmarks};

/// Possible heights of a face mask, a head or a bust, mm: wide enough for children and for busts,
/// narrow enough to reject a wrong unit.
const HEIGHT_MM: std::ops::RangeInclusive<f64> = 100.0..=600.0;
/// Possible distances between the outer corners of the eyes, mm (adults: about 90).
const EYES_MM: std::ops::RangeInclusive<f64> = 55.0..=140.0;

/// A template and its origin.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedTemplate {
    /// Name of the preset, of the sidecar, or of the file.
    pub name: String,
    /// Mesh and landmarks, model frame, mm.
    pub template: Template,
    /// The unit of its file.
    pub unit: LengthUnit,
    /// For each vertex its index in the file; they differ if the mesh was cropped.
    pub source_vertices: Vec<u32>,
    /// Its own texture, if the file has one.
    pub texture: Option<Rgb>,
    /// Height of the mesh, mm.
    pub height_mm: f64,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

impl LoadedTemplate {
    /// The template with its name and texture, ready for a run.
    pub fn into_template(self) -> Template {
        Template { name: self.name, texture: self.texture, ..self.template }
    }
}

/// The template of a name: `head`, `head-coarse`, a preset with the user's
/// file (`ict=FILE`, or `ict` and `file`), or a mesh file with its sidecar.
///
/// # Errors
/// [`TemplateError`] with the reason and the remedy.
pub fn resolve(text: &str, file: Option<&Path>) -> Result<LoadedTemplate, TemplateError> {
    match (text, file) {
        ("head", None) => return Ok(built_in(text, head())),
        ("head-coarse", None) => return Ok(built_in(text, head_coarse())),
        _ => {}
    }
    if let Some(file) = file {
        let found = preset(text).ok_or_else(|| unknown(text))?;
        return load_template(file, Some(found), None);
    }
    if let Some((name, file)) = text.split_once('=')
        && let Some(found) = preset(name)
    {
        return load_template(Path::new(file), Some(found), None);
    }
    let path = Path::new(text);
    match preset(text) {
        Some(found) if !path.exists() => {
            Err(TemplateError::NoFile { name: found.name, title: found.title })
        }
        None if !path.exists() && path.extension().is_none() => Err(unknown(text)),
        _ => load_template(path, None, None),
    }
}

fn unknown(name: &str) -> TemplateError {
    let known: Vec<&str> = PRESETS.iter().map(|p| p.name).collect();
    let all = known.iter().copied().chain(["head", "head-coarse"]);
    TemplateError::Unknown {
        name: name.to_owned(),
        hint: crate::settings::nearest_name(name, all)
            .map_or(String::new(), |n| format!(" (did you mean {n}?)")),
        known: known.join(", "),
    }
}

fn built_in(name: &str, template: Template) -> LoadedTemplate {
    let source_vertices = (0..template.mesh.vertices.len() as u32).collect();
    let height_mm = height(&template.mesh);
    LoadedTemplate {
        name: name.to_owned(),
        template,
        unit: LengthUnit::Millimetre,
        source_vertices,
        texture: None,
        height_mm,
        warnings: Vec::new(),
    }
}

/// Loads a mesh file as a template. The unit is that of the format (GLB), else `unit`, else that of the
/// sidecar (`NAME.landmarks.toml`), else that of the preset. The kept vertices are those of the sidecar,
/// else those of the preset. Landmarks are taken from both; the sidecar has priority.
///
/// # Errors
/// [`TemplateError`] with the reason and the remedy.
pub fn load_template(
    path: &Path,
    preset: Option<&'static Preset>,
    unit: Option<LengthUnit>,
) -> Result<LoadedTemplate, TemplateError> {
    let loaded = read_mesh(path)?;
    let (mut mesh, mut warnings) = (loaded.mesh, loaded.warnings);
    let count = mesh.vertices.len();
    check_vertex_count(path, preset, count)?;
    let side_path = sidecar_path(path);
    let side = Sidecar::read(&side_path)?;
    side.turn(&mut mesh).map_err(|m| IoError::malformed(&side_path, m))?;
    let preset_unit = || preset.map(|p| p.unit);
    // The reader of a format that states its unit has converted the mesh to millimetres.
    let unit = match loaded.unit.or(unit).or(side.unit).or_else(preset_unit) {
        Some(unit) => unit,
        None => return Err(unit_missing(path, &mesh, side_path)),
    };
    let scale = unit.in_mm();
    mesh.vertices.iter_mut().for_each(|v| *v *= scale);

    let keep =
        if side.keep.is_empty() { preset.map_or(&[][..], |p| p.keep) } else { &side.keep[..] };
    let top_mm = side.top_mm.or(preset.and_then(|p| p.top_mm));
    let cropped = crop::crop(&mesh, keep, top_mm);
    if cropped.mesh.validate().is_err() {
        return Err(TemplateError::NothingKept { path: path.into(), vertices: count });
    }
    let known = preset.map_or(&[][..], |p| p.landmarks);
    let mut landmarks: Landmarks = known.iter().map(|&(n, i)| (n.to_owned(), i)).collect();
    landmarks.extend(side.landmarks);
    let landmark_file = if side_path.exists() { &side_path } else { path };
    let landmarks = renumber(landmarks, count, &cropped.new_index, landmark_file)?;
    let template = Template { mesh: cropped.mesh, landmarks, ..Template::default() };
    let height_mm = check_size(path, unit, &template)?;
    warnings.extend(missing_landmarks(&template, &side_path));
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let name = side.name.or(preset.map(|p| p.name.to_owned())).unwrap_or(stem);
    Ok(LoadedTemplate {
        name,
        template,
        unit,
        source_vertices: cropped.source_vertices,
        texture: loaded.texture,
        height_mm,
        warnings,
    })
}

/// Whether a file can be that of a preset.
fn check_vertex_count(
    path: &Path,
    preset: Option<&'static Preset>,
    got: usize,
) -> Result<(), TemplateError> {
    match preset {
        Some(p) if !p.vertices.contains(&got) => {
            let expected: Vec<String> = p.vertices.iter().map(ToString::to_string).collect();
            let (path, expected) = (path.into(), expected.join(" or "));
            Err(TemplateError::VertexCount { path, name: p.name, got, expected })
        }
        _ => Ok(()),
    }
}

/// A warning if landmarks have no vertex.
fn missing_landmarks(template: &Template, sidecar: &Path) -> Option<String> {
    let missing = LANDMARKS.iter().filter(|f| !template.landmarks.contains_key(**f)).count();
    (missing > 0).then(|| {
        format!(
            "{missing} of the 18 landmarks have no vertex on the template; write them into {}",
            sidecar.display()
        )
    })
}

fn height(mesh: &Mesh) -> f64 {
    mesh.bounds().map_or(0.0, |(low, high)| high.y - low.y)
}

fn unit_missing(path: &Path, mesh: &Mesh, sidecar: PathBuf) -> TemplateError {
    let height = height(mesh);
    let near = presets_with(mesh.vertices.len()).next();
    TemplateError::UnitMissing {
        path: path.into(),
        height,
        fits: fitting_units(height),
        sidecar,
        preset: near.map_or(String::new(), |p| {
            format!(
                "; or, with {} vertices, is it {}? Then give {}=FILE",
                mesh.vertices.len(),
                p.title,
                p.name
            )
        }),
    }
}

/// The units in which a mesh of this height, in file units, has the size of a head.
fn fitting_units(height: f64) -> String {
    let fits: Vec<String> = LengthUnit::ALL
        .into_iter()
        .filter(|u| HEIGHT_MM.contains(&(height * u.in_mm())))
        .map(|u| format!("{:.0} mm in {u}", height * u.in_mm()))
        .collect();
    if fits.is_empty() { String::new() } else { format!(" ({})", fits.join(", ")) }
}

/// Rejects a mesh without the size of a head; returns the height, mm.
fn check_size(path: &Path, unit: LengthUnit, template: &Template) -> Result<f64, TemplateError> {
    let refuse = |what, got_mm: f64, range: std::ops::RangeInclusive<f64>| TemplateError::Size {
        path: path.into(),
        what,
        unit,
        got_mm,
        low: *range.start(),
        high: *range.end(),
        fits: fitting_units(height(&template.mesh) / unit.in_mm()),
    };
    let height = height(&template.mesh);
    if !HEIGHT_MM.contains(&height) {
        return Err(refuse("the height", height, HEIGHT_MM));
    }
    let vertex = |name: &str| template.landmarks.get(name).map(|&i| template.mesh.vertices[i]);
    if let (Some(left), Some(right)) = (vertex("eye_left_outer"), vertex("eye_right_outer")) {
        let width = (left - right).norm();
        if !EYES_MM.contains(&width) {
            return Err(refuse(
                "the distance between the outer corners of the eyes",
                width,
                EYES_MM,
            ));
        }
    }
    Ok(height)
}

/// Landmarks by vertices of the file to landmarks by vertices of the cropped mesh.
fn renumber(
    landmarks: Landmarks,
    count: usize,
    new_index: &[Option<u32>],
    path: &Path,
) -> Result<Landmarks, TemplateError> {
    let one = |(name, index): (String, usize)| {
        let fail = |reason: String| TemplateError::Landmark {
            path: path.to_owned(),
            name: name.clone(),
            index,
            reason,
        };
        match new_index.get(index) {
            Some(Some(new)) => Ok((name, *new as usize)),
            Some(None) => Err(fail("that vertex is left out by keep or top_mm".into())),
            None => Err(fail(format!("the mesh has {count} vertices (counted from 0)"))),
        }
    };
    landmarks.into_iter().map(one).collect()
}

#[cfg(test)]
mod tests;
