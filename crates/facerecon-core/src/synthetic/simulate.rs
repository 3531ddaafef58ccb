//! The virtual rig: photographs of a mesh under the projected pattern, with the truth.
//!
//! Light is computed in linear units from depth buffers of both cameras and of the projector
//! (shadows), with nine samples a pixel. Then follow lens blur, photon and read noise, and 8 bit sRGB
//! coding (IEC 61966-2-1) at the same exposure for both cameras.

mod error;
mod files;
mod ground_truth;
mod lit_scene;
mod params;
mod photo;
mod rig;
mod subject;
mod truth;
mod viewpoint;

#[cfg(test)]
mod tests;

pub use error::SimulateError;
pub use files::{dots_csv, npy, write_simulated};
pub use params::SimulateParams;
pub use subject::Subject;
pub use truth::{DotTruth, Simulated, Truth};

use crate::data::{Capture, LandmarkPairs, Photo};
use crate::observer::{Artifact, Event, Observer};
use crate::settings::Value;

use ground_truth::ground_truth;
use lit_scene::LitScene;
use photo::{Exposure, Received, develop, receive};
use rig::Rig;
use viewpoint::Viewpoint;

/// Photographs the subject with and without the projected pattern.
///
/// ```
/// use facerecon_core::synthetic::pattern::PatternParams;
/// use facerecon_core::synthetic::simulate::{SimulateParams, Subject, simulate};
/// use facerecon_core::template::head_coarse;
///
/// let head = head_coarse();
/// let subject = Subject {
///     mesh: &head.mesh,
///     texture: None,
///     landmarks: Some(&head.landmarks),
///     face: None,
/// };
/// let params = SimulateParams {
///     width_px: 192,
///     height_px: 144,
///     focal_px: 690.0,
///     dot_mm: 18.0,
///     pattern: PatternParams { columns: 21, rows: 16, ..Default::default() },
///     ..Default::default()
/// };
/// let simulated = simulate(&subject, &params, &())?;
/// assert_eq!(simulated.capture.left.size(), (192, 144));
/// assert_eq!(simulated.truth.dots.len(), 21 * 16);
/// # Ok::<(), facerecon_core::synthetic::simulate::SimulateError>(())
/// ```
///
/// # Errors
/// [`SimulateError`] for parameters out of range, an invalid mesh or rig, a subject outside the
/// photos, or when the observer cancels.
pub fn simulate(
    subject: &Subject<'_>,
    params: &SimulateParams,
    observer: &dyn Observer,
) -> Result<Simulated, SimulateError> {
    params.check("simulate", None)?;
    subject.check()?;
    let rig = Rig::new(params);
    rig.nominal.validate((params.width_px, params.height_px))?;
    let camera_from_model = rig.camera_from_model(subject.mesh, params);
    let plain_from_dots = rig.plain_from_dots(&camera_from_model, subject.mesh, params);

    let still = LitScene::new(subject, &camera_from_model, &rig, params)?;
    let moved = plain_from_dots
        .map(|motion| LitScene::new(subject, &motion.compose(&camera_from_model), &rig, params));
    let moved = moved.transpose()?;
    let viewpoints = rig.viewpoints();
    let received = [
        receive_pair("left", &still, moved.as_ref(), &viewpoints[0], params, observer)?,
        receive_pair("right", &still, moved.as_ref(), &viewpoints[1], params, observer)?,
    ];
    let [[left, right], plain] = develop_all(&received, params, observer)?;

    let truth = ground_truth(subject, &still, &rig, plain_from_dots, params)?;
    observer.event(&Event::Count {
        stage: "simulate",
        what: "dots on the subject seen by both cameras",
        count: truth.dots.iter().filter(|d| d.lit && d.visible == [true, true]).count(),
    });
    observer.artifact("simulate", "truth_mesh", Artifact::Mesh(&truth.mesh));
    let capture = Capture {
        left,
        right,
        plain: Some(plain),
        extra: Vec::new(),
        pattern: params.pattern.pattern(),
        rig: Some(rig.nominal),
        seeds: truth.seeds(),
        landmarks: LandmarkPairs::new(),
    };
    Ok(Simulated { capture, truth })
}

/// The light that one camera receives: from the still scene under the pattern, from the moved scene
/// (or the still one, if the head does not move) without it.
fn receive_pair(
    camera: &'static str,
    still: &LitScene<'_>,
    moved: Option<&LitScene<'_>>,
    viewpoint: &Viewpoint,
    params: &SimulateParams,
    observer: &dyn Observer,
) -> Result<Received, SimulateError> {
    let mut received = receive(still, viewpoint, params, observer)?;
    if let Some(moved) = moved {
        received.plain = receive(moved, viewpoint, params, observer)?.plain;
    }
    if !received.subject.contains(&true) {
        return Err(SimulateError::Unseen { camera, distance_mm: params.distance_mm });
    }
    Ok(received)
}

/// Photos `[left, right]` of the dotted pair and of the plain pair.
fn develop_all(
    received: &[Received; 2],
    params: &SimulateParams,
    observer: &dyn Observer,
) -> Result<[[Photo; 2]; 2], SimulateError> {
    let exposure = [
        Exposure::automatic(&received[0].dotted, &received[0].subject, params),
        Exposure::of_paper(params),
    ];
    let photo = |side: usize, plain: usize| -> Result<Photo, SimulateError> {
        observer.check()?;
        let linear = if plain == 1 { &received[side].plain } else { &received[side].dotted };
        let gain = if side == 1 { params.gain_right } else { 1.0 };
        let noise_stream = side * 2 + plain;
        Ok(Photo::from_rgb(develop(linear, &exposure[plain].times(gain), noise_stream, params)))
    };
    Ok([[photo(0, 0)?, photo(1, 0)?], [photo(0, 1)?, photo(1, 1)?]])
}
