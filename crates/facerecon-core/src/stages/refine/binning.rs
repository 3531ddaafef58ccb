//! Between the given pictures and the smaller ones that are matched where the pattern is coarse.

use super::prior::Sample;
use super::surface::Surface;
use crate::data::{Gray, Match, Raster};

/// Means of `bin` x `bin` blocks; pixels that are not finite count as black.
pub(super) fn binned(image: &Gray, bin: usize) -> Gray {
    let bin = bin.max(1);
    let (width, height) = (image.width() / bin, image.height() / bin);
    let scale = 1.0 / (bin * bin) as f32;
    Raster::from_fn(width, height, |x, y| {
        let block = (0..bin).flat_map(|j| (0..bin).map(move |i| (x * bin + i, y * bin + j)));
        let sum: f32 = block
            .map(|(i, j)| image.at(i, j))
            .map(|v| if v.is_finite() { v.clamp(0.0, 255.0) } else { 0.0 })
            .sum();
        sum * scale
    })
}

/// The working pictures' pixels and the given ones.
#[derive(Clone, Copy, Debug)]
pub(super) struct Binning {
    /// Given pixels per working pixel.
    pub(super) bin: f64,
}

impl Binning {
    /// A coordinate in working pixels.
    fn place(&self, v: f64) -> f64 {
        (v - 0.5 * (self.bin - 1.0)) / self.bin
    }

    /// A sample in working pixels.
    pub(super) fn shrink(&self, s: &Sample) -> Sample {
        Sample { x: self.place(s.x), y: self.place(s.y), disparity: s.disparity / self.bin }
    }

    /// Standard deviation in the pixel nearest to a given picture's place; NaN outside.
    fn sigma_at(&self, sigma: &Gray, x: f64, y: f64) -> f32 {
        sigma
            .get(self.place(x).round() as isize, self.place(y).round() as isize)
            .map_or(f32::NAN, |s| s * self.bin as f32)
    }

    /// Disparity and standard deviation at the given pictures' pixels.
    pub(super) fn enlarge(
        &self,
        surface: &Surface,
        sigma: &Gray,
        size: (usize, usize),
    ) -> (Gray, Gray) {
        let sigma =
            Raster::from_fn(size.0, size.1, |x, y| self.sigma_at(sigma, x as f64, y as f64));
        let holes = sigma.map(|s| s.is_finite());
        let stretched = Surface {
            origin: surface.origin.map(|o| self.bin * o + 0.5 * (self.bin - 1.0)),
            knot: self.bin * surface.knot,
            columns: surface.columns,
            rows: surface.rows,
            control: surface.control.iter().map(|d| self.bin * d).collect(),
        };
        (stretched.sampled(&holes).0.map(|d| d as f32), sigma)
    }
}

/// The matches with the surface's disparity where it was measured near theirs; else with their
/// own (and the largest standard deviation that is no hole), unless the surface contradicts it by
/// a large part of the pitch. A match with no place in the lattice was only guessed from its
/// neighbours: it must lie on the surface.
pub(super) fn moved(
    matches: &[Match],
    samples: &[Sample],
    grid: &Binning,
    surface: &Surface,
    sigma: &Gray,
    pitch: f64,
    max_sigma_px: f64,
) -> Vec<Match> {
    let mut out = Vec::with_capacity(matches.len());
    for (m, s) in matches.iter().zip(samples) {
        let mut m = *m;
        let sigma_px = f64::from(grid.sigma_at(sigma, m.left.x, m.left.y));
        let disparity = surface.value(s.x, s.y);
        let away = (disparity - s.disparity).abs();
        if sigma_px.is_finite() && away > 0.4 * pitch {
            continue;
        }
        let on_surface = sigma_px.is_finite() && away < 0.15 * pitch;
        if !on_surface && m.lattice.is_none() {
            continue;
        }
        m.right.x = m.left.x - grid.bin * if on_surface { disparity } else { s.disparity };
        m.sigma_px = if on_surface { sigma_px } else { max_sigma_px };
        out.push(m);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_average_and_places_agree() {
        let small = binned(&Gray::from_fn(5, 4, |x, _| x as f32), 2);
        assert_eq!((small.size(), small.at(1, 1)), ((2, 2), 2.5));
        // the middle of the second bin lies between pixels 2 and 3
        let s = Binning { bin: 2.0 }.shrink(&Sample { x: 2.5, y: 0.5, disparity: 3.0 });
        assert_eq!((s.x, s.y, s.disparity), (1.0, 0.0, 1.5));
    }

    #[test]
    fn an_enlarged_surface_keeps_its_shape() {
        let domain = Raster::filled(20, 20, true);
        let mut surface = Surface::over(&domain, 4.0).unwrap();
        for k in 0..surface.control.len() {
            surface.control[k] = 3.0 + 0.1 * surface.node(k % surface.columns, 0)[0];
        }
        let grid = Binning { bin: 3.0 };
        let sigma = Gray::filled(20, 20, 0.1);
        let (disparity, sigma) = grid.enlarge(&surface, &sigma, (60, 60));
        // disparity 3 * (3 + 0.1 * (x - 1) / 3)
        assert!((disparity.at(31, 40) - 12.0).abs() < 1e-5);
        assert!((sigma.at(31, 40) - 0.3).abs() < 1e-6);
    }
}
