//! Every command on a small capture, end to end.
#![allow(clippy::unwrap_used, clippy::panic)] // also the helpers of tests may stop a test

#[path = "support/cli.rs"]
mod cli;

use cli::Bench;
use serde_json::Value;

/// The files of a result (of a capture with a plain pair).
const RESULT: [&str; 14] = [
    "cloud.ply",
    "coverage.png",
    "depth_left.png",
    "depth_right.png",
    "distances.csv",
    "face.glb",
    "face.landmarks.toml",
    "face.mtl",
    "face.obj",
    "landmarks.csv",
    "matches.csv",
    "report.html",
    "result.json",
    "texture.png",
];

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error} in {text}"))
}

#[test]
fn reconstruct_writes_every_file_and_prints_the_result() {
    let bench = Bench::new();
    let ran = bench.done("reconstruct capture -o out --json --quiet");
    assert_eq!(ran.err, "");
    assert_eq!(bench.files("out"), RESULT);
    let facts = json(&ran.out);
    assert_eq!(facts, json(&bench.text("out/result.json")));
    assert_eq!(facts["metric"], true);
    assert_eq!(facts["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(facts["params"]["profile"], "precise");
    let table = bench.text("out/matches.csv");
    assert!(table.starts_with("id,xl,yl,xr,yr,disparity,x_mm,y_mm,z_mm,column,row,score\n"));
    assert_eq!(facts["matches"], table.lines().count() - 1);
    let stages = facts["timings_ms"].as_object().unwrap();
    for stage in ["rectify", "detect", "correspond", "refine", "register", "deform", "total"] {
        assert!(stages.contains_key(stage), "{stage} is not timed");
    }
    let landmarks = facts["landmarks"].as_array().unwrap();
    assert_eq!(landmarks.len(), 18);
    let table = bench.text("out/landmarks.csv");
    assert_eq!(table.lines().count(), 19, "{table}");
    // a length that rests on the template alone is not a measurement
    let known =
        |name: &str| landmarks.iter().any(|l| l["name"] == name && l["status"] != "template only");
    let both = known("ear_left_upper") && known("ear_right_upper");
    assert_eq!(facts["face_width_mm"].is_number(), both);
    for distance in facts["distances"].as_array().unwrap() {
        let measured =
            known(distance["from"].as_str().unwrap()) && known(distance["to"].as_str().unwrap());
        assert_eq!(distance["value_mm"].is_number(), measured, "{distance}");
        assert_eq!(distance["template_mm"].is_number(), !measured, "{distance}");
    }
    let level = facts["verdict"]["level"].as_str().unwrap();
    assert!(["good", "usable", "doubtful"].contains(&level), "{level}");
    assert!(facts["verdict"]["figures"]["measured_share"].as_f64().unwrap() > 0.5);
    bench.done("render out/face.glb --mode uncertainty -o sigma.png -q");
    assert!(
        bench.run("render out/face.obj --mode uncertainty -o no.png").err.contains("deviation")
    );
    let report = bench.text("out/report.html");
    for remote in ["src=\"http", "href=\"http", "url(http"] {
        assert!(!report.contains(remote), "the report needs the network: {remote}");
    }
    // both meshes are the same face
    for mesh in ["face.obj", "face.glb"] {
        let facts = json(&bench.done(&format!("info out/{mesh}")).out);
        assert_eq!((&facts["kind"], &facts["has_uv"]), (&"mesh".into(), &true.into()), "{mesh}");
        assert!(facts["texture"]["width"].as_u64() >= Some(512), "{mesh}: {facts}");
        assert_eq!(facts["non_manifold_edges"], 0, "{mesh}");
    }
    let between = json(&bench.done("compare out/face.obj out/face.glb --json").out);
    assert!(between["before"]["first_to_second"]["max_mm"].as_f64().unwrap() < 0.01, "{between}");
}

#[test]
fn frames_stages_and_progress_are_as_requested() {
    let bench = Bench::new();
    let ran =
        bench.done("reconstruct capture -o out --profile facebuilder --frame camera --keep-stages");
    assert_eq!(ran.out, "");
    for stage in ["rectify", "detect", "correspond", "register", "deform", "smooth", "texture"] {
        assert!(ran.err.contains(stage), "no line of {stage}:\n{}", ran.err);
    }
    let kept = bench.files("out/stages").join(" ");
    for picture in ["filter", "detect", "deform"] {
        assert!(kept.contains(picture), "{picture} is not among {kept}");
    }
    // one metre away, in the camera frame
    let bounds = &json(&bench.done("info out/face.obj").out)["bounds"];
    assert!(bounds[0][2].as_f64().unwrap() > 1000.0, "{bounds}");
    // the methods of the profile, and a single setting
    let facts = json(&bench.text("out/result.json"));
    assert_eq!(facts["params"]["correspond"]["method"], "scan");
    bench.done("reconstruct capture -o mixed --set correspond.method=scan -q");
    let facts = json(&bench.text("mixed/result.json"));
    assert_eq!(facts["params"]["correspond"]["method"], "scan");
    assert_eq!(facts["params"]["deform"]["method"], "nicp");
}

#[test]
fn photos_can_be_given_one_by_one() {
    let bench = Bench::new();
    bench.done(
        "reconstruct --left capture/left_dots.png --right capture/right_dots.png \
         --calibration capture/calibration.yml --columns 64 --rows 48 -o out -q",
    );
    let names = bench.files("out");
    assert!(!names.contains(&"texture.png".to_owned()), "a texture without a plain pair");
    let facts = json(&bench.text("out/result.json"));
    let warnings = facts["warnings"].to_string();
    assert!(warnings.contains("no texture"), "{warnings}");
    assert_eq!(facts["metric"], true);
    // the plain pair by its present and by its earlier option
    for name in ["plain", "texture"] {
        bench.done(&format!(
            "reconstruct --left capture/left_dots.png --right capture/right_dots.png \
             --left-{name} capture/left_plain.png --right-{name} capture/right_plain.png \
             --calibration capture/calibration.yml --columns 64 --rows 48 -o {name} -q"
        ));
        assert_eq!(bench.files(name), RESULT);
    }
    assert_eq!(bench.read("plain/texture.png"), bench.read("texture/texture.png"));
}

#[test]
fn warnings_are_in_the_result_and_printed_once() {
    let bench = Bench::new();
    bench.bring("toed_in", "moved");
    bench.bring("parallel", "bare");
    let text = bench.text("capture/capture.toml");
    bench.write("capture/capture.toml", format!("{text}\n[colour]\nvalue = 1\n"));
    let (before, after) = text.split_once("[rig]").unwrap();
    let seeds = after.split_once("[seeds]").unwrap().1;
    bench.write("bare/capture.toml", format!("{before}[seeds]{seeds}"));
    let kernel = "--set filter.kernel=[0,0,0,0,1.5,0,0,0,0]";
    for (arguments, parts) in [
        // a table that the reader does not know, a kernel that brightens, a low resolution
        (format!("capture --profile facebuilder {kernel}"), &["colour", "kernel", "768"][..]),
        // the head moved between the dotted and the plain pair
        ("moved".to_owned(), &["moved by"]),
        ("bare".to_owned(), &["calibrat"]),
    ] {
        let ran = bench.done(&format!("reconstruct {arguments} -o out"));
        let facts = json(&bench.text("out/result.json"));
        let all = facts["warnings"].as_array().unwrap().iter().map(|w| w.as_str().unwrap());
        let warnings: Vec<&str> = all.collect();
        for part in parts {
            assert!(warnings.iter().any(|w| w.contains(part)), "{part} is not in {warnings:?}");
        }
        for warning in warnings {
            assert_eq!(ran.err.matches(warning).count(), 1, "{warning} in\n{}", ran.err);
        }
    }
    // a single stage prints its warnings too
    let filter = format!("filter capture/left_dots.png -o binary.png {kernel}");
    let ran = bench.done(&filter);
    assert_eq!(ran.err.matches("warning:").count(), 1, "{}", ran.err);
    assert_eq!(bench.done(&format!("{filter} -q")).err, "");
}

#[test]
fn stripes_are_summarised_as_stripes() {
    let bench = Bench::new();
    bench.done(
        "simulate -o stripes --set width_px=512 --set height_px=384 --set focal_px=1844 \
         --set sensor_shift=1 --set dot_mm=6 --set pattern.kind=stripes --set pattern.columns=64 \
         --set pattern.rows=48 -q",
    );
    let ran = bench.done("reconstruct stripes -o out");
    let facts = json(&bench.text("out/result.json"));
    let summary = format!("{} points on stripe edges were matched", facts["matches"]);
    assert!(ran.err.contains(&summary) && !ran.err.contains("dots were found"), "{}", ran.err);
}

#[test]
fn the_stages_run_one_by_one() {
    let bench = Bench::new();
    for step in ["equalize", "sharpen", "threshold", "thin"] {
        let set = if step == "equalize" { "--set filter.equalize=global" } else { "" };
        let out = format!("{step}.png");
        bench.done(&format!("filter capture/left_dots.png -o {out} --step {step} {set} -q"));
        let facts = json(&bench.done(&format!("info {out}")).out);
        assert_eq!((&facts["width"], &facts["height"]), (&512.into(), &384.into()), "{step}");
    }
    assert_ne!(bench.read("sharpen.png"), bench.read("threshold.png"));
    assert_ne!(bench.read("thin.png"), bench.read("threshold.png"));

    let dots = bench.done(
        "detect capture/left_dots.png -o dots.csv --picture dots.png --profile facebuilder --json -q",
    );
    let count = json(&dots.out)["dots"].as_u64().unwrap();
    assert!(count > 600, "{count} dots");
    assert_eq!(bench.text("dots.csv").lines().count() as u64, count + 1);

    let found = bench.done("correspond capture -o matches.csv --profile facebuilder --json -q");
    bench.done("match capture -o again.csv --profile facebuilder -q");
    assert_eq!(bench.read("matches.csv"), bench.read("again.csv"), "match is an alias");
    let matches = json(&found.out)["matches"].as_u64().unwrap();
    assert!(matches > 500, "{matches} matches");
    bench.done("triangulate matches.csv --capture capture -o cloud.ply -q");
    let pose = bench.done("register cloud.ply -o registered.ply --profile facebuilder --json -q");
    assert_eq!(json(&pose.out), json(&bench.text("registered.json")));
    bench.done("deform registered.ply -o deformed.obj --profile facebuilder -q");
    bench
        .done("smooth deformed.obj -o face.ply --set smooth.method=taubin --set smooth.steps=3 -q");

    bench.done("texture face.ply --capture capture -o textured.glb --pose registered.json -q");
    let facts = bench.done("smooth deformed.obj -o again.obj --json -q").out;
    assert_eq!(json(&facts)["wrote"], serde_json::json!(["again.obj"]), "{facts}");

    // the same face as by reconstruct, up to smoothing and pose
    bench.done("reconstruct capture -o out --profile facebuilder -q");
    let between = json(&bench.done("compare face.ply out/face.obj --json").out);
    let median = between["after"]["first_to_second"]["median_mm"].as_f64().unwrap();
    assert!(median < 0.5, "{between}");

    bench.done("reconstruct capture -o camera --profile facebuilder --frame camera -q");
    bench.done(
        "texture camera/face.obj --capture capture -o coloured.glb --set texture.size=256 -q",
    );
    assert_eq!(json(&bench.done("info coloured.glb").out)["texture"]["width"], 256);
}

#[test]
fn renderings_comparisons_and_conversions() {
    let bench = Bench::new();
    bench.done("template export head-coarse -o head.obj -q");
    bench.done("template export head -o full.obj -q");
    assert!(bench.text("head.landmarks.toml").contains("nose_tip"));
    let facts = json(&bench.done("info head.obj").out);
    for format in ["ply", "glb", "stl"] {
        bench.done(&format!("convert head.obj head.{format} -q"));
        let other = json(&bench.done(&format!("info head.{format}")).out);
        assert_eq!(other["faces"], facts["faces"], "{format}");
    }
    for mode in ["shaded", "wireframe", "heat"] {
        bench.done(&format!(
            "render head.obj --view front,profile --mode {mode} --against full.obj --size 96 -o {mode}.png -q"
        ));
        let facts = json(&bench.done(&format!("info {mode}.png")).out);
        assert!(facts["width"].as_u64() >= Some(192), "{mode}: {facts}");
    }
    let table = bench.done("compare head.obj full.obj").out;
    assert!(table.contains("before alignment") && table.contains("after alignment"), "{table}");
}

#[test]
fn patterns_simulations_and_lists() {
    let bench = Bench::new();
    bench.done("pattern -o pattern.png --set columns=40 --set rows=30 --set rotation_deg=7.125 -q");
    assert_eq!(json(&bench.done("info pattern.png").out)["width"], 1024);
    assert!(bench.done("pattern -o x.png --set help").out.contains("rotation_deg"));

    let small = "--set width_px=160 --set height_px=120 --set focal_px=560 --set sensor_shift=1 \
                 --set pattern.columns=20 --set pattern.rows=15 --set dot_mm=20";
    bench.done(&format!("simulate -o made {small} -q"));
    let facts = json(&bench.done("info made").out);
    assert_eq!(facts["kind"], "capture");
    assert_eq!((&facts["calibrated"], &facts["plain_pair"]), (&true.into(), &true.into()));
    for truth in ["truth_mesh.ply", "truth_dots.csv", "truth_depth.npy", "truth.json"] {
        assert!(bench.files("made").contains(&truth.to_owned()), "{truth}");
    }
    let facts = json(&bench.done("info made/calibration.yml").out);
    assert!((facts["baseline_mm"].as_f64().unwrap() - 150.0).abs() < 1e-6, "{facts}");

    bench.done("new fresh -q");
    assert!(bench.text("fresh/capture.toml").contains("[images]"));
    let again = bench.run("new fresh");
    assert_eq!(again.code, 2, "{}", again.err);
    assert!(again.err.contains("not overwritten"));

    let list = bench.done("template list").out;
    assert!(list.contains("head-coarse") && list.contains("ict"), "{list}");
    assert!(bench.done("completions bash").out.contains("facerecon"));
    assert!(bench.done("--help").out.contains("reconstruct"));
    assert!(bench.done("--version").out.contains(env!("CARGO_PKG_VERSION")));
}

#[test]
fn check_reports_what_to_improve() {
    let bench = Bench::new();
    let report = bench.done("check capture").out;
    // smaller than the thesis requires
    assert!(report.contains("WARNING") && report.contains("768"), "{report}");
    let facts = json(&bench.done("check capture --json").out);
    assert_eq!(facts["good"], false);
    assert!(facts["findings"].as_array().is_some_and(|f| f.len() >= 4), "{facts}");
}

#[test]
fn printed_parameters_can_be_read_again() {
    let bench = Bench::new();
    let toml = bench.done("params --profile facebuilder --set smooth.steps=2").out;
    bench.write("mine.toml", &toml);
    assert_eq!(bench.done("params --config mine.toml").out, toml);
    bench.done("reconstruct capture -o out --config mine.toml -q");
    let facts = json(&bench.text("out/result.json"));
    assert_eq!(facts["params"]["profile"], "facebuilder");
    assert_eq!(facts["params"]["smooth"]["steps"], 2);
}

#[test]
fn batch_continues_after_a_failure_and_repeats_nothing() {
    let bench = Bench::new();
    for name in ["many/a", "many/b", "many/broken"] {
        bench.bring("parallel", name);
    }
    bench.write("many/broken/left_dots.png", "no picture");
    let arguments = "batch many -o results --profile facebuilder --json -q";
    let status = |ran: &cli::Ran| -> Vec<String> {
        let outcomes = json(&ran.out);
        let all = outcomes.as_array().unwrap().iter();
        all.map(|o| o["status"].as_str().unwrap().to_owned()).collect()
    };
    let first = bench.run(arguments);
    assert_eq!(first.code, 1);
    assert!(first.err.contains("1 of 3"), "{}", first.err);
    assert_eq!(status(&first), ["done", "done", "failed"]);
    let before = bench.text("results/a/result.json");

    bench.bring("parallel", "many/broken");
    bench.edit("many/b/capture.toml", "columns = 64", "columns = 65");
    let second = bench.done(arguments);
    assert_eq!(status(&second), ["kept", "done", "done"]);
    assert_eq!(bench.text("results/a/result.json"), before, "done twice");
    assert_eq!(bench.text("results/batch.csv").lines().count(), 4);
    assert!(bench.text("results/batch.html").contains("a/report.html"));
}

#[test]
fn the_demo_needs_no_input_and_reports_its_error() {
    let bench = Bench::new();
    let facts = json(&bench.done("demo -o out --json -q").out);
    let median = facts["error_mm"]["median_mm"].as_f64().unwrap();
    assert!(median < 0.3, "{median} mm from the truth");
    let files = bench.files("out");
    for name in RESULT.iter().chain(&["picture.png", "capture"]) {
        assert!(files.iter().any(|f| f == name), "{name}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let bench = Bench::new();
    bench.bring("toed_in", "toed_in");
    for (capture, profile) in
        [("capture", "facebuilder"), ("capture", "precise"), ("toed_in", "precise")]
    {
        let out = |threads: u8| format!("{capture}-{profile}-{threads}");
        for threads in [1, 2] {
            let to = out(threads);
            bench.done(&format!(
                "reconstruct {capture} -o {to} --profile {profile} --threads {threads} -q"
            ));
        }
        for name in RESULT.iter().filter(|n| !["result.json", "report.html"].contains(n)) {
            let [one, two] = [1, 2].map(|t| bench.read(&format!("{}/{name}", out(t))));
            assert!(one == two, "{capture}, {profile}: {name} differs");
        }
        let [one, two] = [1, 2].map(|t| {
            let mut facts = json(&bench.text(&format!("{}/result.json", out(t))));
            facts.as_object_mut().unwrap().remove("timings_ms");
            // the report without its times
            let report = bench.text(&format!("{}/report.html", out(t)));
            let times = [" ms</td>", "The run took", "for all stages"];
            let timed = |line: &&str| times.iter().any(|t| line.contains(t));
            let untimed: Vec<_> = report.lines().filter(|l| !timed(l)).map(str::to_owned).collect();
            (facts, untimed)
        });
        assert_eq!(one.0, two.0, "{capture}, {profile}");
        assert!(one.1 == two.1, "{capture}, {profile}: report.html differs");
    }
}
