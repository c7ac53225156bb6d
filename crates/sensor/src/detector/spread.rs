//! The even times at which the events of a frame are, and the refractory periods between them.
//!
//! # Model
//! With `n` the largest count of any pixel, event `k = 0 .. n - 1` of a pixel is at
//! `t_start + (k + 1) dt / n`. An event is lost if it is not later than the refractory period
//! behind the one before, unless refractory periods are not longer than `dt / n`: then they are
//! passed over, neither looked at nor kept.
//!
//! # Source
//! The published emulator of v2e, which has both conventions.

use super::pixel::RefractoryState;
use crate::tick::Tick;

#[derive(Debug, Clone, Copy)]
pub(super) struct Spread {
    start_s: f64,
    end_s: f64,
    count: u32,
    refractory_s: f64,
    is_rounded: bool,
}

impl Spread {
    /// `count` even times in a step, or one, at its end.
    pub(super) fn new(tick: &Tick, count: u32, refractory_s: f64, is_rounded: bool) -> Self {
        // Exposures are at whole microseconds, whose nearest seconds are these.
        let nearest = |s: f64| if is_rounded { (s * 1e6).round() / 1e6 } else { s };
        let (start_s, end_s) = (nearest(tick.start_s), nearest(tick.end_s));
        Self { start_s, end_s, count: count.max(1), refractory_s, is_rounded }
    }

    /// Whether refractory periods are passed over in this step.
    pub(super) fn ignores_refractory(&self) -> bool {
        self.refractory_s <= (self.end_s - self.start_s) / f64::from(self.count)
    }

    /// The time of event `k`.
    pub(super) fn at(&self, k: u32) -> f64 {
        self.start_s + f64::from(k + 1) / f64::from(self.count) * (self.end_s - self.start_s)
    }

    /// Whether event `k` is lost in the refractory period of the one before.
    pub(super) fn is_refractory(&self, k: u32, refractory: RefractoryState) -> bool {
        if !self.is_rounded {
            return self.at(k) <= refractory.free_s;
        }
        let last_s = (refractory.free_s - self.refractory_s) as f32;
        // What is no number is no refractory period: there was no event before.
        self.single(k) - last_s <= self.refractory_s as f32
    }

    /// The refractory state after event `k`, if there is one.
    pub(super) fn keep(&self, k: u32, refractory: &mut RefractoryState) {
        if self.is_rounded && self.refractory_s > 0.0 {
            refractory.free_s = f64::from(self.single(k)) + self.refractory_s;
        }
    }

    /// The time of event `k` in single precision, counted from the nearer end of the step in steps
    /// of single precision, with one rounding of their sum.
    fn single(&self, k: u32) -> f32 {
        let n = f64::from(self.count);
        let first = (self.start_s + (self.end_s - self.start_s) / n) as f32;
        let last = self.end_s as f32;
        if self.count == 1 {
            return first;
        }
        // As `torch.linspace` of the published emulator computes it: from both ends towards the
        // middle.
        let step = (last - first) / (self.count - 1) as f32;
        let (from, steps) = if k < self.count / 2 {
            (first, f64::from(k))
        } else {
            (last, -f64::from(self.count - 1 - k))
        };
        (f64::from(step) * steps + f64::from(from)) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread(start_us: u32, end_us: u32, count: u32, is_rounded: bool) -> Spread {
        let [start_s, end_s] = [start_us, end_us].map(|us| f64::from(us) * 1e-6);
        let tick = Tick { start_s, end_s, index: 1 };
        Spread::new(&tick, count, 0.5e-3, is_rounded)
    }

    #[test]
    fn times_are_even_and_the_last_is_the_frame() {
        let spread = spread(1_000, 2_000, 4, false);
        let expected = [1.25e-3, 1.5e-3, 1.75e-3, 2e-3];
        for (k, expected) in (0..4).zip(expected) {
            assert!((spread.at(k) - expected).abs() < 1e-12, "{k}");
        }
    }

    #[test]
    fn refractory_periods_up_to_the_spacing_are_ignored() {
        assert!(spread(1_000, 2_000, 1, false).ignores_refractory());
        assert!(!spread(1_000, 2_000, 3, false).ignores_refractory());
    }

    #[test]
    fn rounded_times_are_within_one_rounding() {
        for count in 1..20 {
            let spread = spread(299_000, 300_000, count, true);
            for k in 0..count {
                let error = f64::from(spread.single(k)) - spread.at(k);
                assert!(error.abs() < 4e-8, "{k} of {count}: {error}");
            }
        }
    }

    #[test]
    fn an_event_exactly_at_the_end_of_the_refractory_period_is_lost_unless_rounding_saves_it() {
        let refractory_after = |spread: Spread| {
            let mut refractory =
                RefractoryState { free_s: spread.at(1) + 0.5e-3, ..RefractoryState::NONE };
            spread.keep(1, &mut refractory);
            spread.is_refractory(3, refractory)
        };
        assert!((0..300).all(|k| {
            !spread(k * 1_000, (k + 1) * 1_000, 4, true).is_refractory(0, RefractoryState::NONE)
        }));
        let lost =
            (1..300).filter(|k| refractory_after(spread(k * 1_000, (k + 1) * 1_000, 4, true)));
        let lost = lost.count();
        assert!((50..250).contains(&lost), "{lost} of 299");
    }
}
