//! One HTML file with everything in it.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use rayon::prelude::*;

use super::{marks, plots, words};
use crate::data::{Capture, Mesh, Photo, Rgb};
use crate::io;
use crate::math::percentile;
use crate::pipeline::Reconstruction;
use crate::record::{Kept, Record};
use crate::render::{Mode, Scene, Studio, View};

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
    let cast = Studio::new(&Scene::new(&result.mesh), Mode::Shaded).ok();
    face(&mut page, result, cast.as_ref());
    photos(&mut page, capture, result);
    depth(&mut page, result);
    stages(&mut page, result, record, cast.as_ref());
    convergence(&mut page, result, record);
    table(&mut page, result);
    page.push_str("</html>\n");
    page
}

fn face(page: &mut String, result: &Reconstruction, cast: Option<&Studio<'_>>) {
    page.push_str("<h2>The face</h2>\n");
    let texture = result.texture.as_ref().map(|t| &t.image);
    let scene = Scene { texture, ..Scene::new(&result.mesh) };
    let textured = texture.and_then(|_| Studio::new(&scene, Mode::Textured).ok());
    let mut pictures = Vec::new();
    for (view, name) in
        [(View::Front, "front"), (View::ThreeQuarter, "three-quarter"), (View::Profile, "profile")]
    {
        if texture.is_some() {
            pictures.push((drawn(textured.as_ref(), view), format!("{name}, textured")));
        }
        pictures.push((drawn(cast, view), format!("{name}, shaded")));
    }
    figures(page, "third", &pictures);
    if let Some(texture) = texture {
        figures(page, "third", &[(shrunk(texture, 512), "the texture".to_owned())]);
    }
}

fn photos(page: &mut String, capture: &Capture, result: &Reconstruction) {
    page.push_str("<h2>Photographs and matches</h2>\n");
    let disparities: Vec<f64> = result.matches.iter().map(|m| m.disparity()).collect();
    let low = percentile(&disparities, 0.02).unwrap_or(0.0);
    let high = percentile(&disparities, 0.98).unwrap_or(1.0);
    let colors: Vec<_> = disparities.iter().map(|d| marks::ramp(*d, low, high)).collect();
    let views = &result.rectification;
    let picture = |(photo, left): (&Photo, bool)| {
        let mut image = shrunk(&photo.rgb, WIDEST);
        let scale = 1.0 / factor(photo.rgb.width(), WIDEST) as f64;
        let places = result.matches.iter().map(|m| {
            let place =
                if left { views.left.to_photo(m.left) } else { views.right.to_photo(m.right) };
            // pixel centres are at integers, so the picture's corner is at -0.5
            place.map(|c| (c + 0.5) * scale - 0.5)
        });
        marks::crosses(&mut image, places.zip(colors.iter().copied()));
        let side = if left { "left" } else { "right" };
        let dots = result.dots[usize::from(!left)];
        (image, format!("{side}: {dots} dots; crosses are matches, red nearer, blue farther"))
    };
    figures(page, "half", &[(&capture.left, true), (&capture.right, false)].map(picture));
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
    page.push_str("<h2>Depth</h2>\n");
    let [left, right] = [0, 1].map(|k| shrunk(&marks::colored(&result.depth[k]), WIDEST));
    let caption = |side: &str| format!("{side}: lighter is nearer (thesis Fig. 2.5)");
    figures(page, "half", &[(left, caption("left")), (right, caption("right"))]);
    if let Some(texture) = &result.texture {
        let caption = "coverage of the texture: red from the left photo, green from the right, \
                       yellow from both, blue from others, grey filled";
        let coverage = shrunk(&marks::coverage(&texture.coverage), 512);
        figures(page, "third", &[(coverage, caption.to_owned())]);
    }
}

fn stages(page: &mut String, result: &Reconstruction, record: &Record, cast: Option<&Studio<'_>>) {
    let cast_of = |mesh: &Mesh| {
        if *mesh == result.mesh {
            return drawn(cast, View::ThreeQuarter);
        }
        let own = Studio::new(&Scene::new(mesh), Mode::Shaded).ok();
        drawn(own.as_ref(), View::ThreeQuarter)
    };
    let picture = |kept: &Kept| match kept {
        Kept::Gray(image) => Some(shrunk(&marks::colored(image), WIDEST)),
        Kept::Rgb(image) => Some(shrunk(image, WIDEST)),
        Kept::Mesh(mesh) => Some(cast_of(mesh)),
        Kept::Points(_) => None,
    };
    let pictures: Vec<_> = record
        .artifacts
        .iter()
        .filter_map(|(stage, name, kept)| {
            Some((picture(kept)?, format!("{stage}: {name}").replace('_', " ")))
        })
        .collect();
    if !pictures.is_empty() {
        page.push_str("<h2>Stage by stage</h2>\n");
        figures(page, "third", &pictures);
    }
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

/// Pictures with their captions, side by side in a block of a class.
fn figures(page: &mut String, class: &str, pictures: &[(Rgb, String)]) {
    let coded: Vec<_> = pictures.par_iter().map(|(image, _)| embedded(image)).collect();
    page.push_str(&format!("<div class=\"{class}\">"));
    for ((_, caption), source) in pictures.iter().zip(coded) {
        let Some(source) = source else { continue };
        page.push_str(&format!(
            "<figure><img alt=\"{0}\" src=\"{source}\"><figcaption>{0}</figcaption></figure>",
            escape(caption),
        ));
    }
    page.push_str("</div>\n");
}

/// A picture as an address that holds it: as PNG, or where that takes more than a byte a pixel, as
/// photographs do, as JPEG.
fn embedded(image: &Rgb) -> Option<String> {
    let png = io::encode_png(image).ok()?;
    let (kind, bytes) = if png.len() > image.data().len() {
        ("jpeg", io::encode_jpeg(image, 90).ok()?)
    } else {
        ("png", png)
    };
    Some(format!("data:image/{kind};base64,{}", STANDARD.encode(bytes)))
}

/// A view of a mesh; a mesh that cannot be drawn leaves a plain tile.
fn drawn(studio: Option<&Studio<'_>>, view: View) -> Rgb {
    const SIDE: usize = 370;
    studio
        .and_then(|s| s.picture(view, None, (SIDE, SIDE)).ok())
        .unwrap_or_else(|| Rgb::filled(SIDE, SIDE, [230, 230, 230]))
}

/// Photographs are shown no wider than this, pixels.
const WIDEST: usize = 1024;

/// A picture at most `side` wide, by averaging whole blocks.
fn shrunk(image: &Rgb, side: usize) -> Rgb {
    let k = factor(image.width(), side);
    if k == 1 {
        return image.clone();
    }
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

/// Pixels that become one where a picture is to be at most `side` wide.
fn factor(width: usize, side: usize) -> usize {
    width.div_ceil(side).max(1)
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
