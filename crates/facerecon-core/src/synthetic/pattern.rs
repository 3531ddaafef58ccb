//! The projector image: a lattice of dots, or stripes whose order of colours identifies each one.

mod design;
mod stripes;

pub use design::Design;
pub use stripes::{PALETTE, STRIPE_PERIOD, Stripe, stripe};

use crate::data::{Pattern, PatternKind, Rgb};
use crate::render::srgb_from_linear;
use crate::settings::settings;
use crate::settings::{SettingsError, Value};
use crate::stages::{ErrorKind, StageError};

settings! {
    /// The projected pattern.
    pub struct PatternParams {
        /// Dots or stripes.
        kind: PatternKind = PatternKind::Dots;
        /// Dots in a row, or number of stripes.
        columns: usize = 85, range 2.0..=1000.0;
        /// Dots in a column; for stripes their length in units of their distance.
        rows: usize = 64, range 1.0..=1000.0;
        /// Width of the projector image.
        width_px: usize = 1024, range 16.0..=16384.0, unit "px";
        /// Height of the projector image.
        height_px: usize = 768, range 16.0..=16384.0, unit "px";
        /// Diameter of a dot as a fraction of the distance between dots.
        dot_fraction: f64 = 0.4, range 0.05..=0.95;
        /// Free border as a fraction of the shorter side of the image.
        margin_fraction: f64 = 0.02, range 0.0..=0.45;
        /// Rotation of the pattern, clockwise. At atan(1/k) a row of dots returns to the same height only
        /// after k columns, so that far fewer dots share an epipolar line. 7.125 (k = 8) suits most
        /// rigs; see `rotation_for_range`.
        rotation_deg: f64 = 0.0, range -45.0..=45.0, unit "deg";
    }
}

/// A pattern that cannot be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PatternError {
    /// A parameter out of range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Dots too small for the image's resolution.
    #[error(
        "{columns}x{rows} dots in an image of {width}x{height} pixels are {spacing_px:.1} px apart (at least {needed_px:.1} px expected); set a larger image or fewer dots"
    )]
    TooFine {
        /// Columns of the pattern.
        columns: usize,
        /// Rows of the pattern.
        rows: usize,
        /// Width of the image.
        width: usize,
        /// Height of the image.
        height: usize,
        /// Distance between dots.
        spacing_px: f64,
        /// Least distance.
        needed_px: f64,
    },
}

impl StageError for PatternError {
    const STAGE: &'static str = "pattern";

    fn kind(&self) -> ErrorKind {
        match self {
            Self::Settings(error) => ErrorKind::Settings(error.clone()),
            Self::TooFine { .. } => ErrorKind::Input,
        }
    }
}

impl PatternParams {
    /// The description of the pattern in a capture.
    pub fn pattern(&self) -> Pattern {
        let rotation = self.rotation_deg.to_radians();
        Pattern { kind: self.kind, columns: self.columns, rows: self.rows, rotation }
    }
}

/// The least rotation `atan(1/k)`, degrees, at which no two dots within `range_spacings` (the range of
/// disparities divided by the distance between dots) are on the same epipolar line: neighbours on such
/// a line are `sqrt(k^2 + 1)` spacings apart.
///
/// ```
/// use facerecon_core::synthetic::pattern::rotation_for_range;
/// assert!((rotation_for_range(8.0) - 7.125).abs() < 0.001);
/// ```
pub fn rotation_for_range(range_spacings: f64) -> f64 {
    let mut k = 1u32;
    while f64::from(k * k + 1).sqrt() < range_spacings.min(LARGEST_RANGE_SPACINGS) {
        k += 1;
    }
    (1.0 / f64::from(k)).atan().to_degrees()
}

/// Largest range of disparities that [`rotation_for_range`] considers, in distances between dots.
const LARGEST_RANGE_SPACINGS: f64 = 60.0;
/// Samples per pixel of the projector image in each direction.
const SAMPLES: usize = 4;
/// Half width of the smooth edges of dots in the projector image: reduces the aliasing of the few
/// samples, symmetric about the edge.
const EDGE_PX: f64 = 0.35;
/// Least distance between dots (or stripes), projector pixels: below it a dot has less than 2 pixels.
const LEAST_SPACING_PX: f64 = 4.0;

/// Draws the projector image: white dots or coloured stripes on black, 8 bit sRGB. The dot of column
/// `c` and row `r` is centred at [`Design::pixel`] of `(c, r)`.
///
/// ```
/// use facerecon_core::math::Vec2;
/// use facerecon_core::synthetic::pattern::{Design, PatternParams, pattern_image};
///
/// let params = PatternParams {
///     columns: 8, rows: 6, width_px: 80, height_px: 60, ..Default::default()
/// };
/// let image = pattern_image(&params)?;
/// let dot = Design::new(&params).pixel(Vec2::new(3.0, 2.0));
/// assert_eq!(image.at(dot.x.round() as usize, dot.y.round() as usize), [255; 3]);
/// # Ok::<(), facerecon_core::synthetic::pattern::PatternError>(())
/// ```
///
/// # Errors
/// [`PatternError`] for parameters out of range and for patterns too fine for the image.
pub fn pattern_image(params: &PatternParams) -> Result<Rgb, PatternError> {
    params.check("pattern", None)?;
    let design = Design::new(params);
    let (width, height) = (params.width_px, params.height_px);
    if design.spacing_px < LEAST_SPACING_PX {
        return Err(PatternError::TooFine {
            columns: params.columns,
            rows: params.rows,
            width,
            height,
            spacing_px: design.spacing_px,
            needed_px: LEAST_SPACING_PX,
        });
    }
    Ok(Rgb::par_from_fn(width, height, |x, y| {
        let mut sum = [0.0; 3];
        for sample in 0..SAMPLES * SAMPLES {
            let offset = |k: usize| (k as f64 + 0.5) / SAMPLES as f64 - 0.5;
            let x = x as f64 + offset(sample % SAMPLES);
            let y = y as f64 + offset(sample / SAMPLES);
            let color = design.light(design.lattice(x, y), EDGE_PX / design.spacing_px);
            for k in 0..3 {
                sum[k] += color[k] / (SAMPLES * SAMPLES) as f64;
            }
        }
        sum.map(|light| srgb_from_linear(light).round() as u8)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec2;
    use crate::render::linear_from_srgb;

    #[test]
    fn dots_are_centred_at_their_lattice_points() {
        let params = PatternParams {
            columns: 23,
            rows: 15,
            width_px: 400,
            height_px: 300,
            rotation_deg: 7.125,
            ..PatternParams::default()
        };
        let image = pattern_image(&params).unwrap();
        let design = Design::new(&params);
        for row in 0..15 {
            for column in 0..23 {
                let p = design.pixel(Vec2::new(f64::from(column), f64::from(row)));
                let half = design.spacing_px / 2.0;
                let (mut sum, mut at) = (0.0, Vec2::zeros());
                for y in 0..300 {
                    for x in 0..400 {
                        let q = Vec2::new(f64::from(x), f64::from(y));
                        if (q - p).norm() < half {
                            let light = linear_from_srgb(image.at(x as usize, y as usize)[0]);
                            sum += light;
                            at += q * light;
                        }
                    }
                }
                assert!((at / sum - p).norm() < 0.02, "{column},{row}: {:?}", at / sum - p);
                let area = std::f64::consts::PI * (0.2 * design.spacing_px).powi(2);
                assert!((sum / area - 1.0).abs() < 0.03);
            }
        }
    }

    #[test]
    fn three_neighbouring_stripes_are_unique() {
        let mut seen = std::collections::BTreeSet::new();
        for i in 0..STRIPE_PERIOD {
            let triple = [0, 1, 2].map(|k| stripe(i + k).color_index);
            assert!(triple[0] != triple[1]);
            assert!(seen.insert(triple), "{triple:?} occurs twice");
        }
        let widths: Vec<f64> = (0..60).map(|i| stripe(i).width).collect();
        assert!(widths.iter().any(|w| *w < 0.4) && widths.iter().any(|w| *w > 0.5));
        let params =
            PatternParams { kind: PatternKind::Stripes, columns: 40, ..Default::default() };
        let image = pattern_image(&params).unwrap();
        let design = Design::new(&params);
        for i in 0..40 {
            let middle = Vec2::new(i as f64 + stripe(i).width / 2.0, 30.0);
            let p = design.pixel(middle);
            let expected = PALETTE[stripe(i).color_index].map(|v| (v * 255.0) as u8);
            assert_eq!(image.at(p.x.round() as usize, p.y.round() as usize), expected);
        }
    }

    #[test]
    fn too_fine_or_invalid_patterns_are_refused_and_rotations_recommended() {
        let params = PatternParams { columns: 600, ..Default::default() };
        let message = pattern_image(&params).unwrap_err().to_string();
        assert!(message.contains("600x64") && message.contains("larger image"), "{message}");
        let params = PatternParams { dot_fraction: 1.5, ..Default::default() };
        assert!(pattern_image(&params).unwrap_err().to_string().contains("dot_fraction"));
        assert!((rotation_for_range(8.0) - 7.125).abs() < 1e-3);
        assert_eq!(rotation_for_range(1.0), 45.0);
    }
}
