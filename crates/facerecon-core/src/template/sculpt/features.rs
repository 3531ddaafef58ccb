//! Lines of the face that the mesh must follow, and the places of the landmarks, in the chart.

use super::Sculpt;
use nalgebra::Vector2;
use std::f64::consts::TAU;

/// A line that mesh edges run along.
#[derive(Debug, Clone)]
pub(crate) struct Feature {
    /// Dense polyline in the chart.
    pub(crate) line: Vec<Vector2<f64>>,
    pub(crate) closed: bool,
    /// Distance of vertices along it in the fine head, mm.
    pub(crate) spacing: f64,
    /// Nearer to an earlier vertex than this, that one is used instead, mm.
    pub(crate) apart: f64,
    /// Left out of the coarse head.
    pub(crate) fine_only: bool,
}

/// Samples of each line.
const SAMPLES: usize = 160;

impl Sculpt {
    /// Chart position on the front midline at height `y`.
    pub(crate) fn midline_at(&self, y: f64) -> Vector2<f64> {
        let (mut low, mut high) = (-0.9_f64, 1.2_f64);
        for _ in 0..60 {
            let a = 0.5 * (low + high);
            let (s, c, v) = Self::direction(Vector2::new(a.cos(), a.sin()));
            if self.mask(s, c, v).y < y { low = a } else { high = a }
        }
        Vector2::new(low.cos(), low.sin())
    }

    /// Chart position where the mask has the given coordinates: (x, y) in front, (z, y) at the
    /// side.
    fn locate(&self, target: [f64; 2], front: bool) -> Vector2<f64> {
        if front && target[0] < 1e-9 {
            return self.midline_at(target[1]);
        }
        let read = |q: Vector2<f64>| {
            let (s, c, v) = Self::direction(q);
            let p = self.mask(s, c, v);
            Vector2::new(if front { p.x } else { p.z }, p.y)
        };
        let target = Vector2::new(target[0], target[1]);
        let mut q = if front { Vector2::new(0.75, 0.1) } else { Vector2::new(0.0, 0.1) };
        for _ in 0..60 {
            let here = read(q);
            let miss = target - here;
            if miss.norm() < 1e-9 {
                break;
            }
            let h = 1e-5;
            let dx = (read(q + Vector2::new(-h, 0.0)) - here) / -h;
            let dy = (read(q + Vector2::new(0.0, h)) - here) / h;
            let det = dx.x * dy.y - dx.y * dy.x;
            let mut step = Vector2::new(
                (dy.y * miss.x - dy.x * miss.y) / det,
                (dx.x * miss.y - dx.y * miss.x) / det,
            );
            let length = step.norm();
            if length > 0.08 {
                step *= 0.08 / length;
            }
            q += step;
            let r = q.norm();
            if r > 0.9995 {
                q *= 0.9995 / r;
            }
        }
        q
    }

    /// All lines of the half head.
    pub(crate) fn features(&self) -> Vec<Feature> {
        let mut out = Vec::new();
        let front = |points: &mut dyn Iterator<Item = [f64; 2]>| -> Vec<Vector2<f64>> {
            points.map(|p| self.locate(p, true)).collect()
        };
        let mut add = |line, closed, spacing: f64, fine_only| {
            // The ball begins right behind the margin of the lids, elsewhere rows stay apart.
            let apart = if spacing < 2.05 { 0.2 } else { 0.45 * spacing };
            out.push(Feature { line, closed, spacing, apart, fine_only });
        };
        let unit = |k: usize| k as f64 / SAMPLES as f64;

        // Eye: margin of the lids, the line where they meet the ball, the fold above.
        let [inner, outer] = [self.eye.shape.inner, self.eye.shape.outer];
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        // Denser toward the corners, where the margins turn.
        let ease = |t: f64| 0.5 - 0.5 * (std::f64::consts::PI * t).cos();
        let margin = |from: f64, to: f64, inset: f64| {
            let up = (0..=SAMPLES).map(move |k| (mix(from, to, ease(unit(k))), true));
            let low = (1..SAMPLES).rev().map(move |k| (mix(from, to, ease(unit(k))), false));
            up.chain(low).map(move |(x, upper)| {
                let (u, l) = self.eye.margins(x);
                let middle = 0.5 * (u + l);
                [x, if upper { (u - inset).max(middle) } else { (l + inset).min(middle) }]
            })
        };
        add(front(&mut margin(inner[0], outer[0], 0.0)), true, 2.1, false);
        add(front(&mut margin(inner[0] + 0.9, outer[0] - 0.8, 0.5)), true, 2.0, true);
        add(
            front(&mut (0..=SAMPLES).map(|k| {
                let x = mix(inner[0] + 2.0, outer[0] - 0.5, unit(k));
                [x, self.eye.fold(x)]
            })),
            false,
            2.4,
            true,
        );

        // Mouth: lip line, the rolls beside it, the vermilion borders.
        let half = self.mouth.half_width();
        for (share, spacing, fine_only) in [
            (0.0, 2.2, false),
            (0.24, 2.4, true),
            (-0.22, 2.4, true),
            (1.0, 2.4, false),
            (-1.0, 2.6, false),
        ] {
            let reach = if share == 0.0 { 1.0 } else { 0.985 };
            // The midline has no vertex of its own at the rolls.
            let start = if fine_only { 0.05 } else { 0.0 };
            let line = front(&mut (0..=SAMPLES).map(|k| {
                let x = half * mix(start, reach, unit(k));
                let (line, (up, low)) = (self.mouth.line(x), self.mouth.borders(x));
                [x, if share >= 0.0 { mix(line, up, share) } else { mix(line, low, -share) }]
            }));
            add(line, false, spacing, fine_only);
        }

        // Nose: rim and inside of the nostril, furrow around the wing.
        for (r, spacing) in [(1.1, 2.1), (0.55, 2.1)] {
            let ring = (0..SAMPLES).map(|k| self.nose.nostril_point(TAU * unit(k), r));
            add(front(&mut { ring }), true, spacing, true);
        }
        let arc = (0..=SAMPLES).map(|k| self.nose.wing_point(mix(-1.4, 1.9, unit(k)), 1.06));
        add(front(&mut { arc }), false, 2.3, true);

        // Ear: rings from the root to the bowl.
        for (fraction, spacing, fine_only) in [
            (1.0, 4.6, false),
            (0.90, 5.0, true),
            (0.80, 4.4, true),
            (0.74, 4.0, false),
            (0.69, 3.8, true),
            (0.63, 3.8, true),
            (0.56, 3.8, true),
            (0.46, 3.4, false),
            (0.33, 3.2, true),
            (0.17, 3.2, false),
        ] {
            let ring = (0..SAMPLES)
                .map(|k| {
                    let [y, z] = self.ear.side_point(TAU * unit(k), fraction);
                    self.locate([z, y], false)
                })
                .collect();
            add(ring, true, spacing, fine_only);
        }
        out
    }

    /// Landmarks of the front midline by height, top to bottom.
    pub(crate) fn midline_landmarks(&self) -> [(&'static str, f64); 6] {
        let (up, low) = self.mouth.borders(0.0);
        [
            ("forehead", 69.0),
            ("nose_saddle", 27.0),
            ("nose_tip", -13.5),
            ("mouth_up", up),
            ("mouth_down", low),
            ("chin", -86.0),
        ]
    }

    /// Paired landmarks of the half head (named without their side).
    pub(crate) fn side_landmarks(&self) -> [(&'static str, Vector2<f64>); 6] {
        let half = self.mouth.half_width();
        let root = |degrees: f64| {
            let [y, z] = self.ear.side_point(degrees.to_radians(), 1.0);
            self.locate([z, y], false)
        };
        [
            ("eye_{}_inner", self.locate(self.eye.shape.inner, true)),
            ("eye_{}_outer", self.locate(self.eye.shape.outer, true)),
            ("mouth_{}", self.locate([half, self.mouth.line(half)], true)),
            ("ala_{}", self.locate(self.nose.ala(), true)),
            ("ear_{}_upper", root(328.0)),
            ("ear_{}_lower", root(222.0)),
        ]
    }
}
