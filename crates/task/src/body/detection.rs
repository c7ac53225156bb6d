//! When a pose of a person is reported.

use evpose_core::SensorSize;
use serde::{Deserialize, Serialize};

/// Conditions for a pose of a person.
///
/// # Model
/// The maps of a network have a maximum on every image, that of an empty room included. So nothing is
/// inferred before the representation has taken enough events, and somebody is there where the score of
/// the pose is high enough, a mean over time of its best joints': see [`evpose_pose::body::pose_score`]
/// and [`evpose_pose::body::PresenceScore`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyDetectionConfig {
    /// Poses of a lower score are of nobody: none of their joints is reported.
    pub min_score: f32,
    /// Time constant of the score in milliseconds; 0 takes each pose by itself.
    pub memory_ms: f32,
    /// Events per pixel of the canonical view, after its filter, before the first inference. 0 infers
    /// from the beginning.
    pub min_events_per_pixel: f32,
}

impl Default for BodyDetectionConfig {
    /// Chosen on simulated recordings with and without people: see `docs/guide/poses.md`.
    fn default() -> Self {
        Self { min_score: 0.3, memory_ms: 100.0, min_events_per_pixel: 0.01 }
    }
}

impl BodyDetectionConfig {
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Whether it makes sense.
    pub(super) fn is_valid(&self) -> bool {
        (0.0..=1.0).contains(&self.min_score)
            && (0.0..=60_000.0).contains(&self.memory_ms)
            && (0.0..=100.0).contains(&self.min_events_per_pixel)
    }

    /// Events of a view before the first inference.
    pub(super) fn min_events(&self, view: SensorSize) -> u64 {
        (self.min_events_per_pixel * view.pixels() as f32).ceil() as u64
    }
}
