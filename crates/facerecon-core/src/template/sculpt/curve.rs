//! Functions of one variable that the sculpt is made of: interpolating curves and smooth steps.

/// Natural cubic spline through `(t, value)` knots, constant beyond both ends.
#[derive(Debug, Clone)]
pub(super) struct Curve {
    t: Vec<f64>,
    y: Vec<f64>,
    /// Second derivatives at the knots.
    m: Vec<f64>,
}

impl Curve {
    /// Spline with free (natural) ends. Knots must have increasing `t`.
    pub(super) fn new(knots: &[(f64, f64)]) -> Self {
        Self::build(knots, None)
    }

    /// Spline whose slope at the first knot is zero: the meridian of a smooth pole.
    pub(super) fn flat_start(knots: &[(f64, f64)]) -> Self {
        Self::build(knots, Some(0.0))
    }

    /// Periodic spline over `[0, period)`; the knots are repeated on both sides.
    pub(super) fn periodic(knots: &[(f64, f64)], period: f64) -> Self {
        let mut all = Vec::with_capacity(3 * knots.len());
        for turn in [-1.0, 0.0, 1.0] {
            all.extend(knots.iter().map(|&(t, y)| (t + turn * period, y)));
        }
        Self::build(&all, None)
    }

    fn build(knots: &[(f64, f64)], start_slope: Option<f64>) -> Self {
        let n = knots.len();
        let t: Vec<f64> = knots.iter().map(|k| k.0).collect();
        let y: Vec<f64> = knots.iter().map(|k| k.1).collect();
        let mut m = vec![0.0; n];
        // Thomas algorithm on the tridiagonal system of the second derivatives.
        let (mut c, mut d) = (vec![0.0; n], vec![0.0; n]);
        if let Some(slope) = start_slope {
            let h = t[1] - t[0];
            c[0] = 0.5;
            d[0] = 3.0 * ((y[1] - y[0]) / h - slope) / h;
        }
        for i in 1..n.saturating_sub(1) {
            let (h0, h1) = (t[i] - t[i - 1], t[i + 1] - t[i]);
            let rhs = 6.0 * ((y[i + 1] - y[i]) / h1 - (y[i] - y[i - 1]) / h0);
            let pivot = 2.0 * (h0 + h1) - h0 * c[i - 1];
            c[i] = h1 / pivot;
            d[i] = (rhs - h0 * d[i - 1]) / pivot;
        }
        for i in (0..n.saturating_sub(1)).rev() {
            m[i] = d[i] - c[i] * m[i + 1];
        }
        Self { t, y, m }
    }

    pub(super) fn at(&self, t: f64) -> f64 {
        let n = self.t.len();
        let t = t.clamp(self.t[0], self.t[n - 1]);
        let i = self.t.partition_point(|&k| k <= t).clamp(1, n - 1);
        let h = self.t[i] - self.t[i - 1];
        let (a, b) = ((self.t[i] - t) / h, (t - self.t[i - 1]) / h);
        a * self.y[i - 1]
            + b * self.y[i]
            + ((a * a * a - a) * self.m[i - 1] + (b * b * b - b) * self.m[i]) * h * h / 6.0
    }
}

/// 0 below `a`, 1 above `b`, smooth (C1) between; `a > b` gives the falling step.
pub fn smoothstep(a: f64, b: f64, t: f64) -> f64 {
    let u = ((t - a) / (b - a)).clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

/// Maximum of two heights with a rounded valley of size `k` between them.
pub(super) fn smooth_max(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.max(b) + h * h * h * k / 6.0
}

/// Gaussian of height 1 and standard deviation `sigma`, zero beyond 4.5 sigma.
pub(super) fn bell(d: f64, sigma: f64) -> f64 {
    let u = d / sigma;
    if u.abs() > 4.5 { 0.0 } else { (-0.5 * u * u).exp() }
}

/// Linear interpolation from `a` (t = 0) to `b` (t = 1).
pub(super) fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}
