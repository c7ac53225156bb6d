//! Detection of columns without a name.

/// Minimal share of steps in which times do not go back.
const MIN_FORWARD: f64 = 0.9;

/// Whether a column may hold times: over a lag of a twentieth of its length, values of any other
/// column fall as often as they rise.
pub(crate) fn is_time(values: &(impl ExactSizeIterator<Item = f64> + Clone)) -> bool {
    let lag = (values.len() / 20).max(1);
    let pairs = values.clone().zip(values.clone().skip(lag));
    let steps = values.len().saturating_sub(lag);
    let forward = pairs.filter(|(a, b)| b >= a).count();
    forward as f64 >= MIN_FORWARD * steps as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_distinguished_from_coordinates_and_polarities() {
        let is_time = |value: fn(usize) -> usize| {
            let values: Vec<f64> = (0..1000).map(|k| value(k) as f64).collect();
            is_time(&values.iter().copied())
        };
        assert!(is_time(|k| 3 * k) && is_time(|k| k / 10 * 10 + (7 * k) % 10));
        assert!(!is_time(|k| (37 * k) % 101) && !is_time(|k| (k / 3) % 2));
    }
}
