//! One HTML file with everything in it.

use super::page::{Row, STYLE, WIDEST, cast, drawn, escape, factor, shrunk};
use super::{marks, plots, steps, words};
use crate::data::{Capture, PatternKind};
use crate::math::{Vec2, percentile};
use crate::output::{Kept, Record};
use crate::pipeline::Reconstruction;
use crate::render::{Mode, Scene, Studio, View};

/// The report of a run as an HTML text that needs no other file.
pub fn html(capture: &Capture, result: &Reconstruction, record: &Record) -> String {
    let mut page = String::from(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\">\
        <meta name=\"viewport\" content=\"width=device-width\"><title>facerecon report</title>",
    );
    page.push_str(&format!("<style>{STYLE}</style>\n"));
    head(&mut page, capture, result);
    let plaster = cast(&result.mesh);
    face(&mut page, result, plaster.as_ref());
    photos(&mut page, capture, result, record);
    depth(&mut page, result);
    steps::steps(&mut page, capture, result, record, plaster.as_ref());
    times(&mut page, result);
    // A struct of plain numbers always has a TOML form; without one the report leaves it out.
    let params = toml::to_string(&result.params).unwrap_or_default();
    page.push_str(&format!(
        "<details><summary>All parameters of the run</summary><pre>{}</pre></details>\n</html>\n",
        escape(&params)
    ));
    page
}

fn head(page: &mut String, capture: &Capture, result: &Reconstruction) {
    let (width, height) = capture.left.size();
    let pattern = &capture.pattern;
    let projected = match pattern.kind {
        PatternKind::Dots => format!("{} x {} dots", pattern.columns, pattern.rows),
        PatternKind::Stripes => format!("{} stripes", pattern.columns),
    };
    page.push_str(&format!(
        "<h1>The reconstructed face</h1>\n<p class=\"soft\">Photos of {width} x {height} pixels under a \
         pattern of {projected}; profile {}; facerecon {}.</p>\n<div class=\"facts\">",
        result.params.profile,
        env!("CARGO_PKG_VERSION")
    ));
    let mut fact = |value: String, name: &str| {
        page.push_str(&format!("<div class=\"fact\"><b>{value}</b>{name}</div>\n"));
    };
    fact(result.matches.len().to_string(), "matches");
    fact(result.cloud.len().to_string(), "points measured");
    fact(result.mesh.vertices.len().to_string(), "vertices of the face");
    if let Some(size) = result.face_size() {
        fact(format!("{:.1} mm", size.width_mm), "ear to ear");
        fact(format!("{:.1} mm", size.height_mm), "nose saddle to chin");
    }
    fact(format!("{:.1} s", words::total_ms(result) / 1000.0), "for all stages");
    page.push_str("</div>\n");
    for sentence in words::summary(result) {
        page.push_str(&format!("<p>{}</p>\n", escape(&sentence)));
    }
    for warning in &result.warnings {
        page.push_str(&format!("<div class=\"warning\">{}</div>\n", escape(warning)));
    }
}

fn face(page: &mut String, result: &Reconstruction, plaster: Option<&Studio<'_>>) {
    page.push_str("<h2>The face</h2>\n");
    let views = [
        (View::Front, "from the front"),
        (View::ThreeQuarter, "three-quarter"),
        (View::Profile, "in profile"),
    ];
    let mut row = Row::new("three");
    if let Some(texture) = &result.texture {
        let scene = Scene { texture: Some(&texture.image), ..Scene::new(&result.mesh) };
        let textured = Studio::new(&scene, Mode::Textured).ok();
        for (view, name) in views {
            row.picture(drawn(textured.as_ref(), view), name);
        }
    }
    for (view, name) in views {
        row.picture(drawn(plaster, view), format!("{name}, shape only"));
    }
    row.end(page);
}

fn photos(page: &mut String, capture: &Capture, result: &Reconstruction, record: &Record) {
    page.push_str("<h2>Photographs, dots and matches</h2>\n");
    let disparities: Vec<f64> = result.matches.iter().map(|m| m.disparity()).collect();
    let low = percentile(&disparities, 0.02).unwrap_or(0.0);
    let high = percentile(&disparities, 0.98).unwrap_or(1.0);
    let colors: Vec<_> = disparities.iter().map(|d| marks::ramp(*d, low, high)).collect();
    let views = &result.rectification;
    let mut row = Row::new("two");
    for (photo, left) in [(&capture.left, true), (&capture.right, false)] {
        let mut image = marks::brightened(&shrunk(&photo.rgb, WIDEST));
        let scale = 1.0 / factor(photo.rgb.width(), WIDEST) as f64;
        let (side, view) = if left { ("left", &views.left) } else { ("right", &views.right) };
        // pixel centres are at integers, so the picture's corner is at -0.5
        let place = |p: Vec2| view.to_photo(p).map(|c| (c + 0.5) * scale - 0.5);
        if let Some(Kept::Points(dots)) = record.kept("detect", &format!("{side}_dots")) {
            let places = dots.iter().map(|d| place(Vec2::new(d.x, d.y)));
            marks::points(&mut image, places, [255, 255, 255]);
        }
        let places = result.matches.iter().map(|m| place(if left { m.left } else { m.right }));
        marks::crosses(&mut image, places.zip(colors.iter().copied()));
        let dots = result.dots[usize::from(!left)];
        let what = match capture.pattern.kind {
            PatternKind::Dots => format!("{dots} dots found (white)"),
            PatternKind::Stripes => format!("{dots} edges found"),
        };
        let matched = result.matches.len();
        row.picture(
            image,
            format!(
                "{side} photo, brightened; {what}, {matched} matched (crosses: blue far, {low:.0} px of disparity, to red near, {high:.0} px)"
            ),
        );
    }
    row.end(page);
    let mut row = Row::new("two");
    row.plot(plots::histogram("Disparity", "disparity, px", &disparities, 40));
    let sigmas: Vec<f64> = result.matches.iter().map(|m| m.sigma_px).filter(|s| *s > 0.0).collect();
    let label = "standard deviation, px";
    row.plot(plots::histogram("Uncertainty of the disparity", label, &sigmas, 40));
    row.end(page);
}

fn depth(page: &mut String, result: &Reconstruction) {
    page.push_str("<h2>Depth</h2>\n");
    let mut row = Row::new("two");
    for (image, side) in result.depth.iter().zip(["left", "right"]) {
        let caption =
            format!("{side} photo: lighter is nearer, black was not measured (thesis Fig. 2.5)");
        row.picture(shrunk(&marks::colored(image), WIDEST), caption);
    }
    row.end(page);
}

fn times(page: &mut String, result: &Reconstruction) {
    page.push_str("<h2>Times</h2>\n<table>");
    let longest = result.timings_ms.iter().map(|t| t.1).fold(1e-9, f64::max);
    for (stage, ms) in &result.timings_ms {
        page.push_str(&format!(
            "<tr><td>{stage}</td><td class=\"n\">{ms:.0} ms</td><td class=\"bar\"><div style=\"width:{:.1}%\"></div></td></tr>",
            100.0 * ms / longest
        ));
    }
    page.push_str(&format!(
        "<tr><td>total</td><td class=\"n\">{:.0} ms</td><td></td></tr></table>\n",
        words::total_ms(result)
    ));
}
