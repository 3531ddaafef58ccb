//! Every stage before and after.

use super::page::{Row, cast, drawn, shrunk};
use super::{marks, plots};
use crate::data::{Capture, Gray, Mesh, Rgb};
use crate::math::Vec3;
use crate::output::{Kept, Record};
use crate::pipeline::Reconstruction;
use crate::render::{Mode, Scene, Studio, View};
use crate::stages::register::{RegisterMethod, Registration};
use crate::stages::texture::SEEN_EXTRA;

/// The stages in order: pictures of what went in and what came out, and the errors of those that
/// go step by step. `plaster` is the finished mesh.
pub(super) fn steps(
    page: &mut String,
    capture: &Capture,
    result: &Reconstruction,
    record: &Record,
    plaster: Option<&Studio<'_>>,
) {
    page.push_str("<h2>Stage by stage</h2>\n");
    rectify(page, capture, record);
    filter(page, record);
    if let Some(history) = record.histories.get("refine") {
        page.push_str("<h3>Refine</h3>\n");
        let mut row = Row::new("three");
        let label = "difference of the photos over their noise";
        row.plot(plots::convergence("Misfit of the disparity", label, history, 1));
        row.end(page);
    }
    let unit = if result.metric { "mm" } else { "model units" };
    if let Some(head) = mesh(record, "register", "head") {
        let before = cast(head);
        register(page, result, head, before.as_ref(), unit);
        if let Some(bent) = mesh(record, "deform", "mesh") {
            let smoothed = *bent != result.mesh;
            let own = if smoothed { cast(bent) } else { None };
            let after = if smoothed { own.as_ref() } else { plaster };
            deform(page, record, [before.as_ref(), after], unit);
            smooth(page, record, [after, plaster], unit);
        }
    }
    texture(page, result);
}

fn rectify(page: &mut String, capture: &Capture, record: &Record) {
    let (Some(left), Some(right)) =
        (gray(record, "rectify", "left"), gray(record, "rectify", "right"))
    else {
        return;
    };
    let [before, after] = [[&capture.left.gray, &capture.right.gray], [left, right]];
    let same = before.iter().zip(&after).all(|(b, a)| b.data() == a.data());
    page.push_str("<h3>Rectify</h3>\n");
    if same {
        page.push_str("<p>The rows of the photos are level already: they stay as they are.</p>\n");
        return;
    }
    let mut row = Row::new("four");
    for (images, state) in [(before, "as taken"), (after, "level rows")] {
        for (image, side) in images.into_iter().zip(["left", "right"]) {
            row.picture(bright(image), format!("{side}, {state}"));
        }
    }
    row.end(page);
}

/// A grey image small and brightened.
fn bright(image: &Gray) -> Rgb {
    marks::brightened(&shrunk(&marks::colored(image), 400))
}

/// The thesis's preprocessing, of the left photo.
fn filter(page: &mut String, record: &Record) {
    let steps = [
        ("filter", "left_equalized", "equalised"),
        ("filter", "left_sharpened", "sharpened (Eq. 2.1)"),
        ("filter", "left_binary", "thresholded"),
        ("detect", "left_thinned", "thinned: one pixel a dot (drawn larger)"),
    ];
    let found: Vec<_> =
        steps.iter().filter_map(|(s, n, words)| Some((*n, gray(record, s, n)?, *words))).collect();
    if found.is_empty() {
        return;
    }
    page.push_str("<h3>Filter and detect, left photo</h3>\n");
    let mut row = Row::new(if found.len() > 3 { "four" } else { "three" });
    for (name, image, words) in found {
        let shown = match name {
            "left_thinned" => shrunk(&marks::widened(&marks::colored(image)), 400),
            "left_binary" => shrunk(&marks::colored(image), 400),
            _ => bright(image),
        };
        row.picture(shown, words);
    }
    row.end(page);
}

fn register(
    page: &mut String,
    result: &Reconstruction,
    head: &Mesh,
    plaster: Option<&Studio<'_>>,
    unit: &str,
) {
    let Some(pose) = &result.registration else { return };
    page.push_str("<h3>Register</h3>\n");
    let dots = registered(result, pose);
    let colored = |mesh: &Mesh, openness: &[f64]| {
        let studded = marks::studded(mesh, &dots);
        let scene = Scene::new(&studded);
        let studio = Studio::with_openness(&scene, Mode::Lit, openness.to_vec()).ok();
        drawn(studio.as_ref(), View::ThreeQuarter)
    };
    let openness = plaster.map_or(&[][..], Studio::openness);
    let mut row = Row::new("three");
    row.picture(colored(&Mesh::default(), &[]), "before: the points measured at the dots");
    row.picture(colored(head, openness), "after: the points on the generic head");
    let label = match result.params.register.method {
        RegisterMethod::Besl => format!("root of the sum of squares (Eq. 3.8), {unit}"),
        RegisterMethod::Robust => format!("distance from the surface, {unit}"),
    };
    row.plot(plots::convergence("Error of the last descent", &label, &pose.history, 0));
    row.end(page);
}

fn deform(page: &mut String, record: &Record, meshes: [Option<&Studio<'_>>; 2], unit: &str) {
    page.push_str("<h3>Deform</h3>\n");
    let mut row = Row::new("three");
    for (mesh, words) in
        meshes.into_iter().zip(["before: the generic head", "after: bent to the points"])
    {
        row.picture(drawn(mesh, View::ThreeQuarter), words);
    }
    if let Some(history) = record.histories.get("deform") {
        let label = format!("root mean square of the distances, {unit}");
        row.plot(plots::convergence("Distance from the points", &label, history, 1));
    }
    row.end(page);
}

fn smooth(page: &mut String, record: &Record, meshes: [Option<&Studio<'_>>; 2], unit: &str) {
    let Some(history) = record.histories.get("smooth") else { return };
    page.push_str("<h3>Smooth</h3>\n");
    let mut row = Row::new("three");
    for (mesh, words) in meshes.into_iter().zip(["before", "after"]) {
        row.picture(drawn(mesh, View::Front), words);
    }
    let label = format!("mean movement of a vertex, {unit}");
    row.plot(plots::convergence("Movement in each step", &label, history, 1));
    row.end(page);
}

fn texture(page: &mut String, result: &Reconstruction) {
    let Some(made) = &result.texture else { return };
    page.push_str("<h3>Texture</h3>\n");
    let mut row = Row::new("two");
    row.picture(shrunk(&made.image, 512), "the texture");
    let others = made.coverage.data().iter().any(|bits| bits & SEEN_EXTRA != 0);
    let extra = if others { ", blue from others" } else { "" };
    row.picture(
        shrunk(&marks::coverage(&made.coverage), 512),
        format!(
            "where it comes from: red from the left photo, green from the right, yellow from both{extra}, grey filled in"
        ),
    );
    row.end(page);
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
