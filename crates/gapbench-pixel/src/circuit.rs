//! The camera in circuit units: amperes, farads, volts, nanoseconds.
//!
//! [`Circuit::ideal`] is the pixel whose every imperfection is off: a change amplifier of the
//! nominal gain and thresholds behind a photodiode without dark current. The parts an effect adds
//! are `Option`s or zeros. What each value means in the units of a catalogue of effects is
//! derived in [`crate::catalogue`].

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
}

/// Lamp and lens; `None` and 0 are perfect.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Optics {
    /// Ripple of the lamp.
    pub lamp: Option<Lamp>,
    /// Standard deviation of the Gaussian point spread function in pixels; 0 is sharp.
    pub blur_sigma_px: f64,
    /// Share of the light that is scattered evenly over the picture.
    pub scattered_share: f64,
    /// Radial distortion: a point at radius `r` (in half diagonals) is seen at `r (1 + k1 r^2)`.
    pub distortion_k1: f64,
}

/// A lamp on rectified mains: the ripple and a little of its second harmonic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lamp {
    /// Frequency of the ripple, Hz.
    pub ripple_hz: f64,
    /// Amplitude of the ripple relative to the mean.
    pub ripple_share: f64,
    /// Phase at t = 0, radians.
    pub phase_rad: f64,
}

/// Photodiode and logarithmic photoreceptor.
#[derive(Debug, Clone, PartialEq)]
pub struct Photoreceptor {
    /// Photocurrent at white (luminance 1), A.
    pub white_current_a: f64,
    /// Dark current of the junction, fA.
    pub dark_current_fa: f64,
    /// Parasitic capacitance of the photodiode node, fF; `None` is a node without delay.
    pub node_ff: Option<f64>,
    /// Source follower behind it.
    pub follower: Option<Follower>,
    /// Slow feedback that takes the mean away.
    pub highpass: Option<HighPass>,
    /// Thermal and shot noise of the node.
    pub noise: Option<NodeNoise>,
}

/// A source follower: one pole that light does not move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Follower {
    /// Bias current, A.
    pub bias_a: f64,
    /// Load, pF.
    pub load_pf: f64,
}

/// A transconductor that pulls the coupling capacitor to the signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HighPass {
    /// Bias current of the transconductor, A.
    pub bias_a: f64,
    /// Coupling capacitance, pF.
    pub coupling_pf: f64,
}

/// Noise of the photodiode node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeNoise {
    /// Capacitance that sets the corner of the noise together with the photocurrent, fF.
    pub node_ff: f64,
    /// Noise power over the `k T / C` of that capacitance, without unit.
    pub excess_factor: f64,
}

/// Change amplifier, comparators, reset.
#[derive(Debug, Clone, PartialEq)]
pub struct Detector {
    /// Gain `C1 / C2`.
    pub gain: f64,
    /// Feedback capacitance `C2`, fF.
    pub feedback_ff: f64,
    /// ON threshold at the amplifier's output, mV.
    pub threshold_on_mv: f64,
    /// OFF threshold at the amplifier's output, mV (a positive number).
    pub threshold_off_mv: f64,
    /// Log-normal spread of the comparators' thresholds over the pixels (sigma of the logarithm).
    pub offset_sigma_ln: f64,
    /// Noise of each comparison at the amplifier's output, mV r.m.s.
    pub comparator_noise_mv: f64,
    /// Leaking junction of the reset switch.
    pub leak: Option<Junction>,
    /// Timer that holds the pixel in reset.
    pub refractory: Option<Timer>,
    /// Comparators fired by photon noise.
    pub photon_noise: Option<PhotonNoise>,
    /// What no catalogue knows.
    pub oddity: Option<DetectorOddity>,
}

/// A junction that leaks onto the amplifier's floating node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Junction {
    /// Current at 300 K, fA.
    pub current_fa: f64,
    /// Kelvins that double the current.
    pub doubling_k: f64,
    /// Log-normal spread over the pixels (sigma of the logarithm).
    pub spread_ln: f64,
}

/// A capacitor discharged by a current: the time in reset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timer {
    /// Discharging current, pA.
    pub current_pa: f64,
    /// Capacitance, fF.
    pub capacitance_ff: f64,
    /// Swing to the end of the reset, V.
    pub swing_v: f64,
}

/// Events of photon noise: their rate follows the relative noise density `2 q / (I + I_half)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhotonNoise {
    /// Rate of both polarities together in complete darkness, Hz.
    pub dark_rate_hz: f64,
    /// Photocurrent at which the rate has halved, A.
    pub half_current_a: f64,
}

/// Faults of the change detector that no catalogue knows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DetectorOddity {
    /// The timer holds the pixel after ON events only.
    OneSidedTimer(Timer),
    /// Thresholds of neighbours are alike: a smooth log-normal field.
    SmoothOffsets {
        /// Sigma of the logarithm.
        sigma_ln: f64,
        /// Correlation length in pixels.
        length_px: f64,
    },
    /// The spread of the thresholds grows towards the dark, as `sqrt(.1 / (I + .1))`.
    DarkOffsets {
        /// Sigma of the logarithm in complete darkness.
        sigma_ln: f64,
    },
    /// The comparator that did not fire last needs this much more, mV at the amplifier's output.
    Hysteresis {
        /// Extra threshold, mV.
        extra_mv: f64,
    },
    /// Charge of the reset switch: every reset shifts the memory the same way.
    ChargeInjection {
        /// Charge in attocoulombs; positive makes the next ON event come earlier.
        charge_ac: f64,
    },
}

/// Events that no light causes; they leave the pixel's memory alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Background {
    /// Rate of ON events for each pixel, Hz.
    pub on_hz: f64,
    /// Rate of OFF events for each pixel, Hz.
    pub off_hz: f64,
    /// Pixels that fire by themselves.
    pub hot: Option<HotPixels>,
}

/// Pixels with a broken junction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HotPixels {
    /// Expected number among the pixels of the sensor.
    pub count: f64,
    /// Median of their rates, Hz.
    pub median_hz: f64,
    /// Spread of the rates (sigma of the logarithm).
    pub spread_ln: f64,
}

/// Way from the pixels to the time-stamper.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Readout {
    /// Who decides which pixel is read.
    pub access: Access,
    /// What no catalogue knows.
    pub oddity: Option<ReadoutOddity>,
}

/// Who decides which pixel is read.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Access {
    /// Every request is read at once.
    #[default]
    Direct,
    /// Requests are acknowledged row by row.
    Arbiter {
        /// Time to select a row, ns.
        row_ns: f64,
        /// Time for each event of the selected row, ns.
        event_ns: f64,
    },
    /// Columns are visited in turn.
    Scan {
        /// Time for each column, ns.
        column_ns: f64,
    },
}

/// Faults of the readout that no catalogue knows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReadoutOddity {
    /// Events come back later at the same pixel.
    Echo {
        /// Share of the events that come back.
        share: f64,
        /// Delay, s.
        delay_s: f64,
    },
    /// Events get lost in bursts (a two-state process over the whole sensor).
    BurstLoss {
        /// Share of the events lost in a bad spell.
        share: f64,
        /// Mean length of a bad spell, s.
        bad_s: f64,
        /// Mean length of a good spell, s.
        good_s: f64,
    },
    /// Events are also sent from the pixel on the right.
    NeighbourCopy {
        /// Share of the events that are copied.
        share: f64,
        /// Delay of the copy, s.
        delay_s: f64,
    },
}

/// The time-stamper.
#[derive(Debug, Clone, PartialEq)]
pub struct Clock {
    /// Period of the counter, us; 1 is the unit of the stamps.
    pub period_us: f64,
    /// Jitter of the sampled request, us r.m.s.
    pub jitter_us: f64,
    /// Constant delay of comparator and logic, us.
    pub latency_us: f64,
    /// Zero of the counter against the frames' clock, us.
    pub offset_us: f64,
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
            photoreceptor: Photoreceptor {
                white_current_a: 10e-12,
                dark_current_fa: 0.0,
                node_ff: None,
                follower: None,
                highpass: None,
                noise: None,
            },
            detector: Detector {
                gain,
                feedback_ff: 5.0,
                threshold_on_mv: threshold_mv,
                threshold_off_mv: threshold_mv,
                offset_sigma_ln: 0.0,
                comparator_noise_mv: 0.0,
                leak: None,
                refractory: None,
                photon_noise: None,
                oddity: None,
            },
            background: Background::default(),
            readout: Readout::default(),
            clock: Clock { period_us: 1.0, jitter_us: 0.0, latency_us: 0.0, offset_us: 0.0 },
        }
    }

    /// Volts at the amplifier's output for one e-fold of light, `(C1 / C2) U_T / kappa`.
    pub fn output_volts_per_efold_v(&self) -> f64 {
        self.detector.gain * volts_per_efold_v(self.temperature_k)
    }
}
