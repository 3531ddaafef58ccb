//! The edges of the stripes in one row.

use super::params::StripesParams;
use crate::data::Rgb;

/// Narrower photos have no edges, pixels: the windows below need this much.
const MIN_WIDTH_PX: usize = 16;
/// Rows above and below that are averaged with each, px: less noise, while a stripe hardly moves.
const AVERAGED_ROWS: usize = 2;
/// Radius of the smoothing kernel, in standard deviations.
const KERNEL_RADIUS: f64 = 3.0;
/// An edge is dropped beside one this many times stronger within a radius (pixels): it is a ripple
/// of compression or sharpening.
const RIPPLE_SHARE: f64 = 0.2;
const RIPPLE_RADIUS_PX: usize = 8;
/// Part of a stripe whose colour is averaged, as shares of its width: the blurred edges are left out.
const INNER_PART: [f64; 2] = [0.3, 0.7];
/// The same where the other edge of the stripe is missing, pixels from the edge.
const INNER_PX: [f64; 2] = [1.5, 3.0];

/// The left or right edge of a stripe in one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Edge {
    /// Position along the row, pixels.
    pub x: f64,
    /// Whether the stripe begins here (rising brightness).
    pub rising: bool,
    /// Share of red, green and blue in the stripe.
    pub color: [f64; 3],
    /// Width of the stripe, pixels; 0 where its other edge is missing.
    pub width: f64,
}

/// The edges of one row, left to right.
pub(super) fn row_edges(image: &Rgb, y: usize, params: &StripesParams) -> Vec<Edge> {
    if image.width() < MIN_WIDTH_PX {
        return Vec::new();
    }
    let mean = mean_row(image, y, AVERAGED_ROWS);
    let slope = brightness_slope(&mean, params.smooth_px);
    let mut edges = strongest_slopes(&slope, params.min_step);
    measure_stripes(&mut edges, &mean);
    edges
}

/// Mean colour of a row and of `around` rows above and below.
fn mean_row(image: &Rgb, y: usize, around: usize) -> Vec<[f64; 3]> {
    let (width, height) = image.size();
    let rows = y.saturating_sub(around)..(y + around + 1).min(height);
    let mut mean = vec![[0.0_f64; 3]; width];
    for row in rows.clone() {
        for (m, v) in mean.iter_mut().zip(image.row(row)) {
            (0..3).for_each(|c| m[c] += f64::from(v[c]) / rows.len() as f64);
        }
    }
    mean
}

/// Derivative of the Gaussian-smoothed brightness (sum of the colour channels), grey levels a pixel.
fn brightness_slope(mean: &[[f64; 3]], sigma_px: f64) -> Vec<f64> {
    let width = mean.len() as isize;
    let radius = (KERNEL_RADIUS * sigma_px).ceil() as isize;
    let sigma2 = sigma_px * sigma_px;
    let kernel: Vec<f64> =
        (-radius..=radius).map(|t| (-0.5 * (t * t) as f64 / sigma2).exp()).collect();
    let total: f64 = kernel.iter().sum();
    let at = |x: isize| mean[x.clamp(0, width - 1) as usize];
    (0..width)
        .map(|x| {
            (-radius..=radius)
                .zip(&kernel)
                .map(|(t, k)| at(x + t).iter().sum::<f64>() * k * t as f64 / sigma2 / total)
                .sum()
        })
        .collect()
}

/// Local maxima of the slope's magnitude, at the vertex of a parabola.
fn strongest_slopes(slope: &[f64], min_step: f64) -> Vec<Edge> {
    let width = slope.len();
    let mut edges = Vec::new();
    for x in 1..width - 1 {
        let (a, b, c) = (slope[x - 1].abs(), slope[x].abs(), slope[x + 1].abs());
        let near =
            &slope[x.saturating_sub(RIPPLE_RADIUS_PX)..(x + RIPPLE_RADIUS_PX + 1).min(width)];
        let strongest = near.iter().fold(0.0_f64, |m, s| m.max(s.abs()));
        if b > a && b >= c && b > min_step && b > RIPPLE_SHARE * strongest {
            let curvature = a - 2.0 * b + c;
            let shift = if curvature < 0.0 { 0.5 * (a - c) / curvature } else { 0.0 };
            let rising = slope[x] > 0.0;
            edges.push(Edge { x: x as f64 + shift, rising, color: [0.0; 3], width: 0.0 });
        }
    }
    edges
}

/// Measures width and colour of the stripe of every edge: between a rising edge and the falling one
/// after it.
fn measure_stripes(edges: &mut [Edge], mean: &[[f64; 3]]) {
    let last = mean.len() - 1;
    let pixel = |x: f64| (x.round().max(0.0) as usize).min(last);
    for i in 0..edges.len() {
        let Edge { x, rising, .. } = edges[i];
        let next = if rising { edges.get(i + 1) } else { i.checked_sub(1).map(|j| &edges[j]) };
        let other = next.filter(|o| o.rising != rising).map(|o| o.x);
        let inward = if rising { 1.0 } else { -1.0 };
        let [from, to] = match other {
            Some(other) => INNER_PART.map(|share| x + share * (other - x)),
            None => INNER_PX.map(|distance| x + distance * inward),
        };
        edges[i].width = other.map_or(0.0, |o| (o - x).abs());
        let (first, end) = (pixel(from.min(to)), pixel(from.max(to)));
        let mut sum = [0.0; 3];
        mean[first..=end].iter().for_each(|m| (0..3).for_each(|c| sum[c] += m[c]));
        let total: f64 = sum.iter().sum::<f64>().max(1e-9);
        edges[i].color = sum.map(|s| s / total);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_have_position_width_and_colour_of_their_stripe() {
        // a red stripe over pixels 20 to 29, half of it in pixel 30, and a blue one cut by the border
        let image = Rgb::from_fn(60, 5, |x, _| match x {
            20..=29 => [200, 0, 0],
            30 => [100, 0, 0],
            50.. => [0, 0, 200],
            _ => [0; 3],
        });
        let edges = row_edges(&image, 2, &StripesParams::default());
        let found: Vec<(bool, usize)> = edges
            .iter()
            .map(|e| (e.rising, e.color.iter().position(|c| *c > 0.9).unwrap()))
            .collect();
        assert_eq!(found, [(true, 0), (false, 0), (true, 2)]);
        for (edge, (x, width)) in edges.iter().zip([(19.5, 10.5), (30.0, 10.5), (49.5, 0.0)]) {
            assert!((edge.x - x).abs() < 0.1, "{edge:?}");
            assert!((edge.width - width).abs() < 0.15, "{edge:?}");
        }
    }
}
