//! Settings of the slow-motion mode.

use evpose_pose::filter::{AdaptiveFilterConfig, StillnessConfig};
use evpose_repr::TriggerConfig;
use serde::{Deserialize, Serialize};

/// Settings of the slow-motion mode. `Default` has the published values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SlowMotionConfig {
    /// Inputs of one inference.
    // The card of the shipped `hand-quick` spells it so.
    #[serde(alias = "batch_surfaces")]
    pub batch_inputs: usize,
    /// Trigger of inputs.
    pub trigger: TriggerConfig,
    /// Criterion of a scene at rest, whose batches are not inferred. Its threshold is meant for
    /// LNES.
    pub stillness: StillnessConfig,
    /// Temporal filter of poses.
    pub filter: AdaptiveFilterConfig,
}

impl Default for SlowMotionConfig {
    fn default() -> Self {
        Self {
            batch_inputs: 16,
            trigger: TriggerConfig::default(),
            stillness: StillnessConfig::default(),
            filter: AdaptiveFilterConfig::default(),
        }
    }
}
