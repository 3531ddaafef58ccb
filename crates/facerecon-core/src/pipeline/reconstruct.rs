//! The stages in order and nothing else.

use super::landmarks::find_unmarked;
use super::matching::match_photos;
use super::measured::{Measured, Points};
use super::photo_check::check_rectified;
use super::run::Run;
use super::shape::{self, Shape};
use super::uncertainty::with_uncertainty;
use super::verdict::{FaceVerdict, verdict_of};
use super::{Error, Params, Reconstruction, covered, inputs, outline};
use crate::data::{Capture, CloudFrame, Dot, Match, Mesh};
use crate::observer::{Artifact, Event, Observer};
use crate::stages::correspond::Correspondence;
use crate::stages::rectify::{Rectified, rectify};
use crate::stages::refine::{RefineMethod, Refined, match_remaining_dots, refine};
use crate::stages::register::{RegisterInput, register};
use crate::stages::smooth::smooth;
use crate::stages::surface::SurfaceMethod;
use crate::stages::texture::{Texture, TextureInput, texture};
use crate::stages::triangulate::{depth_maps, triangulate};
use crate::template::Template;

/// From photographs to a textured face.
///
/// # Errors
/// [`Error`] naming the stage that could not do its work, with the figures found and expected.
pub fn reconstruct(
    capture: &Capture,
    template: &Template,
    params: &Params,
    observer: &dyn Observer,
) -> Result<Reconstruction, Error> {
    run_stages(capture, template, params, true, observer)
}

/// As [`reconstruct`], without the texture.
pub(super) fn reconstruct_untextured(
    capture: &Capture,
    template: &Template,
    params: &Params,
    observer: &dyn Observer,
) -> Result<Reconstruction, Error> {
    run_stages(capture, template, params, false, observer)
}

fn run_stages(
    capture: &Capture,
    template: &Template,
    params: &Params,
    textured: bool,
    observer: &dyn Observer,
) -> Result<Reconstruction, Error> {
    let run = Run::new(observer);

    let mut rectified = run.stage("rectify", |o| rectify(capture, &params.rectify, o))?;
    let checked = run.stage("check", |o| check_rectified(capture, &rectified, params, o))?;
    let found = match_photos(&run, capture, &rectified, params)?;
    if rectified.rectification.rig.is_none() && params.cameras.estimate {
        rectified.rectification.rig =
            inputs::cameras(&run, &found.correspondence, &rectified, params)?;
    }
    let (mut matches, mut dense) =
        measure_disparity(&run, &rectified, found.correspondence, &found.dots, params)?;

    let views = &rectified.rectification;
    let outlines = run.stage("outline", |o| {
        let outlines = outline::subject_outlines(capture, views, &matches, params, o)?;
        let count = outline::keep_subject(&mut matches, dense.as_mut(), &outlines, views);
        o.event(&Event::Count { stage: "outline", what: "matches off the subject", count });
        Ok::<_, Error>(outlines)
    })?;

    let rig = rectified.rectification.rig.as_ref();
    let features = inputs::features(capture, &rectified.rectification, template)?;
    let all_matches = inputs::with_features(&matches, &features);
    let points = run.stage("triangulate", |o| {
        triangulate(&all_matches, rig, &template.mesh, &params.triangulate, o)
            .map_err(|fault| inputs::of_feature(fault, &matches, &features))
    })?;
    let frame = points.frame;
    let rig = rig.filter(|_| frame != CloudFrame::Model);
    let dots = &points.cloud;
    let mut points = inputs::points(dots, matches.len(), dense.as_ref(), rig, &features);
    let covers = find_unmarked(&run, capture, &rectified, frame, &outlines, &mut points, params)?;
    if let Some(covers) = &covers {
        covered::leave_out(&run, covers, &mut matches, dense.as_mut(), rig, &mut points);
    }
    let all_matches = inputs::with_features(&matches, &features);
    let measured = Measured {
        matches: &matches,
        dense: dense.as_ref(),
        rig,
        all_matches: &all_matches,
        frame,
    };
    points.outlines = outline::camera_outlines(capture, frame, outlines);

    let shape = fit_shape(&run, template, &points, &measured, params)?;
    let smoothed =
        run.stage("smooth", |o| smooth(&shape.mesh, &shape.reference, &params.smooth, o))?;
    run.artifact("smooth", "mesh", Artifact::Mesh(&smoothed.mesh));
    let mesh = with_uncertainty(
        smoothed.mesh,
        &points.all.transformed(&shape.model_from_camera),
        &shape.model_from_camera.translation,
    );
    let texture = if textured {
        paint(&run, capture, &rectified, &mesh, &shape, &points, &matches, template, params)?
    } else {
        None
    };

    let blur_difference = dense.as_ref().map_or(0.0, |d| d.blur_difference);
    let (timings_ms, warnings) = run.finish();
    let mut result = Reconstruction {
        mesh,
        landmarks: shape.landmarks,
        texture,
        cloud: points.all,
        measured_landmarks: points.landmarks,
        match_points: points.dots.points.iter().copied().map(Some).collect(),
        depth: depth_maps(&matches, &rectified.rectification, capture.left.size()),
        matches,
        rectification: rectified.rectification,
        rows: rectified.rows,
        pattern: capture.pattern.kind,
        dots: found.counts,
        registration: shape.registration,
        model_from_camera: shape.model_from_camera,
        metric: frame.is_metric(),
        blur_difference,
        dots_before_eyes: covers.map_or(0, |c| c.dots()),
        timings_ms,
        verdict: FaceVerdict::default(),
        warnings,
        params: params.clone(),
    };
    result.verdict = verdict_of(&result, checked.faults());
    Ok(result)
}

/// Refine, where the parameters ask for it: better disparities of the matches, and the disparity
/// between them.
fn measure_disparity(
    run: &Run<'_>,
    rectified: &Rectified,
    found: Correspondence,
    dots: &[Vec<Dot>; 2],
    params: &Params,
) -> Result<(Vec<Match>, Option<Refined>), Error> {
    if params.refine.method == RefineMethod::None {
        return Ok((found.matches, None));
    }
    let rig = rectified.rectification.rig.as_ref();
    let (left, right) = (&rectified.left, &rectified.right);
    let mut refined =
        run.stage("refine", |o| refine(left, right, rig, &found.matches, &params.refine, o))?;
    let max_sigma_px = params.refine.unmatched_sigma * refined.pitch_px;
    match_remaining_dots(&mut refined, [&dots[0], &dots[1]], max_sigma_px);
    Ok((refined.matches.clone(), Some(refined)))
}

/// Register, then deform the template or mesh the measured surface.
fn fit_shape(
    run: &Run<'_>,
    template: &Template,
    points: &Points,
    measured: &Measured<'_>,
    params: &Params,
) -> Result<Shape, Error> {
    let input = RegisterInput {
        data: &points.dots,
        model: &template.mesh,
        coarse: template.coarse.as_ref(),
        chin_y: template.chin_y(),
        landmarks: &inputs::landmark_points(&points.landmarks, template),
        frame: measured.frame,
    };
    let pose = run.stage("register", |o| register(&input, &params.register, o));
    match params.surface.method {
        SurfaceMethod::None => {
            shape::deformed(run, template, points, pose?, measured.frame.is_metric(), params)
        }
        SurfaceMethod::Auto | SurfaceMethod::Dots => {
            shape::measured(run, template, points, pose, measured, params)
        }
    }
}

/// The texture from the plain photos; `None` without them.
fn paint(
    run: &Run<'_>,
    capture: &Capture,
    rectified: &Rectified,
    mesh: &Mesh,
    shape: &Shape,
    points: &Points,
    matches: &[Match],
    template: &Template,
    params: &Params,
) -> Result<Option<Texture>, Error> {
    let Some(plain) = &capture.plain else { return Ok(None) };
    let model_from_camera = &shape.model_from_camera;
    let mut photos = inputs::photos(capture, plain, &model_from_camera.inverse());
    let (views, dots) = (&rectified.rectification, &points.dots);
    inputs::place_dots(&mut photos, mesh, matches, dots, &shape.on_mesh, views, model_from_camera);
    let photos: Vec<_> = photos.iter().map(inputs::PlainPhoto::lend).collect();
    let is_template = params.surface.method == SurfaceMethod::None;
    let template_texture = template.texture.as_ref().filter(|_| is_template);
    let input = TextureInput { mesh, photos: &photos, template_texture };
    let mut settings = params.texture.clone();
    // the plane of symmetry is known in the template's frame only
    settings.projective.mirror &= shape.registration.is_some();
    Ok(Some(run.stage("texture", |o| texture(&input, &settings, o))?))
}
