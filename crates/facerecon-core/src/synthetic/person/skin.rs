//! Colours of a made-up person: skin with regional tints and texture, lips, brows, eyes, hair.

use crate::math::Vec3;
use crate::synthetic::random::Sequence;
use crate::template::{Mouth, Sculpt, smoothstep};

type Colour = [f64; 3];

/// Linear RGB of skin, eyes and hair, from light to dark.
const TONES: [Colour; 4] =
    [[0.60, 0.385, 0.285], [0.50, 0.295, 0.20], [0.34, 0.185, 0.115], [0.16, 0.082, 0.05]];
const IRISES: [Colour; 4] =
    [[0.16, 0.26, 0.36], [0.17, 0.20, 0.10], [0.13, 0.065, 0.025], [0.06, 0.03, 0.015]];
const HAIRS: [Colour; 4] =
    [[0.16, 0.095, 0.045], [0.06, 0.034, 0.018], [0.028, 0.018, 0.012], [0.012, 0.010, 0.009]];

/// The colours of a person as a function of position.
#[derive(Clone, Debug)]
pub(super) struct Skin {
    sculpt: Sculpt,
    tone: Colour,
    hair: Colour,
    iris: Colour,
    /// Strength of the tint of a shaved beard, 0 to 1.
    beard: f64,
    /// Height of the hairline over the forehead, mm.
    hairline: f64,
    /// Moles: positions and sizes, mm.
    moles: Vec<(Vec3, f64)>,
    /// Shift of the noise, different for each person.
    offset: Vec3,
}

fn mix(a: Colour, b: Colour, t: f64) -> Colour {
    [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t.clamp(0.0, 1.0))
}

fn scale(a: Colour, by: Colour) -> Colour {
    [0, 1, 2].map(|k| a[k] * by[k])
}

/// Gaussian at `at` and at its mirror image.
fn spot(p: &Vec3, at: [f64; 3], sigma: [f64; 3]) -> f64 {
    let d = [p.x.abs() - at[0], p.y - at[1], p.z - at[2]];
    (-0.5 * (0..3).map(|k| (d[k] / sigma[k]).powi(2)).sum::<f64>()).exp()
}

/// Smooth value noise in space, -1 to 1, with structures of about one unit.
fn noise(p: Vec3) -> f64 {
    let cell = p.map(f64::floor);
    let f = (p - cell).map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let corner = |i: i64, j: i64, k: i64| {
        let mut h = (cell.x as i64 + i).wrapping_mul(0x2545_f491_4f6c_dd1d)
            ^ (cell.y as i64 + j).wrapping_mul(0x27d4_eb2f_1656_67c5)
            ^ (cell.z as i64 + k).wrapping_mul(0x1656_67b1_9e37_79f9);
        h = (h ^ (h >> 29)).wrapping_mul(0x3c79_ac49_2ba7_b653);
        h = (h ^ (h >> 32)).wrapping_mul(0x1c69_b3f7_4ac4_ae35);
        ((h >> 40) & 0xffff) as f64 / 32767.5 - 1.0
    };
    let lerp = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let row = |j, k| lerp(corner(0, j, k), corner(1, j, k), f.x);
    lerp(lerp(row(0, 0), row(1, 0), f.y), lerp(row(0, 1), row(1, 1), f.y), f.z)
}

impl Skin {
    pub(super) fn new(sculpt: &Sculpt, random: &mut Sequence) -> Self {
        let pick = |random: &mut Sequence, list: &[Colour; 4], at: f64| {
            let t = (at * 3.0).clamp(0.0, 2.999);
            let k = t as usize;
            mix(list[k], list[k + 1], t - k as f64).map(|c| c * random.between(0.94, 1.06))
        };
        let dark = random.unit().powf(1.6);
        let tone = pick(random, &TONES, dark);
        let hair_at = (dark + random.between(0.0, 0.7)).min(1.0);
        let hair = pick(random, &HAIRS, hair_at);
        let iris_at = (1.4 * dark + random.between(-0.2, 0.5)).clamp(0.0, 1.0);
        let iris = pick(random, &IRISES, iris_at);
        let beard = (random.between(-0.8, 0.8)).max(0.0);
        let hairline = random.between(82.0, 92.0);
        let moles = (0..9)
            .map(|_| {
                let at = Vec3::new(random.between(-60.0, 60.0), random.between(-85.0, 70.0), 0.0);
                (at, random.between(0.35, 0.95))
            })
            .collect();
        let offset = Vec3::new(
            random.between(0.0, 500.0),
            random.between(0.0, 500.0),
            random.between(0.0, 500.0),
        );
        Self { sculpt: sculpt.clone(), tone, hair, iris, beard, hairline, moles, offset }
    }

    /// Linear RGB of skin without detail.
    pub(super) fn plain(&self) -> [f32; 3] {
        self.tone.map(|c| c as f32)
    }

    /// Linear RGB of hair.
    pub(super) fn hair(&self) -> Colour {
        self.hair
    }

    /// The mouth before its deformation.
    pub(super) fn mouth(&self) -> &Mouth {
        self.sculpt.mouth()
    }

    /// Linear RGB at a point of the head before its deformation, mm.
    pub(super) fn albedo(&self, p: &Vec3) -> [f32; 3] {
        let mut c = self.bare(p);
        let front = p.z > 55.0;
        if front {
            c = self.lips(p, c);
            c = self.brow(p, c);
            c = self.eye(p, c);
        }
        c = self.scalp(p, c);
        c.map(|v| v.clamp(0.002, 0.95) as f32)
    }

    pub(super) fn noise_at(&self, p: &Vec3, size: f64) -> f64 {
        noise((p + self.offset) / size)
    }

    /// Skin: regional tints, blotches, pores, moles.
    fn bare(&self, p: &Vec3) -> Colour {
        let blood = 0.9 * spot(p, [42.0, -6.0, 82.0], [15.0, 13.0, 25.0])
            + 0.9 * spot(p, [0.0, -15.0, 116.0], [11.0, 8.0, 14.0])
            + 0.5 * spot(p, [10.0, -20.0, 100.0], [7.0, 7.0, 12.0])
            + 0.4 * spot(p, [0.0, -78.0, 88.0], [15.0, 9.0, 20.0])
            + 0.8 * spot(p, [84.0, 0.0, -14.0], [12.0, 34.0, 18.0]);
        let mut c = scale(self.tone, [1.0 + 0.03 * blood, 1.0 - 0.15 * blood, 1.0 - 0.13 * blood]);
        let forehead = spot(p, [0.0, 68.0, 95.0], [45.0, 20.0, 35.0]);
        c = scale(c, [1.0 + 0.03 * forehead, 1.0 + 0.04 * forehead, 1.0 - 0.01 * forehead]);
        // Thin skin around the eyes.
        let around = spot(p, [30.0, 15.0, 86.0], [15.0, 6.0, 20.0])
            + 0.8 * spot(p, [31.0, 30.0, 88.0], [13.0, 4.5, 20.0]);
        c = scale(c, [1.0 - 0.10 * around, 1.0 - 0.15 * around, 1.0 - 0.10 * around]);
        // Inside the nostrils and behind the wings.
        let nostril = spot(p, [6.2, -22.5, 102.0], [3.0, 2.6, 5.0]);
        c = scale(c, [1.0 - 0.62 * nostril, 1.0 - 0.78 * nostril, 1.0 - 0.78 * nostril]);
        // Shaved beard: cooler, darker, speckled.
        let jaw = smoothstep(-24.0, -40.0, p.y)
            * smoothstep(20.0, 45.0, p.z)
            * smoothstep(-112.0, -92.0, p.y);
        let stubble =
            self.beard * jaw * (0.55 + 0.45 * smoothstep(0.1, 0.7, self.noise_at(p, 0.8)));
        c = scale(c, [1.0 - 0.38 * stubble, 1.0 - 0.30 * stubble, 1.0 - 0.22 * stubble]);
        let blotch = 0.045 * self.noise_at(p, 17.0) + 0.035 * self.noise_at(p, 6.0);
        let pore = 0.030 * self.noise_at(p, 2.1) + 0.035 * self.noise_at(p, 0.9);
        c = scale(
            c,
            [1.0 + 0.8 * blotch + pore, 1.0 + 1.3 * blotch + pore, 1.0 + 1.2 * blotch + pore],
        );
        for (at, size) in &self.moles {
            let d = (p.x - at.x).hypot(p.y - at.y);
            if d < 3.0 * size && p.z > 30.0 {
                c = mix(
                    c,
                    scale(self.tone, [0.45, 0.36, 0.33]),
                    0.75 * smoothstep(1.5 * size, 0.5 * size, d),
                );
            }
        }
        c
    }

    fn lips(&self, p: &Vec3, skin: Colour) -> Colour {
        let mouth = self.sculpt.mouth();
        let x = p.x.abs();
        let half = mouth.half_width();
        if x > half + 3.0 || p.z < 70.0 {
            return skin;
        }
        let (up, low) = mouth.borders(x);
        let line = mouth.line(x);
        let inside = (up - p.y).min(p.y - low) + 0.3 * self.noise_at(p, 1.6);
        let red = smoothstep(-0.5, 0.7, inside) * smoothstep(half + 0.5, half - 3.0, x);
        let wrinkle = noise(Vec3::new(p.x * 1.3, p.y * 0.16, 7.0) + self.offset);
        let lip = scale(skin, [0.86, 0.63, 0.68].map(|v| v * (1.0 + 0.09 * wrinkle)));
        let c = mix(skin, lip, red);
        let seam = smoothstep(0.9, 0.1, (p.y - line).abs()) * smoothstep(half + 1.0, half - 1.0, x);
        mix(c, scale(skin, [0.30, 0.16, 0.17]), 0.8 * seam)
    }

    fn brow(&self, p: &Vec3, skin: Colour) -> Colour {
        let x = p.x.abs();
        // Position along the brow, 0 to 1; then height and half width of the brow there.
        let t = (x - 13.0) / 40.0;
        if !(-0.08..1.05).contains(&t) {
            return skin;
        }
        let arch = 35.6 + 5.6 * smoothstep(0.0, 0.62, t) - 4.6 * smoothstep(0.6, 1.05, t);
        let half = 4.3 * smoothstep(-0.08, 0.15, t) * (1.0 - 0.62 * smoothstep(0.4, 1.05, t));
        // Hairs: noise stretched along their direction, upward at the inner end, then outward.
        let lean = 0.9 - 0.75 * smoothstep(0.0, 0.45, t);
        let (along, across) =
            (x * lean.cos() + p.y * lean.sin(), p.y * lean.cos() - x * lean.sin());
        let hairs = noise(Vec3::new(0.22 * along, 1.7 * across, p.x.signum() * 40.0) + self.offset);
        let fringe = 1.0 - ((p.y - arch).abs() / half.max(0.3)).powi(2);
        let cover = smoothstep(-0.55, 0.85, fringe + 0.8 * hairs) * smoothstep(0.0, 0.5, half);
        mix(skin, self.hair.map(|c| 0.9 * c + 0.012), 0.80 * cover * smoothstep(1.05, 0.88, t))
    }

    fn eye(&self, p: &Vec3, skin: Colour) -> Colour {
        let eye = self.sculpt.eye();
        let x = p.x.abs();
        if !(10.0..52.0).contains(&x) || !(8.0..36.0).contains(&p.y) {
            return skin;
        }
        let inside = eye.inside(x, p.y);
        let [cx, cy, _] = eye.shape.centre;
        let (up, _) = eye.margins(x);
        // Lashes: dark lines along the margins, stronger above than below.
        let upper = (p.y - up).abs() < (p.y - cy).abs() || p.y > cy;
        let lash_width = if upper { 1.0 } else { 0.5 };
        let comb = 0.75 + 0.25 * noise(Vec3::new(p.x * 1.8, 3.0, 1.0) + self.offset);
        let lash = smoothstep(lash_width, 0.0, (inside + 0.25).abs())
            * comb
            * if upper { 0.85 } else { 0.45 };
        let lash = lash * smoothstep(17.5, 22.0, x);
        let mut c =
            mix(skin, scale(skin, [0.84, 0.64, 0.62]), 0.6 * smoothstep(-1.4, -0.1, inside));
        if inside > 0.0 {
            let r = (x - cx).hypot(p.y - cy);
            let vein = self.noise_at(p, 1.4);
            let corner = smoothstep(6.5, 14.5, r);
            let white = mix([0.50, 0.465, 0.44], [0.42, 0.28, 0.245], 0.75 * corner + 0.06 * vein);
            // Shadow of the upper lid.
            let shade = 0.55 + 0.45 * smoothstep(0.0, 3.2, up - p.y);
            let angle = (p.y - cy).atan2(p.x - cx * p.x.signum());
            let rays = noise(
                Vec3::new(5.0 * angle.cos(), 5.0 * angle.sin(), 0.25 * r) * 1.6 + self.offset,
            );
            let mut ball = white;
            let ring = 1.0 - 0.6 * smoothstep(4.6, 5.9, r);
            let iris = self
                .iris
                .map(|v| v * (1.0 + 0.35 * rays) * ring * (1.25 - 0.25 * smoothstep(2.0, 4.0, r)));
            ball = mix(ball, iris, smoothstep(6.15, 5.6, r));
            ball = mix(ball, [0.004; 3], smoothstep(2.45, 2.05, r));
            ball = ball.map(|v| v * shade);
            // Inner corner.
            ball = mix(ball, scale(skin, [0.95, 0.62, 0.60]), smoothstep(20.2, 18.0, x));
            c = mix(c, ball, smoothstep(0.05, 0.5, inside));
        }
        mix(c, self.hair.map(|v| 0.6 * v), lash)
    }

    fn scalp(&self, p: &Vec3, skin: Colour) -> Colour {
        // Distance inside the hair: above the hairline, behind the temples, and above and behind a
        // line around the ear down to the nape.
        let x = p.x.abs();
        let forehead = p.y - self.hairline + 0.0045 * x * x;
        let temple = 0.9 * (26.0 - p.z) + 0.25 * (p.y - 40.0);
        let top = forehead.max(temple);
        let sideburn = p.y + 2.0 - 0.9 * (p.z - 12.0).abs();
        let over_ear = p.y - 33.0 + 0.02 * (p.z + 6.0).powi(2);
        let nape = (-27.0 - p.z).min(p.y + 66.0 + 0.12 * (p.z + 60.0));
        let side = over_ear.max(nape).max(if p.z > 4.0 { sideburn } else { -9.0 });
        if self.sculpt.over_side(p) > 1.6 && p.y.abs() < 40.0 && (-46.0..12.0).contains(&p.z) {
            return skin;
        }
        let above = if p.z > 26.0 && p.y > 40.0 { top } else { top.min(side) };
        let edge = above + 3.5 * self.noise_at(p, 6.0) + 1.3 * self.noise_at(p, 1.7);
        let cover = 0.94 * smoothstep(-6.0, 7.5, edge);
        if cover <= 0.0 {
            return skin;
        }
        // Short hair combed back and down from the crown.
        let angle = p.x.atan2(p.z + 10.0);
        let strand = noise(Vec3::new(angle * 42.0, 0.10 * p.y, 0.05 * p.z) + self.offset);
        let fine = noise(Vec3::new(angle * 110.0, 0.22 * p.y, 0.1 * p.z) + self.offset);
        let tuft = 1.0 + 0.35 * strand + 0.30 * fine + 0.20 * self.noise_at(p, 9.0);
        mix(skin, self.hair.map(|c| c * tuft), cover)
    }
}
