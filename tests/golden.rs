//! Golden meshes: the captures of the fixtures reconstructed with every method of deform and
//! smooth, compared with stored meshes and with the ground truth.
//!
//! `REGENERATE=1 cargo test -p facerecon-cli --test golden` rewrites the stored meshes; say in the
//! commit why they change.
#![allow(clippy::unwrap_used, clippy::panic)] // also the helpers of tests may stop a test
#![allow(clippy::print_stdout)] // the figures are of interest

#[path = "support/truth.rs"]
mod truth;

use std::path::{Path, PathBuf};

use facerecon_core::Params;
use facerecon_core::data::{Capture, Cloud, LANDMARKS, Pair};
use facerecon_core::io;
use facerecon_core::math::{Vec2, Vec3};
use facerecon_core::render::Frame;
use facerecon_core::{Reconstruction, reconstruct};
use facerecon_core::{output, template};

/// The stored meshes hold every 11th vertex, to keep them small.
const STRIDE: usize = 11;
/// Greatest distance of a vertex from its stored position. One machine always gives the same bytes;
/// the mathematics library of another differs in the last digit, which hundreds of iterations
/// amplify.
const TOLERANCE_MM: f64 = 0.02;

/// A run, with the bounds of its distance from the true face.
struct Case {
    capture: &'static str,
    /// Whether the 18 landmarks are marked in it.
    marked: bool,
    profile: &'static str,
    set: Vec<(String, String)>,
    name: String,
    median_mm: f64,
    p90_mm: f64,
}

impl Case {
    fn new(capture: &'static str, profile: &'static str, median_mm: f64, p90_mm: f64) -> Self {
        let name = format!("{capture}-{profile}");
        Self { capture, marked: false, profile, set: Vec::new(), name, median_mm, p90_mm }
    }

    fn set(mut self, parameter: &str, value: &str) -> Self {
        self.name = format!("{}-{value}", self.name);
        self.set.push((parameter.to_owned(), value.to_owned()));
        self
    }

    fn marked(mut self) -> Self {
        self.marked = true;
        self.name.push_str("-marked");
        self
    }

    fn run(&self) -> Reconstruction {
        let mut capture = read(self.capture);
        if self.marked {
            mark_landmarks(&mut capture, &fixtures().join(self.capture));
        }
        let params = Params::load(Some(self.profile), None, &self.set).unwrap();
        reconstruct(&capture, &template::built_in(), &params, &())
            .unwrap_or_else(|error| panic!("{}: {error}", self.name))
    }
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for deform in ["gaussian-rbf", "linear-rbf", "biharmonic-rbf"] {
        for smooth in ["none", "laplacian", "taubin"] {
            let case = Case::new("parallel", "facebuilder", 1.0, 2.2);
            cases.push(case.set("deform.method", deform).set("smooth.method", smooth));
        }
    }
    cases.push(Case::new("parallel", "facebuilder", 1.0, 2.2).marked());
    cases.push(Case::new("toed_in", "facebuilder", 1.0, 2.2));
    cases.push(Case::new("parallel", "precise", 0.12, 0.4));
    cases.push(Case::new("toed_in", "precise", 0.12, 0.4));
    cases
}

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures")
}

fn read(capture: &str) -> Capture {
    io::capture::read_capture(&fixtures().join(capture)).unwrap().capture
}

/// Marks the 18 landmarks at their true positions.
fn mark_landmarks(capture: &mut Capture, folder: &Path) {
    let text = std::fs::read_to_string(folder.join("truth.json")).unwrap();
    let truth: serde_json::Value = serde_json::from_str(&text).unwrap();
    for name in LANDMARKS {
        let at = |side: &str| {
            let xy = &truth["features"][name][side];
            Vec2::new(xy[0].as_f64().unwrap(), xy[1].as_f64().unwrap())
        };
        capture.landmarks.insert(name.to_owned(), Pair { left: at("left"), right: at("right") });
    }
}

fn sampled(found: &Reconstruction) -> Vec<Vec3> {
    found.mesh.vertices.iter().copied().step_by(STRIDE).collect()
}

fn stored(name: &str) -> PathBuf {
    fixtures().join("golden").join(format!("{name}.ply"))
}

fn regenerating() -> bool {
    std::env::var_os("REGENERATE").is_some_and(|v| v == "1")
}

/// The difference of a mesh from the stored one, if too large.
fn against_golden(name: &str, points: &[Vec3]) -> Option<String> {
    let file = stored(name);
    let golden = match io::read_points(&file) {
        Ok(golden) => golden.points,
        Err(error) => return Some(format!("{name}: {error}; make it with REGENERATE=1")),
    };
    if golden.len() != points.len() {
        let (got, expected) = (points.len(), golden.len());
        return Some(format!("{name}: {got} sampled vertices, {expected} are stored"));
    }
    let apart = golden.iter().zip(points).map(|(a, b)| (a - b).norm());
    let (worst, at) = apart.zip(0..).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let vertex: usize = at * STRIDE;
    // written so that NaN is a failure too
    (!(worst <= TOLERANCE_MM)).then(|| {
        format!("{name}: vertex {vertex} lies {worst:.4} mm from its stored position, at most {TOLERANCE_MM} is allowed")
    })
}

/// The bounds that a result violates.
fn against_truth(case: &Case, found: &Reconstruction) -> Vec<String> {
    let dots = truth::face_dots(&fixtures().join(case.capture));
    let score = truth::score(&dots, &output::match_rows(found, Frame::Camera));
    let d = truth::distances(&dots, &found.mesh_in(Frame::Camera));
    let name = &case.name;
    println!(
        "{name}: {} vertices, recall {:.3}, wrong {:.3}, median {:.3} mm, p90 {:.3} mm",
        found.mesh.vertices.len(),
        score.recall,
        score.wrong,
        d.median_mm,
        d.p90_mm
    );
    let mut failures = Vec::new();
    let mut require = |good: bool, what: String| {
        if !good {
            failures.push(format!("{name}: {what}"));
        }
    };
    require(dots.len() > 400, format!("only {} true dots on the face", dots.len()));
    require(score.recall >= 0.9, format!("{:.3} of the face's dots matched", score.recall));
    require(score.wrong <= 0.005, format!("{:.4} of the matches wrong", score.wrong));
    require(d.median_mm <= case.median_mm, format!("median {:.3} mm from the truth", d.median_mm));
    require(d.p90_mm <= case.p90_mm, format!("p90 {:.3} mm from the truth", d.p90_mm));
    failures
}

#[test]
fn meshes_are_as_stored_and_near_the_truth() {
    let mut failures = Vec::new();
    for case in cases() {
        let found = case.run();
        failures.extend(against_truth(&case, &found));
        let points = sampled(&found);
        if regenerating() {
            let comment = format!("every {STRIDE}th vertex, model frame, mm");
            let cloud = Cloud::from_points(points.clone());
            io::ply::write_cloud(&stored(&case.name), &cloud, &comment).unwrap();
        }
        failures.extend(against_golden(&case.name, &points));
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_stored_mesh_belongs_to_a_case() {
    let known: Vec<String> = cases().iter().map(|c| format!("{}.ply", c.name)).collect();
    for entry in std::fs::read_dir(fixtures().join("golden")).unwrap() {
        let file = entry.unwrap().file_name().into_string().unwrap();
        assert!(known.contains(&file), "fixtures/golden/{file} belongs to no case");
    }
}

#[test]
fn a_moved_vertex_is_noticed() {
    if regenerating() {
        return;
    }
    let name = "parallel-facebuilder-marked";
    let kept = io::read_points(&stored(name)).unwrap().points;
    let mut moved = kept.clone();
    moved[100].x += 2.0 * TOLERANCE_MM;
    assert_eq!(against_golden(name, &kept), None);
    assert!(against_golden(name, &kept[1..]).is_some());
    let vertex = format!("vertex {}", 100 * STRIDE);
    assert!(against_golden(name, &moved).is_some_and(|fault| fault.contains(&vertex)));
    moved[100].x = f64::NAN;
    assert!(against_golden(name, &moved).is_some());
    assert!(against_golden("no-such-case", &kept).is_some_and(|f| f.contains("REGENERATE")));
}

#[test]
fn marked_landmarks_save_registration_steps() {
    let bare = Case::new("parallel", "facebuilder", 0.0, 0.0).run().registration.unwrap();
    let marked =
        Case::new("parallel", "facebuilder", 0.0, 0.0).marked().run().registration.unwrap();
    assert!(!bare.from_landmarks && marked.from_landmarks);
    assert!(
        2 * marked.iterations < bare.iterations,
        "{} steps with the landmarks, {} without",
        marked.iterations,
        bare.iterations
    );
}
