//! Random numbers by counter: the value depends on seed, stream and index only, so that it is the
//! same in whatever order and on however many threads it is drawn.

/// Mixes 64 bits (the finaliser of SplitMix64, Steele et al. 2014).
fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A uniform number in (0, 1).
fn uniform(seed: u64, stream: u64, index: u64) -> f64 {
    const STEP: u64 = 0x9e37_79b9_7f4a_7c15;
    let key = mix(seed.wrapping_add(STEP)) ^ mix(stream.wrapping_mul(STEP).wrapping_add(1));
    let bits = mix(key.wrapping_add(index.wrapping_mul(STEP)));
    ((bits >> 11) as f64 + 0.5) / (1u64 << 53) as f64
}

/// A normal number of mean 0 and variance 1 (Box and Muller 1958).
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
