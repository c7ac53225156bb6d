//! Event rate control: what is above a budget is thrown away.
//!
//! # Model
//! Time is cut in windows of `window_us`, one of which begins at `phase_us`. Of the events served in one, at most `rate_hz` times its
//! length get through: the first ones (`drop = "late"`), or each with the same chance
//! (`drop = "random"`, as far as the events of a window come with one exposure). Pixels are served
//! all the same: there is no delay, and memories know nothing of it.
//!
//! # Source
//! Finateu et al. 2020 describe the event rate controller of a Prophesee sensor.

use evpose_core::StageNoise;

use crate::Request;
use crate::clock::ClockStage;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::tick::Tick;
use crate::{
    Citation, Domain, LINEAR_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec, Traits, WordSpec,
};

const RATE: Parameter = Parameter::Number(NumberSpec {
    name: "rate_hz",
    unit: "Hz",
    range: (1e3, 1e10),
    typical: Some((1e6, 1e8)),
    default: Some(f64::INFINITY),
    doc: "events per second of the whole sensor that get through",
    ..NumberSpec::LOG
});

const WINDOW: Parameter = Parameter::Number(NumberSpec {
    name: "window_us",
    unit: "us",
    range: (1.0, 1e6),
    typical: Some((100.0, 10_000.0)),
    doc: "time over which events are counted",
    ..NumberSpec::LOG
});

const PHASE: Parameter = Parameter::Number(NumberSpec {
    name: "phase_us",
    unit: "us",
    range: (0.0, 1e6),
    doc: "time at which the first window begins",
    ..LINEAR_OFF_AT_ZERO
});

const DROP: Parameter = Parameter::Word(WordSpec {
    name: "drop",
    allowed: &["random", "late"],
    default: Some("random"),
    doc: "whether any event or the last ones of a window are thrown away",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "event_rate_control",
    domain: Domain::Readout,
    summary: "events above a rate are thrown away, without delay",
    formula: "at most rate_hz window_us events per window",
    params: &[RATE, WINDOW, PHASE, DROP],
    source: Citation::FINATEU_2020,
    signature: Signature {
        look_for: "the rate is cut at a ceiling, without delay; parts of a busy image are \
                   missing",
        probe: Probe::FlashRate,
        strength: Strength::Falling(&["rate_hz"]),
        beside: &[],
    },
    build: |settings| {
        let window_s = settings.number(&WINDOW) * 1e-6;
        Ok(Stage::Clock(Box::new(EventRateControl {
            budget: (settings.number(&RATE) * window_s).floor(),
            window_s,
            phase_s: settings.number(&PHASE) * 1e-6,
            is_random: settings.word(&DROP) == Some("random"),
        })))
    },
};

/// A budget per window. Its state: the number of the window plus one, and what it has let through.
#[derive(Debug)]
struct EventRateControl {
    budget: f64,
    window_s: f64,
    phase_s: f64,
    is_random: bool,
}

impl EventRateControl {
    fn window(&self, t_s: f64) -> f64 {
        // The end of a window belongs to it, as the end of a step does.
        ((t_s - self.phase_s) / self.window_s).ceil() + 1.0
    }
}

impl ClockStage for EventRateControl {
    fn traits(&self) -> Traits {
        Traits { needs_order: true, ..Traits::default() }
    }

    fn state_len(&self) -> usize {
        2
    }

    fn step(&self, _tick: &Tick, events: &mut Vec<Request>, state: &mut [f64], noise: StageNoise) {
        let [window, passed] = state else { return };
        let mut kept = Vec::with_capacity(events.len());
        for group in events.chunk_by(|a, b| self.window(a.t_s) == self.window(b.t_s)) {
            let here = self.window(group[0].t_s);
            if here != *window {
                // A new window has its whole budget: what the last one left is lost.
                (*window, *passed) = (here, 0.0);
            }
            let mut room = (self.budget - *passed).max(0.0).min(group.len() as f64);
            *passed += room;
            for (k, event) in group.iter().enumerate() {
                // Exactly `room` of the group, each as likely as any other.
                let left = (group.len() - k) as f64;
                let chance = if self.is_random && room < left {
                    // By pixel and time: the draw does not depend on the other events of the group.
                    let draw = event.t_s.to_bits() as u32;
                    f64::from(noise.uniform(event.pixel as usize, draw))
                } else {
                    0.0
                };
                if room > 0.0 && chance * left <= room {
                    room -= 1.0;
                    kept.push(*event);
                }
            }
        }
        *events = kept;
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Polarity;

    use super::*;
    use crate::Origin;

    fn through(is_random: bool, phase_s: f64, events_per_ms: usize) -> Vec<f64> {
        let control = EventRateControl { budget: 100.0, window_s: 1e-3, phase_s, is_random };
        let mut state = vec![0.0; 2];
        let mut out = Vec::new();
        for index in 1..=20u64 {
            let (start_s, end_s) = ((index - 1) as f64 * 5e-4, index as f64 * 5e-4);
            let event = |k: usize| Request {
                t_s: start_s + (end_s - start_s) * (k + 1) as f64 / (events_per_ms / 2) as f64,
                pixel: k as u32,
                polarity: Polarity::On,
                origin: Origin::Signal,
            };
            let mut events: Vec<Request> = (0..events_per_ms / 2).map(event).collect();
            let tick = Tick { start_s, end_s, index };
            control.step(&tick, &mut events, &mut state, StageNoise::new(1, SPEC.name, index));
            out.extend(events.iter().map(|e| e.t_s));
        }
        out
    }

    #[test]
    fn a_quiet_scene_passes_and_a_busy_one_is_cut_to_the_budget() {
        for is_random in [false, true] {
            assert_eq!(through(is_random, 0.0, 90).len(), 900);
            assert_eq!(through(is_random, 0.0, 1000).len(), 1000);
        }
        // The late ones are gone: what is left lies in the first tenth of its window.
        let first = through(false, 0.0, 1000);
        assert!(first.iter().all(|t| (t / 1e-3 - 1e-9).rem_euclid(1.0) < 0.1001));
        let shifted = through(false, 3e-4, 1000);
        assert!(shifted.iter().skip(100).all(|t| (t / 1e-3 - 0.3 - 1e-9).rem_euclid(1.0) < 0.1001));
    }
}
