//! Any mesh as the generic face: `--template FILE` with `NAME.landmarks.toml` beside it, or a preset
//! that knows the file.

mod crop;
mod sidecar;

use std::path::{Path, PathBuf};

use super::presets::{PRESETS, Preset, preset, presets_with};
use super::{Template, head, head_coarse};
use crate::data::{LANDMARKS, Landmarks, Mesh, Rgb};
use crate::io::{IoError, LengthUnit, read_mesh};
use crate::math::Vec3;
use sidecar::Sidecar;
pub use sidecar::{landmarks_toml, sidecar_path, write_landmarks};

/// Heights that a head, a face mask or a bust can have, mm.
const HEIGHT_MM: std::ops::RangeInclusive<f64> = 100.0..=600.0;
/// Distances that the outer corners of a person's eyes can have, mm (adults: about 90).
const EYES_MM: std::ops::RangeInclusive<f64> = 55.0..=140.0;

/// A template and what is known about it.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedTemplate {
    /// Name of the preset, of the sidecar, or of the file.
    pub name: String,
    /// Mesh and features, model frame, mm.
    pub template: Template,
    /// The unit its file is in.
    pub unit: LengthUnit,
    /// For each vertex its number in the file; they differ where parts were left out.
    pub kept: Vec<u32>,
    /// Its own texture, where the file has one.
    pub texture: Option<Rgb>,
    /// Height of the mesh, mm.
    pub height_mm: f64,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// A template that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TemplateError {
    /// A file cannot be read.
    #[error(transparent)]
    Io(#[from] IoError),
    /// No preset of that name.
    #[error(
        "there is no template {name}{hint}; known are head, head-coarse, {known}, or a mesh file"
    )]
    Unknown {
        /// The name given.
        name: String,
        /// The nearest name.
        hint: String,
        /// The presets.
        known: String,
    },
    /// A preset without a file.
    #[error(
        "{name} is known ({title}), but the mesh is not part of this program: give its file, as {name}=FILE"
    )]
    NoFile {
        /// The preset.
        name: &'static str,
        /// What it is.
        title: &'static str,
    },
    /// A file that is not the preset's.
    #[error(
        "{path} has {got} vertices, but {name} has {expected}; give the right file, or use it without the preset"
    )]
    VertexCount {
        /// The file.
        path: PathBuf,
        /// The preset.
        name: &'static str,
        /// Vertices found.
        got: usize,
        /// Vertices the preset's files have.
        expected: String,
    },
    /// Nobody says what a unit of the file is.
    #[error(
        "the unit of {path} is not stated; its coordinates are {height:.4} high{fits}. Write unit = \"mm\" (or cm, m ...) into {sidecar}{preset}"
    )]
    UnitMissing {
        /// The file.
        path: PathBuf,
        /// Height in the file's unit.
        height: f64,
        /// Which unit would make it a head.
        fits: String,
        /// Where to state it.
        sidecar: PathBuf,
        /// A preset with as many vertices.
        preset: String,
    },
    /// A head of impossible size.
    #[error(
        "with the unit {unit} the template {path} {what} {got_mm:.1} mm, but {low} to {high} mm are possible{fits}; state the right unit, or keep only the head"
    )]
    Size {
        /// The file.
        path: PathBuf,
        /// What is measured: its height, or between the eyes' outer corners.
        what: &'static str,
        /// The unit.
        unit: LengthUnit,
        /// Measured, mm.
        got_mm: f64,
        /// Least possible, mm.
        low: f64,
        /// Greatest possible, mm.
        high: f64,
        /// Which unit would make it a head.
        fits: String,
    },
    /// A feature on a vertex that is not there.
    #[error("{path}: {name} names vertex {index}, but {reason}")]
    Landmark {
        /// The file with the features.
        path: PathBuf,
        /// The feature.
        name: String,
        /// Its vertex, counted from 0.
        index: usize,
        /// Why it cannot be.
        reason: String,
    },
    /// Cropping left no mesh.
    #[error("{path}: of {vertices} vertices none that make a face are kept; check keep and top_mm")]
    NothingKept {
        /// The file.
        path: PathBuf,
        /// Vertices of the file.
        vertices: usize,
    },
}

impl LoadedTemplate {
    /// The template with its name and texture, ready for a run.
    pub fn into_template(self) -> Template {
        Template { name: self.name, texture: self.texture, ..self.template }
    }
}

/// The template of a command line's `--template`: `head`, `head-coarse`, a preset with the user's
/// file (`ict=FILE`, or `ict` and `file`), or a mesh file with its sidecar.
///
/// # Errors
/// [`TemplateError`] with what was found and what to do.
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
    let kept = (0..template.mesh.vertices.len() as u32).collect();
    let height_mm = height(&template.mesh);
    LoadedTemplate {
        name: name.to_owned(),
        template,
        unit: LengthUnit::Millimetre,
        kept,
        texture: None,
        height_mm,
        warnings: Vec::new(),
    }
}

/// Loads a mesh file as a template. The unit comes from `unit`, else the sidecar
/// (`NAME.landmarks.toml`), else the preset; GLB states its own. What is kept comes from the sidecar
/// or else from the preset; features from both, the sidecar's counting.
///
/// # Errors
/// [`TemplateError`] with what was found and what to do.
pub fn load_template(
    path: &Path,
    preset: Option<&'static Preset>,
    unit: Option<LengthUnit>,
) -> Result<LoadedTemplate, TemplateError> {
    let loaded = read_mesh(path)?;
    let (mut mesh, mut warnings) = (loaded.mesh, loaded.warnings);
    let count = mesh.vertices.len();
    if let Some(p) = preset
        && !p.vertices.contains(&count)
    {
        let expected: Vec<String> = p.vertices.iter().map(ToString::to_string).collect();
        let expected = expected.join(" or ");
        return Err(TemplateError::VertexCount {
            path: path.into(),
            name: p.name,
            got: count,
            expected,
        });
    }
    let side_path = sidecar_path(path);
    let side = Sidecar::read(&side_path)?;
    side.turn(&mut mesh).map_err(|m| IoError::malformed(&side_path, m))?;
    let own = || preset.map(|p| p.unit);
    // A format that states its unit has been converted to millimetres by its reader.
    let unit = match loaded.unit.or(unit).or(side.unit).or_else(own) {
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
    let place = if side_path.exists() { &side_path } else { path };
    let landmarks = renumber(landmarks, count, &cropped.place_of, place)?;
    let template = Template { mesh: cropped.mesh, landmarks, ..Template::default() };
    let height_mm = check_size(path, unit, &template)?;
    let missing = LANDMARKS.iter().filter(|f| !template.landmarks.contains_key(**f)).count();
    if missing > 0 {
        warnings.push(format!(
            "{missing} of the 18 features have no vertex on the template; write them into {}",
            side_path.display()
        ));
    }
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let name = side.name.or(preset.map(|p| p.name.to_owned())).unwrap_or(stem);
    Ok(LoadedTemplate {
        name,
        template,
        unit,
        kept: cropped.kept,
        texture: loaded.texture,
        height_mm,
        warnings,
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
        fits: fitting(height),
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

/// The units that make a head of a height in file units.
fn fitting(height: f64) -> String {
    let fits: Vec<String> = LengthUnit::ALL
        .into_iter()
        .filter(|u| HEIGHT_MM.contains(&(height * u.in_mm())))
        .map(|u| format!("{:.0} mm in {u}", height * u.in_mm()))
        .collect();
    if fits.is_empty() { String::new() } else { format!(" ({})", fits.join(", ")) }
}

/// Refuses what is no head's size; returns the height, mm.
fn check_size(path: &Path, unit: LengthUnit, template: &Template) -> Result<f64, TemplateError> {
    let refuse = |what, got_mm: f64, range: std::ops::RangeInclusive<f64>| TemplateError::Size {
        path: path.into(),
        what,
        unit,
        got_mm,
        low: *range.start(),
        high: *range.end(),
        fits: fitting(height(&template.mesh) / unit.in_mm()),
    };
    let height = height(&template.mesh);
    if !HEIGHT_MM.contains(&height) {
        return Err(refuse("has a height of", height, HEIGHT_MM));
    }
    let place = |name: &str| template.landmarks.get(name).map(|&i| template.mesh.vertices[i]);
    if let (Some(left), Some(right)) = (place("eye_left_outer"), place("eye_right_outer")) {
        let width = (left - right).norm();
        if !EYES_MM.contains(&width) {
            return Err(refuse("has between the outer corners of its eyes", width, EYES_MM));
        }
    }
    Ok(height)
}

/// Vertex numbers of the file to those of the cropped mesh.
fn renumber(
    landmarks: Landmarks,
    count: usize,
    place_of: &[Option<u32>],
    path: &Path,
) -> Result<Landmarks, TemplateError> {
    let one = |(name, index): (String, usize)| {
        let fail = |reason: String| TemplateError::Landmark {
            path: path.to_owned(),
            name: name.clone(),
            index,
            reason,
        };
        match place_of.get(index) {
            Some(Some(place)) => Ok((name, *place as usize)),
            Some(None) => Err(fail("that vertex is among the parts left out".into())),
            None => Err(fail(format!("the mesh has {count} (counted from 0)"))),
        }
    };
    landmarks.into_iter().map(one).collect()
}

/// The direction of an axis name such as `y` or `-z`.
fn axis(name: &str) -> Option<Vec3> {
    let (sign, name) = name.strip_prefix('-').map_or((1.0, name), |n| (-1.0, n));
    let axis = match name {
        "x" => Vec3::x(),
        "y" => Vec3::y(),
        "z" => Vec3::z(),
        _ => return None,
    };
    Some(axis * sign)
}

#[cfg(test)]
mod tests;
