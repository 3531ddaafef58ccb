//! What speaks for one shift of the lattice and against another: the cues of the absolute period.
//!
//! Every cue gives a badness above 0; those of one shift multiply. The ratio of the runner-up's
//! badness to the winner's is the confidence.

use rayon::prelude::*;

use crate::data::{Dot, Gray, Seeds};
use crate::math::Vec2;

use super::graph::Graph;
use super::shifts::{Pair, Rows};

/// Samples a side of a dot's surroundings.
const SIDE: usize = 6;
/// Zero-mean, unit-length samples of a dot's surroundings.
type Patch = [f32; SIDE * SIDE];

/// The surroundings of every dot in the pair without the pattern, at half size.
pub(super) struct Plain {
    /// With the contrast (standard deviation, grey levels).
    left: Vec<Option<(Patch, f64)>>,
    /// At the dot, and two pixels to either side along the row: the head may have moved since.
    right: Vec<[Option<(Patch, f64)>; 3]>,
}

impl Plain {
    /// Samples the photos around the dots, over about one spacing.
    pub(super) fn new(images: [&Gray; 2], dots: [&[Dot]; 2], spacing_px: f64) -> Self {
        let [left, right] = images.map(|i| i.halved().blurred(1.0));
        let step = spacing_px / 2.0 / SIDE as f64 * 1.2;
        let half = |dot: &Dot| (dot.position - Vec2::new(0.5, 0.5)) / 2.0;
        let sides = [-1.0, 0.0, 1.0];
        Self {
            left: dots[0].par_iter().map(|d| patch(&left, half(d), step)).collect(),
            right: dots[1]
                .par_iter()
                .map(|d| sides.map(|s| patch(&right, half(d) + Vec2::new(s, 0.0), step)))
                .collect(),
        }
    }

    /// Likeness of the surroundings of two dots (zero-mean normalised cross-correlation), and its
    /// weight: the contrast. `None` at the border and where there is no contrast.
    pub(super) fn likeness(&self, left: usize, right: usize) -> Option<(f64, f64)> {
        let (a, contrast) = self.left[left].as_ref()?;
        let product = |b: &Patch| a.iter().zip(b).map(|(p, q)| p * q).sum::<f32>();
        let best = self.right[right]
            .iter()
            .flatten()
            .map(|(b, _)| f64::from(product(b)))
            .max_by(f64::total_cmp)?;
        // Contrast beyond a few grey levels is no better than a few.
        Some((best, contrast.min(8.0)))
    }
}

/// Zero-mean, unit-length samples around a point, and their standard deviation.
fn patch(image: &Gray, at: Vec2, step: f64) -> Option<(Patch, f64)> {
    let mut samples = [0.0; SIDE * SIDE];
    for (k, s) in samples.iter_mut().enumerate() {
        let offset = |i: usize| (i as f64 - (SIDE - 1) as f64 / 2.0) * step;
        *s = image.bilinear(at.x + offset(k % SIDE), at.y + offset(k / SIDE))?;
    }
    let n = samples.len() as f32;
    let mean = samples.iter().sum::<f32>() / n;
    samples.iter_mut().for_each(|v| *v -= mean);
    let norm = samples.iter().map(|v| v * v).sum::<f32>().sqrt();
    (norm > 0.2 * n.sqrt()).then(|| {
        samples.iter_mut().for_each(|v| *v /= norm);
        (samples, f64::from(norm / n.sqrt()))
    })
}

/// What the cues are read from.
pub(super) struct Evidence<'a> {
    pub dots: [&'a [Dot]; 2],
    pub graphs: &'a [Graph; 2],
    pub plain: Option<Plain>,
    pub seeds: Option<Seeds>,
    pub spacing_px: f64,
    pub tolerance_px: f64,
}

/// How badly a shift fits; each part 1 or near it where the cue is silent.
#[derive(Clone, Copy, Debug)]
pub(super) struct Badness {
    pub rows: f64,
    pub plain: f64,
    pub brightness: f64,
    pub holes: f64,
    pub seeds: f64,
}

impl Badness {
    /// All cues together.
    pub(super) fn total(&self) -> f64 {
        self.rows * self.plain * self.brightness * self.holes * self.seeds
    }

    /// Whether the photos or the marks speak for the shift, beyond the rows.
    pub(super) fn speaks(&self) -> bool {
        self.plain * self.brightness < 0.75 || self.seeds < 1.0
    }
}

impl Evidence<'_> {
    /// How alike two dots' surroundings look without the pattern, 0 to 1; small where there is no
    /// contrast, 1 without the plain pair.
    pub(super) fn alike(&self, (left, right): &Pair) -> f64 {
        self.plain.as_ref().map_or(1.0, |plain| {
            plain.likeness(*left, *right).map_or(0.1, |(z, _)| 0.1 + 0.9 * z.max(0.0).powi(2))
        })
    }

    /// The badness of pairing `pairs`, out of the left dots `asked`.
    pub(super) fn badness(&self, asked: &[usize], pairs: &[Pair], rows: &Rows) -> Badness {
        let partner = Partners::new(self.dots[0].len(), pairs);
        Badness {
            rows: self.rows(pairs, rows),
            plain: self.plain(pairs),
            brightness: self.brightness(pairs, &partner),
            holes: self.holes(asked, &partner, pairs.len()),
            seeds: self.seeds(&partner),
        }
    }

    /// Rows: a dot and its partner lie on one row; with a wrong shift they differ as the lattice's
    /// rows bend over the face. Root mean square difference over what noise allows.
    fn rows(&self, pairs: &[Pair], rows: &Rows) -> f64 {
        let clip = (4.0 * self.tolerance_px).powi(2);
        let sum: f64 = pairs
            .iter()
            .map(|(i, j)| {
                let (l, r) = (self.dots[0][*i].position, self.dots[1][*j].position);
                (r.y - l.y - rows.at(&l)).powi(2).min(clip)
            })
            .sum();
        let floor = 0.015 * self.spacing_px;
        let n = pairs.len() as f64;
        ((sum / n.max(1.0)).sqrt().max(floor) / floor).powf(n / (n + 10.0))
    }

    /// The plain pair looks alike around a dot and its partner.
    fn plain(&self, pairs: &[Pair]) -> f64 {
        let Some(plain) = &self.plain else {
            return 1.0;
        };
        let (mut sum, mut weights, mut n) = (0.0, 0.0, 0.0);
        for (z, w) in pairs.iter().filter_map(|(i, j)| plain.likeness(*i, *j)) {
            sum += w * z;
            weights += w;
            n += 1.0;
        }
        if weights > 0.0 { 1.1 - sum / weights * (n / (n + 10.0)) } else { 1.0 }
    }

    /// Dots on dark skin are dim in both photos: correlation of each dot's height over that of its
    /// lattice neighbours, which takes shading and exposure out.
    fn brightness(&self, pairs: &[Pair], partner: &Partners) -> f64 {
        let (mut ab, mut aa, mut bb, mut n) = (0.0, 0.0, 0.0, 0.0);
        for (a, b) in pairs.iter().filter_map(|p| self.relative_brightness(p, partner)) {
            (ab, aa, bb, n) = (ab + a * b, aa + a * a, bb + b * b, n + 1.0);
        }
        let correlation = if aa * bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 };
        1.1 - correlation * n / (n + 40.0)
    }

    /// Logarithms of the heights of two dots over those of their lattice neighbours.
    pub(super) fn relative_brightness(
        &self,
        pair: &Pair,
        partner: &Partners,
    ) -> Option<(f64, f64)> {
        let log = |side: usize, i: usize| self.dots[side][i].amplitude.max(1.0).ln();
        let (mut a, mut b, mut count) = (0.0, 0.0, 0.0);
        for (k, m) in self.graphs[0].neighbours(pair.0).filter_map(|k| Some((k, partner.of(k)?))) {
            a += log(0, k);
            b += log(1, m);
            count += 1.0;
        }
        let over = |own: f64, sum: f64| (own - sum / count).clamp(-0.7, 0.7);
        (count >= 2.0).then(|| (over(log(0, pair.0), a), over(log(1, pair.1), b)))
    }

    /// Holes of the lattice (eyes, nostrils, brows) are the same in both photos: share of dots
    /// whose partner is missing although the partners on either side are there.
    fn holes(&self, asked: &[usize], partner: &Partners, paired: usize) -> f64 {
        let enclosed = |i: &usize| {
            partner.of(*i).is_none()
                && self.graphs[0].neighbours(*i).filter(|n| partner.of(*n).is_some()).count() >= 2
        };
        let missing = asked.iter().filter(|i| enclosed(i)).count() as f64;
        let n = paired as f64;
        ((0.1 + missing / (n + missing + 40.0)) / 0.1).sqrt()
    }

    /// Marked pairs that the shift pairs as marked, or otherwise.
    fn seeds(&self, partner: &Partners) -> f64 {
        let Some(seeds) = &self.seeds else {
            return 1.0;
        };
        let mut badness: f64 = 1.0;
        for seed in [seeds.head, seeds.left_ear, seeds.right_ear] {
            let near = |side: usize, p: Vec2| {
                (0..self.dots[side].len())
                    .map(|i| ((self.dots[side][i].position - p).norm(), i))
                    .min_by(|a, b| a.0.total_cmp(&b.0))
                    .filter(|n| n.0 < 0.6 * self.spacing_px)
                    .map(|n| n.1)
            };
            if let (Some(i), Some(j)) = (near(0, seed.left), near(1, seed.right)) {
                match partner.of(i) {
                    Some(p) if p == j => badness /= 4.0,
                    Some(_) => badness *= 4.0,
                    None => {}
                }
            }
        }
        badness
    }
}

/// Right partner by left dot.
pub(super) struct Partners(Vec<usize>);

impl Partners {
    pub(super) fn new(len: usize, pairs: &[Pair]) -> Self {
        let mut partners = vec![usize::MAX; len];
        pairs.iter().for_each(|(i, j)| partners[*i] = *j);
        Self(partners)
    }

    pub(super) fn of(&self, left: usize) -> Option<usize> {
        Some(self.0[left]).filter(|j| *j != usize::MAX)
    }
}
