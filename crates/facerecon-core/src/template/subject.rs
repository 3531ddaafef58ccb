//! People: heads that differ from the generic one in identity and asymmetry, with skin, for the
//! virtual rig and the demo.

use super::asset::HalfHead;
use super::head::{Template, assemble};
use super::sculpt::{Proportions, Sculpt};
use super::skin::Skin;
use crate::data::Raster;
use crate::math::Vec3;

/// A made-up person.
#[derive(Clone, Debug)]
pub struct Subject {
    /// About 22,000 vertices; frame as the built-in head's, mm.
    pub head: Template,
    /// The same vertices before the person's own shape: where the skin's features are looked up.
    rest: Vec<Vec3>,
    skin: Skin,
}

/// Numbers from a seed: splitmix64 (Steele, Lea & Flood 2014).
#[derive(Clone, Debug)]
pub(super) struct Draw(u64);

impl Draw {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Evenly in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Roughly normal with deviation 1, within +-1.9.
    fn spread(&mut self) -> f64 {
        ((0..3).map(|_| self.unit()).sum::<f64>() * 2.0 - 3.0).clamp(-1.9, 1.9)
    }
}

/// The person of a seed. The same seed is always the same person.
pub(crate) fn subject(seed: u64, half: &HalfHead) -> Subject {
    let mut draw = Draw::new(seed);
    let sculpt = Sculpt::new(&features(&mut draw));
    let mut head = assemble(&sculpt, &half.split());
    let rest = head.mesh.vertices.clone();
    let identity = Identity::new(&mut draw);
    let bumps: Vec<Bump> = (0..14).map(|_| Bump::new(&mut draw)).collect();
    for v in &mut head.mesh.vertices {
        *v = identity.apply(v);
        let side: Vec3 = bumps.iter().map(|b| b.at(v)).sum();
        *v += side;
    }
    Subject { head, rest, skin: Skin::new(&sculpt, &mut draw) }
}

/// Local shape: heights of the planes of the face, lips, wings of the nose.
fn features(draw: &mut Draw) -> Proportions {
    let mut p = Proportions::default();
    for m in &mut p.mounds {
        m.height += 0.25 * draw.spread() * m.height.abs().max(2.0);
        if m.name == "larynx" {
            m.height = m.height.max(0.0);
        }
    }
    p.mouth.fullness *= 1.0 + 0.18 * draw.spread();
    p.nose.wing_rise *= 1.0 + 0.05 * draw.spread();
    p.ear.protrusion *= 1.0 + 0.10 * draw.spread();
    p
}

/// Proportions as gentle bends of space, each symmetric.
struct Identity {
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

fn bell3(p: &Vec3, at: [f64; 3], sigma: [f64; 3]) -> f64 {
    let sum: f64 = (0..3).map(|k| ((p[k] - at[k]) / sigma[k]).powi(2)).sum();
    (-0.5 * sum).exp()
}

impl Identity {
    fn new(draw: &mut Draw) -> Self {
        let mut mm = |deviation: f64| deviation * draw.spread();
        Self {
            size: [mm(0.018), mm(0.018), mm(0.018)],
            lower_face: mm(3.5),
            jaw: mm(0.045),
            cheeks: mm(0.03),
            nose_length: mm(2.2),
            nose_breadth: mm(0.07),
            nose_tip: mm(2.0),
            bridge: mm(1.6),
            chin: mm(2.6),
            forehead: mm(2.2),
            eyes_apart: mm(1.3),
            mouth_breadth: mm(0.05),
            mouth_height: mm(1.2),
            brow: mm(1.2),
        }
    }

    fn apply(&self, p: &Vec3) -> Vec3 {
        let mut d = Vec3::zeros();
        let side = |x: f64| (p.x / x).tanh();
        // Below the nose the face grows longer down to the chin; the neck follows.
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

/// One smooth irregularity of the face; some of them together make it asymmetric.
struct Bump {
    at: [f64; 3],
    sigma: f64,
    shift: Vec3,
}

impl Bump {
    fn new(draw: &mut Draw) -> Self {
        let (x, y) = (draw.between(-70.0, 70.0), draw.between(-90.0, 90.0));
        let z = 100.0 - 0.012 * x * x - 0.002 * y * y;
        let shift = Vec3::new(draw.spread(), draw.spread(), draw.spread()) * 0.8;
        Self { at: [x, y, z], sigma: draw.between(16.0, 34.0), shift }
    }

    fn at(&self, p: &Vec3) -> Vec3 {
        self.shift * bell3(p, self.at, [self.sigma; 3])
    }
}

impl Subject {
    /// Colour of the skin (and brows, eyes, hair) over the texture square: linear RGB, 0 to 1,
    /// `size` x `size`, row 0 at v = 1; texels outside the layout repeat their nearest triangle's
    /// colour within a few texels.
    pub fn albedo(&self, size: usize) -> Raster<[f32; 3]> {
        const GUTTER: f64 = 2.5;
        // First who owns a texel, then its colour: that is the costly part.
        let mut owner = Raster::filled(size, size, (f64::MAX, Vec3::zeros()));
        let mesh = &self.head.mesh;
        let n = size as f64;
        for (f, t) in mesh.faces.iter().zip(&mesh.face_uvs) {
            let uv = t.map(|i| {
                let [u, v] = mesh.uvs[i as usize];
                [u * n - 0.5, (1.0 - v) * n - 0.5]
            });
            let p = f.map(|i| self.rest[i as usize]);
            let cross = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
                (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
            };
            let area = cross(uv[0], uv[1], uv[2]);
            if area.abs() < 1e-12 {
                continue;
            }
            let range = |k: usize| {
                let c = uv.map(|q| q[k]);
                let low = (c[0].min(c[1]).min(c[2]) - GUTTER).ceil().max(0.0) as usize;
                let high = (c[0].max(c[1]).max(c[2]) + GUTTER).floor().max(0.0) as usize;
                low..(high + 1).min(size)
            };
            let longest = (0..3)
                .map(|k| (uv[k][0] - uv[(k + 1) % 3][0]).hypot(uv[k][1] - uv[(k + 1) % 3][1]))
                .fold(1e-9, f64::max);
            for y in range(1) {
                for x in range(0) {
                    let at = [x as f64, y as f64];
                    let b = [0, 1, 2].map(|k| cross(uv[(k + 1) % 3], uv[(k + 2) % 3], at) / area);
                    // Distance outside the triangle, in texels (0 inside).
                    let outside = -b[0].min(b[1]).min(b[2]).min(0.0) * area.abs() / longest;
                    if outside > GUTTER || outside >= owner.at(x, y).0 {
                        continue;
                    }
                    let b = b.map(|w| w.clamp(-0.5, 1.5));
                    let sum: f64 = b.iter().sum();
                    let q = (p[0] * b[0] + p[1] * b[1] + p[2] * b[2]) / sum;
                    owner.set(x, y, (outside, q));
                }
            }
        }
        Raster::par_from_fn(size, size, |x, y| {
            let (outside, q) = owner.at(x, y);
            if outside < f64::MAX { self.skin.albedo(&q) } else { self.skin.plain() }
        })
    }
}
