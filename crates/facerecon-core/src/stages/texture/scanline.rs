//! The scan-line texture of the thesis (section 5.2): each row of a photo is copied to a row of the
//! texture, stretched or compressed.

mod anchors;
mod mapping;
mod region;
mod sheet;

use super::error::TextureError;
use super::input::TextureInput;
use super::output::{SEEN_LEFT, SEEN_RIGHT, Texture};
use super::params::{Source, TextureParams};
use crate::data::{Raster, Rgb};
use crate::observer::Observer;
use anchors::{Anchor, anchors};
use mapping::Mapping;
use region::{Extremes, Region};
use sheet::Sheet;

/// Fewest dots from which the region is taken: two for each extreme.
const LEAST_DOTS: usize = 8;
/// Dots within this fraction of the region's height of a row determine its stretching.
const NEAR: f64 = 1.0 / 24.0;

/// Scans the photos row by row into the texture and fills the rows that stayed empty.
pub(super) fn texture(
    input: &TextureInput<'_>,
    params: &TextureParams,
    observer: &dyn Observer,
) -> Result<Texture, TextureError> {
    let used: &[(usize, u8)] = match params.source {
        Source::Halves => &[(0, SEEN_LEFT), (1, SEEN_RIGHT)],
        Source::Left => &[(0, SEEN_LEFT)],
        Source::Right => &[(1, SEEN_RIGHT)],
    };
    let needed = used.iter().map(|u| u.0 + 1).max().unwrap_or(1);
    if input.photos.len() < needed {
        return Err(TextureError::Photos { got: input.photos.len(), needed });
    }
    let mut sheets = Vec::new();
    for &(photo, code) in used {
        observer.check()?;
        let mut sheet = scan(input, photo, code, params)?;
        // before they are joined: else the other photo's rows would show through the gaps
        sheet.fill_empty_rows();
        sheets.push(sheet);
    }
    let sheet = match <[Sheet; 2]>::try_from(sheets) {
        Ok([left, right]) => left.joined(&right),
        Err(mut single) => single.swap_remove(0),
    };
    Ok(sheet.into_texture(input.template_texture, params.rest))
}

/// Copies each row of the photo's region to its row of the texture.
fn scan(
    input: &TextureInput<'_>,
    photo: usize,
    code: u8,
    params: &TextureParams,
) -> Result<Sheet, TextureError> {
    let size = params.size;
    let segments = params.segments;
    let source = &input.photos[photo];
    let dots = anchors(input.mesh, source.dots, source.image.size(), size);
    let extremes = Extremes::new(&dots).filter(|_| dots.len() >= LEAST_DOTS);
    let Some(extremes) = extremes else {
        return Err(TextureError::TooFewDots { got: dots.len(), needed: LEAST_DOTS });
    };
    let from = Region::photo(&extremes, params.boundary);
    let to = Region::texture(&extremes, params.boundary)?;
    let ((first, last), (top, bottom)) = (from.rows(), to.rows());
    let samples: Vec<(f64, f64)> = dots.iter().map(|a| (a.photo.y, a.texel.y)).collect();
    let rows = Mapping::monotone((first, top), (last, bottom), &samples, segments);

    let mut image = Rgb::filled(size, size, [0; 3]);
    let mut seen = Raster::filled(size, size, 0u8);
    for line in first.ceil().max(0.0) as usize..=last.floor().max(0.0) as usize {
        let y = line as f64;
        let row = rows.at(y).round();
        if !(row >= 0.0 && row < size as f64) || line >= source.image.height() {
            continue;
        }
        let spans = (from.span(y), to.span(row));
        let near = dots.iter().filter(|a| (a.photo.y - y).abs() <= (last - first) * NEAR);
        let Some(columns) = row_mapping(near, spans, segments) else { continue };
        let (left, right) = columns.domain();
        for x in left.ceil().max(0.0) as usize..=(right.floor().max(0.0) as usize).min(size - 1) {
            let color = sample_row(source.image, columns.at(x as f64), line);
            image.set(x, row as usize, color);
            seen.set(x, row as usize, code);
        }
    }
    Ok(Sheet { image, seen, region: to })
}

/// The mapping of a texture row to the columns of a photo row. With one segment it leads from edge
/// to edge of the `spans` in photo and texture; with several it passes through the dots `near` the
/// row and ends at the outermost of them, since the wall begins beyond. `None` when too few dots are
/// near.
fn row_mapping<'a>(
    near: impl Iterator<Item = &'a Anchor>,
    (pixel, texel): ((f64, f64), (f64, f64)),
    segments: usize,
) -> Option<Mapping> {
    if segments <= 1 {
        return Some(Mapping::linear((texel.0, pixel.0), (texel.1, pixel.1)));
    }
    let near: Vec<(f64, f64)> =
        near.map(|a| (a.texel.x, a.photo.x)).filter(|s| s.0 >= texel.0 && s.0 <= texel.1).collect();
    let first = near.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let last = near.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let wide = last.0 >= first.0 + 1.0 && last.1 > first.1;
    wide.then(|| Mapping::monotone(first, last, &near, segments))
}

/// Linear interpolation along one row of the photo.
fn sample_row(image: &Rgb, x: f64, row: usize) -> [u8; 3] {
    let x = x.clamp(0.0, (image.width() - 1) as f64);
    let i = x.floor() as usize;
    let (a, b) = (image.at(i, row), image.at((i + 1).min(image.width() - 1), row));
    let f = x - i as f64;
    [0, 1, 2].map(|k| (f64::from(a[k]) * (1.0 - f) + f64::from(b[k]) * f).round() as u8)
}
