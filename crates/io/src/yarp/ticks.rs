//! Conversion of ticks to microseconds.

use evpose_core::Micros;

use crate::OpenOptions;
use crate::time_stamp::{HalfPeriodFall, WraparoundCounter};

/// A tick of the cameras' interface, in microseconds.
const INTERFACE_US: f64 = 0.08;
/// The tick of programs that write microseconds.
const MICROSECOND: f64 = 1.0;
/// Bits of the narrowest counter that is in use.
const MIN_COUNTER_BITS: u32 = 24;
/// Maximal ratio, as a logarithm, between the measured tick and one of the known ones: dumpers
/// write bottles some milliseconds late, and the two kinds are 12.5 times apart.
const MAX_LOG_RATIO: f64 = 0.5;

/// Length of a tick, and its origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tick {
    us: f64,
    origin: Origin,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Origin {
    Given,
    Measured,
    Assumed,
}

impl Tick {
    /// The tick that the caller gives, else the known one nearest to that of `elapsed` (ticks and
    /// seconds), else the interface's.
    pub(super) fn new(options: &OpenOptions, elapsed: Option<(f64, f64)>) -> Self {
        let given = options.tick_us.filter(|us| us.is_finite() && *us > 0.0);
        let measured = || {
            let (ticks, seconds) = elapsed?;
            let us = 1e6 * seconds / ticks;
            [INTERFACE_US, MICROSECOND]
                .into_iter()
                .find(|known| (us / known).ln().abs() < MAX_LOG_RATIO)
        };
        match (given, measured()) {
            // A measured tick is snapped to a known one: bottles are stamped too roughly for their
            // own.
            (Some(us), _) => Self { us, origin: Origin::Given },
            (None, Some(us)) => Self { us, origin: Origin::Measured },
            (None, None) => Self { us: INTERFACE_US, origin: Origin::Assumed },
        }
    }

    pub(super) fn fact(self) -> (&'static str, String) {
        let origin = match self.origin {
            Origin::Given => "as given",
            Origin::Measured => "by the times of its bottles",
            Origin::Assumed => "assumed",
        };
        ("tick", format!("{} µs ({origin})", self.us))
    }
}

/// Unwraps stored ticks and converts them to microseconds.
#[derive(Debug, Clone)]
pub(super) struct TickCounter {
    tick: Tick,
    counter: WraparoundCounter,
}

impl TickCounter {
    pub(super) fn new(tick: Tick) -> Self {
        Self { tick, counter: WraparoundCounter::new(MIN_COUNTER_BITS, HalfPeriodFall::StepBack) }
    }

    /// Ticks since the beginning of the first period.
    #[inline]
    pub(super) fn ticks(&mut self, stored: u32) -> i64 {
        let ticks = self.counter.advance(stored.into());
        // Interfaces of 24 to 32 bits are in use, and a log does not state which: the largest stamp
        // decides.
        self.counter.widen_to(stored);
        ticks
    }

    /// Time of the stored ticks, rounded to a microsecond.
    #[inline]
    pub(super) fn time(&mut self, stored: u32) -> Micros {
        Micros((self.ticks(stored) as f64 * self.tick.us).round() as i64)
    }

    pub(super) fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        if self.counter.is_set() && self.tick.origin == Origin::Assumed {
            remarks.push(format!(
                "a tick is taken to be {INTERFACE_US} µs, as the cameras' interface counts and bimvee \
                 writes; nothing in the file states whether it is {MICROSECOND} µs"
            ));
        }
        if self.counter.wraparounds() > 0 {
            remarks.push(format!("times wrapped around {} times", self.counter.wraparounds()));
        }
        remarks
    }
}
