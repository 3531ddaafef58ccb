//! Vertices of the built-in head before it is a mesh: rows along the midline, the neck border
//! and the features, and an even filling between them.

use super::sculpt::{NECK_LATITUDE_DEG, Sculpt};
use crate::math::Vec3;
use nalgebra::{Matrix2, Vector2};

/// How fine a head is made.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fineness {
    /// Factor on all edge lengths of the filling.
    pub(crate) scale: f64,
    /// Factor on the spacing along features.
    pub(crate) along: f64,
    /// Whether the secondary features are followed.
    pub(crate) all_features: bool,
    /// Candidates per unit of the chart in each direction for the filling.
    pub(crate) candidates: usize,
}

/// What holds a vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Hold {
    Midline,
    Border,
    Feature,
    Free,
}

/// Vertices of the half head in the chart.
#[derive(Debug, Clone, Default)]
pub(crate) struct Layout {
    pub(crate) q: Vec<Vector2<f64>>,
    pub(crate) hold: Vec<Hold>,
    /// Edges that the mesh must have.
    pub(crate) edges: Vec<[usize; 2]>,
    /// Landmark names (paired ones with `{}` for the side) and vertices.
    pub(crate) landmarks: Vec<(&'static str, usize)>,
}

/// Wanted edge length at a point of the head, mm, for scale 1.
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

/// Inner products of the surface's tangents at `q`: |J dq| is a length in mm.
pub(crate) fn metric(sculpt: &Sculpt, q: Vector2<f64>) -> Matrix2<f64> {
    let [a, b] = tangents(sculpt, q);
    Matrix2::new(a.dot(&a), a.dot(&b), a.dot(&b), b.dot(&b))
}

/// Derivatives of the surface along the chart's axes.
pub(crate) fn tangents(sculpt: &Sculpt, q: Vector2<f64>) -> [Vec3; 2] {
    let h = 2e-4;
    let inward = |d: Vector2<f64>| if (q + d).norm() < 1.0 { d } else { -d };
    [Vector2::new(h, 0.0), Vector2::new(0.0, h)].map(|d| {
        let (d, sign) = (inward(d), if inward(d) == d { 1.0 } else { -1.0 });
        (sculpt.point(q + d) - sculpt.point(q)) * (sign / h)
    })
}

impl Layout {
    pub(crate) fn new(sculpt: &Sculpt, fineness: Fineness) -> Self {
        let mut layout = Self::default();
        layout.midline(sculpt, fineness);
        layout.border(sculpt, fineness);
        for (name, q) in sculpt.side_landmarks() {
            let vertex = layout.push(q, Hold::Feature);
            layout.landmarks.push((name, vertex));
        }
        for feature in sculpt.features() {
            if fineness.all_features || !feature.fine_only {
                let line = resample(
                    sculpt,
                    &feature.line,
                    feature.closed,
                    feature.spacing * fineness.along,
                );
                layout.chain(sculpt, &line, feature.closed, feature.apart * fineness.along);
            }
        }
        layout.fill(sculpt, fineness);
        layout
    }

    fn push(&mut self, q: Vector2<f64>, hold: Hold) -> usize {
        self.q.push(q);
        self.hold.push(hold);
        self.q.len() - 1
    }

    fn midline(&mut self, sculpt: &Sculpt, fineness: Fineness) {
        let neck = NECK_LATITUDE_DEG.to_radians();
        let marks = sculpt.midline_landmarks();
        let mut stops = vec![-neck];
        let mut heights: Vec<(f64, Option<&'static str>)> =
            marks.iter().map(|m| (m.1, Some(m.0))).collect();
        heights.push((sculpt.lip_line(), None));
        heights.sort_by(|a, b| a.0.total_cmp(&b.0));
        stops.extend(heights.iter().map(|h| {
            let q = sculpt.midline_at(h.0);
            q.y.atan2(q.x)
        }));
        stops.push(std::f64::consts::PI + neck);
        for (k, pair) in stops.windows(2).enumerate() {
            let angles = even_steps(pair[0], pair[1], fineness.scale, |a| {
                sculpt.point(Vector2::new(a.cos(), a.sin()))
            });
            for (i, a) in angles.iter().enumerate() {
                if i > 0 || k == 0 {
                    self.push(Vector2::new(a.cos(), a.sin()), Hold::Midline);
                }
            }
            if let Some((_, Some(name))) = heights.get(k) {
                self.landmarks.push((name, self.q.len() - 1));
            }
        }
        self.edges.extend((1..self.q.len()).map(|i| [i - 1, i]));
    }

    fn border(&mut self, sculpt: &Sculpt, fineness: Fineness) {
        let (front, back) = (0, self.q.len() - 1);
        let chart = |theta: f64| {
            let latitude = -NECK_LATITUDE_DEG.to_radians();
            let d = Vec3::new(
                latitude.cos() * theta.sin(),
                latitude.sin(),
                latitude.cos() * theta.cos(),
            );
            let r = d.x.clamp(-1.0, 1.0).acos() / std::f64::consts::FRAC_PI_2;
            let flat = d.y.hypot(d.z);
            Vector2::new(r * d.z / flat, r * d.y / flat)
        };
        let steps =
            even_steps(0.0, std::f64::consts::PI, fineness.scale, |t| sculpt.point(chart(t)));
        let mut last = front;
        for t in &steps[1..steps.len() - 1] {
            let vertex = self.push(chart(*t), Hold::Border);
            self.edges.push([last, vertex]);
            last = vertex;
        }
        self.edges.push([last, back]);
    }

    /// Adds a row of feature vertices; one that falls on or near an earlier vertex is that one.
    fn chain(&mut self, sculpt: &Sculpt, line: &[Vector2<f64>], closed: bool, near: f64) {
        let before = self.q.len();
        let mut row = Vec::with_capacity(line.len());
        for &q in line {
            let m = metric(sculpt, q * 0.9999);
            let close = (0..before)
                .map(|i| (((self.q[i] - q).transpose() * m * (self.q[i] - q))[(0, 0)].sqrt(), i))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let vertex = match close {
                Some((d, i)) if d < near => i,
                _ => self.push(q, Hold::Feature),
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

    /// Fills the rest by throwing darts: a candidate stays when no vertex is nearer than the
    /// wanted edge length, measured along the surface by the metric at the candidate.
    fn fill(&mut self, sculpt: &Sculpt, fineness: Fineness) {
        let n = fineness.candidates;
        // The ear is small in the chart: candidates are twice as dense around it, in each direction.
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
            if r > 0.995 || (r * std::f64::consts::FRAC_PI_2).sin() * q.y < (sine + 0.01) * r {
                continue;
            }
            let m = metric(sculpt, q);
            let wanted = 0.80 * fineness.scale * edge_length(&sculpt.point(q));
            let limit = wanted * wanted;
            let free = self.q.iter().all(|p| {
                let d = p - q;
                m[(0, 0)] * d.x * d.x + 2.0 * m[(0, 1)] * d.x * d.y + m[(1, 1)] * d.y * d.y > limit
            });
            if free {
                self.push(q, Hold::Free);
            }
        }
    }
}

/// Parameters from `a` to `b` whose points are as far apart as wanted, both ends included.
fn even_steps(a: f64, b: f64, scale: f64, point: impl Fn(f64) -> Vec3) -> Vec<f64> {
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
            let wanted = sum[FINE] * i as f64 / n as f64;
            let k = sum.partition_point(|&s| s < wanted).clamp(1, FINE);
            let f = (wanted - sum[k - 1]) / (sum[k] - sum[k - 1]).max(1e-300);
            if i == n { b } else { at(k - 1) + (at(k) - at(k - 1)) * f }
        })
        .collect()
}

/// A polyline at even distances along the surface.
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
            let wanted = total * i as f64 / n as f64;
            let k = sum.partition_point(|&s| s < wanted).clamp(1, line.len() - 1);
            let f = ((wanted - sum[k - 1]) / (sum[k] - sum[k - 1]).max(1e-300)).clamp(0.0, 1.0);
            line[k - 1] + (line[k] - line[k - 1]) * f
        })
        .collect()
}

/// Fisher-Yates with a fixed linear congruential sequence: the same head every time.
fn shuffle<T>(items: &mut [T]) {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    for i in (1..items.len()).rev() {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        items.swap(i, ((state >> 33) % (i as u64 + 1)) as usize);
    }
}
