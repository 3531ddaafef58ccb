//! The inputs of each stage, collected from the outputs of earlier stages.

use super::measured::Points;
use super::run::Run;
use crate::camera::{Pinhole, Rectification, RectifiedRig};
use crate::data::{
    Capture, Cloud, Gray, LandmarkSource, MARKED_LANDMARK_SIGMA_MM, Match, MeasuredLandmark, Mesh,
    Pair, Photo, Rgb, Seeds,
};
use crate::math::{Similarity, Vec3};
use crate::observer::Observer;
use crate::pipeline::Error;
use crate::pipeline::Params;
use crate::spatial::PointIndex;
use crate::stages::cameras::{CamerasError, estimate_cameras};
use crate::stages::correspond::{CorrespondInput, Correspondence};
use crate::stages::deform::LandmarkTarget;
use crate::stages::detect::Detection;
use crate::stages::rectify::Rectified;
use crate::stages::refine::Refined;
use crate::stages::register::Registration;
use crate::stages::texture::{TextureDot, TexturePhoto};
use crate::stages::triangulate::TriangulateError;
use crate::template::Template;

pub(super) fn correspond<'a>(
    capture: &'a Capture,
    level: &'a Rectified,
    left: &'a Detection,
    right: &'a Detection,
) -> CorrespondInput<'a> {
    let views = &level.rectification;
    let pair = |p: Pair| Pair {
        left: views.left.to_rectified(p.left),
        right: views.right.to_rectified(p.right),
    };
    CorrespondInput {
        left: &left.dots,
        right: &right.dots,
        spacing_px: 0.5 * (left.spacing_px + right.spacing_px),
        plain: level.plain.as_ref().map(|[l, r]| [l, r]),
        pattern: &capture.pattern,
        seeds: capture.seeds.map(|s| Seeds {
            head: pair(s.head),
            left_ear: pair(s.left_ear),
            right_ear: pair(s.right_ear),
        }),
        rig: level.rectification.rig.as_ref(),
    }
}

/// The cameras of a capture without calibration, estimated from the pattern; `None` with a warning
/// where they cannot be.
pub(super) fn cameras(
    run: &Run<'_>,
    found: &Correspondence,
    rectified: &Rectified,
    params: &Params,
) -> Result<Option<RectifiedRig>, Error> {
    let size = rectified.rectification.size;
    let estimated = run.stage("cameras", |o| {
        Ok::<_, Error>(estimate_cameras(&found.matches, size, &params.cameras, o))
    })?;
    match estimated {
        Ok(cameras) => Ok(Some(cameras.rig)),
        Err(error @ (CamerasError::Settings(_) | CamerasError::Cancelled(_))) => Err(error.into()),
        // the run goes on in model units
        Err(why) => {
            run.warn(
                "cameras",
                &format!(
                    "the cameras could not be estimated ({why}): the depth is scaled to the \
                     template, not measured; calibrate the cameras"
                ),
            );
            Ok(None)
        }
    }
}

/// The marked features as matches in rectified pixels.
///
/// # Errors
/// [`Error::Input`] where features are marked but the template knows none of them.
pub(super) fn features(
    capture: &Capture,
    views: &Rectification,
    template: &Template,
) -> Result<Vec<(String, Match)>, Error> {
    let (marked, name) = (capture.landmarks.len(), &template.name);
    if marked > 0 && !capture.landmarks.keys().any(|f| template.landmarks.contains_key(f)) {
        return Err(Error::Input(format!(
            "register: {marked} features are marked in the photos, but the template {name} has none \
             of them among its landmarks; give them in {name}.landmarks.toml, or take [landmarks] \
             out of capture.toml"
        )));
    }
    let rectified = |pair: &Pair| Match {
        left: views.left.to_rectified(pair.left),
        right: views.right.to_rectified(pair.right),
        lattice: None,
        sigma_px: 0.0,
        score: 1.0,
    };
    Ok(capture.landmarks.iter().map(|(name, pair)| (name.clone(), rectified(pair))).collect())
}

/// Matches and features in one list, so that both get the same units.
pub(super) fn with_features(matches: &[Match], features: &[(String, Match)]) -> Vec<Match> {
    matches.iter().copied().chain(features.iter().map(|f| f.1)).collect()
}

/// The fault of a triangulated list of matches and features, by the feature's name where it is one's.
pub(super) fn of_feature(
    fault: TriangulateError,
    matches: &[Match],
    features: &[(String, Match)],
) -> Error {
    let TriangulateError::Behind { index, disparity_px } = fault else { return fault.into() };
    match index.checked_sub(matches.len()).and_then(|i| features.get(i)) {
        Some((name, _)) => Error::Input(format!(
            "triangulate: the feature {name} has a disparity of {disparity_px:.2} px, at or beyond \
             infinity for this rig; mark it anew in both photos ([landmarks] of capture.toml)"
        )),
        None => fault.into(),
    }
}

/// Splits the triangulated points into dots and features, and triangulates the dense disparity.
pub(super) fn points(
    cloud: &Cloud,
    matches: usize,
    dense: Option<&Refined>,
    rig: Option<&RectifiedRig>,
    features: &[(String, Match)],
) -> Points {
    let count = matches.min(cloud.len());
    let dots = Cloud::from_points(cloud.points[..count].to_vec());
    let names = features.iter().map(|f| f.0.clone());
    let landmarks =
        names.zip(&cloud.points[count..]).map(|(n, p)| marked_landmark(n, *p)).collect();
    let all = match (dense, rig) {
        (Some(dense), Some(rig)) => super::dense::cloud(dense, rig),
        _ => dots.clone(),
    };
    Points { dots, all, landmarks, expected: Vec::new(), outlines: Vec::new() }
}

/// A landmark marked by hand, at its triangulated position.
pub(super) fn marked_landmark(name: String, position: Vec3) -> MeasuredLandmark {
    let sigma_mm = MARKED_LANDMARK_SIGMA_MM;
    MeasuredLandmark { name, position, sigma_mm, source: LandmarkSource::Marked }
}

/// Measured landmarks with their positions on the template.
pub fn landmark_points(landmarks: &[MeasuredLandmark], template: &Template) -> Vec<(Vec3, Vec3)> {
    let vertex = |name: &String| Some(template.mesh.vertices[*template.landmarks.get(name)?]);
    landmarks.iter().filter_map(|l| Some((l.position, vertex(&l.name)?))).collect()
}

/// The template in the size of the subject, and the rigid motion into its frame: the measured
/// lengths stay what they are.
pub fn to_scale(template: &Template, pose: &Registration, metric: bool) -> (Mesh, Similarity) {
    let scale = pose.model_from_data.scale;
    if !metric || scale == 1.0 {
        return (template.mesh.clone(), pose.model_from_data);
    }
    let shrink = Similarity { scale: 1.0 / scale, ..Similarity::identity() };
    (template.mesh.transformed(&shrink), shrink.compose(&pose.model_from_data))
}

/// One data point a vertex (thesis section 3.2), in the frame and size of `head`.
pub(super) fn assignments(
    pose: &Registration,
    dots: &Cloud,
    template: &Mesh,
    head_from_camera: &Similarity,
) -> Vec<(usize, Vec3)> {
    let head_from_model = head_from_camera.compose(&pose.model_from_data.inverse());
    let goals = pose.assignments(dots, template);
    goals.into_iter().map(|(vertex, p)| (vertex, head_from_model.apply(&p))).collect()
}

/// Vertices of the landmarks with their measured positions in the model frame.
pub fn landmark_targets(
    landmarks: &[MeasuredLandmark],
    template: &Template,
    model_from_camera: &Similarity,
) -> Vec<LandmarkTarget> {
    landmarks
        .iter()
        .filter_map(|l| {
            Some(LandmarkTarget {
                vertex: *template.landmarks.get(&l.name)?,
                position: model_from_camera.apply(&l.position),
                sigma_mm: l.sigma_mm * model_from_camera.scale,
            })
        })
        .collect()
}

/// A photo for the texture, with what the stage borrows from it.
pub(crate) struct PlainPhoto<'a> {
    image: &'a Rgb,
    camera: Option<(Pinhole, Similarity)>,
    patterned: Option<&'a Gray>,
    dots: Vec<TextureDot>,
}

impl PlainPhoto<'_> {
    pub(crate) fn lend(&self) -> TexturePhoto<'_> {
        TexturePhoto {
            image: self.image,
            camera: self.camera,
            patterned: self.patterned,
            dots: &self.dots,
        }
    }
}

/// The photos without the pattern, left and right first, with their cameras where known.
pub(crate) fn photos<'a>(
    capture: &'a Capture,
    plain: &'a [Photo; 2],
    camera_from_mesh: &Similarity,
) -> Vec<PlainPhoto<'a>> {
    let pair = |i: usize| {
        let rig = capture.rig.as_ref()?;
        Some(match i {
            0 => (rig.left, *camera_from_mesh),
            _ => (rig.right, rig.right_from_left.compose(camera_from_mesh)),
        })
    };
    let extra = capture.extra.iter().map(|e| PlainPhoto {
        image: &e.photo.rgb,
        camera: capture
            .rig
            .is_some()
            .then(|| (e.camera, e.camera_from_left.compose(camera_from_mesh))),
        patterned: None,
        dots: Vec::new(),
    });
    let pair = plain.iter().enumerate().map(|(i, photo)| PlainPhoto {
        image: &photo.rgb,
        camera: pair(i),
        patterned: Some([&capture.left.gray, &capture.right.gray][i]),
        dots: Vec::new(),
    });
    pair.chain(extra).collect()
}

/// Tells the photos where the matched dots lie in them and which vertex of the finished mesh each
/// is nearest to.
pub(super) fn place_dots(
    photos: &mut [PlainPhoto<'_>],
    mesh: &Mesh,
    matches: &[Match],
    dots: &Cloud,
    inliers: &[usize],
    views: &Rectification,
    model_from_camera: &Similarity,
) {
    let Some(index) = PointIndex::<3>::new(&mesh.vertices) else { return };
    let [left, right, ..] = photos else { return };
    for &i in inliers {
        let (Some(m), Some(point)) = (matches.get(i), dots.points.get(i)) else { continue };
        let p = model_from_camera.apply(point);
        if let Some(vertex) = index.nearest(&[p.x, p.y, p.z]).map(|n| n.index) {
            let dot = |pixel| TextureDot { vertex, point: p, pixel };
            left.dots.push(dot(views.left.to_photo(m.left)));
            right.dots.push(dot(views.right.to_photo(m.right)));
        }
    }
}
