//! The scan-line texture of the thesis (section 5.2).

use super::scanline_boundary::{Anchor, Extremes, Region, anchors, course, interpolate};
use super::{
    FILLED, Rest, SEEN_LEFT, SEEN_RIGHT, Source, Texture, TextureError, TextureInput, TextureParams,
};
use crate::data::{Raster, Rgb};
use crate::observer::Observer;

const LEAST_DOTS: usize = 8;

/// Scans both photos line by line into the texture and fills the lines that stayed empty.
pub fn texture(
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
    for &(photo, seen) in used {
        observer.check()?;
        let mut sheet = scan(input, photo, seen, params)?;
        // before they are joined: else the other photo's lines would show through the gaps
        fill_empty_lines(&mut sheet);
        sheets.push(sheet);
    }
    let sheet = match <[Sheet; 2]>::try_from(sheets) {
        Ok([left, right]) => join(left, &right),
        Err(mut single) => single.swap_remove(0),
    };
    Ok(colour_rest(sheet, input.template_texture, params))
}

/// Texels a photo gave: colour, and which photo it was (0 where none).
struct Sheet {
    image: Rgb,
    seen: Raster<u8>,
    region: Region,
}

/// Copies each line of the photo's region to its row of the texture, spread or narrowed.
fn scan(
    input: &TextureInput<'_>,
    photo: usize,
    seen_by: u8,
    params: &TextureParams,
) -> Result<Sheet, TextureError> {
    let size = params.size;
    let source = &input.photos[photo];
    let dots = anchors(input.mesh, source.dots, source.image.size(), size);
    if dots.len() < LEAST_DOTS {
        return Err(TextureError::TooFewDots { got: dots.len(), needed: LEAST_DOTS });
    }
    let Some(extremes) = Extremes::new(&dots) else {
        return Err(TextureError::TooFewDots { got: 0, needed: LEAST_DOTS });
    };
    let from = Region::photo(&extremes, params.boundary);
    let to = Region::texture(&extremes, params.boundary)?;
    let ((first, last), (top, bottom)) = (from.rows(), to.rows());
    let samples: Vec<(f64, f64)> = dots.iter().map(|a| (a.photo.y, a.texel.y)).collect();
    let rows = course((first, top), (last, bottom), &samples, params.stretches);

    let mut image = Rgb::filled(size, size, [0; 3]);
    let mut seen = Raster::filled(size, size, 0u8);
    for line in first.ceil().max(0.0) as usize..=last.floor().max(0.0) as usize {
        let y = line as f64;
        let row = interpolate(&rows, y).round();
        if !(row >= 0.0 && row < size as f64) || line >= source.image.height() {
            continue;
        }
        let spread = spread(&dots, y, &from, &to, row, (last - first) / 24.0, params.stretches);
        let (Some(&(left, _)), Some(&(right, _))) = (spread.first(), spread.last()) else {
            continue;
        };
        for x in left.ceil().max(0.0) as usize..=(right.floor().max(0.0) as usize).min(size - 1) {
            let place = interpolate(&spread, x as f64);
            image.set(x, row as usize, sample_line(source.image, place, line));
            seen.set(x, row as usize, seen_by);
        }
    }
    Ok(Sheet { image, seen, region: to })
}

/// Where on the photo's line each texel of a row lies, as a course of `(texel, pixel)` from edge to
/// edge; or, in several stretches, through the dots near the line and no farther than the outermost
/// of them, since beyond it the wall begins. Empty when too few dots are near.
fn spread(
    dots: &[Anchor],
    y: f64,
    from: &Region,
    to: &Region,
    row: f64,
    reach: f64,
    stretches: usize,
) -> Vec<(f64, f64)> {
    let (pixel, texel) = (from.span(y), to.span(row));
    if stretches <= 1 {
        return vec![(texel.0, pixel.0), (texel.1, pixel.1)];
    }
    let near: Vec<(f64, f64)> = dots
        .iter()
        .filter(|a| (a.photo.y - y).abs() <= reach)
        .map(|a| (a.texel.x, a.photo.x))
        .filter(|s| s.0 >= texel.0 && s.0 <= texel.1)
        .collect();
    let first = near.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
    let last = near.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
    match (first, last) {
        (Some(first), Some(last)) if last.0 >= first.0 + 1.0 && last.1 > first.1 => {
            course(first, last, &near, stretches)
        }
        _ => Vec::new(),
    }
}

/// Linear interpolation along one line.
fn sample_line(image: &Rgb, x: f64, line: usize) -> [u8; 3] {
    let x = x.clamp(0.0, (image.width() - 1) as f64);
    let i = x.floor() as usize;
    let (a, b) = (image.at(i, line), image.at((i + 1).min(image.width() - 1), line));
    let f = x - i as f64;
    [0, 1, 2].map(|k| (f64::from(a[k]) * (1.0 - f) + f64::from(b[k]) * f).round() as u8)
}

/// Left of the middle of the two regions the left photo counts, right of it the right one; where
/// one has nothing the other stands in.
fn join(mut left: Sheet, right: &Sheet) -> Sheet {
    let size = left.image.width();
    for y in 0..size {
        let (a, b) = (left.region.span(y as f64), right.region.span(y as f64));
        let middle = (a.0.max(b.0) + a.1.min(b.1)) / 2.0;
        for x in 0..size {
            let (l, r) = (left.seen.at(x, y), right.seen.at(x, y));
            if r != 0 && (l == 0 || x as f64 > middle) {
                left.image.set(x, y, right.image.at(x, y));
                left.seen.set(x, y, r);
            }
        }
    }
    left
}

/// Lines of the region that no line of a photo fell on take the line above, resized to their span;
/// above the first one that was scanned, the one below.
fn fill_empty_lines(sheet: &mut Sheet) {
    let size = sheet.image.height();
    let spans: Vec<Option<(usize, usize)>> = (0..size)
        .map(|y| {
            let row = sheet.seen.row(y);
            let first = row.iter().position(|s| *s != 0)?;
            Some((first, row.iter().rposition(|s| *s != 0)?))
        })
        .collect();
    let (top, bottom) = sheet.region.rows();
    let mut last: Option<usize> = None;
    for y in top.round().max(0.0) as usize..=(bottom.round().max(0.0) as usize).min(size - 1) {
        if spans[y].is_some() {
            last = Some(y);
            continue;
        }
        let from = last.or_else(|| (y..size).find(|&k| spans[k].is_some()));
        let Some((source, span)) = from.and_then(|k| Some((k, spans[k]?))) else {
            continue;
        };
        // a line that ended before the region's edge ends as far before it here
        let (left, right) = sheet.region.span(y as f64);
        let edge = sheet.region.span(source as f64);
        let (first, end) = (span.0 as f64 + left - edge.0, span.1 as f64 + right - edge.1);
        let to = (first.round().max(0.0), end.round().min((size - 1) as f64));
        if !(to.1 >= to.0) {
            continue;
        }
        let ratio = (span.1 - span.0) as f64 / (to.1 - to.0).max(1.0);
        for x in to.0 as usize..=to.1 as usize {
            let k = (span.0 + ((x as f64 - to.0) * ratio).round() as usize).min(span.1);
            sheet.image.set(x, y, sheet.image.at(k, source));
            sheet.seen.set(x, y, sheet.seen.at(k, source));
        }
    }
}

/// Gives every texel outside the region a colour.
fn colour_rest(sheet: Sheet, template: Option<&Rgb>, params: &TextureParams) -> Texture {
    let Sheet { mut image, seen, .. } = sheet;
    let skin = median_colour(&image, &seen);
    let template = template.filter(|t| params.rest == Rest::Template && !t.data().is_empty());
    let size = image.width();
    for y in 0..size {
        for x in 0..size {
            if seen.at(x, y) == 0 {
                let colour =
                    template.map_or(skin, |t| t.at(x * t.width() / size, y * t.height() / size));
                image.set(x, y, colour);
            }
        }
    }
    Texture { image, coverage: seen.map(|s| if s == 0 { FILLED } else { s }), head_motion: None }
}

fn median_colour(image: &Rgb, seen: &Raster<u8>) -> [u8; 3] {
    [0, 1, 2].map(|k| {
        let mut counts = [0usize; 256];
        for (c, s) in image.data().iter().zip(seen.data()) {
            if *s != 0 {
                counts[usize::from(c[k])] += 1;
            }
        }
        let half = counts.iter().sum::<usize>().div_ceil(2);
        let mut sum = 0;
        counts
            .iter()
            .position(|c| {
                sum += c;
                sum >= half
            })
            .unwrap_or(128) as u8
    })
}
