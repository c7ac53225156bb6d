//! Lamp, lens, photodiode and photoreceptor in circuit units.

/// Lamp and lens; `None` and 0 are perfect.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Optics {
    /// Ripple of the lamp.
    pub lamp: Option<Lamp>,
    /// Standard deviation of the Gaussian point spread function in pixels; 0 is sharp.
    pub blur_sigma_px: f64,
    /// Share of the light that is scattered evenly over the image.
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
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Photoreceptor {
    /// Photocurrent at white (luminance 1), A.
    pub white_current_a: f64,
    /// Dark current of the junction, fA.
    pub dark_current_fa: f64,
    /// Current that is added before the logarithm, relative to the photocurrent at white: a bias of
    /// the photoreceptor.
    pub added_share: f64,
    /// Slope of the logarithm that changes with light.
    pub bend: Option<Bend>,
    /// Capacitance of the photodiode node as the photocurrent sees it, fF: the parasitic one
    /// divided by the gain of the feedback amplifier. `None` is a node without delay.
    pub node_ff: Option<f64>,
    /// Source follower behind it.
    pub follower: Option<Follower>,
    /// Slow feedback that takes the mean away.
    pub highpass: Option<HighPass>,
    /// Thermal and shot noise of the node.
    pub noise: Option<NodeNoise>,
}

/// A slope factor of the feedback transistor that changes with its level: volts per e-fold are
/// `1 - share` of the nominal ones at the darkest light of a scene, `1 + share` at white, and
/// nominal in the middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bend {
    /// Relative change of the slope over half of the range; negative where the slope falls.
    pub share: f64,
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
