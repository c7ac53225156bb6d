//! A clock that counts in steps longer than a microsecond.
//!
//! # Model
//! `t ← ⌈t / q⌉ q`.
//!
//! # Source
//! Lichtsteiner et al. 2008: events are stamped by a counter off the chip.

use evpose_core::StageNoise;

use super::{ClockStage, next_count_us};
use crate::search_spec::SearchSpec;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::tick::Tick;
use crate::{Citation, Domain, ParamSpec, Prior, RecordingMark, Request, Scale, StageSpec};

const PERIOD: ParamSpec = ParamSpec {
    name: "period_us",
    unit: "us",
    range: (1.0, 100_000.0),
    scale: Scale::Log,
    prior: Prior::Typical(1.0, 1000.0),
    // Streams count whole microseconds anyway.
    neutral: Some(1.0),
    doc: "length of one count of the clock",
};

/// The registry entry.
pub(crate) static SPEC: StageSpec = StageSpec {
    name: "timestamp_quantisation",
    domain: Domain::Clock,
    summary: "timestamps are counts of a clock",
    formula: "t = ceil(t / period_us) period_us",
    params: &[PERIOD],
    choices: &[],
    files: &[],
    source: Citation {
        key: "Lichtsteiner et al. 2008",
        text: "P. Lichtsteiner, C. Posch, T. Delbruck: A 128x128 120 dB 15 us Latency Asynchronous \
               Temporal Contrast Vision Sensor, IEEE JSSC 43(2), 2008",
    },
    signature: Signature {
        look_for: "stamps are multiples of a period: a saw tooth with that period, always late",
        probe: Probe::StampError,
        strength: Strength::Rising(&["period_us"]),
        beside: &[],
    },
    search: SearchSpec {
        mark: Some(RecordingMark::TimeGrid),
        resembles: &["frame_grid"],
        ..SearchSpec::PLAIN
    },
    build: |settings| {
        Ok(Stage::Clock(Box::new(TimestampQuantisation { period_us: settings.number(&PERIOD) })))
    },
};

/// Rounding up to counts.
#[derive(Debug)]
struct TimestampQuantisation {
    period_us: f64,
}

impl ClockStage for TimestampQuantisation {
    fn is_neutral(&self) -> bool {
        Some(self.period_us) == PERIOD.neutral
    }

    fn step(
        &self,
        _tick: &Tick,
        events: &mut Vec<Request>,
        _state: &mut [f64],
        _noise: StageNoise,
    ) {
        for event in events {
            event.t_s = next_count_us(event.t_s, self.period_us) * 1e-6;
        }
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Polarity;

    use super::*;
    use crate::Origin;
    use crate::clock::stamp;

    #[test]
    fn times_wait_for_the_next_count() {
        let clock = TimestampQuantisation { period_us: 250.0 };
        let tick = Tick { start_s: 0.0, end_s: 1e-3, index: 1 };
        for (t_us, expected_us) in [(0, 0), (1, 250), (249, 250), (250, 250), (251, 500)] {
            let (t_s, polarity, origin) = (f64::from(t_us) * 1e-6, Polarity::On, Origin::Signal);
            let event = Request { t_s, pixel: 0, polarity, origin };
            let mut events = vec![event];
            clock.step(&tick, &mut events, &mut [], StageNoise::new(0, SPEC.name, 1));
            assert_eq!(stamp(events[0].t_s).0, expected_us, "{t_us}");
        }
    }
}
