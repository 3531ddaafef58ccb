//! One bench a stage and one end to end, on simulated captures of three sizes, so that growth is
//! visible: `cargo bench`, or for one stage `cargo bench -- refine`.
#![allow(clippy::expect_used)] // a bench may stop

use std::sync::OnceLock;

use divan::Bencher;
use facerecon_core::Params;
use facerecon_core::data::{Capture, Cloud, CloudFrame, Mesh};
use facerecon_core::render::Frame;
use facerecon_core::spatial::eliminate_multiple;
use facerecon_core::stages::deform::{DeformInput, deform};
use facerecon_core::stages::filter::filter;
use facerecon_core::stages::rectify::rectify;
use facerecon_core::stages::refine::refine;
use facerecon_core::stages::register::{RegisterInput, register};
use facerecon_core::stages::smooth::smooth;
use facerecon_core::stages::surface::{SurfaceInput, surface};
use facerecon_core::stages::triangulate::triangulate;
use facerecon_core::synthetic::Person;
use facerecon_core::synthetic::simulate::{SimulateParams, Simulated, simulate};
use facerecon_core::template::{self, Template};
use facerecon_core::{Reconstruction, reconstruct, single_stage};

/// Widths of the photos; the number of dots grows with their area.
const WIDTHS: [usize; 3] = [512, 768, 1152];
const PROFILES: [&str; 2] = ["precise", "facebuilder"];
const SUBJECT: u64 = 1;

fn main() {
    divan::main();
}

/// A capture and what every stage of the profile `precise` is given and gives.
struct Scene {
    capture: Capture,
    params: Params,
    template: Template,
    found: Reconstruction,
    /// The template in the size of the subject.
    head: Mesh,
    /// All measured points in the model frame.
    registered: Cloud,
}

fn photograph(width: usize) -> Simulated {
    let person = Person::new(SUBJECT);
    let usual = SimulateParams::default();
    let ratio = width as f64 / usual.width_px as f64;
    let mut rig = SimulateParams {
        width_px: width,
        height_px: width * usual.height_px / usual.width_px,
        focal_px: usual.focal_px * ratio,
        dot_mm: usual.dot_mm / ratio,
        ..usual.clone()
    };
    rig.pattern.columns = (usual.pattern.columns as f64 * ratio).round() as usize;
    rig.pattern.rows = (usual.pattern.rows as f64 * ratio).round() as usize;
    simulate(&person.subject(), &rig, &()).expect("the virtual rig can be built")
}

/// The scene of a photo width, made once.
fn scene(width: usize) -> &'static Scene {
    static SCENES: [OnceLock<Scene>; 3] = [const { OnceLock::new() }; 3];
    let place = WIDTHS.iter().position(|w| *w == width).expect("a width of the list");
    SCENES[place].get_or_init(|| {
        let capture = photograph(width).capture;
        let (params, template) = (Params::default(), template::built_in());
        let found = reconstruct(&capture, &template, &params, &()).expect("a face");
        let pose = found.registration.as_ref().expect("a registered face");
        let (head, _) = single_stage::to_scale(&template, pose, found.metric);
        let registered = found.cloud.transformed(&found.model_from_camera);
        Scene { capture, params, template, found, head, registered }
    })
}

#[divan::bench(args = WIDTHS, sample_count = 5)]
fn a_rectify(bencher: Bencher<'_, '_>, width: usize) {
    let s = scene(width);
    bencher.bench(|| rectify(&s.capture, &s.params.rectify, &()));
}

#[divan::bench(args = WIDTHS, sample_count = 5)]
fn b_filter(bencher: Bencher<'_, '_>, width: usize) {
    let s = scene(width);
    bencher.bench(|| filter(&s.capture.left.gray, &s.params.filter, &()));
}

#[divan::bench(args = WIDTHS, sample_count = 5)]
fn c_detect(bencher: Bencher<'_, '_>, width: usize) {
    let s = scene(width);
    bencher.bench(|| single_stage::detect_dots(&s.capture.left.gray, &s.params, &()));
}

/// Both photos rectified, their dots found and matched.
#[divan::bench(args = WIDTHS, sample_count = 5)]
fn d_rectify_detect_correspond(bencher: Bencher<'_, '_>, width: usize) {
    let s = scene(width);
    bencher.bench(|| single_stage::find_matches(&s.capture, &s.params, &()));
}

#[divan::bench(args = WIDTHS, sample_count = 5)]
fn e_refine(bencher: Bencher<'_, '_>, width: usize) {
    let s = scene(width);
    let level = rectify(&s.capture, &s.params.rectify, &()).expect("level photos");
    let rig = level.rectification.rig.as_ref();
    let matches = single_stage::find_matches(&s.capture, &s.params, &()).expect("matches").matches;
    bencher.bench(|| refine(&level.left, &level.right, rig, &matches, &s.params.refine, &()));
}

#[divan::bench(args = WIDTHS, sample_count = 5)]
fn f_triangulate(bencher: Bencher<'_, '_>, width: usize) {
    let s = scene(width);
    let rig = s.found.rectification.rig.as_ref();
    let mesh = &s.template.mesh;
    bencher.bench(|| triangulate(&s.found.matches, rig, mesh, &s.params.triangulate, &()));
}

#[divan::bench(args = WIDTHS, sample_count = 5)]
fn g_register(bencher: Bencher<'_, '_>, width: usize) {
    let s = scene(width);
    let data = Cloud::from_points(s.found.match_points.iter().copied().flatten().collect());
    let input = RegisterInput {
        data: &data,
        model: &s.template.mesh,
        coarse: s.template.coarse.as_ref(),
        chin_y: s.template.chin_y(),
        landmarks: &[],
        frame: CloudFrame::Metric,
    };
    bencher.bench(|| register(&input, &s.params.register, &()));
}

#[divan::bench(args = WIDTHS, sample_count = 5)]
fn h_deform(bencher: Bencher<'_, '_>, width: usize) {
    let s = scene(width);
    let goals = eliminate_multiple(&s.registered.points, &s.head.vertices, None);
    let input = DeformInput {
        template: &s.head,
        data: &s.registered,
        assignments: &goals,
        landmarks: &[],
        outlines: &[],
    };
    bencher.bench(|| deform(&input, &s.params.deform, &()));
}

/// The thesis's smoothing: `precise` smooths nothing.
#[divan::bench(args = WIDTHS, sample_count = 5)]
fn i_smooth(bencher: Bencher<'_, '_>, width: usize) {
    let s = scene(width);
    let params = Params::profile("facebuilder").expect("a profile").smooth;
    bencher.bench(|| smooth(&s.found.mesh, &[], &params, &()));
}

#[divan::bench(args = WIDTHS, sample_count = 5)]
fn j_texture(bencher: Bencher<'_, '_>, width: usize) {
    let s = scene(width);
    let mesh = s.found.mesh_in(Frame::Camera);
    bencher.bench(|| single_stage::texture_mesh(&s.capture, &mesh, &s.params, &()));
}

#[divan::bench(args = WIDTHS, sample_count = 5)]
fn h_surface(bencher: Bencher<'_, '_>, width: usize) {
    let s = scene(width);
    let level = rectify(&s.capture, &s.params.rectify, &()).expect("level photos");
    let rig = level.rectification.rig.as_ref().expect("a calibrated capture");
    let matches = &s.found.matches;
    let (left, right) = (&level.left, &level.right);
    let dense = refine(left, right, Some(rig), matches, &s.params.refine, &()).expect("a surface");
    let unproject = |p, d| rig.point(p, d);
    let disparity = Some(&dense.disparity);
    let input = SurfaceInput { disparity, matches, on_subject: &[], unproject: &unproject };
    bencher.bench_local(|| surface(&input, &s.params.surface, &()));
}

#[divan::bench(args = WIDTHS, consts = [0, 1], sample_count = 3)]
fn k_end_to_end<const PROFILE: usize>(bencher: Bencher<'_, '_>, width: usize) {
    let s = scene(width);
    let params = Params::profile(PROFILES[PROFILE]).expect("a profile");
    bencher.bench(|| reconstruct(&s.capture, &s.template, &params, &()));
}

#[divan::bench(args = WIDTHS, sample_count = 3)]
fn l_simulate(bencher: Bencher<'_, '_>, width: usize) {
    bencher.bench(|| photograph(width));
}
