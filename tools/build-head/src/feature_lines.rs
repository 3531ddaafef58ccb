//! Lines of the face along which mesh edges must run, and the landmarks, in the chart.

use facerecon_core::template::build::Sculpt;
use nalgebra::Vector2;
use std::f64::consts::{PI, TAU};

/// A line along which mesh edges run.
#[derive(Debug, Clone)]
pub(crate) struct FeatureLine {
    /// Dense polyline in the chart.
    pub(crate) line: Vec<Vector2<f64>>,
    pub(crate) closed: bool,
    /// Distance between vertices along the line in the fine head, mm.
    pub(crate) spacing: f64,
    /// A vertex closer than this to an earlier one is merged with it, mm.
    pub(crate) merge_distance: f64,
    /// Left out of the coarse head.
    pub(crate) fine_only: bool,
}

/// Samples of each line.
const SAMPLES: usize = 160;
/// Steps of the bisection (to machine precision) and most steps of Newton's method.
const SEARCH_STEPS: usize = 60;
/// Range of chart angles (radians) of the front midline, from the neck to above the forehead.
const FRONT_MIDLINE: (f64, f64) = (-0.9, 1.2);
/// Longest Newton step in the chart, so that the search does not leave the chart.
const LONGEST_STEP: f64 = 0.08;
/// Largest radius in the chart that is searched; the midline lies at 1.
const LARGEST_RADIUS: f64 = 0.9995;

/// Position of sample `k` along a line, 0 to 1.
fn unit(k: usize) -> f64 {
    k as f64 / SAMPLES as f64
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// Chart position on the front midline at height `y`.
pub(crate) fn midline_at(sculpt: &Sculpt, y: f64) -> Vector2<f64> {
    let (mut low, mut high) = FRONT_MIDLINE;
    for _ in 0..SEARCH_STEPS {
        let a = 0.5 * (low + high);
        if sculpt.mask_point(Vector2::new(a.cos(), a.sin())).y < y { low = a } else { high = a }
    }
    Vector2::new(low.cos(), low.sin())
}

/// Chart position where the mask has the coordinates `(x, y)`, in front.
fn locate_in_front(sculpt: &Sculpt, target: [f64; 2]) -> Vector2<f64> {
    if target[0] < 1e-9 {
        return midline_at(sculpt, target[1]);
    }
    locate(Vector2::new(0.75, 0.1), target, |q| {
        let p = sculpt.mask_point(q);
        Vector2::new(p.x, p.y)
    })
}

/// Chart position where the mask has the coordinates `(z, y)`, at the side.
fn locate_at_side(sculpt: &Sculpt, target: [f64; 2]) -> Vector2<f64> {
    locate(Vector2::new(0.0, 0.1), target, |q| {
        let p = sculpt.mask_point(q);
        Vector2::new(p.z, p.y)
    })
}

/// Newton's method from `start` for the chart position with the given coordinates.
fn locate(
    start: Vector2<f64>,
    target: [f64; 2],
    coordinates: impl Fn(Vector2<f64>) -> Vector2<f64>,
) -> Vector2<f64> {
    let target = Vector2::new(target[0], target[1]);
    let mut q = start;
    for _ in 0..SEARCH_STEPS {
        let here = coordinates(q);
        let residual = target - here;
        if residual.norm() < 1e-9 {
            break;
        }
        let h = 1e-5;
        let dx = (coordinates(q + Vector2::new(-h, 0.0)) - here) / -h;
        let dy = (coordinates(q + Vector2::new(0.0, h)) - here) / h;
        let det = dx.x * dy.y - dx.y * dy.x;
        let mut step = Vector2::new(
            (dy.y * residual.x - dy.x * residual.y) / det,
            (dx.x * residual.y - dx.y * residual.x) / det,
        );
        let length = step.norm();
        if length > LONGEST_STEP {
            step *= LONGEST_STEP / length;
        }
        q += step;
        let r = q.norm();
        if r > LARGEST_RADIUS {
            q *= LARGEST_RADIUS / r;
        }
    }
    q
}

/// All lines of the half head.
pub(crate) fn feature_lines(sculpt: &Sculpt) -> Vec<FeatureLine> {
    let mut lines = eye_lines(sculpt);
    lines.extend(mouth_lines(sculpt));
    lines.extend(nose_lines(sculpt));
    lines.extend(ear_lines(sculpt));
    lines
}

fn feature(line: Vec<Vector2<f64>>, closed: bool, spacing: f64, fine_only: bool) -> FeatureLine {
    // The line on the eyeball (the densest) runs close behind the margin of the lids; elsewhere
    // lines keep a distance.
    let merge_distance = if spacing < 2.05 { 0.2 } else { 0.45 * spacing };
    FeatureLine { line, closed, spacing, merge_distance, fine_only }
}

fn in_front(sculpt: &Sculpt, points: impl Iterator<Item = [f64; 2]>) -> Vec<Vector2<f64>> {
    points.map(|p| locate_in_front(sculpt, p)).collect()
}

/// Margin of the lids, the line where they meet the eyeball, the fold above.
fn eye_lines(sculpt: &Sculpt) -> Vec<FeatureLine> {
    let eye = sculpt.eye();
    let [inner, outer] = eye.corners();
    // Denser toward the corners, where the margins turn.
    let ease = |t: f64| 0.5 - 0.5 * (PI * t).cos();
    let margin = |from: f64, to: f64, inset: f64| {
        let up = (0..=SAMPLES).map(move |k| (mix(from, to, ease(unit(k))), true));
        let low = (1..SAMPLES).rev().map(move |k| (mix(from, to, ease(unit(k))), false));
        up.chain(low).map(move |(x, upper)| {
            let (u, l) = eye.margins(x);
            let middle = 0.5 * (u + l);
            [x, if upper { (u - inset).max(middle) } else { (l + inset).min(middle) }]
        })
    };
    let fold = (0..=SAMPLES).map(|k| {
        let x = mix(inner[0] + 2.0, outer[0] - 0.5, unit(k));
        [x, eye.fold(x)]
    });
    vec![
        feature(in_front(sculpt, margin(inner[0], outer[0], 0.0)), true, 2.1, false),
        feature(in_front(sculpt, margin(inner[0] + 0.9, outer[0] - 0.8, 0.5)), true, 2.0, true),
        feature(in_front(sculpt, fold), false, 2.4, true),
    ]
}

/// Lip line, a line along each lip, the vermilion borders.
fn mouth_lines(sculpt: &Sculpt) -> Vec<FeatureLine> {
    let mouth = sculpt.mouth();
    let half = mouth.half_width();
    // Share of the way from the lip line to the upper (positive) or lower vermilion border.
    [
        (0.0, 2.2, false),
        (0.24, 2.4, true),
        (-0.22, 2.4, true),
        (1.0, 2.4, false),
        (-1.0, 2.6, false),
    ]
    .into_iter()
    .map(|(share, spacing, fine_only)| {
        let end = if share == 0.0 { 1.0 } else { 0.985 };
        // The midline has no vertex on the lines along the lips.
        let start = if fine_only { 0.05 } else { 0.0 };
        let points = (0..=SAMPLES).map(|k| {
            let x = half * mix(start, end, unit(k));
            let (line, (up, low)) = (mouth.line(x), mouth.borders(x));
            [x, if share >= 0.0 { mix(line, up, share) } else { mix(line, low, -share) }]
        });
        feature(in_front(sculpt, points), false, spacing, fine_only)
    })
    .collect()
}

/// Rim and inside of the nostril, groove around the wing.
fn nose_lines(sculpt: &Sculpt) -> Vec<FeatureLine> {
    let nose = sculpt.nose();
    let mut lines: Vec<FeatureLine> = [(1.1, 2.1), (0.55, 2.1)]
        .into_iter()
        .map(|(r, spacing)| {
            let ring = (0..SAMPLES).map(|k| nose.nostril_point(TAU * unit(k), r));
            feature(in_front(sculpt, ring), true, spacing, true)
        })
        .collect();
    let arc = (0..=SAMPLES).map(|k| nose.wing_point(mix(-1.4, 1.9, unit(k)), 1.06));
    lines.push(feature(in_front(sculpt, arc), false, 2.3, true));
    lines
}

/// Rings from the root of the ear to its bowl.
fn ear_lines(sculpt: &Sculpt) -> Vec<FeatureLine> {
    [
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
    ]
    .into_iter()
    .map(|(fraction, spacing, fine_only)| {
        let ring = (0..SAMPLES)
            .map(|k| {
                let [y, z] = sculpt.ear().side_point(TAU * unit(k), fraction);
                locate_at_side(sculpt, [z, y])
            })
            .collect();
        feature(ring, true, spacing, fine_only)
    })
    .collect()
}

/// Height of the lip line on the midline.
pub(crate) fn lip_line(sculpt: &Sculpt) -> f64 {
    sculpt.mouth().line(0.0)
}

/// Landmarks of the front midline and their heights, top to bottom.
pub(crate) fn midline_landmarks(sculpt: &Sculpt) -> [(&'static str, f64); 6] {
    let (up, low) = sculpt.mouth().borders(0.0);
    [
        ("forehead", 69.0),
        ("nose_saddle", 27.0),
        ("nose_tip", -13.5),
        ("mouth_up", up),
        ("mouth_down", low),
        ("chin", -86.0),
    ]
}

/// Paired landmarks of the half head; `{}` stands for the side.
pub(crate) fn side_landmarks(sculpt: &Sculpt) -> [(&'static str, Vector2<f64>); 6] {
    let (mouth, [inner, outer]) = (sculpt.mouth(), sculpt.eye().corners());
    let half = mouth.half_width();
    let front = |target| locate_in_front(sculpt, target);
    [
        ("eye_{}_inner", front(inner)),
        ("eye_{}_outer", front(outer)),
        ("mouth_{}", front([half, mouth.line(half)])),
        // The most lateral point of the wing.
        ("ala_{}", front(sculpt.nose().wing_point(0.0, 0.97))),
        // On the head, in front of the uppermost part of the helix and of the end of the lobe, where
        // the outline of a face seen from the front turns from the head to the ear.
        ("ear_{}_upper", locate_at_side(sculpt, [4.0, 27.0])),
        ("ear_{}_lower", locate_at_side(sculpt, [0.0, -27.0])),
    ]
}
