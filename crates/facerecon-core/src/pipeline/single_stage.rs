//! Parts of the pipeline that make sense alone: for the commands and functions of single stages.

use super::inputs;
pub use super::inputs::{feature_goals, feature_points, to_scale};
use super::reconstruct;
use super::run::Run;
use crate::camera::Rectification;
use crate::data::{Capture, Gray, Match, Mesh, PatternKind, Rgb};
use crate::math::{Similarity, Vec2, Vec3};
use crate::observer::{Artifact, Observer};
use crate::pipeline::Error;
use crate::pipeline::Params;
use crate::render::Frame;
use crate::spatial::SurfaceIndex;
use crate::stages::correspond::{Correspondence, correspond, correspond_stripes};
use crate::stages::detect::{DetectMethod, Detection, detect};
use crate::stages::filter::filter;
use crate::stages::rectify::{Rectified, rectify};
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
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// The dots of one photo: after the thesis's preprocessing where `detect.method` is `thin`, else
/// from the photo itself.
///
/// # Errors
/// Those of the stages filter and detect.
pub fn dots(image: &Gray, params: &Params, observer: &dyn Observer) -> Result<Detection, Error> {
    let found = if params.detect.method == DetectMethod::Thin {
        let filtered = filter(image, &params.filter, observer)?;
        detect(&filtered.binary, &params.detect, observer)?
    } else {
        detect(image, &params.detect, observer)?
    };
    let places: Vec<Vec3> = found.dots.iter().map(|d| d.position.push(0.0)).collect();
    observer.artifact("detect", "dots", Artifact::Points(&places));
    Ok(found)
}

/// The matches of a capture of stripes.
///
/// # Errors
/// Those of the stage correspond.
pub fn stripes(
    level: &Rectified,
    params: &Params,
    observer: &dyn Observer,
) -> Result<Correspondence, Error> {
    let rig = level.rectification.rig.as_ref();
    let empty = [Rgb::filled(0, 0, [0; 3]), Rgb::filled(0, 0, [0; 3])];
    let [left, right] = level.colors.as_ref().unwrap_or(&empty);
    Ok(correspond_stripes([left, right], rig, &params.correspond.stripes, observer)?)
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
    let mut run = Run::new(observer);
    let level: Rectified = run.stage("rectify", |o| rectify(capture, &params.rectify, o))?;
    let (found, dots) = match capture.pattern.kind {
        PatternKind::Stripes => {
            let found = run.stage("correspond", |o| stripes(&level, params, o))?;
            let count = found.matches.len();
            (found, [count; 2])
        }
        PatternKind::Dots => {
            let left = run.stage("detect", |o| dots(&level.left, params, o))?;
            let right = run.stage("detect", |o| dots(&level.right, params, o))?;
            let input = inputs::correspond(capture, &level, &left, &right);
            let found = run.stage("correspond", |o| correspond(&input, &params.correspond, o))?;
            (found, [left.dots.len(), right.dots.len()])
        }
    };
    let warnings = level.warnings.iter().chain(&found.warnings).cloned().collect();
    Ok(Matched { matches: found.matches, rectification: level.rectification, dots, warnings })
}

/// The features marked in a calibrated capture, with their places in the camera frame, mm.
///
/// # Errors
/// [`Error::Input`] without calibration, or where the template knows none of the marked features;
/// those of the stages rectify and triangulate.
pub fn features(
    capture: &Capture,
    template: &Template,
    params: &Params,
) -> Result<Vec<(String, Vec3)>, Error> {
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
    Ok(marked.into_iter().map(|m| m.0).zip(places.cloud.points).collect())
}

/// The measured surface of a capture.
#[derive(Clone, Debug)]
pub struct MeasuredSurface {
    /// The mesh: left camera frame in millimetres when `metric`, else the frame and units of the
    /// points. It has texture coordinates, but no texture yet.
    pub mesh: Mesh,
    /// Whether lengths are true.
    pub metric: bool,
    /// What the user should know.
    pub warnings: Vec<String>,
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
    Ok(MeasuredSurface { mesh, metric: found.metric, warnings: found.warnings })
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

/// Measured points that belong to a mesh lie at most this far from it.
const NEAR_MM: f64 = 10.0;

/// Numbers of the points that lie near a mesh.
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
            "texture: the capture has no pair without the pattern; add left_texture and \
             right_texture to capture.toml"
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
    stands_before(capture, mesh)?;
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

/// Checks that a mesh is where the cameras look.
fn stands_before(capture: &Capture, mesh: &Mesh) -> Result<(), Error> {
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
