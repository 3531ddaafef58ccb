//! The stages in order and nothing else.

use super::run::{OfSide, Run};
use super::{Error, Params, Reconstruction, inputs, shape, single_stage};
use crate::data::{Capture, CloudFrame, PatternKind};
use crate::observer::{Artifact, Observer};
use crate::stages::check::{CheckParams, check};
use crate::stages::correspond::correspond;
use crate::stages::rectify::rectify;
use crate::stages::refine::{RefineMethod, refine};
use crate::stages::register::{RegisterInput, register};
use crate::stages::smooth::smooth;
use crate::stages::surface::SurfaceMethod;
use crate::stages::texture::{TextureInput, texture};
use crate::stages::triangulate::{depth_maps, triangulate};
use crate::template::Template;

/// From photographs to a textured face.
///
/// # Errors
/// [`Error`] naming the stage that could not do its work, with the figures found and needed.
pub fn reconstruct(
    capture: &Capture,
    template: &Template,
    params: &Params,
    observer: &dyn Observer,
) -> Result<Reconstruction, Error> {
    let mut run = Run::new(observer);

    let mut level = run.stage("rectify", |o| rectify(capture, &params.rectify, o))?;
    run.warn(&level.warnings);
    let photos = run.stage("check", |_| Ok::<_, Error>(check(capture, &CheckParams::default())))?;
    run.warn(&photos.warnings());

    let (found, seen, dots) = match capture.pattern.kind {
        PatternKind::Stripes => {
            let found = run.stage("correspond", |o| single_stage::stripes(&level, params, o))?;
            let count = found.matches.len();
            (found, [Vec::new(), Vec::new()], [count; 2])
        }
        PatternKind::Dots => {
            let mut dots = |side, image| {
                run.stage("detect", |o| {
                    single_stage::dots(image, params, &OfSide { side, observer: o })
                })
            };
            let (left, right) = (dots("left", &level.left)?, dots("right", &level.right)?);
            let input = inputs::correspond(capture, &level, &left, &right);
            let found = run.stage("correspond", |o| correspond(&input, &params.correspond, o))?;
            let count = [left.dots.len(), right.dots.len()];
            (found, [left.dots, right.dots], count)
        }
    };
    run.warn(&found.warnings);

    if level.rectification.rig.is_none() && params.cameras.estimate {
        level.rectification.rig = inputs::cameras(&found, &level, params, &mut run)?;
    }
    let rig = level.rectification.rig.as_ref();

    let (matches, dense) = match params.refine.method {
        RefineMethod::None => (found.matches, None),
        RefineMethod::Photometric => {
            let (left, right) = (&level.left, &level.right);
            let mut refined = run
                .stage("refine", |o| refine(left, right, rig, &found.matches, &params.refine, o))?;
            refined.add_lone_dots([&seen[0], &seen[1]], params.refine.lone_sigma_px);
            (refined.matches.clone(), Some(refined))
        }
    };

    let features = inputs::features(capture, &level.rectification, template)?;
    let points = run.stage("triangulate", |o| {
        let all = inputs::with_features(&matches, &features);
        triangulate(&all, rig, &template.mesh, &params.triangulate, o)
            .map_err(|fault| inputs::of_feature(fault, &matches, &features))
    })?;
    let frame = points.frame;
    let by_rig = rig.filter(|_| frame != CloudFrame::Model);
    let points = inputs::points(&points.cloud, &matches, &features, dense.as_ref(), by_rig);
    let depth = depth_maps(&matches, &level.rectification, capture.left.size());

    let input = RegisterInput {
        data: &points.dots,
        model: &template.mesh,
        coarse: template.coarse.as_ref(),
        features: &inputs::feature_points(&points.features, template),
        frame,
    };
    let pose = run.stage("register", |o| register(&input, &params.register, o));
    let shape = match params.surface.method {
        SurfaceMethod::None => {
            shape::bent_head(&mut run, template, &points, pose?, frame.is_metric(), params)?
        }
        SurfaceMethod::Auto | SurfaceMethod::Dots => {
            let dense = dense.as_ref();
            let all_matches = &inputs::with_features(&matches, &features);
            let rig = by_rig;
            let found = shape::Measured { matches: &matches, dense, rig, all_matches, frame };
            shape::measured(&mut run, template, &points, pose, &found, params)?
        }
    };
    let model_from_camera = shape.model_from_camera;

    let smooth =
        run.stage("smooth", |o| smooth(&shape.mesh, &shape.reference, &params.smooth, o))?;
    run.observer.artifact("smooth", "mesh", Artifact::Mesh(&smooth.mesh));

    let texture = match &capture.plain {
        Some(plain) => {
            let camera_from_model = model_from_camera.inverse();
            let mut photos = inputs::photos(capture, plain, &camera_from_model);
            let (mesh, views) = (&smooth.mesh, &level.rectification);
            let dots = &points.dots;
            let seen = &shape.on_mesh;
            inputs::place_dots(&mut photos, mesh, &matches, dots, seen, views, &model_from_camera);
            let photos: Vec<_> = photos.iter().map(inputs::PlainPhoto::lend).collect();
            let bent = params.surface.method == SurfaceMethod::None;
            let own = template.texture.as_ref().filter(|_| bent);
            let input = TextureInput { mesh, photos: &photos, template_texture: own };
            let mut settings = params.texture.clone();
            // only the frame of the generic head knows where the middle of the face is
            settings.projective.mirror &= shape.registration.is_some();
            Some(run.stage("texture", |o| texture(&input, &settings, o))?)
        }
        None => None,
    };
    Ok(Reconstruction {
        mesh: smooth.mesh,
        landmarks: shape.landmarks,
        texture,
        cloud: points.all,
        match_points: points.dots.points.iter().copied().map(Some).collect(),
        matches,
        rectification: level.rectification,
        rows: level.rows,
        dots,
        depth,
        registration: shape.registration,
        model_from_camera,
        metric: frame.is_metric(),
        timings_ms: run.timings_ms,
        warnings: run.warnings,
        params: params.clone(),
    })
}
