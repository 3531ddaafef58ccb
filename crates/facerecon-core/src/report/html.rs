//! One HTML file with everything in it.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::{marks, plots, words};
use crate::data::{Capture, Mesh, Rgb};
use crate::io;
use crate::math::percentile;
use crate::pipeline::Reconstruction;
use crate::record::{Kept, Record};
use crate::render::{Mode, Scene, View, picture};

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:1180px;padding:0 1rem;color:#1c2733}\
h1{font-size:1.6rem}h2{font-size:1.15rem;margin-top:2.2rem;border-bottom:1px solid #d8dee4;padding-bottom:.2rem}\
figure{display:inline-block;margin:.4rem;vertical-align:top}figcaption{font-size:.85rem;color:#57606a;max-width:36rem}\
img{max-width:100%;border-radius:4px}.half img{max-width:560px}.third img{max-width:370px}\
table{border-collapse:collapse}td,th{padding:.15rem .9rem .15rem 0;text-align:left}td.n{text-align:right;font-variant-numeric:tabular-nums}\
.warning{background:#fff8e5;border-left:4px solid #d4a72c;padding:.4rem .8rem;margin:.4rem 0}pre{background:#f6f8fa;padding:1rem;overflow:auto;font-size:.8rem}";

/// The report of a run as an HTML text that needs no other file.
pub fn html(capture: &Capture, result: &Reconstruction, record: &Record) -> String {
    let mut page = String::from(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\">\
        <meta name=\"viewport\" content=\"width=device-width\"><title>facerecon report</title>",
    );
    page.push_str(&format!("<style>{STYLE}</style>\n<h1>facerecon report</h1>\n"));
    for sentence in words::summary(result) {
        page.push_str(&format!("<p>{}</p>\n", escape(&sentence)));
    }
    for warning in &result.warnings {
        page.push_str(&format!("<div class=\"warning\">{}</div>\n", escape(warning)));
    }
    face(&mut page, result);
    photos(&mut page, capture, result);
    depth(&mut page, result);
    stages(&mut page, record);
    convergence(&mut page, result, record);
    table(&mut page, result);
    page.push_str("</html>\n");
    page
}

fn face(page: &mut String, result: &Reconstruction) {
    page.push_str("<h2>The face</h2>\n<div class=\"third\">");
    let texture = result.texture.as_ref().map(|t| &t.image);
    for (view, name) in
        [(View::Front, "front"), (View::ThreeQuarter, "three-quarter"), (View::Profile, "profile")]
    {
        if let Some(texture) = texture {
            let image = drawn(&result.mesh, Some(texture), view, Mode::Textured);
            figure(page, &image, &format!("{name}, textured"));
        }
        let image = drawn(&result.mesh, None, view, Mode::Shaded);
        figure(page, &image, &format!("{name}, shaded"));
    }
    page.push_str("</div>\n");
    if let Some(texture) = texture {
        page.push_str("<div class=\"third\">");
        figure(page, &shrunk(texture, 512), "the texture");
        page.push_str("</div>\n");
    }
}

fn photos(page: &mut String, capture: &Capture, result: &Reconstruction) {
    page.push_str("<h2>Photographs and matches</h2>\n<div class=\"half\">");
    let disparities: Vec<f64> = result.matches.iter().map(|m| m.disparity()).collect();
    let low = percentile(&disparities, 0.02).unwrap_or(0.0);
    let high = percentile(&disparities, 0.98).unwrap_or(1.0);
    let colors: Vec<_> = disparities.iter().map(|d| marks::ramp(*d, low, high)).collect();
    let views = &result.rectification;
    let sides = [(&capture.left, true), (&capture.right, false)];
    for (photo, left) in sides {
        let mut image = photo.rgb.clone();
        let places = result.matches.iter().map(|m| {
            if left { views.left.to_photo(m.left) } else { views.right.to_photo(m.right) }
        });
        marks::crosses(&mut image, places.zip(colors.iter().copied()));
        let side = if left { "left" } else { "right" };
        let dots = result.dots[usize::from(!left)];
        figure(
            page,
            &image,
            &format!("{side}: {dots} dots; crosses are matches, red nearer, blue farther"),
        );
    }
    page.push_str("</div>\n");
    page.push_str(&plots::histogram("Disparity", "disparity, px", &disparities, 40));
    let sigmas: Vec<f64> = result.matches.iter().map(|m| m.sigma_px).filter(|s| *s > 0.0).collect();
    page.push_str(&plots::histogram(
        "Uncertainty of the disparity",
        "standard deviation, px",
        &sigmas,
        40,
    ));
}

fn depth(page: &mut String, result: &Reconstruction) {
    page.push_str("<h2>Depth</h2>\n<div class=\"half\">");
    for (image, side) in result.depth.iter().zip(["left", "right"]) {
        figure(
            page,
            &marks::colored(image),
            &format!("{side}: lighter is nearer (thesis Fig. 2.5)"),
        );
    }
    page.push_str("</div>\n");
    if let Some(texture) = &result.texture {
        page.push_str("<div class=\"third\">");
        let coverage = marks::coverage(&texture.coverage);
        figure(
            page,
            &shrunk(&coverage, 512),
            "coverage of the texture: red from the left photo, green from the right, yellow from both, blue from others, grey filled",
        );
        page.push_str("</div>\n");
    }
}

fn stages(page: &mut String, record: &Record) {
    let images: Vec<_> = record
        .artifacts
        .iter()
        .filter_map(|(stage, name, kept)| match kept {
            Kept::Gray(image) => Some((format!("{stage}: {name}"), marks::colored(image))),
            Kept::Rgb(image) => Some((format!("{stage}: {name}"), image.clone())),
            Kept::Mesh(mesh) => Some((
                format!("{stage}: {name}"),
                drawn(mesh, None, View::ThreeQuarter, Mode::Shaded),
            )),
            Kept::Points(_) => None,
        })
        .collect();
    if images.is_empty() {
        return;
    }
    page.push_str("<h2>Stage by stage</h2>\n<div class=\"third\">");
    for (caption, image) in &images {
        figure(page, image, &caption.replace('_', " "));
    }
    page.push_str("</div>\n");
}

fn convergence(page: &mut String, result: &Reconstruction, record: &Record) {
    page.push_str("<h2>Convergence</h2>\n");
    page.push_str(&plots::convergence("Registration", "error", &result.registration.history));
    for (stage, history) in record.histories.iter().filter(|(stage, _)| *stage != "register") {
        page.push_str(&plots::convergence(stage, "error", history));
    }
}

fn table(page: &mut String, result: &Reconstruction) {
    page.push_str("<h2>Times</h2>\n<table>");
    for (stage, ms) in &result.timings_ms {
        page.push_str(&format!("<tr><td>{stage}</td><td class=\"n\">{ms:.1} ms</td></tr>"));
    }
    page.push_str("</table>\n<h2>Parameters</h2>\n");
    // A struct of plain numbers always has a TOML form; without one the report leaves it out.
    let params = toml::to_string(&result.params).unwrap_or_default();
    page.push_str(&format!("<pre>{}</pre>\n", escape(&params)));
    page.push_str(&format!("<p>facerecon {}</p>\n", env!("CARGO_PKG_VERSION")));
}

fn figure(page: &mut String, image: &Rgb, caption: &str) {
    let Ok(png) = io::image::encode_png(image) else { return };
    page.push_str(&format!(
        "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>",
        escape(caption),
        STANDARD.encode(png)
    ));
}

/// A view of a mesh; a mesh that cannot be drawn leaves a plain tile.
fn drawn(mesh: &Mesh, texture: Option<&Rgb>, view: View, mode: Mode) -> Rgb {
    const SIDE: usize = 420;
    let scene = Scene { texture, ..Scene::new(mesh) };
    picture(&scene, view, mode, (SIDE, SIDE))
        .unwrap_or_else(|_| Rgb::filled(SIDE, SIDE, [230, 230, 230]))
}

/// A picture at most `side` wide, by averaging whole blocks.
fn shrunk(image: &Rgb, side: usize) -> Rgb {
    let k = image.width().div_ceil(side).max(1);
    Rgb::from_fn(image.width() / k, image.height() / k, |x, y| {
        let mut sum = [0u32; 3];
        for dy in 0..k {
            for dx in 0..k {
                let p = image.at(x * k + dx, y * k + dy);
                (0..3).for_each(|c| sum[c] += u32::from(p[c]));
            }
        }
        sum.map(|s| (s / (k * k) as u32) as u8)
    })
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_from_files_cannot_become_markup() {
        assert_eq!(escape("<script>\"&\""), "&lt;script&gt;&quot;&amp;&quot;");
    }

    #[test]
    fn shrinking_averages_blocks() {
        let image = Rgb::from_fn(4, 2, |x, _| [if x < 2 { 0 } else { 200 }, 10, 20]);
        assert_eq!(shrunk(&image, 2).data(), [[0, 10, 20], [200, 10, 20]]);
    }
}
