//! Event times to timestamps.

use std::fmt::Debug;

use evpose_core::{Micros, StageNoise};

use crate::tick::Tick;
use crate::{Request, Traits};

pub(crate) mod clock_offset_drift;
pub(crate) mod frame_grid;
pub(crate) mod pixel_latency;
pub(crate) mod timestamp_jitter;
pub(crate) mod timestamp_quantisation;

/// Moves events in time.
pub trait ClockStage: Send + Sync + Debug {
    /// Properties from which the chain chooses the path of a step.
    fn traits(&self) -> Traits {
        Traits::default()
    }

    /// How many `f64` values it keeps between exposures; they start at zero.
    fn state_len(&self) -> usize {
        0
    }

    /// The earliest that the clock shows of what happens at `t_s`: on one that runs slow, or
    /// scatters, events of the next step may have stamps before those of this one, which therefore
    /// wait until nothing can come before them.
    fn earliest_shown(&self, t_s: f64) -> f64 {
        t_s
    }

    /// The time that the clock shows of what happens at `t_s`, where that is all it depends on.
    fn shown(&self, t_s: f64) -> f64 {
        t_s
    }

    /// Changes the times of the events served in `tick`, or takes some away. Those moved behind
    /// `tick.end_s` are delivered with the exposure that they precede; none is stamped before what
    /// the clock showed at the start of the tick.
    fn step(&self, _: &Tick, events: &mut Vec<Request>, _state: &mut [f64], _: StageNoise) {
        for event in events {
            event.t_s = self.shown(event.t_s);
        }
    }
}

/// A billionth of a second that `f64` seconds may be off without reaching the next count.
const GRACE_US: f64 = 1e-3;

/// The first multiple of `period_us` that is not before `t_s`, in microseconds.
pub(crate) fn next_count_us(t_s: f64, period_us: f64) -> f64 {
    ceil((t_s * 1e6 - GRACE_US) / period_us) * period_us
}

/// The least whole number not below `x`. Baseline processors have no instruction for it, and the
/// library call costs as much as all else about a stamp; times are well within an `i64`.
fn ceil(x: f64) -> f64 {
    let whole = x as i64 as f64;
    if whole < x { whole + 1.0 } else { whole }
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
