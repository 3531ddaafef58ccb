//! Bad input: the message names the file or the stage, the exit code is right, and no file is left
//! incomplete.
#![allow(clippy::unwrap_used, clippy::panic)] // also the helpers of tests may stop a test

#[path = "support/cli.rs"]
mod cli;

use cli::Bench;
use facerecon_core::data::Raster;
use facerecon_core::io;

/// Runs a command that must fail with `code`, with all `parts` in the message and no folder `out`.
fn refused(bench: &Bench, arguments: &str, code: i32, parts: &[&str]) {
    let ran = bench.run(arguments);
    assert_eq!(ran.code, code, "facerecon {arguments}\n{}{}", ran.out, ran.err);
    for part in parts {
        assert!(ran.err.contains(part), "facerecon {arguments}: no {part:?} in\n{}", ran.err);
    }
    assert!(!ran.err.contains("panicked"), "{}", ran.err);
    assert_eq!(ran.out, "", "facerecon {arguments}: a result despite the error");
    assert_eq!(bench.files("out"), [] as [&str; 0], "facerecon {arguments} left files behind");
}

const RECONSTRUCT: &str = "reconstruct capture -o out --profile facebuilder -q";
const PRECISE: &str = "reconstruct capture -o out -q";

#[test]
fn wrong_usage_has_exit_code_two() {
    let bench = Bench::new();
    for (arguments, words) in [
        ("", &["Usage"][..]),
        ("reconstrukt capture", &["reconstrukt"]),
        ("reconstruct capture", &["--output"]),
        ("reconstruct -o out", &["--left"]),
        ("reconstruct capture -o out --set smoth.steps=3", &["smoth"]),
        ("reconstruct capture -o out --set smooth.steps", &["NAME=VALUE"]),
        ("reconstruct capture -o out --set smooth.lambda=7", &["smooth.lambda", "7"]),
        ("reconstruct capture -o out --set smooth.lambda=nan", &["smooth.lambda"]),
        ("reconstruct capture -o out --set detect.method=magic", &["magic"]),
        ("reconstruct capture -o out --profile best", &["best", "facebuilder"]),
        ("simulate -o out --set baseline_mm=-5", &["baseline_mm"]),
        ("simulate -o out --set baselin=5", &["baselin"]),
        ("pattern -o out/p.png --set columns=1", &["columns"]),
        ("template export haed -o out/h.obj", &["haed"]),
        ("render capture/left_dots.png --view behind -o out/p.png", &["behind", "front"]),
        ("render capture/left_dots.png --mode nice -o out/p.png", &["nice", "shaded"]),
        ("info", &["FILE"]),
        ("info capture --threads 0", &["--threads"]),
        ("info capture --threads 100000", &["--threads"]),
        ("pattern -o out/p.jpg", &["out/p.jpg", ".png"]),
        ("pattern -o out/p.png --set dots=9", &["dots", "pattern --set help"]),
        ("render capture/left_dots.png -o out/p.gif", &["out/p.gif", ".png"]),
    ] {
        refused(&bench, arguments, 2, words);
    }
}

#[test]
fn missing_and_unreadable_files_are_named() {
    let bench = Bench::new();
    refused(&bench, "reconstruct nowhere -o out", 1, &["nowhere"]);
    std::fs::create_dir(bench.path("empty")).unwrap();
    refused(&bench, "check empty", 1, &["empty", "facerecon new"]);
    bench.write("mine.toml", "a = [");
    refused(&bench, "reconstruct capture -o out --config mine.toml", 2, &["mine.toml", "line 1"]);
    std::fs::remove_file(bench.path("mine.toml")).unwrap();
    refused(&bench, "reconstruct capture -o out --config mine.toml", 1, &["mine.toml"]);
    refused(&bench, "reconstruct capture -o out --template h.obj", 1, &["h.obj"]);
    refused(&bench, "triangulate no.csv --capture capture -o out/c.ply", 1, &["no.csv"]);
    refused(&bench, "register no.ply -o out/r.ply", 1, &["no.ply"]);
    refused(&bench, "info no.obj", 1, &["no.obj"]);
    refused(&bench, "convert capture/capture.toml out/m.ply", 1, &["capture.toml"]);

    let photo = bench.read("capture/right_dots.png");
    bench.write("capture/right_dots.png", &photo[..photo.len() / 2]);
    refused(&bench, RECONSTRUCT, 1, &["right_dots.png"]);
    bench.write("capture/right_dots.png", "no picture");
    refused(&bench, RECONSTRUCT, 1, &["right_dots.png"]);
    std::fs::remove_file(bench.path("capture/right_dots.png")).unwrap();
    refused(&bench, RECONSTRUCT, 1, &["right_dots.png"]);
}

#[test]
fn a_broken_capture_file_is_named_with_its_fault() {
    let bench = Bench::new();
    let text = bench.text("capture/capture.toml");
    for (from, to, part) in [
        ("[images]", "[images", "line 1"),
        ("columns = 64", "columns = -3", "line 9"),
        // the misspelt table is ignored with a warning, so the columns are missing
        ("[pattern]", "[patern]", "columns"),
        ("left_dots.png", "../../left_dots.png", "outside"),
        ("left = \"left_dots.png\"", "", "left"),
    ] {
        bench.write("capture/capture.toml", &text);
        bench.edit("capture/capture.toml", from, to);
        refused(&bench, RECONSTRUCT, 1, &["capture.toml", part]);
    }
}

#[test]
fn an_unknown_table_of_a_capture_file_is_a_warning() {
    let bench = Bench::new();
    let text = bench.text("capture/capture.toml");
    bench.write("capture/capture.toml", format!("{text}\n[patern]\ncolumns = 64\n"));
    for command in ["info capture", "check capture --json -q"] {
        let facts: serde_json::Value = serde_json::from_str(&bench.done(command).out).unwrap();
        assert!(facts["warnings"].to_string().contains("patern"), "{command}: {facts}");
    }
    assert!(bench.done("check capture").err.contains("patern"));
}

#[test]
fn photos_of_different_sizes_are_refused_with_both_sizes() {
    let bench = Bench::new();
    let file = bench.path("capture/right_dots.png");
    let photo = io::image::read_rgb(&file).unwrap();
    let smaller = Raster::from_fn(photo.width() - 12, photo.height(), |x, y| photo.at(x, y));
    io::image::write_png(&file, &smaller).unwrap();
    refused(&bench, RECONSTRUCT, 1, &["512x384", "500x384", "right_dots.png"]);
}

#[test]
fn photos_without_dots_are_refused_by_the_detection() {
    let bench = Bench::new();
    let black = Raster::filled(512, 384, [0u8; 3]);
    io::image::write_png(&bench.path("capture/left_dots.png"), &black).unwrap();
    refused(&bench, RECONSTRUCT, 1, &["detect", "0 dots", "at least"]);
    refused(&bench, PRECISE, 1, &["detect", "at least"]);
    refused(&bench, "detect capture/left_dots.png -o out/d.csv -q", 1, &["detect"]);
    let ran = bench.run("check capture");
    assert!(ran.code == 1 && ran.out.contains("FAULT"), "{}{}", ran.out, ran.err);
    assert!(ran.err.contains("cannot be reconstructed"), "{}", ran.err);
    // the plain photo given by mistake
    bench.bring("parallel", "capture");
    bench.edit("capture/capture.toml", "\"right_dots.png\"", "\"right_plain.png\"");
    let ran = bench.run(PRECISE);
    assert_eq!((ran.code, bench.files("out").len()), (1, 0), "{}", ran.err);
}

#[test]
fn photos_that_do_not_belong_together_are_never_called_good() {
    let bench = Bench::new();
    let text = bench.text("capture/capture.toml");
    for (from, to, words) in [
        ("\"right_dots.png\"", "\"left_dots.png\"", "same picture"),
        ("\"left_plain.png\"", "\"left_dots.png\"", "pattern's contrast"),
    ] {
        bench.write("capture/capture.toml", &text);
        bench.edit("capture/capture.toml", from, to);
        let checked = bench.run("check capture");
        assert!(checked.out.contains(words), "{}{}", checked.out, checked.err);
        let ran = bench.run("reconstruct capture -o out --json -q");
        assert!(ran.code == 1 || ran.out.contains("doubtful"), "{from}: {}", ran.out);
    }
}

#[test]
fn seeds_off_any_dot_are_named() {
    let bench = Bench::new();
    let text = bench.text("capture/capture.toml");
    let seeds = text.find("[seeds]").unwrap();
    let off = "[seeds]\nhead = { left = [5.0, 5.0], right = [6.0, 5.0] }\n\
               left_ear = { left = [150.0, 170.0], right = [160.0, 170.0] }\n\
               right_ear = { left = [340.0, 170.0], right = [350.0, 170.0] }\n";
    bench.write("capture/capture.toml", format!("{}{off}", &text[..seeds]));
    refused(&bench, RECONSTRUCT, 1, &["correspond", "seed head", "px"]);
    bench.write("capture/capture.toml", &text[..seeds]);
    refused(&bench, RECONSTRUCT, 1, &["correspond", "[seeds]"]);
}

#[test]
fn a_corrupted_calibration_is_named() {
    let bench = Bench::new();
    let good = bench.text("capture/calibration.yml");
    for broken in ["%YAML:1.0\n---\nK1: nonsense\n", "", "\u{0}\u{1}", &good[..good.len() / 2]] {
        bench.write("capture/calibration.yml", broken);
        refused(&bench, RECONSTRUCT, 1, &["calibration.yml"]);
        refused(&bench, "info capture/calibration.yml", 1, &["calibration.yml"]);
    }
    std::fs::remove_file(bench.path("capture/calibration.yml")).unwrap();
    refused(&bench, PRECISE, 1, &["calibration.yml"]);
}

#[test]
fn swapped_photos_and_points_of_no_face_are_refused() {
    let bench = Bench::new();
    bench.edit("capture/capture.toml", "left_dots.png", "swap.png");
    bench.edit("capture/capture.toml", "right_dots.png", "left_dots.png");
    bench.edit("capture/capture.toml", "swap.png", "right_dots.png");
    let ran = bench.run(PRECISE);
    assert_eq!((ran.code, bench.files("out").len()), (1, 0), "{}", ran.err);
    // the results of the stages before the failure, and nothing else
    let ran = bench.run("reconstruct capture -o kept --keep-stages");
    assert!(ran.code == 1 && ran.err.contains("kept/stages"), "{}", ran.err);
    assert_eq!(bench.files("kept"), ["stages"]);
    let kept = bench.files("kept/stages").join(" ");
    assert!(kept.contains("rectify_left.png") && kept.contains("detect_right_dots.ply"), "{kept}");

    // a straight line is no face
    let line: String = (0..200).map(|i| format!("{i},{i},{i}\n")).collect();
    bench.write("line.csv", format!("x,y,z\n{line}"));
    refused(&bench, "register line.csv -o out/r.ply -q", 1, &["register"]);
    refused(&bench, "register line.csv -o out/r.ply --profile facebuilder -q", 1, &["register"]);
    bench.write("few.csv", "x,y,z\n0,0,900\n1,0,900\n0,1,900\n");
    refused(&bench, "register few.csv -o out/r.ply -q", 1, &["register", "3 points"]);
    bench.write("nan.csv", "x,y,z\nnan,0,900\n");
    refused(&bench, "register nan.csv -o out/r.ply -q", 1, &["line 2"]);
}

#[test]
fn a_wrongly_marked_landmark_is_named() {
    let bench = Bench::new();
    let text = bench.text("capture/capture.toml");
    let marked = "\n[landmarks]\nnose_tip = { left = [1.0, 2.0], right = [500.0, 300.0] }\n";
    bench.write("capture/capture.toml", format!("{text}{marked}"));
    refused(&bench, PRECISE, 1, &["triangulate", "feature nose_tip", "px"]);
}

#[test]
fn a_mesh_out_of_view_is_not_textured() {
    let bench = Bench::new();
    bench.done("template export head-coarse -o head.obj -q");
    let texture = "texture head.obj --capture capture -o out/t.obj -q";
    refused(&bench, texture, 1, &["texture", "of the mesh's 846", "--pose"]);
    bench.write("pose.json", "{ \"model_from_data\": 5 }");
    refused(&bench, &format!("{texture} --pose pose.json"), 1, &["pose.json", "register"]);
}

#[test]
fn a_template_must_give_its_unit_and_its_landmarks() {
    let bench = Bench::new();
    bench.done("template export head-coarse -o mine.obj -q");
    let sidecar = bench.text("mine.landmarks.toml");
    std::fs::remove_file(bench.path("mine.landmarks.toml")).unwrap();
    let mine = format!("{RECONSTRUCT} --template mine.obj");
    refused(&bench, &mine, 1, &["mine.obj", "unit"]);
    bench.write("mine.landmarks.toml", "unit = \"mm\"\n");
    let marked = "\n[landmarks]\nnose_tip = { left = [250.0, 200.0], right = [260.0, 200.0] }\n";
    let text = bench.text("capture/capture.toml");
    bench.write("capture/capture.toml", format!("{text}{marked}"));
    refused(&bench, &mine, 1, &["template mine", "landmarks"]);
    bench.write("mine.landmarks.toml", sidecar.replace("nose_tip", "nose_tipp"));
    let ran = bench.run(&mine);
    assert!(ran.code != 0 && ran.err.contains("nose_tipp"), "{}", ran.err);
    // without marked landmarks a template needs none
    bench.write("mine.landmarks.toml", "unit = \"mm\"\n");
    bench.write("capture/capture.toml", text);
    bench.done(&mine.replace("out", "bare"));
}

#[test]
fn a_result_that_cannot_be_written_is_an_error() {
    let bench = Bench::new();
    bench.write("out", "a file where the folder should be");
    let ran = bench.run(RECONSTRUCT);
    assert_eq!(ran.code, 1, "{}", ran.err);
    assert!(ran.err.contains("out"), "{}", ran.err);
    assert_eq!(bench.text("out"), "a file where the folder should be");
    refused(&Bench::new(), "convert capture/calibration.yml x.xyz", 1, &["calibration.yml"]);
}
