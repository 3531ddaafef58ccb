//! The demo: a made-up person is simulated, reconstructed and compared with the truth.

use std::time::Instant;

use crate::data::Rgb;
use crate::evaluate::Distances;
use crate::math::{Vec2, Vec3};
use crate::observer::{Event, Observer};
use crate::pipeline::{Error, Params, Reconstruction, reconstruct};
use crate::render::{self, Mode, Scene, View, contact_sheet};
use crate::spatial::SurfaceIndex;
use crate::synthetic::person::Person;
use crate::synthetic::simulate::{SimulateParams, Simulated, simulate};
use crate::template;

/// Every so many pixels of the true depth map, in x and y, one distance is measured.
const STEP_PX: usize = 2;
/// Width and height of one view of the picture.
const VIEW_PX: (usize, usize) = (360, 420);

/// A simulated capture, its reconstruction, and the distance from the truth.
#[derive(Clone, Debug)]
pub struct Demo {
    /// The skin of the person: the texture of the true mesh.
    pub skin: Rgb,
    /// The capture and its truth.
    pub simulated: Simulated,
    /// The reconstruction of the capture.
    pub reconstruction: Reconstruction,
    /// Distances of the true face, where the left camera sees it, from the reconstructed mesh, mm.
    pub error: Distances,
}

/// Simulates the person of a seed, reconstructs, compares.
///
/// ```no_run
/// use facerecon_core::{Params, synthetic::demo::demo};
/// let demo = demo(1, &Params::default(), &())?;
/// assert!(demo.error.median_mm < 0.5);
/// # Ok::<(), facerecon_core::Error>(())
/// ```
///
/// # Errors
/// [`Error`] of the simulation or of the stage that failed.
pub fn demo(seed: u64, params: &Params, observer: &dyn Observer) -> Result<Demo, Error> {
    let person = Person::new(seed);
    let rig = SimulateParams { seed, ..Default::default() };
    observer.event(&Event::Started { stage: "simulate" });
    let start = Instant::now();
    let simulated = simulate(&person.subject(), &rig, observer)?;
    observer.event(&Event::Finished { stage: "simulate", elapsed: start.elapsed() });
    let reconstruction = reconstruct(&simulated.capture, &template::built_in(), params, observer)?;
    let error = face_error(&simulated, &reconstruction).ok_or_else(|| {
        Error::Input("demo: the left photo shows no part of the true face; report this".into())
    })?;
    Ok(Demo { skin: person.skin, simulated, reconstruction, error })
}

/// Distances of the true face, at pixels of the left photo, from the reconstructed mesh.
fn face_error(simulated: &Simulated, reconstruction: &Reconstruction) -> Option<Distances> {
    let mesh = reconstruction.mesh_in(render::Frame::Camera);
    let index = SurfaceIndex::new(&mesh)?;
    let truth = &simulated.truth;
    let camera = truth.rig.left;
    let (width, height) = truth.depth_mm.size();
    let mut distances = Vec::new();
    for y in (0..height).step_by(STEP_PX) {
        for x in (0..width).step_by(STEP_PX) {
            let z = f64::from(truth.depth_mm.at(x, y));
            if truth.face.at(x, y) && z.is_finite() {
                let p: Vec3 = camera.ray(Vec2::new(x as f64, y as f64)) * z;
                distances.extend(index.closest(&p).map(|c| c.distance));
            }
        }
    }
    Distances::of(&distances)
}

/// A picture of four rows: the true face in colour, the reconstructed one in colour, then both
/// shaded.
///
/// # Errors
/// [`Error::Render`] if a mesh cannot be drawn.
pub fn picture(demo: &Demo) -> Result<Rgb, Error> {
    let views = [View::Front, View::ThreeQuarter, View::Profile];
    let truth = &demo.simulated.truth;
    let true_mesh = truth.mesh.transformed(&truth.camera_from_model.inverse());
    let true_face = Scene { texture: Some(&demo.skin), ..Scene::new(&true_mesh) };
    let texture = demo.reconstruction.texture.as_ref().map(|t| &t.image);
    let result = Scene { texture, ..Scene::new(&demo.reconstruction.mesh) };
    // The reconstructed texture contains the light of the photos; the true skin needs some.
    let textured = if texture.is_some() { Mode::Textured } else { Mode::Shaded };
    let rows = [
        contact_sheet(&true_face, &views, Mode::Lit, VIEW_PX)?,
        contact_sheet(&result, &views, textured, VIEW_PX)?,
        contact_sheet(&true_face, &views, Mode::Shaded, VIEW_PX)?,
        contact_sheet(&result, &views, Mode::Shaded, VIEW_PX)?,
    ];
    Ok(render::tile(&rows, 1)?)
}
