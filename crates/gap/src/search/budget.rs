//! Time that a search may take.

use std::time::{Duration, Instant};

/// Fraction of the time after which no further effect is tried: testing those found takes about as
/// long as finding them.
const FOR_FINDING: f64 = 0.5;
/// Fraction of the time after which effects are not compared with their rivals any more.
const FOR_RIVALS: f64 = 0.75;

/// Time that a search may take, from its start. With a budget the result depends on the speed of
/// the machine.
#[derive(Debug, Clone, Copy)]
pub struct Budget {
    start: Instant,
    length: Duration,
}

impl Budget {
    /// A budget that begins now.
    pub fn from_now(length: Duration) -> Self {
        Self { start: Instant::now(), length }
    }

    /// Whether there is time to try a further effect.
    pub(super) fn allows_finding(&self) -> bool {
        self.is_within(FOR_FINDING)
    }

    /// Whether there is time to compare effects with their rivals.
    pub(super) fn allows_rivals(&self) -> bool {
        self.is_within(FOR_RIVALS)
    }

    fn is_within(&self, fraction: f64) -> bool {
        self.start.elapsed() < self.length.mul_f64(fraction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spent_budget_allows_nothing_and_a_long_one_everything() {
        let spent = Budget::from_now(Duration::ZERO);
        assert!(!spent.allows_finding() && !spent.allows_rivals());
        let long = Budget::from_now(Duration::from_secs(3600));
        assert!(long.allows_finding() && long.allows_rivals());
    }
}
