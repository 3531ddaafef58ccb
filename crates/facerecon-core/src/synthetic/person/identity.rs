//! Shape of a made-up person: how it differs from the generic head.

use crate::math::Vec3;
use crate::synthetic::random::Sequence;
use crate::template::Proportions;

/// Proportions that vary about those of the generic head: planes of the face, lips, wings of the
/// nose, ears.
pub(super) fn proportions(random: &mut Sequence) -> Proportions {
    let mut p = Proportions::default();
    for m in &mut p.mounds {
        m.height += 0.25 * random.deviate() * m.height.abs().max(2.0);
        if m.name == "larynx" {
            m.height = m.height.max(0.0);
        }
    }
    p.mouth.fullness *= 1.0 + 0.18 * random.deviate();
    p.nose.wing_rise *= 1.0 + 0.05 * random.deviate();
    p.ear.protrusion *= 1.0 + 0.10 * random.deviate();
    p
}

/// Symmetric deformations of the whole head: factors without unit, lengths in mm.
pub(super) struct Identity {
    size: [f64; 3],
    lower_face: f64,
    jaw: f64,
    cheeks: f64,
    nose_length: f64,
    nose_breadth: f64,
    nose_tip: f64,
    bridge: f64,
    chin: f64,
    forehead: f64,
    eyes_apart: f64,
    mouth_breadth: f64,
    mouth_height: f64,
    brow: f64,
}

/// Gaussian in space, 1 at `at`.
fn bell3(p: &Vec3, at: [f64; 3], sigma: [f64; 3]) -> f64 {
    let sum: f64 = (0..3).map(|k| ((p[k] - at[k]) / sigma[k]).powi(2)).sum();
    (-0.5 * sum).exp()
}

impl Identity {
    pub(super) fn new(random: &mut Sequence) -> Self {
        let mut draw = |deviation: f64| deviation * random.deviate();
        Self {
            size: [draw(0.018), draw(0.018), draw(0.018)],
            lower_face: draw(3.5),
            jaw: draw(0.045),
            cheeks: draw(0.03),
            nose_length: draw(2.2),
            nose_breadth: draw(0.07),
            nose_tip: draw(2.0),
            bridge: draw(1.6),
            chin: draw(2.6),
            forehead: draw(2.2),
            eyes_apart: draw(1.3),
            mouth_breadth: draw(0.05),
            mouth_height: draw(1.2),
            brow: draw(1.2),
        }
    }

    /// A point of the generic head on this head.
    pub(super) fn apply(&self, p: &Vec3) -> Vec3 {
        let mut d = Vec3::zeros();
        let side = |x: f64| (p.x / x).tanh();
        // The lower face, from the nose to the chin, is longer or shorter; the neck moves with it.
        let down = ((-28.0 - p.y) / 62.0).clamp(0.0, 1.0);
        d.y -= self.lower_face * down * down * (3.0 - 2.0 * down);
        d.x += p.x * self.jaw * bell3(p, [0.0, -62.0, 30.0], [90.0, 26.0, 55.0]);
        d.x += p.x * self.cheeks * bell3(p, [0.0, 4.0, 45.0], [90.0, 24.0, 45.0]);
        let tip = bell3(p, [0.0, -15.0, 110.0], [16.0, 13.0, 22.0]);
        d.y -= self.nose_length * tip;
        d.z += self.nose_tip * bell3(p, [0.0, -14.0, 118.0], [11.0, 13.0, 20.0]);
        d.x += p.x * self.nose_breadth * tip;
        d.z += self.bridge * bell3(p, [0.0, 14.0, 104.0], [8.0, 14.0, 20.0]);
        d.z += self.chin * bell3(p, [0.0, -78.0, 86.0], [22.0, 16.0, 40.0]);
        d.z += self.forehead * bell3(p, [0.0, 84.0, 90.0], [55.0, 34.0, 50.0]);
        d.x += self.eyes_apart * side(12.0) * bell3(p, [0.0, 22.0, 85.0], [45.0, 15.0, 30.0]);
        let mouth = bell3(p, [0.0, -49.0, 92.0], [30.0, 13.0, 25.0]);
        d.x += p.x * self.mouth_breadth * mouth;
        d.y += self.mouth_height * mouth;
        d.y += self.brow * bell3(p, [0.0, 40.0, 95.0], [45.0, 9.0, 30.0]);
        p + d + Vec3::new(p.x * self.size[0], p.y * self.size[1], p.z * self.size[2])
    }
}

/// A smooth local deformation of the face; several together make it asymmetric.
pub(super) struct Bump {
    at: [f64; 3],
    sigma: f64,
    shift: Vec3,
}

impl Bump {
    pub(super) fn new(random: &mut Sequence) -> Self {
        let (x, y) = (random.between(-70.0, 70.0), random.between(-90.0, 90.0));
        let z = 100.0 - 0.012 * x * x - 0.002 * y * y;
        let shift = Vec3::new(random.deviate(), random.deviate(), random.deviate()) * 0.8;
        Self { at: [x, y, z], sigma: random.between(16.0, 34.0), shift }
    }

    /// Displacement of a point.
    pub(super) fn at(&self, p: &Vec3) -> Vec3 {
        self.shift * bell3(p, self.at, [self.sigma; 3])
    }
}
