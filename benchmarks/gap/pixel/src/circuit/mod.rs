//! The camera in circuit units: amperes, farads, volts, nanoseconds.
//!
//! [`Circuit::ideal`] is the pixel whose every imperfection is off: a change amplifier of the
//! nominal gain and thresholds behind a photodiode without dark current. The parts an effect adds
//! are `Option`s or zeros. What each value means in the units of a catalogue of effects is
//! derived in [`crate::catalogue`].

mod address;
mod detector;
mod optics;
mod readout;

pub(crate) use address::CellCounter;
pub use address::NoiseAddress;
pub use detector::{Detector, DetectorOddity, Junction, PhotonNoise, Timer};
pub use optics::{Bend, Follower, HighPass, Lamp, NodeNoise, Optics, Photoreceptor};
pub use readout::{Access, Background, Clock, HotPixels, Readout, ReadoutOddity};

use crate::physics::{REFERENCE_TEMPERATURE_K, volts_per_efold_v};

/// Nominal threshold of both polarities in natural-log units of light.
pub const NOMINAL_THRESHOLD_LN: f64 = 0.25;

/// A whole camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Circuit {
    /// Temperature of the die, K.
    pub temperature_k: f64,
    /// Lamp and lens.
    pub optics: Optics,
    /// Photodiode and logarithmic photoreceptor.
    pub photoreceptor: Photoreceptor,
    /// Change amplifier, comparators, reset.
    pub detector: Detector,
    /// Events that no light causes.
    pub background: Background,
    /// Way from the pixels to the time-stamper.
    pub readout: Readout,
    /// The time-stamper.
    pub clock: Clock,
    /// Address of the draws that belong to single events.
    pub noise_address: NoiseAddress,
}

impl Circuit {
    /// The pixel whose every imperfection is off, at 300 K.
    pub fn ideal() -> Self {
        let gain = 20.0;
        let temperature_k = REFERENCE_TEMPERATURE_K;
        let threshold_mv = NOMINAL_THRESHOLD_LN * gain * volts_per_efold_v(temperature_k) * 1e3;
        Self {
            temperature_k,
            optics: Optics::default(),
            photoreceptor: Photoreceptor { white_current_a: 10e-12, ..Photoreceptor::default() },
            detector: Detector {
                gain,
                feedback_ff: 5.0,
                threshold_on_mv: threshold_mv,
                threshold_off_mv: threshold_mv,
                ..Detector::default()
            },
            background: Background::default(),
            readout: Readout::default(),
            clock: Clock { period_us: 1.0, ..Clock::default() },
            noise_address: NoiseAddress::default(),
        }
    }

    /// Volts at the amplifier's output for one e-fold of light, `(C1 / C2) U_T / kappa`.
    pub fn output_volts_per_efold_v(&self) -> f64 {
        self.detector.gain * volts_per_efold_v(self.temperature_k)
    }
}
