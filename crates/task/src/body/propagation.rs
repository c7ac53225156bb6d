//! Settings of poses that are propagated from those of the network by velocities of events.

use evpose_pose::body::fusion::{ConfidenceTest, FusionConfig};
use evpose_pose::body::velocity::TripletVelocityConfig;
use serde::{Deserialize, Serialize};

/// Rates, latency and filters of propagated poses.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PropagationConfig {
    /// Inferences of the network per second.
    pub network_hz: f64,
    /// Delay from the time stamp of an input to its output, in milliseconds.
    pub latency_ms: f64,
    /// Poses a second.
    pub output_hz: f64,
    /// Minimum number of pixels for an estimate of the velocity of a joint; with fewer it is taken
    /// as 0.
    pub min_samples: u32,
    /// Velocities from events.
    pub velocity: TripletVelocityConfig,
    /// Filter that fuses detections and velocities.
    pub fusion: FusionConfig,
}

impl Default for PropagationConfig {
    fn default() -> Self {
        Self {
            network_hz: 50.0,
            latency_ms: 10.0,
            output_hz: 500.0,
            min_samples: 3,
            velocity: TripletVelocityConfig::default(),
            // What scores too low is not detected: a joint that is reported is propagated, or its old place would stand.
            fusion: FusionConfig {
                confidence: ConfidenceTest { joint: 0.0, pose: 0.0 },
                ..FusionConfig::default()
            },
        }
    }
}
