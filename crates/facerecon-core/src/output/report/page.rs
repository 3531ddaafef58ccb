//! The parts a page is put together from.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use rayon::prelude::*;

use crate::data::{Mesh, Rgb};
use crate::io;
use crate::render::{Mode, Scene, Studio, View};

pub(super) const STYLE: &str = "\
:root{--ink:#1c2733;--soft:#57606a;--line:#d8dee4;--pale:#f6f8fa;--accent:#2166ac}\
body{font:15px/1.55 system-ui,-apple-system,'Segoe UI',sans-serif;margin:2rem auto;max-width:1140px;padding:0 1.2rem;color:var(--ink)}\
h1{font-size:1.7rem;margin:0}h2{font-size:1.2rem;margin:2.6rem 0 .8rem;border-bottom:1px solid var(--line);padding-bottom:.3rem}\
h3{font-size:1rem;margin:1.4rem 0 .5rem}p{margin:.35rem 0;max-width:52rem}.soft,figcaption{color:var(--soft)}\
.facts{display:grid;grid-template-columns:repeat(auto-fit,minmax(150px,1fr));gap:.7rem;margin:1.2rem 0}\
.fact{background:var(--pale);border-radius:8px;padding:.6rem .9rem}.fact b{display:block;font-size:1.25rem;font-weight:600;color:var(--accent);font-variant-numeric:tabular-nums}\
.row{display:grid;gap:.9rem;align-items:start}.two{grid-template-columns:repeat(2,minmax(0,1fr))}.three{grid-template-columns:repeat(3,minmax(0,1fr))}.four{grid-template-columns:repeat(4,minmax(0,1fr))}\
figure{margin:0}figcaption{font-size:.85rem;line-height:1.4;margin-top:.3rem}img,svg{display:block;width:100%;height:auto;border-radius:6px}\
table{border-collapse:collapse}td{padding:.15rem 1.2rem .15rem 0}td.n{text-align:right;font-variant-numeric:tabular-nums}\
td.bar{width:22rem}td.bar div{background:var(--accent);opacity:.75;height:.7rem;border-radius:3px}\
.warning{background:#fff8e5;border-left:4px solid #d4a72c;padding:.45rem .9rem;margin:.5rem 0;border-radius:0 6px 6px 0}\
details{margin:2rem 0}summary{cursor:pointer;font-weight:600}pre{background:var(--pale);padding:1rem;overflow:auto;font-size:.8rem;border-radius:6px}\
@media(max-width:720px){.two,.three,.four{grid-template-columns:1fr}}";

/// Photographs are shown no wider than this, pixels.
pub(super) const WIDEST: usize = 1024;

/// Pictures and plots side by side.
pub(super) struct Row {
    class: &'static str,
    cells: Vec<Cell>,
}

enum Cell {
    Picture(Rgb, String),
    Plot(String),
}

impl Row {
    /// A row of `two`, `three` or `four` columns.
    pub(super) fn new(class: &'static str) -> Self {
        Self { class, cells: Vec::new() }
    }

    pub(super) fn picture(&mut self, image: Rgb, caption: impl Into<String>) {
        self.cells.push(Cell::Picture(image, caption.into()));
    }

    pub(super) fn plot(&mut self, svg: String) {
        self.cells.push(Cell::Plot(svg));
    }

    /// Puts the row on the page; without cells there is none.
    pub(super) fn end(self, page: &mut String) {
        if self.cells.is_empty() {
            return;
        }
        let coded: Vec<String> = self.cells.into_par_iter().map(Cell::html).collect();
        page.push_str(&format!("<div class=\"row {}\">{}</div>\n", self.class, coded.concat()));
    }
}

impl Cell {
    fn html(self) -> String {
        match self {
            Self::Plot(svg) => svg,
            Self::Picture(image, caption) => embedded(&image).map_or_else(String::new, |source| {
                format!(
                    "<figure><img alt=\"{0}\" src=\"{source}\"><figcaption>{0}</figcaption></figure>",
                    escape(&caption)
                )
            }),
        }
    }
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

/// A mesh ready to be drawn as a plaster cast.
pub(super) fn cast(mesh: &Mesh) -> Option<Studio<'_>> {
    Studio::new(&Scene::new(mesh), Mode::Shaded).ok()
}

/// A view of a mesh; a mesh that cannot be drawn leaves a plain tile.
pub(super) fn drawn(studio: Option<&Studio<'_>>, view: View) -> Rgb {
    const SIDE: usize = 370;
    studio
        .and_then(|s| s.picture(view, None, (SIDE, SIDE)).ok())
        .unwrap_or_else(|| Rgb::filled(SIDE, SIDE, [230, 230, 230]))
}

/// A picture at most `side` wide, by averaging whole blocks.
pub(super) fn shrunk(image: &Rgb, side: usize) -> Rgb {
    let k = factor(image.width(), side);
    if k == 1 {
        return image.clone();
    }
    Rgb::par_from_fn(image.width() / k, image.height() / k, |x, y| {
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
pub(super) fn factor(width: usize, side: usize) -> usize {
    width.div_ceil(side).max(1)
}

pub(super) fn escape(text: &str) -> String {
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
