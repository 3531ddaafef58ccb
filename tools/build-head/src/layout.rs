//! Vertices of the half head before triangulation: rows along the midline, the neck border and the
//! feature lines, and free vertices at even distances between them.

use crate::feature_lines::{
    feature_lines, lip_line, midline_at, midline_landmarks, side_landmarks,
};
use facerecon_core::math::Vec3;
use facerecon_core::template::build::{NECK_LATITUDE_DEG, Sculpt};
use nalgebra::{Matrix2, Vector2};
use std::f64::consts::{FRAC_PI_2, PI};

/// Resolution of a head.
#[derive(Debug, Clone, Copy)]
pub struct Resolution {
    /// Factor on the edge lengths between the feature lines.
    pub(crate) scale: f64,
    /// Factor on the spacing along feature lines.
    pub(crate) along: f64,
    /// Whether the lines of fine heads are included.
    pub(crate) all_features: bool,
    /// Candidates for free vertices per unit of the chart in each direction.
    pub(crate) candidates: usize,
}

/// What a vertex lies on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum VertexKind {
    Midline,
    Border,
    Feature,
    Free,
}

/// Least spacing of free vertices as a fraction of the target edge length; below 1, as random darts
/// leave gaps.
const DART_SPACING: f64 = 0.80;

/// Vertices of the half head in the chart.
#[derive(Debug, Clone, Default)]
pub(crate) struct Layout {
    pub(crate) q: Vec<Vector2<f64>>,
    pub(crate) kinds: Vec<VertexKind>,
    /// Edges that the mesh must have.
    pub(crate) edges: Vec<[usize; 2]>,
    /// Landmark names (paired ones with `{}` for the side) and vertices.
    pub(crate) landmarks: Vec<(&'static str, usize)>,
}

/// Target edge length at a point of the head, mm, for scale 1: about 2.5 mm at eyes, nose and mouth,
/// 3.6 mm at the ears, growing with the distance from them to at most 10 mm.
pub(crate) fn edge_length(p: &Vec3) -> f64 {
    let gap = |centre: [f64; 3], radii: [f64; 3]| {
        let d = Vec3::new(p.x.abs() - centre[0], p.y - centre[1], p.z - centre[2]);
        let e = Vec3::new(d.x / radii[0], d.y / radii[1], d.z / radii[2]).norm();
        (1.0 - 1.0 / e.max(1.0)) * d.norm()
    };
    let core = gap([31.0, 22.0, 86.0], [19.0, 10.0, 14.0])
        .min(gap([0.0, -16.0, 100.0], [18.0, 16.0, 25.0]))
        .min(gap([0.0, -49.0, 92.0], [29.0, 13.0, 20.0]));
    let ear = gap([82.0, 0.0, -12.0], [14.0, 34.0, 22.0]);
    (2.45 + 0.085 * core).min(3.6 + 0.13 * ear).min(10.0)
}

/// First fundamental form of the surface from its tangents: `dq' M dq` is a squared length in mm.
pub(crate) fn metric([a, b]: [Vec3; 2]) -> Matrix2<f64> {
    Matrix2::new(a.dot(&a), a.dot(&b), a.dot(&b), b.dot(&b))
}

/// Derivatives of the surface along the chart's axes.
pub(crate) fn tangents(sculpt: &Sculpt, q: Vector2<f64>) -> [Vec3; 2] {
    /// Step of the difference quotient, chart units.
    const H: f64 = 2e-4;
    let inward = |d: Vector2<f64>| if (q + d).norm() < 1.0 { d } else { -d };
    [Vector2::new(H, 0.0), Vector2::new(0.0, H)].map(|d| {
        let (d, sign) = (inward(d), if inward(d) == d { 1.0 } else { -1.0 });
        (sculpt.point(q + d) - sculpt.point(q)) * (sign / H)
    })
}

impl Layout {
    pub(crate) fn new(sculpt: &Sculpt, resolution: Resolution) -> Self {
        let mut layout = Self::default();
        layout.midline(sculpt, resolution);
        layout.border(sculpt, resolution);
        for (name, q) in side_landmarks(sculpt) {
            let vertex = layout.push(q, VertexKind::Feature);
            layout.landmarks.push((name, vertex));
        }
        for feature in feature_lines(sculpt) {
            if resolution.all_features || !feature.fine_only {
                let line = resample(
                    sculpt,
                    &feature.line,
                    feature.closed,
                    feature.spacing * resolution.along,
                );
                let merge_distance = feature.merge_distance * resolution.along;
                layout.chain(sculpt, &line, feature.closed, merge_distance);
            }
        }
        layout.fill(sculpt, resolution);
        layout
    }

    fn push(&mut self, q: Vector2<f64>, kinds: VertexKind) -> usize {
        self.q.push(q);
        self.kinds.push(kinds);
        self.q.len() - 1
    }

    fn midline(&mut self, sculpt: &Sculpt, resolution: Resolution) {
        let neck = NECK_LATITUDE_DEG.to_radians();
        let mut heights: Vec<(f64, Option<&'static str>)> =
            midline_landmarks(sculpt).iter().map(|m| (m.1, Some(m.0))).collect();
        heights.push((lip_line(sculpt), None));
        heights.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Chart angles that must have a vertex: neck, landmarks and lip line, neck.
        let mut stops = vec![-neck];
        stops.extend(heights.iter().map(|h| {
            let q = midline_at(sculpt, h.0);
            q.y.atan2(q.x)
        }));
        stops.push(PI + neck);
        for (k, pair) in stops.windows(2).enumerate() {
            let angles = even_steps(pair[0], pair[1], resolution.scale, |a| {
                sculpt.point(Vector2::new(a.cos(), a.sin()))
            });
            for (i, a) in angles.iter().enumerate() {
                if i > 0 || k == 0 {
                    self.push(Vector2::new(a.cos(), a.sin()), VertexKind::Midline);
                }
            }
            if let Some((_, Some(name))) = heights.get(k) {
                self.landmarks.push((name, self.q.len() - 1));
            }
        }
        self.edges.extend((1..self.q.len()).map(|i| [i - 1, i]));
    }

    fn border(&mut self, sculpt: &Sculpt, resolution: Resolution) {
        let (front, back) = (0, self.q.len() - 1);
        let chart = |theta: f64| {
            let latitude = -NECK_LATITUDE_DEG.to_radians();
            let d = Vec3::new(
                latitude.cos() * theta.sin(),
                latitude.sin(),
                latitude.cos() * theta.cos(),
            );
            let r = d.x.clamp(-1.0, 1.0).acos() / FRAC_PI_2;
            let flat = d.y.hypot(d.z);
            Vector2::new(r * d.z / flat, r * d.y / flat)
        };
        let steps = even_steps(0.0, PI, resolution.scale, |t| sculpt.point(chart(t)));
        let mut last = front;
        for t in &steps[1..steps.len() - 1] {
            let vertex = self.push(chart(*t), VertexKind::Border);
            self.edges.push([last, vertex]);
            last = vertex;
        }
        self.edges.push([last, back]);
    }

    /// Adds a row of vertices with the edges between them. A vertex closer than `merge_distance` (mm)
    /// to an earlier one is merged with it.
    fn chain(&mut self, sculpt: &Sculpt, line: &[Vector2<f64>], closed: bool, merge_distance: f64) {
        let before = self.q.len();
        let mut row = Vec::with_capacity(line.len());
        for &q in line {
            let m = metric(tangents(sculpt, q * 0.9999));
            let closest = (0..before)
                .map(|i| (((self.q[i] - q).transpose() * m * (self.q[i] - q))[(0, 0)].sqrt(), i))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let vertex = match closest {
                Some((d, i)) if d < merge_distance => i,
                _ => self.push(q, VertexKind::Feature),
            };
            if row.last() != Some(&vertex) {
                row.push(vertex);
            }
        }
        self.edges.extend(row.windows(2).map(|w| [w[0], w[1]]));
        if closed && row.len() > 2 && row[0] != row[row.len() - 1] {
            self.edges.push([row[row.len() - 1], row[0]]);
        }
    }

    /// Adds free vertices by dart throwing: a candidate becomes a vertex when no other vertex is closer
    /// than `DART_SPACING` of the target edge length, measured along the surface by the metric at the
    /// candidate.
    fn fill(&mut self, sculpt: &Sculpt, resolution: Resolution) {
        let n = resolution.candidates;
        let mut candidates: Vec<Vector2<f64>> = Vec::new();
        for i in 0..2 * n {
            for j in 0..2 * n {
                let q = Vector2::new(i as f64 + 0.5, j as f64 + 0.5) / n as f64
                    - Vector2::new(1.0, 1.0);
                candidates.push(q);
            }
        }
        shuffle(&mut candidates);
        let sine = -NECK_LATITUDE_DEG.to_radians().sin();
        for q in candidates {
            let r = q.norm();
            if r > 0.995 || (r * FRAC_PI_2).sin() * q.y < (sine + 0.01) * r {
                continue;
            }
            let m = metric(tangents(sculpt, q));
            let spacing = DART_SPACING * resolution.scale * edge_length(&sculpt.point(q));
            let limit = spacing * spacing;
            let free = self.q.iter().all(|p| {
                let d = p - q;
                m[(0, 0)] * d.x * d.x + 2.0 * m[(0, 1)] * d.x * d.y + m[(1, 1)] * d.y * d.y > limit
            });
            if free {
                self.push(q, VertexKind::Free);
            }
        }
    }
}

/// Parameters from `a` to `b`, both included, whose points are one target edge length apart.
fn even_steps(a: f64, b: f64, scale: f64, point: impl Fn(f64) -> Vec3) -> Vec<f64> {
    /// Steps of the arc length integral.
    const FINE: usize = 600;
    let at = |k: usize| a + (b - a) * k as f64 / FINE as f64;
    let mut sum = vec![0.0];
    for k in 0..FINE {
        let (p, q) = (point(at(k)), point(at(k + 1)));
        sum.push(sum[k] + (q - p).norm() / (scale * edge_length(&p)));
    }
    let n = (sum[FINE].round() as usize).max(1);
    (0..=n)
        .map(|i| {
            let target = sum[FINE] * i as f64 / n as f64;
            let k = sum.partition_point(|&s| s < target).clamp(1, FINE);
            let f = (target - sum[k - 1]) / (sum[k] - sum[k - 1]).max(1e-300);
            if i == n { b } else { at(k - 1) + (at(k) - at(k - 1)) * f }
        })
        .collect()
}

/// Points at even distances (mm, along the surface) on a polyline of the chart.
fn resample(
    sculpt: &Sculpt,
    line: &[Vector2<f64>],
    closed: bool,
    spacing: f64,
) -> Vec<Vector2<f64>> {
    let mut line = line.to_vec();
    if closed {
        line.push(line[0]);
    }
    let points: Vec<Vec3> = line.iter().map(|&q| sculpt.point(q)).collect();
    let mut sum = vec![0.0];
    for w in points.windows(2) {
        sum.push(sum[sum.len() - 1] + (w[1] - w[0]).norm());
    }
    let total = sum[sum.len() - 1];
    let n = ((total / spacing).round() as usize).max(3);
    (0..if closed { n } else { n + 1 })
        .map(|i| {
            let target = total * i as f64 / n as f64;
            let k = sum.partition_point(|&s| s < target).clamp(1, line.len() - 1);
            let f = ((target - sum[k - 1]) / (sum[k] - sum[k - 1]).max(1e-300)).clamp(0.0, 1.0);
            line[k - 1] + (line[k] - line[k - 1]) * f
        })
        .collect()
}

/// Fisher-Yates shuffle with a fixed linear congruential sequence, so that the result is repeatable.
fn shuffle<T>(items: &mut [T]) {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    for i in (1..items.len()).rev() {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        items.swap(i, ((state >> 33) % (i as u64 + 1)) as usize);
    }
}
