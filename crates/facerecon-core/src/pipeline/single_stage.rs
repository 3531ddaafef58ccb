//! Parts of the pipeline that make sense alone: for the commands and functions of single stages.
//! Warnings are events of the observer.

use super::inputs;
pub use super::inputs::{landmark_points, landmark_targets, to_scale};
pub use super::matching::detect_dots;
use super::matching::match_photos;
use super::run::Run;
use super::{Error, Params, reconstruct};
use crate::camera::Rectification;
use crate::data::{Capture, Match, MeasuredLandmark, Mesh};
use crate::math::{Similarity, Vec2, Vec3};
use crate::observer::Observer;
use crate::render::Frame;
use crate::spatial::SurfaceIndex;
use crate::stages::rectify::rectify;
use crate::stages::surface::SurfaceMethod;
use crate::stages::texture::{Texture, TextureInput, TextureMethod, texture};
use crate::stages::triangulate::{TriangulateMethod, TriangulateParams, Triangulated, triangulate};
use crate::template::Template;

/// The matches of a capture.
#[derive(Clone, Debug)]
pub struct Matched {
    /// The matches, rectified pixels.
    pub matches: Vec<Match>,
    /// How photo and rectified pixels belong together.
    pub rectification: Rectification,
    /// Dots found in the left and the right photo; for stripes, the edges matched.
    pub dots: [usize; 2],
}

/// Rectify, detect, correspond.
///
/// # Errors
/// Those of these stages.
pub fn find_matches(
    capture: &Capture,
    params: &Params,
    observer: &dyn Observer,
) -> Result<Matched, Error> {
    let run = Run::new(observer);
    let rectified = run.stage("rectify", |o| rectify(capture, &params.rectify, o))?;
    let found = match_photos(&run, capture, &rectified, params)?;
    Ok(Matched {
        matches: found.correspondence.matches,
        rectification: rectified.rectification,
        dots: found.counts,
    })
}

/// The landmarks marked in a calibrated capture, with their positions in the camera frame, mm.
///
/// # Errors
/// [`Error::Input`] without calibration, or where the template knows none of the marked features;
/// those of the stages rectify and triangulate.
pub fn marked_landmarks(
    capture: &Capture,
    template: &Template,
    params: &Params,
) -> Result<Vec<MeasuredLandmark>, Error> {
    let views = rectify(capture, &params.rectify, &())?.rectification;
    let marked = inputs::features(capture, &views, template)?;
    let Some(rig) = views.rig.as_ref().filter(|_| !marked.is_empty()) else {
        return match marked.len() {
            0 => Ok(Vec::new()),
            _ => Err(Error::Input(
                "register: features can only be used alone with calibrated cameras; add [rig] to \
                 capture.toml, or leave out --capture"
                    .into(),
            )),
        };
    };
    let pairs = inputs::with_features(&[], &marked);
    let metric = TriangulateParams { method: TriangulateMethod::Metric };
    let places = triangulate(&pairs, Some(rig), &template.mesh, &metric, &())
        .map_err(|fault| inputs::of_feature(fault, &[], &marked))?;
    let measured = marked.into_iter().map(|m| m.0).zip(places.cloud.points);
    Ok(measured.map(|(name, position)| inputs::marked_landmark(name, position)).collect())
}

/// The measured surface of a capture.
#[derive(Clone, Debug)]
pub struct MeasuredSurface {
    /// The mesh: left camera frame in millimetres when `metric`, else the frame and units of the
    /// points. It has texture coordinates, but no texture yet.
    pub mesh: Mesh,
    /// Whether lengths are true.
    pub metric: bool,
}

/// The measured surface of a capture alone: a reconstruction with `surface.method` (`none` counts
/// as `auto`), up to the texture.
///
/// # Errors
/// Those of the stages.
pub fn measure_surface(
    capture: &Capture,
    template: &Template,
    params: &Params,
    observer: &dyn Observer,
) -> Result<MeasuredSurface, Error> {
    // The pair without the pattern helps to match; the texture itself is not asked for.
    let pair = Capture { extra: Vec::new(), ..capture.clone() };
    let mut params = params.clone();
    params.texture.size = 16;
    if params.surface.method == SurfaceMethod::None {
        params.surface.method = SurfaceMethod::Auto;
    }
    let found = reconstruct(&pair, template, &params, observer)?;
    let mesh = found.mesh_in(Frame::Camera);
    Ok(MeasuredSurface { mesh, metric: found.metric })
}

/// Points from pairs in the photos' own pixels.
///
/// # Errors
/// Those of the stages rectify and triangulate.
pub fn triangulate_photo_pairs(
    capture: &Capture,
    pairs: &[(Vec2, Vec2)],
    template: &Template,
    params: &Params,
    observer: &dyn Observer,
) -> Result<Triangulated, Error> {
    let views = rectify(capture, &params.rectify, observer)?.rectification;
    let matches: Vec<Match> = pairs
        .iter()
        .map(|(left, right)| Match {
            left: views.left.to_rectified(*left),
            right: views.right.to_rectified(*right),
            lattice: None,
            sigma_px: 0.0,
            score: 1.0,
        })
        .collect();
    let rig = views.rig.as_ref();
    Ok(triangulate(&matches, rig, &template.mesh, &params.triangulate, observer)?)
}

/// Greatest distance of a measured point that belongs to a mesh, mm: more than a fitted mesh is off
/// anywhere on the face, less than the distance to the background.
const NEAR_MM: f64 = 10.0;

/// Indices of the points near a mesh.
fn near_mesh(points: &[Vec3], mesh: &Mesh) -> Vec<usize> {
    let index = SurfaceIndex::new(mesh);
    let near = |p: &Vec3| index.as_ref().is_some_and(|i| i.closest_within(p, NEAR_MM).is_some());
    (0..points.len()).filter(|i| near(&points[*i])).collect()
}

/// Colours a mesh of the camera frame (mm) from the photographs of a calibrated capture.
///
/// # Errors
/// [`Error::Input`] without a pair without the pattern or without calibration; those of texture.
pub fn texture_mesh(
    capture: &Capture,
    mesh: &Mesh,
    params: &Params,
    observer: &dyn Observer,
) -> Result<Texture, Error> {
    let Some(plain) = &capture.plain else {
        return Err(Error::Input(
            "texture: the capture has no pair without the pattern; add left_plain and \
             right_plain to capture.toml"
                .into(),
        ));
    };
    if capture.rig.is_none() {
        return Err(Error::Input(
            "texture: a mesh alone can only be coloured with calibrated cameras; add [rig] to \
             capture.toml"
                .into(),
        ));
    }
    capture.validate().map_err(|e| Error::Input(format!("texture: {e}")))?;
    require_in_view(capture, mesh)?;
    let in_place = Similarity::identity();
    let mut photos = inputs::photos(capture, plain, &in_place);
    if params.texture.method == TextureMethod::Scanline {
        // the thesis bounds the face by matched dots
        let found = find_matches(capture, params, observer)?;
        let views = &found.rectification;
        let rig = views.rig.as_ref();
        let dots = triangulate(&found.matches, rig, mesh, &params.triangulate, observer)?.cloud;
        let near = near_mesh(&dots.points, mesh);
        inputs::place_dots(&mut photos, mesh, &found.matches, &dots, &near, views, &in_place);
    }
    let photos: Vec<_> = photos.iter().map(inputs::PlainPhoto::lend).collect();
    let input = TextureInput { mesh, photos: &photos, template_texture: None };
    Ok(texture(&input, &params.texture, observer)?)
}

/// Checks that a mesh lies in the field of view of the left camera.
fn require_in_view(capture: &Capture, mesh: &Mesh) -> Result<(), Error> {
    let Some(rig) = &capture.rig else { return Ok(()) };
    let (width, height) = capture.left.size();
    let seen = |v: &&Vec3| {
        v.z > 0.0
            && rig.left.project(v).is_some_and(|p| {
                (0.0..width as f64).contains(&p.x) && (0.0..height as f64).contains(&p.y)
            })
    };
    let (count, all) = (mesh.vertices.iter().filter(seen).count(), mesh.vertices.len());
    if 10 * count >= all {
        return Ok(());
    }
    Err(Error::Input(format!(
        "texture: {count} of the mesh's {all} vertices lie in the left photo, at least a tenth is \
         needed; the mesh must be in the camera frame in mm (reconstruct --frame camera), or its pose \
         be given (texture --pose, the JSON that register wrote)"
    )))
}
