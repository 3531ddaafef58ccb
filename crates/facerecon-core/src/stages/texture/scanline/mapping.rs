//! Monotone piecewise linear mappings of one coordinate to another.

/// Least slope of a segment, as a fraction of the mean slope: flatter ones would fold at the next
/// dot or smear one pixel over many texels.
const LEAST_SLOPE: f64 = 0.15;
/// Fewest samples that give a knot.
const LEAST_SAMPLES: usize = 2;

/// A mapping through knots of ascending coordinates, constant outside.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mapping {
    knots: Vec<(f64, f64)>,
}

impl Mapping {
    /// A straight line between two knots.
    pub fn linear(from: (f64, f64), to: (f64, f64)) -> Self {
        Self { knots: vec![from, to] }
    }

    /// Through given knots of ascending first coordinate.
    pub fn through(knots: Vec<(f64, f64)>) -> Self {
        Self { knots }
    }

    /// A strictly rising mapping between two knots, in equal segments. Where two segments meet, the
    /// mean of the samples around is a knot, unless the mapping would fold there.
    pub fn monotone(
        from: (f64, f64),
        to: (f64, f64),
        samples: &[(f64, f64)],
        segments: usize,
    ) -> Self {
        let mut knots = vec![from];
        let width = (to.0 - from.0) / segments.max(1) as f64;
        let least = LEAST_SLOPE * width * (to.1 - from.1) / (to.0 - from.0);
        for k in 0..segments.saturating_sub(1) {
            let centre = from.0 + width * (k + 1) as f64;
            let near: Vec<&(f64, f64)> =
                samples.iter().filter(|s| (s.0 - centre).abs() <= width / 2.0).collect();
            if near.len() < LEAST_SAMPLES {
                continue;
            }
            let n = near.len() as f64;
            let (a, b) = near.iter().fold((0.0, 0.0), |m, s| (m.0 + s.0 / n, m.1 + s.1 / n));
            let last = knots[knots.len() - 1];
            if a > last.0 && b > last.1 + least && b < to.1 - least && a < to.0 {
                knots.push((a, b));
            }
        }
        knots.push(to);
        Self { knots }
    }

    /// The mapped coordinate.
    pub fn at(&self, x: f64) -> f64 {
        let after = self.knots.partition_point(|k| k.0 <= x);
        match (after.checked_sub(1).and_then(|i| self.knots.get(i)), self.knots.get(after)) {
            (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0),
            (Some(k), None) | (None, Some(k)) => k.1,
            (None, None) => x,
        }
    }

    /// First coordinates of the first and the last knot.
    pub fn domain(&self) -> (f64, f64) {
        let ends = (self.knots.first(), self.knots.last());
        if let (Some(first), Some(last)) = ends { (first.0, last.0) } else { (0.0, 0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knots_that_would_fold_are_left_out() {
        let rising: Vec<(f64, f64)> =
            (0..=100).map(f64::from).map(|x| (x, 2.0 * x + 5.0 * (x / 9.0).sin())).collect();
        let good = Mapping::monotone((0.0, 0.0), (100.0, 200.0), &rising, 10);
        assert_eq!((good.knots.len(), good.domain()), (11, (0.0, 100.0)));
        let folded: Vec<(f64, f64)> = rising
            .iter()
            .map(|s| if (30.0..40.0).contains(&s.0) { (s.0, 10.0) } else { *s })
            .collect();
        let kept = Mapping::monotone((0.0, 0.0), (100.0, 200.0), &folded, 10);
        assert!(kept.knots.len() < 11);
        for mapping in [&good, &kept] {
            assert!(mapping.knots.windows(2).all(|k| k[0].0 < k[1].0 && k[0].1 < k[1].1));
        }
        assert_eq!((good.at(-5.0), good.at(500.0)), (0.0, 200.0));
        assert_eq!(Mapping::linear((0.0, 1.0), (4.0, 9.0)).at(1.0), 3.0);
    }
}
