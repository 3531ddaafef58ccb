//! `--surface`: the measured surface as the mesh, compared with the ground truth; results without a
//! registration; refusals.
#![allow(clippy::unwrap_used, clippy::panic)] // also the helpers of tests may stop a test
#![allow(clippy::print_stdout)] // the figures are of interest
#![allow(dead_code)] // not every helper is used here

#[path = "support/cli.rs"]
mod cli;
#[path = "support/truth.rs"]
mod truth;

use cli::Bench;
use facerecon_core::Params;
use facerecon_core::data::Topology;
use facerecon_core::io;
use facerecon_core::reconstruct;
use facerecon_core::render::Frame;
use facerecon_core::template;
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error} in {text}"))
}

fn params(profile: &str, sets: &[(&str, &str)]) -> Params {
    let sets: Vec<_> = sets.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
    Params::load(Some(profile), None, &sets).unwrap()
}

#[test]
fn the_surface_is_where_the_face_is() {
    // (capture, profile, method, bounds of the median and 90th percentile of the distances in mm,
    // part within 1 mm: dots on the border and in the nostrils, which the surface leaves out, are
    // farther away)
    let cases = [
        ("parallel", "precise", "auto", 0.1, 0.35, 0.93),
        ("toed_in", "precise", "auto", 0.1, 0.35, 0.93),
        ("parallel", "precise", "dots", 0.12, 0.5, 0.93),
        ("parallel", "facebuilder", "auto", 1.5, 4.5, 0.35),
    ];
    for (name, profile, method, median_mm, p90_mm, within) in cases {
        let folder = cli::fixtures().join(name);
        let capture = io::capture::read_capture(&folder).unwrap().capture;
        let params = params(profile, &[("surface.method", method)]);
        let found = reconstruct(&capture, &template::built_in(), &params, &()).unwrap();
        let d = truth::distances(&truth::face_dots(&folder), &found.mesh_in(Frame::Camera));
        println!(
            "{name} {profile} {method}: {} vertices, median {:.3}, p90 {:.3} mm, {:.3} within 1 mm",
            found.mesh.vertices.len(),
            d.median_mm,
            d.p90_mm,
            d.within_1mm
        );
        assert!(d.median_mm <= median_mm && d.p90_mm <= p90_mm && d.within_1mm >= within, "{d:?}");
        assert_eq!(Topology::new(&found.mesh).non_manifold_edges, 0);
        assert!(found.mesh.has_uv() && found.landmarks.is_empty());
        assert!(found.registration.is_some() && found.texture.is_some());
    }
}

#[test]
fn the_result_has_null_for_what_needs_a_template() {
    let bench = Bench::new();
    let ran = bench.done("reconstruct capture -o out --surface --json");
    assert!(ran.err.contains("measured surface"), "{}", ran.err);
    let facts = json(&ran.out);
    assert_eq!(facts["params"]["surface"]["method"], "auto");
    // the width needs the ears, which only a template has; saddle and chin were found
    assert_eq!(facts["face_width_mm"], Value::Null);
    assert!((90.0..150.0).contains(&facts["face_height_mm"].as_f64().unwrap()));
    let stages = facts["timings_ms"].as_object().unwrap();
    assert!(stages.contains_key("surface") && !stages.contains_key("deform"));
    assert!(facts["registration"]["iterations"].as_u64().is_some());
    for mesh in ["face.obj", "face.glb"] {
        let mesh = json(&bench.done(&format!("info out/{mesh}")).out);
        assert_eq!(mesh["vertices"], facts["vertices"], "{mesh}");
        assert_eq!((&mesh["has_uv"], &mesh["non_manifold_edges"]), (&true.into(), &0.into()));
        assert!(mesh["texture"]["width"].as_u64() >= Some(512), "{mesh}");
    }
    for name in ["coverage.png", "report.html", "cloud.ply", "matches.csv", "depth_left.png"] {
        assert!(bench.files("out").contains(&name.to_owned()), "{name}");
    }
    // a setting overrides the flag; the surface alone can be textured afterwards
    bench.done("reconstruct capture -o dots --surface --set surface.method=dots -q");
    let dots = json(&bench.text("dots/result.json"));
    assert_eq!(dots["params"]["surface"]["method"], "dots");
    assert!(dots["vertices"].as_u64() < facts["vertices"].as_u64());
    bench.done("surface capture -o alone.obj -q");
    bench.done("texture alone.obj --capture capture -o textured.glb --set texture.size=256 -q");
    assert_eq!(json(&bench.done("info textured.glb").out)["texture"]["width"], 256);
    bench.done("reconstruct capture -o camera --surface --frame camera -q");
    let between = json(&bench.done("compare alone.obj camera/face.obj --json").out);
    let median = between["before"]["first_to_second"]["median_mm"].as_f64().unwrap();
    assert!(median < 0.01, "{between}");
}

#[test]
fn any_number_of_threads_gives_the_same_surface() {
    let bench = Bench::new();
    for threads in [1, 2] {
        bench.done(&format!("reconstruct capture -o t{threads} --surface --threads {threads} -q"));
    }
    for name in ["face.obj", "face.glb", "texture.png", "coverage.png"] {
        assert!(bench.read(&format!("t1/{name}")) == bench.read(&format!("t2/{name}")), "{name}");
    }
}

#[test]
fn a_surface_that_cannot_be_registered_is_written_with_a_warning() {
    let bench = Bench::new();
    let strict = "--set register.max_residual=0.001";
    let ran = bench.done(&format!("reconstruct capture -o out --surface {strict} --json -q"));
    let facts = json(&ran.out);
    assert_eq!(facts["registration"], Value::Null);
    let warnings = facts["warnings"].to_string();
    assert!(warnings.contains("not in the model frame"), "{warnings}");
    assert!(warnings.contains("register"), "{warnings}");
    // upright, looking along +z, its middle at the origin
    let bounds = &json(&bench.done("info out/face.obj").out)["bounds"];
    let at = |k: usize, c: usize| bounds[k][c].as_f64().unwrap();
    assert!((0..3).all(|c| (at(0, c) + at(1, c)).abs() < 0.01), "{bounds}");
    let mesh = io::read_mesh(&bench.path("out/face.obj")).unwrap().mesh;
    let facing = mesh.vertex_normals().iter().filter(|n| n.z > 0.0).count();
    assert!(facing as f64 > 0.98 * mesh.vertices.len() as f64);
    // without --surface there is nothing to write
    let ran = bench.run(&format!("reconstruct capture -o none {strict} -q"));
    assert_eq!((ran.code, bench.files("none")), (1, Vec::new()), "{}", ran.err);
}

#[test]
fn without_calibration_it_is_in_model_units() {
    let bench = Bench::new();
    let text = bench.text("capture/capture.toml");
    let (before, _) = text.split_once("[rig]").unwrap();
    let after = text.split_once("[seeds]").map_or(String::new(), |(_, s)| format!("[seeds]{s}"));
    bench.write("capture/capture.toml", format!("{before}{after}"));
    for profile in ["precise", "facebuilder"] {
        let run =
            format!("reconstruct capture -o {profile} --profile {profile} --surface --json -q");
        let facts = json(&bench.done(&run).out);
        assert_eq!((&facts["metric"], &facts["face_width_mm"]), (&false.into(), &Value::Null));
        let mesh = json(&bench.done(&format!("info {profile}/face.obj")).out);
        assert_eq!((&mesh["has_uv"], &mesh["non_manifold_edges"]), (&true.into(), &0.into()));
        // the size of a head
        let span = |c: usize| {
            mesh["bounds"][1][c].as_f64().unwrap() - mesh["bounds"][0][c].as_f64().unwrap()
        };
        assert!((100.0..400.0).contains(&span(1)) && span(2) > 30.0, "{mesh}");
        let faces = io::read_mesh(&bench.path(&format!("{profile}/face.obj"))).unwrap().mesh;
        let facing = faces.vertex_normals().iter().filter(|n| n.z > 0.0).count();
        assert!(facing as f64 > 0.98 * faces.vertices.len() as f64, "{profile}");
    }
}

#[test]
fn points_without_a_surface_are_refused() {
    let bench = Bench::new();
    for (set, code, word) in [
        ("surface.max_edge=0.5", 2, "surface.max_edge"),
        ("surface.spacing=0", 2, "surface.spacing"),
        ("surface.method=mesh", 2, "dots"),
        ("surface.min_width=10 --set surface.max_tilt_deg=10", 1, "surface.max_tilt_deg (now 10)"),
    ] {
        let ran = bench.run(&format!("reconstruct capture -o out --surface --set {set} -q"));
        assert_eq!(ran.code, code, "{set}: {}", ran.err);
        assert!(ran.err.contains(word) && !ran.err.contains("panicked"), "{set}: {}", ran.err);
        assert!(bench.files("out").is_empty(), "{set}");
    }
}
