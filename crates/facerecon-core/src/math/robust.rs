//! Order statistics; all return `None` on empty input and ignore NaN.

/// The value below which the fraction `q` (0 to 1) of the values lies, linearly interpolated.
pub fn percentile(values: &[f64], q: f64) -> Option<f64> {
    let mut kept: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
    if kept.is_empty() {
        return None;
    }
    let position = q.clamp(0.0, 1.0) * (kept.len() - 1) as f64;
    let rank = position.floor() as usize;
    let (_, low, above) = kept.select_nth_unstable_by(rank, f64::total_cmp);
    let high = above.iter().copied().min_by(f64::total_cmp).unwrap_or(*low);
    Some(*low + (high - *low) * (position - rank as f64))
}

/// The median.
pub fn median(values: &[f64]) -> Option<f64> {
    percentile(values, 0.5)
}

/// Median absolute deviation from the median, times 1.4826 (a standard deviation for normal data).
pub fn mad(values: &[f64]) -> Option<f64> {
    let centre = median(values)?;
    let deviations: Vec<f64> = values.iter().map(|v| (v - centre).abs()).collect();
    median(&deviations).map(|m| 1.4826 * m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_statistics_of_a_short_list() {
        let v = [4.0, 1.0, f64::NAN, 2.0, 3.0, 5.0];
        assert_eq!(median(&v), Some(3.0));
        assert_eq!(percentile(&v, 0.25), Some(2.0));
        assert!((mad(&v).unwrap() - 1.4826).abs() < 1e-12);
        assert_eq!(median(&[]), None);
    }
}
