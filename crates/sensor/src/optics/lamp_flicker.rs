//! Lamps flicker, and all they light with them.
//!
//! # Model
//! `I ← I (1 + depth w(f t + phase))`, with `w` a sine, or +1 in the first half of a period and -1
//! in the second. A step sees the lamp at its exposure. A camera that is switched on under the lamp
//! has pixels that answer to every period once the swing is more than a threshold, as soon as
//! anything makes them answer to one; with `memory = "trough"` they begin so.
//!
//! # Source
//! IEEE 1789-2015: 100 or 120 Hz from the mains, up to kilohertz from pulsed LEDs.

use std::f64::consts::TAU;

use evpose_core::StageNoise;

use crate::signature::{Probe, Signature, Strength};
use crate::stage::{Block, PixelStage, Stage};
use crate::tick::Tick;
use crate::{
    Citation, Domain, LINEAR_OFF_AT_ZERO, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec,
    WordSpec,
};
use evpose_cpu::vectorize;

const FREQUENCY: Parameter = Parameter::Number(NumberSpec {
    name: "frequency_hz",
    unit: "Hz",
    range: (0.1, 1e5),
    typical: Some((50.0, 1000.0)),
    doc: "periods per second: twice the mains frequency",
    ..NumberSpec::LOG
});

const DEPTH: Parameter = Parameter::Number(NumberSpec {
    name: "depth",
    range: (0.001, 1.0),
    typical: Some((0.02, 0.5)),
    doc: "amplitude as a part of the mean",
    ..LOG_OFF_AT_ZERO
});

const PHASE: Parameter = Parameter::Number(NumberSpec {
    name: "phase_turns",
    unit: "turns",
    range: (0.0, 1.0),
    doc: "where in its period the lamp is at time zero",
    ..LINEAR_OFF_AT_ZERO
});

const WAVE: Parameter = Parameter::Word(WordSpec {
    name: "wave",
    allowed: &["sine", "square"],
    default: Some("sine"),
    doc: "mains or pulsed",
});

const MEMORY: Parameter = Parameter::Word(WordSpec {
    name: "memory",
    allowed: &["now", "trough"],
    default: Some("now"),
    doc: "light that pixels begin with: that of the first exposure, or the least of the lamp, which \
          pixels remember that have answered to it for long",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "lamp_flicker",
    domain: Domain::Optics,
    summary: "the light of the scene varies periodically",
    formula: "I = I (1 + depth sin(2 pi (frequency_hz t + phase_turns)))",
    params: &[FREQUENCY, DEPTH, PHASE, WAVE, MEMORY],
    source: Citation {
        key: "IEEE 1789-2015",
        text: "IEEE Recommended Practices for Modulating Current in High-Brightness LEDs, 2015",
    },
    signature: Signature {
        look_for: "ON and OFF rates of the whole image rise and fall at the frequency of the \
                   lamp, in antiphase; below a depth of about half a threshold nothing happens",
        probe: Probe::RateOverTime,
        strength: Strength::Rising(&["depth"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Pixel(Box::new(LampFlicker {
            frequency_hz: settings.number(&FREQUENCY),
            depth: settings.number(&DEPTH),
            phase_turns: settings.number(&PHASE),
            is_square: settings.word(&WAVE) == Some("square"),
            begins_at_trough: settings.word(&MEMORY) == Some("trough"),
        })))
    },
};

/// Parts of a period into which steps are divided: the chords of a sine then miss half a percent of
/// its amplitude.
const PARTS_OF_PERIOD: f64 = 32.0;

/// The wave that pixels remember, just above its trough: the way back to the very trough would be
/// as long as a threshold and no more, which may cross it or not.
const REMEMBERED: f64 = -0.9;

#[derive(Debug)]
struct LampFlicker {
    frequency_hz: f64,
    depth: f64,
    phase_turns: f64,
    is_square: bool,
    begins_at_trough: bool,
}

impl PixelStage for LampFlicker {
    /// Steps are straight, waves are not.
    fn time_constant_s(&self) -> Option<f64> {
        Some(1.0 / (PARTS_OF_PERIOD * self.frequency_hz))
    }

    fn step(&self, tick: &Tick, block: &mut Block<'_>, _noise: StageNoise) {
        let turn = (self.frequency_hz * tick.end_s + self.phase_turns).rem_euclid(1.0);
        let wave = match (self.is_square, turn < 0.5) {
            _ if self.begins_at_trough && tick.index == 0 => REMEMBERED,
            (false, _) => (TAU * turn).sin(),
            (true, true) => 1.0,
            (true, false) => -1.0,
        };
        let factor = (1.0 + self.depth * wave) as f32;
        vectorize(
            #[inline(always)]
            || block.signal.iter_mut().for_each(|y| *y *= factor),
        );
    }
}
