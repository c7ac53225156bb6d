//! Limits of what an effect must leave alone.

use evpose_sensor::EffectConfig;

use crate::goodness::{Signature, signature};

/// A signature that an effect must leave alone, up to a limit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StrictLimit {
    pub(crate) signature: &'static Signature,
    /// The limit, from the effect with its parameters and the threshold of the model, in units of the
    /// signature.
    pub(crate) limit: fn(&EffectConfig, f64) -> f64,
    /// Whether a deficit counts as well as an excess.
    pub(crate) is_two_sided: bool,
    /// The sign that the recording would have to show instead, after "it would have to".
    pub(crate) must: &'static str,
}

/// Standard deviation of a noise relative to the threshold.
fn relative_noise(effect: &EffectConfig, threshold: f64) -> f64 {
    effect.number("sigma").unwrap_or(0.0) / threshold.max(1e-9)
}

/// Variance of half the noise: a spread of as much that stays is no noise in time.
fn relative_variance(effect: &EffectConfig, threshold: f64) -> f64 {
    (0.5 * relative_noise(effect, threshold)).powi(2)
}

/// Noise in time: nothing of it stays in a pixel, lasts, or drifts.
pub(super) static NOISE_LACKS: [StrictLimit; 3] = [
    StrictLimit {
        signature: &signature::FIXED_PATTERN,
        limit: relative_variance,
        is_two_sided: false,
        must: "differ from event to event of a pixel: here the same pixels have more events in both \
               halves of the recording, as thresholds that differ for good make them",
    },
    StrictLimit {
        signature: &signature::LASTING_PATTERN,
        limit: relative_variance,
        is_two_sided: false,
        must: "be independent from event to event: here pixels are alike for a while, or like their \
               neighbours, as thresholds that drift or belong together make them",
    },
    StrictLimit {
        signature: &signature::LATE_COUNT,
        limit: relative_noise,
        is_two_sided: true,
        must: "be the same from beginning to end: here events become more or fewer, as thresholds \
               that drift make them",
    },
];

/// Largest logarithm of the events that a delay may lose or add.
const DELAY_LOSS: f64 = 0.1;

const NO_LOSS: StrictLimit = StrictLimit {
    signature: &signature::COUNT,
    limit: |_, _| DELAY_LOSS,
    is_two_sided: true,
    must: "delay events and lose none: here their number is another one as well",
};

/// A delay of all pixels: the same in the dark, and without a loss.
pub(super) static LATENCY_LACKS: [StrictLimit; 2] = [
    StrictLimit {
        signature: &signature::DARK_LAG,
        limit: |effect, _| 0.5e-3 * effect.number("delay_us").unwrap_or(0.0).abs(),
        is_two_sided: true,
        must: "delay events in the dark and in bright light alike",
    },
    NO_LOSS,
];

/// Scattered stamps: not late on the whole.
pub(super) static JITTER_LACKS: [StrictLimit; 1] = [StrictLimit {
    signature: &signature::LAG,
    limit: |effect, _| 0.7e-3 * effect.number("sigma_us").unwrap_or(0.0),
    is_two_sided: true,
    must: "scatter times and leave their middle where it is: here all events are late or early",
}];

/// An offset of the clock: the same in the dark.
pub(super) const OFFSET_LACKS: StrictLimit = StrictLimit {
    signature: &signature::DARK_LAG,
    limit: |effect, _| 0.5e-3 * effect.number("offset_us").unwrap_or(0.0).abs(),
    is_two_sided: true,
    must: "delay events in the dark and in bright light alike: a slow photoreceptor delays the dark \
           ones more",
};
