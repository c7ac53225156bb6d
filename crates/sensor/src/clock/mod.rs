//! Event times to timestamps.

use std::fmt::Debug;

use evpose_core::{Micros, StageNoise};

use crate::Request;
use crate::stage::Tick;

pub(crate) mod timestamp_quantisation;

/// Moves events in time.
pub trait ClockStage: Send + Sync + Debug {
    /// Whether the parameters make the stage the identity; the chain then leaves it out.
    fn is_neutral(&self) -> bool;

    /// Changes the times of the events served in `tick`. None may come before `tick.start_s`;
    /// those moved behind `tick.end_s` are delivered with the exposure that they precede.
    fn step(&self, tick: &Tick, events: &mut Vec<Request>, noise: StageNoise);
}

/// A billionth of a second that `f64` seconds may be off without reaching the next count.
const GRACE_US: f64 = 1e-3;

/// The first multiple of `period_us` that is not before `t_s`, in microseconds.
fn next_count_us(t_s: f64, period_us: f64) -> f64 {
    ((t_s * 1e6 - GRACE_US) / period_us).ceil() * period_us
}

/// The first whole microsecond that is not before `t_s`: no stamp precedes its event, and events
/// of one step stay behind those of the step before.
pub(crate) fn stamp(t_s: f64) -> Micros {
    Micros(next_count_us(t_s, 1.0) as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_microseconds_are_stamped_as_they_are() {
        for t in (0..2_000_000).chain(86_400_000_000..86_400_100_000).step_by(7) {
            assert_eq!(stamp(Micros(t).as_seconds()), Micros(t));
        }
    }

    #[test]
    fn anything_later_waits_for_the_next_microsecond() {
        assert_eq!(stamp(3.01e-6), Micros(4));
        assert_eq!(stamp(3.99e-6), Micros(4));
    }
}
