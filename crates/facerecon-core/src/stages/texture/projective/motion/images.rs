//! Images made comparable: smoothed, and free of exposure and shading.

use crate::data::Gray;

/// Window of the local normalisation, thousandths of the photo's width: some times wider than the
/// smoothing, and narrower than a cheek, over which shading changes.
const WINDOW: f64 = 22.0;
/// Added to the local spread, grey levels, so that noise in flat regions is not amplified.
const NOISE: f32 = 1.0;

/// Grey values smoothed over `width` thousandths of the photo's width, less their local mean,
/// divided by their local spread.
pub(super) fn normalised(gray: &Gray, width: f64) -> Gray {
    let smooth = gray.map(|v| [v]).box_blurred(thousandths(gray.width(), width));
    let local = smooth.map(|[v]| [v, v * v]).box_blurred(thousandths(gray.width(), WINDOW));
    smooth.zip_map(&local, |[v], [mean, square]| {
        let spread = (square - mean * mean).max(0.0).sqrt();
        (v - mean) / (spread + NOISE)
    })
}

fn thousandths(length: usize, part: f64) -> usize {
    ((length as f64 * part / 1000.0).round() as usize).max(1)
}

/// The dotted photos and the plain ones, equally smoothed and normalised.
pub(super) struct DottedAndPlain {
    /// Smoothing, thousandths of the photo's width.
    pub width: f64,
    pub dotted: [Option<Gray>; 2],
    pub plain: [Gray; 2],
}

impl DottedAndPlain {
    pub fn new(plain: &[Gray; 2], dotted: &[Option<&Gray>; 2], width: f64) -> Self {
        let (dotted, plain) = rayon::join(
            || both(|k| dotted[k].map(|i| normalised(i, width))),
            || both(|k| normalised(&plain[k], width)),
        );
        Self { width, dotted, plain }
    }
}

/// The same for the left (0) and the right (1) photo, in parallel.
pub(super) fn both<T: Send>(one: impl Fn(usize) -> T + Sync) -> [T; 2] {
    rayon::join(|| one(0), || one(1)).into()
}
