//! Every stage before and after.

use super::page::{RowBuilder, Section};
use super::pictures::{drawn, scaled_down, shaded};
use super::{marks, plots};
use crate::data::{Capture, Gray, Mesh, Rgb};
use crate::math::Vec3;
use crate::output::{Kept, Record};
use crate::pipeline::Reconstruction;
use crate::render::{Mode, Scene, Studio, View};
use crate::stages::register::{RegisterMethod, Registration};
use crate::stages::texture::SEEN_EXTRA;

/// Width of a picture of four in a row, pixels.
const QUARTER_WIDTH: usize = 400;
/// Width of the texture and its coverage, pixels.
const TEXTURE_WIDTH: usize = 512;

/// The stages in order: pictures of input and output, and the errors of the iterative ones.
/// `shaded_result` is the finished mesh.
pub(super) fn sections(
    capture: &Capture,
    result: &Reconstruction,
    record: &Record,
    shaded_result: Option<&Studio<'_>>,
) -> Vec<Section> {
    let mut sections = vec![Section::new("Stage by stage", Vec::new())];
    sections.extend(rectify(capture, record));
    sections.extend(filter(record));
    sections.extend(refine(record));
    let unit = if result.metric { "mm" } else { "model units" };
    if let Some(head) = mesh(record, "register", "head") {
        let before = shaded(head);
        sections.extend(register(result, head, before.as_ref(), unit));
        if let Some(bent) = mesh(record, "deform", "mesh") {
            let is_smoothed = bent.vertices != result.mesh.vertices;
            let own = if is_smoothed { shaded(bent) } else { None };
            let after = if is_smoothed { own.as_ref() } else { shaded_result };
            sections.push(deform(record, [before.as_ref(), after], unit));
            sections.extend(smooth(record, [after, shaded_result], unit));
        }
    }
    sections.extend(texture(result));
    sections
}

fn rectify(capture: &Capture, record: &Record) -> Option<Section> {
    let left = gray(record, "rectify", "left")?;
    let right = gray(record, "rectify", "right")?;
    let [before, after] = [[&capture.left.gray, &capture.right.gray], [left, right]];
    if before.iter().zip(&after).all(|(b, a)| b.data() == a.data()) {
        let text = "The rows of the photos are level: the photos are used as they are.";
        return Some(Section { text, ..Section::of_stage("Rectify", Vec::new()) });
    }
    let mut row = RowBuilder::new(4);
    for (images, state) in [(before, "as taken"), (after, "rectified")] {
        for (image, side) in images.into_iter().zip(["left", "right"]) {
            row.picture(brightened_small(image), format!("{side}, {state}"));
        }
    }
    Some(Section::of_stage("Rectify", vec![row]))
}

/// A grey image scaled down and brightened.
fn brightened_small(image: &Gray) -> Rgb {
    marks::brightened(&scaled_down(&marks::colored(image), QUARTER_WIDTH))
}

/// The thesis's preprocessing of the left photo.
fn filter(record: &Record) -> Option<Section> {
    let steps = [
        ("filter", "left_equalized", "equalised"),
        ("filter", "left_sharpened", "sharpened (Eq. 2.1)"),
        ("filter", "left_binary", "thresholded"),
        ("detect", "left_thinned", "thinned: one pixel a dot (drawn larger)"),
    ];
    let found: Vec<_> = steps
        .iter()
        .filter_map(|(stage, name, caption)| Some((*name, gray(record, stage, name)?, *caption)))
        .collect();
    if found.is_empty() {
        return None;
    }
    let mut row = RowBuilder::new(if found.len() > 3 { 4 } else { 3 });
    for (name, image, caption) in found {
        let shown = match name {
            "left_thinned" => scaled_down(&marks::widened(&marks::colored(image)), QUARTER_WIDTH),
            "left_binary" => scaled_down(&marks::colored(image), QUARTER_WIDTH),
            _ => brightened_small(image),
        };
        row.picture(shown, caption);
    }
    Some(Section::of_stage("Filter and detect, left photo", vec![row]))
}

fn refine(record: &Record) -> Option<Section> {
    let history = record.histories.get("refine")?;
    let mut row = RowBuilder::new(3);
    let label = "difference of the photos over their noise";
    row.plot(plots::convergence("Residual of the disparity", label, history, 1));
    Some(Section::of_stage("Refine", vec![row]))
}

fn register(
    result: &Reconstruction,
    head: &Mesh,
    shaded_head: Option<&Studio<'_>>,
    unit: &str,
) -> Option<Section> {
    let pose = result.registration.as_ref()?;
    let dots = registered(result, pose);
    let with_dots = |mesh: &Mesh, openness: &[f64]| {
        let marked = marks::with_point_markers(mesh, &dots);
        let scene = Scene::new(&marked);
        let studio = Studio::with_openness(&scene, Mode::Lit, openness.to_vec()).ok();
        drawn(studio.as_ref(), View::ThreeQuarter)
    };
    let openness = shaded_head.map_or(&[][..], Studio::openness);
    let mut row = RowBuilder::new(3);
    row.picture(with_dots(&Mesh::default(), &[]), "before: the points measured at the dots");
    row.picture(with_dots(head, openness), "after: the points on the template");
    let label = match result.params.register.method {
        RegisterMethod::Besl => format!("root of the sum of squares (Eq. 3.8), {unit}"),
        RegisterMethod::Robust => format!("distance from the surface, {unit}"),
    };
    row.plot(plots::convergence("Error of the final registration", &label, &pose.history, 0));
    Some(Section::of_stage("Register", vec![row]))
}

fn deform(record: &Record, meshes: [Option<&Studio<'_>>; 2], unit: &str) -> Section {
    let mut row = RowBuilder::new(3);
    for (mesh, caption) in
        meshes.into_iter().zip(["before: the template", "after: deformed to the points"])
    {
        row.picture(drawn(mesh, View::ThreeQuarter), caption);
    }
    if let Some(history) = record.histories.get("deform") {
        let label = format!("root mean square of the distances, {unit}");
        row.plot(plots::convergence("Distance from the points", &label, history, 1));
    }
    Section::of_stage("Deform", vec![row])
}

fn smooth(record: &Record, meshes: [Option<&Studio<'_>>; 2], unit: &str) -> Option<Section> {
    let history = record.histories.get("smooth")?;
    let mut row = RowBuilder::new(3);
    for (mesh, caption) in meshes.into_iter().zip(["before", "after"]) {
        row.picture(drawn(mesh, View::Front), caption);
    }
    let label = format!("mean displacement of a vertex, {unit}");
    row.plot(plots::convergence("Displacement in each step", &label, history, 1));
    Some(Section::of_stage("Smooth", vec![row]))
}

fn texture(result: &Reconstruction) -> Option<Section> {
    let made = result.texture.as_ref()?;
    let mut row = RowBuilder::new(2);
    row.picture(scaled_down(&made.image, TEXTURE_WIDTH), "the texture");
    let has_extra = made.coverage.data().iter().any(|bits| bits & SEEN_EXTRA != 0);
    let extra = if has_extra { ", blue from extra photos" } else { "" };
    row.picture(
        scaled_down(&marks::coverage(&made.coverage), TEXTURE_WIDTH),
        format!(
            "its sources: red from the left photo, green from the right, yellow from both{extra}, \
             grey filled in"
        ),
    );
    Some(Section::of_stage("Texture", vec![row]))
}

/// The points of the matches that the registration used, model frame.
fn registered(result: &Reconstruction, pose: &Registration) -> Vec<Vec3> {
    let used = pose.inliers.iter();
    used.filter_map(|&i| result.match_points.get(i).copied().flatten())
        .map(|p| result.model_from_camera.apply(&p))
        .collect()
}

fn gray<'a>(record: &'a Record, stage: &str, name: &str) -> Option<&'a Gray> {
    match record.kept(stage, name) {
        Some(Kept::Gray(image)) => Some(image),
        _ => None,
    }
}

fn mesh<'a>(record: &'a Record, stage: &str, name: &str) -> Option<&'a Mesh> {
    match record.kept(stage, name) {
        Some(Kept::Mesh(mesh)) => Some(mesh),
        _ => None,
    }
}
