//! Where stripes begin and end.

use crate::data::Rgb;

use super::StripesParams;

/// The left or right edge of a stripe in one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Edge {
    /// Place along the row, pixels.
    pub x: f64,
    /// Whether the stripe begins here (rising brightness).
    pub rising: bool,
    /// Share of red, green and blue in the stripe.
    pub color: [f64; 3],
    /// Width of the stripe, pixels; 0 where its other edge is not seen.
    pub width: f64,
}

/// The edges of one row, left to right.
pub(super) fn row_edges(image: &Rgb, y: usize, params: &StripesParams) -> Vec<Edge> {
    let (width, height) = image.size();
    if width < 16 {
        return Vec::new();
    }
    let rows = y.saturating_sub(params.average_rows)..(y + params.average_rows + 1).min(height);
    let mut mean = vec![[0.0_f64; 3]; width];
    for row in rows.clone() {
        for (m, v) in mean.iter_mut().zip(image.row(row)) {
            (0..3).for_each(|c| m[c] += f64::from(v[c]) / rows.len() as f64);
        }
    }
    let radius = (3.0 * params.smooth_px).ceil() as isize;
    let sigma2 = params.smooth_px * params.smooth_px;
    let kernel: Vec<f64> =
        (-radius..=radius).map(|t| (-0.5 * (t * t) as f64 / sigma2).exp()).collect();
    let total: f64 = kernel.iter().sum();
    let at = |x: isize| mean[x.clamp(0, width as isize - 1) as usize];
    // Derivative of the Gaussian-smoothed brightness.
    let slope: Vec<f64> = (0..width as isize)
        .map(|x| {
            (-radius..=radius)
                .zip(&kernel)
                .map(|(t, k)| at(x + t).iter().sum::<f64>() * k * t as f64 / sigma2 / total)
                .sum()
        })
        .collect();
    let mut edges = Vec::new();
    for x in 1..width - 1 {
        let (a, b, c) = (slope[x - 1].abs(), slope[x].abs(), slope[x + 1].abs());
        // small beside a strong edge nearby is its ripple
        let near = slope[x.saturating_sub(8)..(x + 9).min(width)].iter();
        let strongest = near.fold(0.0_f64, |m, s| m.max(s.abs()));
        if b > a && b >= c && b > params.min_step && b > 0.2 * strongest {
            let curvature = a - 2.0 * b + c;
            let shift = if curvature < 0.0 { 0.5 * (a - c) / curvature } else { 0.0 };
            let rising = slope[x] > 0.0;
            edges.push(Edge { x: x as f64 + shift, rising, color: [0.0; 3], width: 0.0 });
        }
    }
    describe(&mut edges, &mean);
    edges
}

/// Gives every edge the width and colour of its stripe: between a rising edge and the falling one
/// after it.
fn describe(edges: &mut [Edge], mean: &[[f64; 3]]) {
    for i in 0..edges.len() {
        let other =
            if edges[i].rising { edges.get(i + 1) } else { i.checked_sub(1).map(|j| &edges[j]) };
        let partner = other.filter(|o| o.rising != edges[i].rising).map(|o| o.x);
        let x = edges[i].x;
        let inward = if edges[i].rising { 1.0 } else { -1.0 };
        let (from, to) = match partner {
            Some(o) => (x + 0.3 * (o - x), x + 0.7 * (o - x)),
            None => (x + 1.5 * inward, x + 3.0 * inward),
        };
        edges[i].width = partner.map_or(0.0, |o| (o - x).abs());
        let last = mean.len() - 1;
        let pixel = |p: f64| (p.round().max(0.0) as usize).min(last);
        let (a, b) = (pixel(from.min(to)), pixel(from.max(to)));
        let mut sum = [0.0; 3];
        mean[a..=b].iter().for_each(|m| (0..3).for_each(|c| sum[c] += m[c]));
        let total: f64 = sum.iter().sum::<f64>().max(1e-9);
        edges[i].color = sum.map(|s| s / total);
    }
}

/// The edges of all rows, linked down the photo: an edge has the number of its stripe's edge in
/// the row above where one continues it.
pub(super) struct Chains {
    pub rows: Vec<Vec<Edge>>,
    /// Chain number of every edge.
    pub ids: Vec<Vec<usize>>,
}

impl Chains {
    /// Links each edge to the nearest of its kind one row up (two, where that row lacks it).
    pub(super) fn link(rows: Vec<Vec<Edge>>) -> Self {
        let mut ids: Vec<Vec<usize>> = Vec::with_capacity(rows.len());
        let mut next = 0;
        for (n, row) in rows.iter().enumerate() {
            let mut taken = std::collections::BTreeSet::new();
            let mut own = Vec::with_capacity(row.len());
            for edge in row {
                let continued = (1..=2).filter(|up| n >= *up).find_map(|up| {
                    let above = rows[n - up].iter().zip(&ids[n - up]);
                    above
                        .filter(|(a, _)| {
                            let change: f64 =
                                (0..3).map(|c| (a.color[c] - edge.color[c]).abs()).sum();
                            a.rising == edge.rising && change < 0.35
                        })
                        .map(|(a, id)| ((a.x - edge.x).abs(), *id))
                        .filter(|(distance, id)| *distance < 1.8 && !taken.contains(id))
                        .min_by(|a, b| a.0.total_cmp(&b.0))
                        .map(|(_, id)| id)
                });
                let id = continued.unwrap_or_else(|| {
                    next += 1;
                    next - 1
                });
                taken.insert(id);
                own.push(id);
            }
            ids.push(own);
        }
        Self { rows, ids }
    }

    /// Number of edges.
    pub(super) fn count(&self) -> usize {
        self.rows.iter().map(Vec::len).sum()
    }
}
