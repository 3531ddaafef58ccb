//! The built-in head as a function: from a chart of one half of the head to points in space.

mod base;
mod curve;
mod ear;
mod eyes;
mod mouth;
mod nose;
mod proportions;

use crate::math::Vec3;
use base::Base;
use curve::bell;
use ear::EarShape;
use eyes::EyeShape;
use mouth::MouthShape;
use nalgebra::Vector2;
use nose::NoseShape;
use proportions::{Loop, Mound};

pub use curve::smoothstep;
pub use ear::Ear;
pub use eyes::Eye;
pub use mouth::Mouth;
pub use nose::Nose;

/// The measures of one head.
#[derive(Debug, Clone)]
pub struct Proportions {
    pub(crate) loops: Vec<Loop>,
    pub(crate) mounds: Vec<Mound>,
    pub(crate) nose: NoseShape,
    pub(crate) mouth: MouthShape,
    pub(crate) eye: EyeShape,
    pub(crate) ear: EarShape,
}

impl Default for Proportions {
    fn default() -> Self {
        Self {
            loops: proportions::LOOPS.to_vec(),
            mounds: proportions::MOUNDS.to_vec(),
            nose: NoseShape::default(),
            mouth: MouthShape::default(),
            eye: EyeShape::default(),
            ear: EarShape::default(),
        }
    }
}

/// Latitude of the neck border in the chart, degrees below the equator.
pub const NECK_LATITUDE_DEG: f64 = 58.0;

/// Samples of the front midline for interpolation in y.
const MIDLINE_STEPS: usize = 220;

/// A head that can be evaluated at any point of the chart.
///
/// The chart is an azimuthal equidistant projection about the side (+x) of the head. Position `q`
/// lies in the unit disc; the unit circle is the midline (angle 0 at the face, 90 degrees at the
/// crown), so the chart has no pole. It covers the half x >= 0; the other half is the mirror image.
#[derive(Debug, Clone)]
pub struct Sculpt {
    base: Base,
    mounds: Vec<Mound>,
    nose: Nose,
    mouth: Mouth,
    eye: Eye,
    ear: Ear,
    /// z of the mask on the front midline over y, ascending in y.
    midline: Vec<(f64, f64)>,
    /// Side of the head near the ear: x = a + b y + c z.
    side: [f64; 3],
}

impl Sculpt {
    /// The head of the given measures.
    pub fn new(p: &Proportions) -> Self {
        let mut sculpt = Self {
            base: Base::new(&p.loops),
            mounds: p.mounds.clone(),
            nose: Nose::new(&p.nose),
            mouth: Mouth::new(&p.mouth),
            eye: Eye::new(&p.eye),
            ear: Ear::new(&p.ear),
            midline: Vec::new(),
            side: [0.0; 3],
        };
        sculpt.midline = (0..=MIDLINE_STEPS)
            .rev()
            .map(|k| sculpt.mask(0.0, 1.0, 0.25 + 0.5 * k as f64 / MIDLINE_STEPS as f64))
            .map(|p| (p.y, p.z))
            .collect();
        sculpt.side = sculpt.side_plane(&p.ear);
        sculpt
    }

    /// Point of the half head at chart position `q` (unit disc), mm.
    pub fn point(&self, q: Vector2<f64>) -> Vec3 {
        let (sine, cosine, v) = Self::direction(q);
        let p = self.mask(sine, cosine, v);
        if p.z < 30.0 && p.x > 40.0 {
            return self.with_ear(p);
        }
        if p.z < 40.0 || p.y < -100.0 {
            return p;
        }
        let mut d = self.nose.displacement(p.x, p.y, self.midline_z(p.y));
        d += self.mouth.displacement(p.x, p.y);
        let mut out = p + d;
        if p.x > 8.0 {
            out.z = self.eye.height(out.x, out.y, out.z);
        }
        if sine == 0.0 {
            out.x = 0.0;
        }
        out
    }

    /// Point at chart position `q` of the head without nose, mouth, eyes and ears, mm.
    pub fn mask_point(&self, q: Vector2<f64>) -> Vec3 {
        let (sine, cosine, v) = Self::direction(q);
        self.mask(sine, cosine, v)
    }

    /// Distance of a point from the side of the head around the ear, outward, mm.
    pub(crate) fn over_side(&self, p: &Vec3) -> f64 {
        p.x.abs() - (self.side[0] + self.side[1] * p.y + self.side[2] * p.z)
    }

    /// The nose.
    pub fn nose(&self) -> &Nose {
        &self.nose
    }

    /// The mouth.
    pub fn mouth(&self) -> &Mouth {
        &self.mouth
    }

    /// The eye on the +x side.
    pub fn eye(&self) -> &Eye {
        &self.eye
    }

    /// The ear on the +x side.
    pub fn ear(&self) -> &Ear {
        &self.ear
    }

    /// Chart position to (sine, cosine, v) of the loft.
    fn direction(q: Vector2<f64>) -> (f64, f64, f64) {
        let r = q.norm();
        let (dx, ring) = if r >= 1.0 - 1e-6 {
            (0.0, 1.0)
        } else {
            ((r * std::f64::consts::FRAC_PI_2).cos(), (r * std::f64::consts::FRAC_PI_2).sin())
        };
        let (dz, dy) = if r > 1e-12 { (ring * q.x / r, ring * q.y / r) } else { (0.0, 0.0) };
        let across = dx.hypot(dz);
        let latitude = dy.clamp(-1.0, 1.0).asin().to_degrees();
        let v = (90.0 - latitude) / (90.0 + NECK_LATITUDE_DEG);
        if across < 1e-12 { (0.0, 1.0, v) } else { (dx / across, dz / across, v) }
    }

    /// The head without nose, mouth, eyes and ears.
    fn mask(&self, sine: f64, cosine: f64, v: f64) -> Vec3 {
        let p = self.base.point(sine, cosine, v);
        let h = 1e-4;
        let along = self.base.point(sine, cosine, (v + h).min(1.0))
            - self.base.point(sine, cosine, (v - h).max(0.0));
        let (s2, c2) = (sine + h * cosine, cosine - h * sine);
        let around =
            self.base.point(s2, c2, v) - self.base.point(sine - h * cosine, cosine + h * sine, v);
        let mut normal = along.cross(&around);
        let norm = normal.norm();
        if norm < 1e-14 {
            return p;
        }
        normal /= norm;
        if sine == 0.0 {
            normal.x = 0.0;
        }
        let mut height = 0.0;
        for m in &self.mounds {
            let [ax, ay, az] = m.at;
            let [sx, sy, sz] = m.sigma;
            // Both sides' mounds count, so that the midline stays smooth.
            let yz = bell(p.y - ay, sy) * bell(p.z - az, sz);
            let x = if ax == 0.0 { bell(p.x, sx) } else { bell(p.x - ax, sx) + bell(p.x + ax, sx) };
            height += m.height * x * yz;
        }
        p + normal * height
    }

    fn midline_z(&self, y: f64) -> f64 {
        let k = self.midline.partition_point(|m| m.0 < y).clamp(1, self.midline.len() - 1);
        let (a, b) = (self.midline[k - 1], self.midline[k]);
        a.1 + (b.1 - a.1) * ((y - a.0) / (b.0 - a.0)).clamp(0.0, 1.0)
    }

    /// Least-squares plane of the side of the head around the ear, without the ear.
    fn side_plane(&self, shape: &EarShape) -> [f64; 3] {
        let mut ata = nalgebra::Matrix3::zeros();
        let mut atb = Vec3::zeros();
        for i in -8..=8 {
            for j in -8..=8 {
                let q = Vector2::new(f64::from(i), f64::from(j)) * 0.025;
                let p = self.mask_point(q);
                if (p.y - shape.middle[0]).abs() < 25.0 && (p.z - shape.middle[1]).abs() < 16.0 {
                    let row = Vec3::new(1.0, p.y, p.z);
                    ata += row * row.transpose();
                    atb += row * p.x;
                }
            }
        }
        ata.try_inverse().map_or([70.0, 0.0, 0.0], |inverse| (inverse * atb).into())
    }

    fn with_ear(&self, p: Vec3) -> Vec3 {
        let (angle, fraction) = self.ear.polar(p.y, p.z);
        if fraction >= 1.0 {
            return p;
        }
        let a = self.ear.auricle(angle, fraction);
        let plane = |y: f64, z: f64| self.side[0] + self.side[1] * y + self.side[2] * z;
        // The side without ear deviates from its plane; keep the deviation near the root.
        let keep = smoothstep(0.75, 1.0, fraction);
        let bend = (p.x - plane(p.y, p.z)) * keep;
        Vec3::new(plane(a.y, a.z) + a.x + bend, a.y, a.z)
    }
}
