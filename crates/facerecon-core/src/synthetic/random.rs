//! Random numbers, the same on every machine and for any number of threads.

/// Step of the SplitMix64 sequence.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// Mixes 64 bits (the finaliser of SplitMix64, Steele, Lea & Flood 2014).
fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A sequence of random numbers from a seed (SplitMix64).
#[derive(Clone, Debug)]
pub(super) struct Sequence(u64);

impl Sequence {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Uniform in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(STEP);
        (mix(self.0) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [low, high).
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Roughly normal (a sum of three uniform numbers) with standard deviation 1, within +-1.9.
    pub(super) fn deviate(&mut self) -> f64 {
        ((0..3).map(|_| self.unit()).sum::<f64>() * 2.0 - 3.0).clamp(-1.9, 1.9)
    }
}

/// Uniform in (0, 1). The value depends on seed, stream and index only, not on the order of calls.
fn uniform(seed: u64, stream: u64, index: u64) -> f64 {
    let key = mix(seed.wrapping_add(STEP)) ^ mix(stream.wrapping_mul(STEP).wrapping_add(1));
    let bits = mix(key.wrapping_add(index.wrapping_mul(STEP)));
    ((bits >> 11) as f64 + 0.5) / (1u64 << 53) as f64
}

/// Normal with mean 0 and variance 1 (Box and Muller 1958). The value depends on seed, stream and
/// index only.
pub(super) fn gaussian(seed: u64, stream: u64, index: u64) -> f64 {
    let radius = (-2.0 * uniform(seed, stream, 2 * index).ln()).sqrt();
    radius * (std::f64::consts::TAU * uniform(seed, stream, 2 * index + 1)).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_normal_and_streams_differ() {
        let n = 200_000u64;
        let draw: Vec<f64> = (0..n).map(|i| gaussian(7, 1, i)).collect();
        let mean = draw.iter().sum::<f64>() / n as f64;
        let moment = |p: i32| draw.iter().map(|v| (v - mean).powi(p)).sum::<f64>() / n as f64;
        assert!(mean.abs() < 0.01 && (moment(2) - 1.0).abs() < 0.01, "{mean} {}", moment(2));
        assert!(moment(3).abs() < 0.03 && (moment(4) - 3.0).abs() < 0.08);
        let other: Vec<f64> = (0..n).map(|i| gaussian(7, 2, i)).collect();
        let cross = draw.iter().zip(&other).map(|(a, b)| a * b).sum::<f64>() / n as f64;
        assert!(cross.abs() < 0.01, "{cross}");
        let next = draw.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n as f64;
        assert!(next.abs() < 0.01, "{next}");
    }
}
