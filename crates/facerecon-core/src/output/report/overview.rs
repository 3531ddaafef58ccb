//! The head of the page: the numbers, the face, the photographs, the depth maps.

use super::numbers;
use super::page::{Fact, Page, RowBuilder, Section, Time, VerdictBox};
use super::pictures::{MAX_PHOTO_WIDTH, block_size, drawn, scaled_down};
use super::summary::{summary, total_ms};
use super::{marks, plots};
use crate::data::{Capture, PatternKind, Rgb};
use crate::math::{Vec2, percentile};
use crate::output::{Kept, Record};
use crate::pipeline::{FaceVerdict, Reconstruction};
use crate::render::{Mode, Scene, Studio, View, disparity_color};

/// Bins of the histograms: narrow enough to show the two peaks of face and background.
const HISTOGRAM_BINS: usize = 40;

/// The page of a run with its sections.
pub(super) fn page(
    capture: &Capture,
    result: &Reconstruction,
    verdict: FaceVerdict,
    sections: Vec<Section>,
) -> Page {
    let (width, height) = capture.left.size();
    let pattern = &capture.pattern;
    let projected = match pattern.kind {
        PatternKind::Dots => format!("{} x {} dots", pattern.columns, pattern.rows),
        PatternKind::Stripes => format!("{} stripes", pattern.columns),
    };
    let profile = result.params.profile;
    let version = env!("CARGO_PKG_VERSION");
    let longest_ms = result.timings_ms.iter().map(|t| t.1).fold(1e-9, f64::max);
    let times = result.timings_ms.iter().map(|(stage, ms)| Time {
        stage: stage.clone(),
        ms: format!("{ms:.0}"),
        percent: format!("{:.1}", 100.0 * ms / longest_ms),
    });
    Page {
        subtitle: format!(
            "Photos of {width} x {height} pixels, pattern of {projected}; profile {profile}; \
             facerecon {version}."
        ),
        verdict: verdict_box(verdict),
        facts: facts(result),
        landmarks: numbers::landmarks(result),
        distances: numbers::distances(result),
        summary: summary(result),
        warnings: result.warnings.clone(),
        sections,
        times: times.collect(),
        total_ms: format!("{:.0}", total_ms(result)),
        // A struct of plain numbers always has a TOML form; without one the report leaves it out.
        params: toml::to_string(&result.params).unwrap_or_default(),
    }
}

fn verdict_box(verdict: FaceVerdict) -> VerdictBox {
    VerdictBox {
        level: verdict.level.to_string(),
        reasons: verdict.reasons.into_iter().map(|r| r.text).collect(),
    }
}

fn facts(result: &Reconstruction) -> Vec<Fact> {
    let mut facts = vec![
        Fact { value: result.matches.len().to_string(), name: "matches" },
        Fact { value: result.cloud.len().to_string(), name: "points measured" },
        Fact { value: result.mesh.vertices.len().to_string(), name: "vertices of the face" },
    ];
    let size = result.face_size().unwrap_or_default();
    for (length, name) in [(size.width_mm, "ear to ear"), (size.height_mm, "nose saddle to chin")] {
        facts.extend(length.map(|mm| Fact { value: format!("{mm:.1} mm"), name }));
    }
    let seconds = total_ms(result) / 1000.0;
    facts.push(Fact { value: format!("{seconds:.1} s"), name: "for all stages" });
    facts
}

/// The sections before those of the stages. `shaded` is the finished mesh.
pub(super) fn sections(
    capture: &Capture,
    result: &Reconstruction,
    record: &Record,
    verdict: &FaceVerdict,
    shaded: Option<&Studio<'_>>,
) -> Vec<Section> {
    let mut sections = vec![face(result, shaded)];
    sections.extend(measured(result, verdict));
    sections.extend([photos(capture, result, record), depth(result)]);
    sections
}

fn face(result: &Reconstruction, shaded: Option<&Studio<'_>>) -> Section {
    let views = [
        (View::Front, "from the front"),
        (View::ThreeQuarter, "three-quarter"),
        (View::Profile, "in profile"),
    ];
    let mut row = RowBuilder::new(3);
    if let Some(texture) = &result.texture {
        let scene = Scene { texture: Some(&texture.image), ..Scene::new(&result.mesh) };
        let textured = Studio::new(&scene, Mode::Textured).ok();
        for (view, name) in views {
            row.picture(drawn(textured.as_ref(), view), name);
        }
    }
    for (view, name) in views {
        row.picture(drawn(shaded, view), format!("{name}, shape only"));
    }
    Section::new("The face", vec![row])
}

/// The standard deviations on the mesh, and what was not measured.
fn measured(result: &Reconstruction, verdict: &FaceVerdict) -> Option<Section> {
    let mesh = &result.mesh;
    let studio = Studio::new(&Scene::new(mesh), Mode::Uncertainty).ok()?;
    let share = verdict.figures.measured_share;
    let of_face = share.map_or(String::new(), |s| format!("{:.0} % of the face and ", 100.0 * s));
    let count = mesh.measured.iter().filter(|m| **m).count();
    let all = 100.0 * count as f64 / mesh.vertices.len().max(1) as f64;
    let mut row = RowBuilder::new(3);
    for (view, name) in [
        (View::Front, "from the front"),
        (View::ThreeQuarter, "three-quarter"),
        (View::Profile, "in profile"),
    ] {
        let caption = format!(
            "{name}: standard deviation of measured vertices in mm; grey was not measured \
             ({of_face}{all:.0} % of the vertices were)"
        );
        row.picture(drawn(Some(&studio), view), caption);
    }
    Some(Section::new("What was measured", vec![row]))
}

fn photos(capture: &Capture, result: &Reconstruction, record: &Record) -> Section {
    let disparities: Vec<f64> = result.matches.iter().map(|m| m.disparity()).collect();
    let mut pictures = RowBuilder::new(2);
    for side in [Side::Left, Side::Right] {
        let (image, caption) = marked_photo(side, capture, result, record, &disparities);
        pictures.picture(image, caption);
    }
    let sigmas: Vec<f64> = result.matches.iter().map(|m| m.sigma_px).filter(|s| *s > 0.0).collect();
    let mut histograms = RowBuilder::new(2);
    histograms.plot(plots::histogram("Disparity", "disparity, px", &disparities, HISTOGRAM_BINS));
    histograms.plot(plots::histogram(
        "Uncertainty of the disparity",
        "standard deviation, px",
        &sigmas,
        HISTOGRAM_BINS,
    ));
    Section::new("Photographs, dots and matches", vec![pictures, histograms])
}

#[derive(Clone, Copy)]
enum Side {
    Left,
    Right,
}

/// A dotted photo with the dots found and the matches, coloured by disparity; and its caption.
fn marked_photo(
    side: Side,
    capture: &Capture,
    result: &Reconstruction,
    record: &Record,
    disparities: &[f64],
) -> (Rgb, String) {
    let views = &result.rectification;
    let (photo, view, count, name) = match side {
        Side::Left => (&capture.left, &views.left, result.dots[0], "left"),
        Side::Right => (&capture.right, &views.right, result.dots[1], "right"),
    };
    let mut image = marks::brightened(&scaled_down(&photo.rgb, MAX_PHOTO_WIDTH));
    let scale = 1.0 / block_size(photo.rgb.width(), MAX_PHOTO_WIDTH) as f64;
    // pixel centres are at integers, so the corner of the picture is at -0.5
    let position = |p: Vec2| view.to_photo(p).map(|c| (c + 0.5) * scale - 0.5);
    if let Some(Kept::Points(dots)) = record.kept("detect", &format!("{name}_dots")) {
        let positions = dots.iter().map(|d| position(Vec2::new(d.x, d.y)));
        marks::points(&mut image, positions, [255, 255, 255]);
    }
    let low = percentile(disparities, 0.02).unwrap_or(0.0);
    let high = percentile(disparities, 0.98).unwrap_or(1.0);
    let crosses = result.matches.iter().zip(disparities).map(|(m, disparity)| {
        let pixel = match side {
            Side::Left => m.left,
            Side::Right => m.right,
        };
        (position(pixel), disparity_color(*disparity, low, high))
    });
    marks::crosses(&mut image, crosses);
    let found = match capture.pattern.kind {
        PatternKind::Dots => format!("{count} dots found (white)"),
        PatternKind::Stripes => format!("{count} stripe edges found"),
    };
    let caption = format!(
        "{name} photo, brightened; {found}, {} matched (crosses: blue far, {low:.0} px of \
         disparity, to red near, {high:.0} px)",
        result.matches.len()
    );
    (image, caption)
}

fn depth(result: &Reconstruction) -> Section {
    let mut row = RowBuilder::new(2);
    for (image, side) in result.depth.iter().zip(["left", "right"]) {
        let caption =
            format!("{side} photo: lighter is nearer, black was not measured (thesis Fig. 2.5)");
        row.picture(scaled_down(&marks::colored(image), MAX_PHOTO_WIDTH), caption);
    }
    Section::new("Depth", vec![row])
}
