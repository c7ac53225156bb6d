//! Change amplifier, comparators and reset in circuit units.

/// Change amplifier, comparators, reset.
#[derive(Debug, Clone, PartialEq, Default)]
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
    /// Part of a reset that is missing when the switch opens: the memory has then gone so much less
    /// than the whole way.
    pub unsettled_share: f64,
    /// Leaking junction of the reset switch.
    pub leak: Option<Junction>,
    /// Timer that holds the pixel in reset.
    pub refractory: Option<Timer>,
    /// Comparators fired by photon noise.
    pub photon_noise: Option<PhotonNoise>,
    /// An effect that no catalogue has.
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
