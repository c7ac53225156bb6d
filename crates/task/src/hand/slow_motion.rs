//! Settings of the slow-motion mode.

use evpose_pose::filter::{AdaptiveFilterConfig, StillnessConfig};
use evpose_repr::TriggerConfig;
use serde::{Deserialize, Serialize};

/// Settings of the slow-motion mode. `Default` has the published numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SlowMotionConfig {
    /// Surfaces predicted at once.
    pub batch_surfaces: usize,
    /// When there is a surface.
    pub trigger: TriggerConfig,
    /// When a batch is not predicted. Its sum is meant for LNES.
    pub stillness: StillnessConfig,
    /// How poses are smoothed.
    pub filter: AdaptiveFilterConfig,
}

impl Default for SlowMotionConfig {
    fn default() -> Self {
        Self {
            batch_surfaces: 16,
            trigger: TriggerConfig::default(),
            stillness: StillnessConfig::default(),
            filter: AdaptiveFilterConfig::default(),
        }
    }
}
