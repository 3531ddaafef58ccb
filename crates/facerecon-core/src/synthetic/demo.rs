//! The demo: a made-up person before the virtual rig, reconstructed and held against the truth.

use std::time::Instant;

use crate::data::Rgb;
use crate::evaluate::Distances;
use crate::math::Vec3;
use crate::observer::{Event, Observer};
use crate::pipeline::Error;
use crate::pipeline::Params;
use crate::pipeline::{Reconstruction, reconstruct};
use crate::render::{self, Mode, Scene, View, contact_sheet};
use crate::spatial::SurfaceIndex;
use crate::synthetic::pattern::PatternParams;
use crate::synthetic::simulate::{self, SimulateParams, Simulated, simulate};
use crate::template::{self, Template};

/// Edge of the skin's texture.
const SKIN_PX: usize = 1024;
/// The face begins this far before the ears, mm.
const BEFORE_EARS_MM: f64 = 22.0;

/// A simulated capture, what was reconstructed from it, and how far that is from the truth.
#[derive(Clone, Debug)]
pub struct Demo {
    /// The person's skin, the texture of the true mesh.
    pub skin: Rgb,
    /// The capture and its truth.
    pub simulated: Simulated,
    /// What was reconstructed.
    pub found: Reconstruction,
    /// Distance of the true face's surface, where both cameras see it, from the reconstructed mesh, mm.
    pub error: Distances,
}

/// A made-up person ready for the virtual rig: head, skin as an sRGB texture, and which vertices
/// belong to the face (before the ears, from the hairline to the chin).
pub fn person(seed: u64) -> (Template, Rgb, Vec<bool>) {
    let subject = template::subject(seed);
    let skin = subject
        .albedo(SKIN_PX)
        .map(|c| c.map(|v| render::srgb_from_linear(f64::from(v)).round() as u8));
    let face = face_region(&subject.head);
    (subject.head, skin, face)
}

/// Simulates, reconstructs, compares.
///
/// # Errors
/// [`Error`] of the stage that could not do its work.
pub fn demo(seed: u64, params: &Params, observer: &dyn Observer) -> Result<Demo, Error> {
    let (head, skin, face) = person(seed);
    let subject = simulate::Subject {
        mesh: &head.mesh,
        texture: Some(&skin),
        landmarks: Some(&head.landmarks),
        face: Some(&face),
    };
    let rig = SimulateParams { pattern: PatternParams::default(), seed, ..Default::default() };
    observer.event(&Event::Started { stage: "simulate" });
    let start = Instant::now();
    let simulated = simulate(&subject, &rig, observer)?;
    observer.event(&Event::Finished { stage: "simulate", elapsed: start.elapsed() });
    let found = reconstruct(&simulated.capture, &template::built_in(), params, observer)?;
    let error = face_error(&simulated, &found)
        .ok_or_else(|| Error::Input("demo: no part of the true face is seen".into()))?;
    Ok(Demo { skin, simulated, found, error })
}

/// Distances from the true face's dots seen by both cameras, and the surface between them, to the
/// reconstructed mesh.
fn face_error(simulated: &Simulated, found: &Reconstruction) -> Option<Distances> {
    let mesh = found.mesh_in(render::Frame::Camera);
    let index = SurfaceIndex::new(&mesh)?;
    let truth = &simulated.truth;
    let camera = truth.rig.left;
    let (width, height) = truth.depth_mm.size();
    let mut distances = Vec::new();
    for y in (0..height).step_by(2) {
        for x in (0..width).step_by(2) {
            let z = f64::from(truth.depth_mm.at(x, y));
            if truth.face.at(x, y) && z.is_finite() {
                let p: Vec3 = camera.ray(crate::math::Vec2::new(x as f64, y as f64)) * z;
                distances.extend(index.closest(&p).map(|c| c.distance));
            }
        }
    }
    Distances::of(&distances)
}

fn face_region(head: &Template) -> Vec<bool> {
    let at = |name: &str| head.landmarks.get(name).map(|&i| head.mesh.vertices[i]);
    let (Some(ear), Some(chin), Some(forehead)) =
        (at("ear_left_upper"), at("chin"), at("forehead"))
    else {
        return vec![true; head.mesh.vertices.len()];
    };
    let inside =
        |v: &Vec3| v.z > ear.z + BEFORE_EARS_MM && v.y > chin.y - 4.0 && v.y < forehead.y + 6.0;
    head.mesh.vertices.iter().map(inside).collect()
}

/// The true face in colour, the reconstructed one in colour, and the shapes of both, a row each.
///
/// # Errors
/// [`Error::Render`] for a mesh that cannot be drawn.
pub fn picture(demo: &Demo) -> Result<Rgb, Error> {
    const CELL: (usize, usize) = (360, 420);
    let views = [View::Front, View::ThreeQuarter, View::Profile];
    let truth =
        demo.simulated.truth.mesh.transformed(&demo.simulated.truth.camera_from_model.inverse());
    let true_face = Scene { texture: Some(&demo.skin), ..Scene::new(&truth) };
    let texture = demo.found.texture.as_ref().map(|t| &t.image);
    let ours = Scene { texture, ..Scene::new(&demo.found.mesh) };
    // the photos' own light is in our texture, the true skin needs some
    let textured = if texture.is_some() { Mode::Textured } else { Mode::Shaded };
    let rows = [
        contact_sheet(&true_face, &views, Mode::Lit, CELL)?,
        contact_sheet(&ours, &views, textured, CELL)?,
        contact_sheet(&true_face, &views, Mode::Shaded, CELL)?,
        contact_sheet(&ours, &views, Mode::Shaded, CELL)?,
    ];
    Ok(render::tile(&rows, 1)?)
}
