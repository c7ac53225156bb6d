//! The hidden effects of the benchmark and their four absolute strengths, in circuit units.
//!
//! The strengths were set so that the weakest is about invisible on a scene of the benchmark and
//! the two strongest are visible on all of them ([`crate::evidence`] says what visible means).

use serde::Serialize;

use crate::circuit::{
    Access, Circuit, Follower, HighPass, HotPixels, Junction, Lamp, NodeNoise, PhotonNoise, Timer,
};
use crate::draw::Sequence;
use crate::physics::thermal_voltage_v;
use crate::slot::Slot;

/// Part of the camera an effect belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraStage {
    /// Lamp and lens.
    Optics,
    /// Photodiode and photoreceptor.
    Photoreceptor,
    /// Change detector and comparators.
    Detector,
    /// Events that no light causes.
    Background,
    /// Way to the time-stamper.
    Readout,
    /// Time-stamper.
    Clock,
}

/// The effects that appear alone and in pairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Effect {
    /// Junction leakage of the reset switch.
    LeakOn,
    /// Slow photodiode node, and a source follower.
    PhotoreceptorLowpass,
    /// Noise of the photodiode node.
    PhotoreceptorNoise,
    /// Comparators fired by photon noise.
    ShotNoisePoisson,
    /// Slow feedback.
    AdaptiveHighpass,
    /// Dark current of the photodiode.
    DarkCurrent,
    /// Scattered light.
    VeilingGlare,
    /// Point spread function.
    PsfBlur,
    /// Ripple of the lamp.
    LampFlicker,
    /// Spread of the comparators' offsets.
    ThresholdMismatch,
    /// Noise of each comparison.
    ThresholdTemporalNoise,
    /// Time in reset.
    Refractory,
    /// Pixels that fire by themselves.
    HotPixels,
    /// Row-wise request and acknowledge.
    Arbiter,
    /// Columns visited in turn.
    ScannedReadout,
    /// Jitter of the time-stamper.
    TimestampJitter,
    /// Coarse counter.
    TimestampQuantisation,
    /// Constant delay of comparator and logic.
    PixelLatency,
}

/// All effects, in the order of the plan.
pub const EFFECTS: [Effect; 18] = [
    Effect::LeakOn,
    Effect::PhotoreceptorLowpass,
    Effect::PhotoreceptorNoise,
    Effect::ShotNoisePoisson,
    Effect::AdaptiveHighpass,
    Effect::DarkCurrent,
    Effect::VeilingGlare,
    Effect::PsfBlur,
    Effect::LampFlicker,
    Effect::ThresholdMismatch,
    Effect::ThresholdTemporalNoise,
    Effect::Refractory,
    Effect::HotPixels,
    Effect::Arbiter,
    Effect::ScannedReadout,
    Effect::TimestampJitter,
    Effect::TimestampQuantisation,
    Effect::PixelLatency,
];

/// Number of strengths of each effect.
pub const STRENGTHS: usize = 4;

impl Effect {
    /// Name in the catalogue of effects, stage of the camera and slot.
    fn facts(self) -> (&'static str, CameraStage, Slot) {
        use CameraStage::{Background, Clock, Detector, Optics, Photoreceptor, Readout};
        match self {
            Self::LeakOn => ("leak_on", Detector, Slot::Leak),
            Self::PhotoreceptorLowpass => ("photoreceptor_lowpass", Photoreceptor, Slot::Node),
            Self::PhotoreceptorNoise => ("photoreceptor_noise", Photoreceptor, Slot::NodeNoise),
            Self::ShotNoisePoisson => ("shot_noise_poisson", Photoreceptor, Slot::PhotonEvents),
            Self::AdaptiveHighpass => ("adaptive_highpass", Photoreceptor, Slot::Feedback),
            Self::DarkCurrent => ("dark_current", Photoreceptor, Slot::AddedCurrent),
            Self::VeilingGlare => ("veiling_glare", Optics, Slot::AddedCurrent),
            Self::PsfBlur => ("psf_blur", Optics, Slot::Lens),
            Self::LampFlicker => ("lamp_flicker", Optics, Slot::Lamp),
            Self::ThresholdMismatch => ("threshold_mismatch", Detector, Slot::Offsets),
            Self::ThresholdTemporalNoise => {
                ("threshold_temporal_noise", Detector, Slot::ComparatorNoise)
            }
            Self::Refractory => ("refractory", Detector, Slot::Reset),
            Self::HotPixels => ("hot_pixels", Background, Slot::HotPixels),
            Self::Arbiter => ("arbiter", Readout, Slot::Access),
            Self::ScannedReadout => ("scanned_readout", Readout, Slot::Access),
            Self::TimestampJitter => ("timestamp_jitter", Clock, Slot::Jitter),
            Self::TimestampQuantisation => ("timestamp_quantisation", Clock, Slot::Counter),
            Self::PixelLatency => ("pixel_latency", Clock, Slot::Delay),
        }
    }

    /// Name in the catalogue of effects.
    pub fn name(self) -> &'static str {
        self.facts().0
    }

    /// Stage of the camera that the effect belongs to.
    pub fn stage(self) -> CameraStage {
        self.facts().1
    }

    /// The slot that the effect occupies.
    pub fn slot(self) -> Slot {
        self.facts().2
    }

    /// Puts the effect into a circuit at one of its strengths, 0 the weakest to 3. `draws` give the
    /// parameters that a strength does not fix: a lamp's frequency and phase.
    pub fn install(self, strength: usize, circuit: &mut Circuit, draws: &mut Sequence) {
        let pick = |values: [f64; STRENGTHS]| values[strength.min(STRENGTHS - 1)];
        let Circuit { optics, photoreceptor, detector, background, readout, clock, .. } = circuit;
        match self {
            Self::VeilingGlare => optics.scattered_share = pick([0.000_5, 0.01, 0.05, 0.15]),
            Self::PsfBlur => optics.blur_sigma_px = pick([0.06, 0.4, 1.1, 2.2]),
            Self::LampFlicker => {
                let mains = [100.0, 120.0, 60.0];
                optics.lamp = Some(Lamp {
                    ripple_hz: mains[draws.below(mains.len())],
                    ripple_share: pick([0.001, 0.015, 0.06, 0.14]),
                    phase_rad: draws.between(0.0, std::f64::consts::TAU),
                });
            }
            Self::PhotoreceptorLowpass => {
                photoreceptor.node_ff = Some(pick([0.6, 6.0, 60.0, 300.0]));
                // A follower of 8.6 kHz.
                photoreceptor.follower = Some(Follower { bias_a: 1e-9, load_pf: 0.5 });
            }
            Self::PhotoreceptorNoise => {
                let excess_factor = pick([0.06, 3.0, 80.0, 170.0]);
                photoreceptor.noise = Some(NodeNoise { node_ff: 400.0, excess_factor });
            }
            Self::ShotNoisePoisson => {
                detector.photon_noise = Some(PhotonNoise {
                    dark_rate_hz: pick([0.004, 0.03, 0.4, 2.5]),
                    half_current_a: photoreceptor.white_current_a / 3.0,
                });
            }
            Self::AdaptiveHighpass => {
                // Time constants of 200, 6, .25 and .06 s on 1 pF.
                let tau_s = pick([200.0, 6.0, 0.25, 0.06]);
                let bias_a = 1e-12 * thermal_voltage_v(circuit.temperature_k) / tau_s;
                photoreceptor.highpass = Some(HighPass { bias_a, coupling_pf: 1.0 });
            }
            Self::DarkCurrent => photoreceptor.dark_current_fa = pick([2.0, 20.0, 150.0, 600.0]),
            Self::LeakOn => {
                let current_fa = pick([0.004, 0.08, 0.9, 3.2]);
                detector.leak = Some(Junction { current_fa, doubling_k: 8.0, spread_ln: 0.3 });
            }
            Self::ThresholdMismatch => {
                detector.offset_sigma_ln = pick([0.000_7, 0.008, 0.05, 0.13]);
            }
            Self::ThresholdTemporalNoise => {
                let share = pick([0.001_5, 0.015, 0.08, 0.2]);
                detector.comparator_noise_mv = detector.threshold_on_mv * share;
            }
            Self::Refractory => {
                // 10 fC (20 fF over half a volt) taken off in .004, .1, 1.5 and 10 ms.
                let current_pa = 10.0 / pick([0.004, 0.1, 1.5, 10.0]);
                let timer = Timer { current_pa, capacitance_ff: 20.0, swing_v: 0.5 };
                detector.refractory = Some(timer);
            }
            Self::HotPixels => {
                background.hot = Some(HotPixels {
                    count: pick([1.0, 3.0, 12.0, 40.0]),
                    median_hz: pick([6.0, 12.0, 50.0, 120.0]),
                    spread_ln: 0.7,
                });
            }
            Self::Arbiter => {
                readout.access = Access::Arbiter {
                    row_ns: pick([400.0, 4000.0, 25_000.0, 60_000.0]),
                    event_ns: pick([40.0, 400.0, 2000.0, 4000.0]),
                };
            }
            Self::ScannedReadout => {
                let column_ns = pick([500.0, 2000.0, 10_000.0, 50_000.0]);
                readout.access = Access::Scan { column_ns };
            }
            Self::TimestampJitter => clock.jitter_us = pick([20.0, 80.0, 300.0, 1000.0]),
            Self::TimestampQuantisation => clock.period_us = pick([20.0, 100.0, 400.0, 1000.0]),
            Self::PixelLatency => clock.latency_us = pick([30.0, 120.0, 500.0, 2000.0]),
        }
    }
}
