//! False discovery rate of many tests.

/// False discovery rate of what is called significant among many.
pub(crate) const FALSE_DISCOVERY_RATE: f64 = 0.05;

/// Marks the p-values that are significant at a false discovery rate of 5 %.
///
/// # Source
/// Benjamini, Hochberg: *Controlling the false discovery rate*, J. R. Statist. Soc. B 57, 1995.
pub(crate) fn discoveries(p: &[f64]) -> Vec<bool> {
    let mut sorted = p.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let passes = |(i, p): &(usize, &f64)| **p <= FALSE_DISCOVERY_RATE * (*i + 1) as f64 / n;
    // Step-up: the last that passes sets the limit, also for those before it that fail alone.
    let limit = sorted.iter().enumerate().rfind(passes).map(|(_, p)| *p);
    p.iter().map(|p| limit.is_some_and(|limit| *p <= limit)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discoveries_are_those_of_a_worked_example() {
        // Limits are 0.0125, 0.025, 0.0375 and 0.05.
        assert_eq!(discoveries(&[0.001, 0.008, 0.039, 0.6]), [true, true, false, false]);
        // The third passes its limit and takes the second along, which is beyond its own.
        assert_eq!(discoveries(&[0.001, 0.03, 0.036, 0.6]), [true, true, true, false]);
        assert_eq!(discoveries(&[]), Vec::<bool>::new());
    }
}
