//! The texels that one photo gave, and how the sheets of the photos become one texture.

use super::super::output::{FILLED, Texture};
use super::super::params::Rest;
use super::region::Region;
use crate::data::{Raster, Rgb};

/// Colours from one photo.
pub(super) struct Sheet {
    pub image: Rgb,
    /// Code of the photo (coverage), 0 where it gave nothing.
    pub seen: Raster<u8>,
    /// The region on the texture.
    pub region: Region,
}

impl Sheet {
    /// Takes texels from the right photo right of the middle of both regions, and where this sheet
    /// has none.
    pub fn joined(mut self, right: &Sheet) -> Sheet {
        let size = self.image.width();
        for y in 0..size {
            let (a, b) = (self.region.span(y as f64), right.region.span(y as f64));
            let middle = (a.0.max(b.0) + a.1.min(b.1)) / 2.0;
            for x in 0..size {
                let (l, r) = (self.seen.at(x, y), right.seen.at(x, y));
                if r != 0 && (l == 0 || x as f64 > middle) {
                    self.image.set(x, y, right.image.at(x, y));
                    self.seen.set(x, y, r);
                }
            }
        }
        self
    }

    /// Rows of the region to which no row of the photo was copied take the row above, resized to
    /// their span; above the first copied row, the one below.
    pub fn fill_empty_rows(&mut self) {
        let size = self.image.height();
        let spans: Vec<Option<(usize, usize)>> = (0..size)
            .map(|y| {
                let row = self.seen.row(y);
                let first = row.iter().position(|s| *s != 0)?;
                Some((first, row.iter().rposition(|s| *s != 0)?))
            })
            .collect();
        let (top, bottom) = self.region.rows();
        let mut last: Option<usize> = None;
        for y in top.round().max(0.0) as usize..=(bottom.round().max(0.0) as usize).min(size - 1) {
            if spans[y].is_some() {
                last = Some(y);
                continue;
            }
            let from = last.or_else(|| (y..size).find(|&k| spans[k].is_some()));
            if let Some((source, span)) = from.and_then(|k| Some((k, spans[k]?))) {
                self.copy_row(source, span, y);
            }
        }
    }

    /// Copies the `span` of row `source` to row `y`, resized. A row that ended before the edge of
    /// the region ends as far before it.
    fn copy_row(&mut self, source: usize, span: (usize, usize), y: usize) {
        let size = self.image.height();
        let (left, right) = self.region.span(y as f64);
        let edge = self.region.span(source as f64);
        let (first, end) = (span.0 as f64 + left - edge.0, span.1 as f64 + right - edge.1);
        let to = (first.round().max(0.0), end.round().min((size - 1) as f64));
        if !(to.1 >= to.0) {
            return;
        }
        let ratio = (span.1 - span.0) as f64 / (to.1 - to.0).max(1.0);
        for x in to.0 as usize..=to.1 as usize {
            let k = (span.0 + ((x as f64 - to.0) * ratio).round() as usize).min(span.1);
            self.image.set(x, y, self.image.at(k, source));
            self.seen.set(x, y, self.seen.at(k, source));
        }
    }

    /// Gives every texel outside the region a colour.
    pub fn into_texture(self, template: Option<&Rgb>, rest: Rest) -> Texture {
        let Sheet { mut image, seen, .. } = self;
        let skin = median_color(&image, &seen);
        let template = template.filter(|t| rest == Rest::Template && !t.data().is_empty());
        let size = image.width();
        for y in 0..size {
            for x in 0..size {
                if seen.at(x, y) == 0 {
                    let color = template
                        .map_or(skin, |t| t.at(x * t.width() / size, y * t.height() / size));
                    image.set(x, y, color);
                }
            }
        }
        let coverage = seen.map(|s| if s == 0 { FILLED } else { s });
        Texture { image, coverage, head_motion: None }
    }
}

/// Median of each channel over the texels that a photo gave; middle grey without any.
fn median_color(image: &Rgb, seen: &Raster<u8>) -> [u8; 3] {
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
