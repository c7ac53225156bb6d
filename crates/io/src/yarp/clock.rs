//! Ticks to microseconds.

use evpose_core::Micros;

use crate::OpenOptions;

/// A tick of the cameras' interface, in microseconds.
const INTERFACE_US: f64 = 0.08;
/// Ticks that programs have written which took them for microseconds.
const MICROSECOND: f64 = 1.0;
/// The fewest ticks of a period.
const LEAST_PERIOD: u64 = 1 << 24;

/// How long a tick is, and how that is known.
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
    /// A tick as the caller says, else as `passed` ticks within `seconds` tell, else the interface's.
    pub(super) fn new(options: &OpenOptions, passed: Option<(f64, f64)>) -> Self {
        let given = options.tick_us.filter(|us| us.is_finite() && *us > 0.0);
        let measured = || {
            let (ticks, seconds) = passed?;
            let us = 1e6 * seconds / ticks;
            // Dumpers write bottles some milliseconds late; the two kinds are 12.5 times apart.
            [INTERFACE_US, MICROSECOND].into_iter().find(|kind| (us / kind).ln().abs() < 0.5)
        };
        match (given, measured()) {
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

/// Unwraps ticks.
#[derive(Debug, Clone)]
pub(super) struct Clock {
    tick: Tick,
    before: u32,
    most: u32,
    /// Ticks of whole periods that have passed.
    ahead: u64,
    wraps: u64,
    is_used: bool,
}

impl Clock {
    pub(super) fn new(tick: Tick) -> Self {
        Self { tick, before: 0, most: 0, ahead: 0, wraps: 0, is_used: false }
    }

    /// Ticks since the beginning of the first period.
    #[inline]
    pub(super) fn ticks(&mut self, written: u32) -> u64 {
        let fell = u64::from(self.before.saturating_sub(written));
        if fell > LEAST_PERIOD / 2 {
            let period = (u64::from(self.most) + 1).next_power_of_two().max(LEAST_PERIOD);
            if 2 * fell > period {
                self.ahead += period;
                self.wraps += 1;
            }
        }
        self.before = written;
        self.most = self.most.max(written);
        self.is_used = true;
        self.ahead + u64::from(written)
    }

    /// The nearest microsecond.
    #[inline]
    pub(super) fn time(&mut self, written: u32) -> Micros {
        Micros((self.ticks(written) as f64 * self.tick.us).round() as i64)
    }

    pub(super) fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        if self.is_used && self.tick.origin == Origin::Assumed {
            remarks.push(format!(
                "a tick is taken to be {INTERFACE_US} µs, as the cameras' interface counts and bimvee \
                 writes; nothing in the file tells whether it is {MICROSECOND} µs"
            ));
        }
        if self.wraps > 0 {
            remarks.push(format!("times wrapped around {} times", self.wraps));
        }
        remarks
    }
}
