//! Thresholds of the checks.

use serde::{Deserialize, Serialize};

/// Thresholds of the checks. The defaults are for videos of 20 to 100 frames a second.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CheckOptions {
    /// A limb is an outlier this many spreads from the median of its length.
    pub outlier_spreads: f32,
    /// Lower bound of the spread, as a fraction of the median.
    pub min_spread: f32,
    /// The torso is the median over so many frames before and behind.
    pub torso_frames: usize,
    /// Sides are suspected to be exchanged if joints then go less than this part of the way.
    pub swap_ratio: f32,
    /// And only if the way gets shorter by this many torsos.
    pub swap_gain: f32,
    /// On a photograph, sides are suspected to be exchanged if the cosine of the angle between the
    /// lines across shoulders and hips is less, a twist that nobody can make.
    pub opposed_cosine: f32,
    /// And only if both are wider than this, in torsos.
    pub min_width: f32,
    /// A joint that is at the very same place for so many frames is frozen.
    pub frozen_frames: usize,
    /// A single joint only if another one moves by this many torsos meanwhile.
    pub frozen_motion: f32,
    /// Frames that are further apart, in seconds, do not follow each other.
    pub gap_s: f64,
}

impl Default for CheckOptions {
    fn default() -> Self {
        Self {
            outlier_spreads: 6.0,
            min_spread: 0.05,
            torso_frames: 25,
            swap_ratio: 0.5,
            swap_gain: 0.3,
            opposed_cosine: -0.5,
            min_width: 0.2,
            frozen_frames: 50,
            frozen_motion: 0.1,
            gap_s: 0.25,
        }
    }
}
