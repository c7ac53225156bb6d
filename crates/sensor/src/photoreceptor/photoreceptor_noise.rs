//! The photoreceptor's voltage is noisy, within its own bandwidth.
//!
//! # Model
//! `V ← V + n`, `n` an Ornstein-Uhlenbeck process of standard deviation `sigma` and rate
//! `2 π f(I)`, `f = cutoff_hz (I + dark_light)`: exact for steps of any length. Where noise crosses
//! a threshold it comes back: ON and OFF alternate.
//!
//! # Source
//! Graca and Delbruck 2021. The process: Uhlenbeck and Ornstein 1930.

use std::f64::consts::TAU;

use evpose_core::StageNoise;

use super::photoreceptor_lowpass::DARK_LIGHT;
use crate::exponential::decay;
use crate::gaussian::{PIECE, fill_normal};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::{Block, PixelStage, Stage};
use crate::tick::Tick;
use crate::{Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec};
use evpose_cpu::vectorize;

const SIGMA: Parameter = Parameter::Number(NumberSpec {
    name: "sigma",
    unit: "ln",
    range: (1e-4, 2.0),
    typical: Some((0.02, 0.2)),
    doc: "standard deviation of the voltage",
    ..LOG_OFF_AT_ZERO
});

const CUTOFF: Parameter = Parameter::Number(NumberSpec {
    name: "cutoff_hz",
    unit: "Hz",
    range: (0.01, 1e7),
    typical: Some((30.0, 3000.0)),
    doc: "bandwidth at the light of white",
    ..NumberSpec::LOG
});

/// Longest step, as a part of the correlation time of the noise.
const PART: f64 = 0.125;

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "photoreceptor_noise",
    domain: Domain::Photoreceptor,
    summary: "noise of the voltage, within the bandwidth of the photoreceptor",
    formula: "V = V + n; dn = -2 pi f n dt + sigma sqrt(4 pi f) dW; f = cutoff_hz (I + dark_light)",
    params: &[SIGMA, CUTOFF, DARK_LIGHT],
    source: Citation {
        key: "Graca and Delbruck 2021",
        text: "R. Graca, T. Delbruck: Unraveling the Paradox of Intensity-Dependent DVS Pixel \
               Noise, IISW 2021",
    },
    signature: Signature {
        look_for: "ON and OFF in alternating pairs, steep in threshold over sigma; more of them \
                   where the bandwidth is larger, in bright light, unless a slower \
                   source_follower behind it leaves most to the dark",
        probe: Probe::NoisePairs,
        strength: Strength::Rising(&["sigma"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Pixel(Box::new(PhotoreceptorNoise {
            sigma: settings.number(&SIGMA) as f32,
            cutoff_hz: settings.number(&CUTOFF),
            dark_light: settings.number(&DARK_LIGHT) as f32,
        })))
    },
};

#[derive(Debug)]
struct PhotoreceptorNoise {
    sigma: f32,
    cutoff_hz: f64,
    dark_light: f32,
}

impl PixelStage for PhotoreceptorNoise {
    /// Between the ends of a step it may have crossed a threshold and come back, also where the
    /// step is shorter than the correlation time of the noise.
    fn time_constant_s(&self) -> Option<f64> {
        Some(PART / (TAU * self.cutoff_hz * (1.0 + f64::from(self.dark_light))))
    }

    fn state_planes(&self) -> usize {
        1
    }

    /// The process has been running for ever.
    fn init(&self, block: &mut Block<'_>, noise: StageNoise) {
        let [now] = block.state.planes();
        fill_normal(noise, block.pixels.start, now);
        now.iter_mut().for_each(|draw| *draw *= self.sigma);
    }

    fn step(&self, tick: &Tick, block: &mut Block<'_>, noise: StageNoise) {
        let turns = (TAU * self.cutoff_hz * tick.dt_s()) as f32;
        let [now] = block.state.planes();
        let (signal, light) = (&mut *block.signal, block.photocurrent);
        let first = block.pixels.start;
        vectorize(
            #[inline(always)]
            || {
                let pieces = now.chunks_mut(PIECE).zip(signal.chunks_mut(PIECE));
                for (piece, ((now, signal), light)) in pieces.zip(light.chunks(PIECE)).enumerate() {
                    let mut draws = [0.0; PIECE];
                    fill_normal(noise, first + piece * PIECE, &mut draws);
                    let pixels = now.iter_mut().zip(signal).zip(light).zip(&draws);
                    for (((now, signal), light), draw) in pixels {
                        let a = turns * (light + self.dark_light);
                        // The exact update of an Ornstein-Uhlenbeck process, right for steps of any
                        // length.
                        let left = 1.0 - decay(a);
                        let fresh = decay(2.0 * a).sqrt();
                        *now = left * *now + self.sigma * fresh * draw;
                        *signal += *now;
                    }
                }
            },
        );
    }
}
