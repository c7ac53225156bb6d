//! A clock that counts in steps longer than a microsecond.
//!
//! # Model
//! `t ← ⌈t / q⌉ q`, or `⌊t / q⌋ q` where the count that has begun is read (`rounding = "down"`).
//!
//! # Source
//! Lichtsteiner et al. 2008: events are stamped by a counter off the chip.

use super::{ClockStage, GRACE_US, next_count_us};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Domain, NumberSpec, Parameter, StageSpec, WordSpec};

const PERIOD: Parameter = Parameter::Number(NumberSpec {
    name: "period_us",
    unit: "us",
    range: (1.0, 100_000.0),
    typical: Some((1.0, 1000.0)),
    // Streams count whole microseconds anyway.
    default: Some(1.0),
    doc: "length of one count of the clock",
    ..NumberSpec::LOG
});

const ROUNDING: Parameter = Parameter::Word(WordSpec {
    name: "rounding",
    allowed: &["up", "down"],
    default: Some("up"),
    doc: "whether events wait for the next count or carry the one that has begun",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "timestamp_quantisation",
    domain: Domain::Clock,
    summary: "timestamps are counts of a clock, the camera's or a converter's",
    formula: "t = ceil(t / period_us) period_us, or floor",
    params: &[PERIOD, ROUNDING],
    source: Citation::LICHTSTEINER_2008,
    signature: Signature {
        look_for: "stamps are multiples of a period: a saw tooth with that period, always late",
        probe: Probe::StampError,
        strength: Strength::Rising(&["period_us"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Clock(Box::new(TimestampQuantisation {
            period_us: settings.number(&PERIOD),
            is_up: settings.word(&ROUNDING) == Some("up"),
        })))
    },
};

#[derive(Debug)]
struct TimestampQuantisation {
    period_us: f64,
    is_up: bool,
}

impl ClockStage for TimestampQuantisation {
    fn shown(&self, t_s: f64) -> f64 {
        let next_us = next_count_us(t_s, self.period_us);
        let is_between = next_us > t_s * 1e6 + GRACE_US;
        let down_us = if is_between { self.period_us } else { 0.0 };
        1e-6 * if self.is_up { next_us } else { next_us - down_us }
    }

    fn earliest_shown(&self, t_s: f64) -> f64 {
        // What comes right behind may carry the count that has begun.
        if self.is_up { t_s } else { self.shown(t_s) - 1e-6 }
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Polarity, StageNoise};

    use super::*;
    use crate::clock::stamp;
    use crate::tick::Tick;
    use crate::{Origin, Request};

    #[test]
    fn times_wait_for_the_next_count_or_carry_the_last() {
        let tick = Tick { start_s: 0.0, end_s: 1e-3, index: 1 };
        let cases = [(0, 0, 0), (1, 0, 250), (249, 0, 250), (250, 250, 250), (251, 250, 500)];
        for (t_us, down_us, up_us) in cases {
            for (is_up, expected_us) in [(false, down_us), (true, up_us)] {
                let clock = TimestampQuantisation { period_us: 250.0, is_up };
                let (t_s, polarity) = (f64::from(t_us) * 1e-6, Polarity::On);
                let mut events = vec![Request { t_s, pixel: 0, polarity, origin: Origin::Signal }];
                clock.step(&tick, &mut events, &mut [], StageNoise::new(0, SPEC.name, 1));
                assert_eq!(stamp(events[0].t_s).0, expected_us, "{t_us}, up: {is_up}");
            }
        }
    }
}
