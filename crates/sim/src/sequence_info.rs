//! Metadata that the published formats leave out, in a text file beside each sequence: the size of
//! the sensor and the parameters of each episode.

use std::ops::Range;
use std::path::Path;

use evpose_core::{SensorSize, atomic_write};
use evpose_pose::HandSide;
use serde::{Deserialize, Serialize};

use crate::{SimError, with_ending};

/// Frames per episode of EventHands' own sequences: 50 s.
const PUBLISHED_EPISODE_FRAMES: u64 = 50_000;

/// Metadata of a sequence: `STEM.toml` beside `STEM.evc` and `STEM.meta`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SequenceInfo {
    /// Size of the sensor in pixels.
    pub sensor: SensorSize,
    /// Side of the hand.
    #[serde(default, skip_serializing_if = "HandSide::is_right")]
    pub hand: HandSide,
    /// Whether another hand is in view, farther away.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub another_hand: bool,
    /// Stretches of constant shape, texture, lights, background and threshold, in order.
    #[serde(default, rename = "episode")]
    pub episodes: Vec<EpisodeInfo>,
}

/// Parameters of an episode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EpisodeInfo {
    /// First frame, in which the change of scene makes a burst of events.
    pub first_frame: u64,
    /// Shape coefficients of the body.
    pub betas: Vec<f32>,
    /// Offset of the sensor's contrast thresholds, in natural-log intensity.
    pub threshold_offset: f64,
}

impl SequenceInfo {
    /// Defaults for a sequence without metadata: the published episodes of unknown shape.
    pub fn foreign(sensor: SensorSize, frames: u64) -> Self {
        let episode = |i| EpisodeInfo {
            first_frame: i * PUBLISHED_EPISODE_FRAMES,
            betas: Vec::new(),
            threshold_offset: 0.0,
        };
        let episodes = (0..frames.div_ceil(PUBLISHED_EPISODE_FRAMES)).map(episode).collect();
        Self { sensor, hand: HandSide::Right, another_hand: false, episodes }
    }

    /// Reads `STEM.toml`, if there is one.
    ///
    /// # Errors
    /// If the file exists and cannot be read.
    pub fn beside(stem: &Path) -> Result<Option<Self>, SimError> {
        let path = with_ending(stem, "toml");
        match std::fs::read_to_string(&path) {
            Ok(text) => toml::from_str(&text)
                .map(Some)
                .map_err(|source| SimError::SequenceInfo { path, reason: source.to_string() }),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(SimError::SequenceInfo { path, reason: error.to_string() }),
        }
    }

    /// Writes `STEM.toml`.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, stem: &Path) -> Result<(), SimError> {
        let path = with_ending(stem, "toml");
        let failed = |reason: String| SimError::SequenceInfo { path: path.clone(), reason };
        let text = toml::to_string(self).map_err(|error| failed(error.to_string()))?;
        atomic_write(&path, text.as_bytes()).map_err(|error| failed(error.to_string()))
    }

    /// Index of the episode a frame belongs to.
    pub fn episode_of(&self, frame: u64) -> usize {
        self.episodes.partition_point(|episode| episode.first_frame <= frame).saturating_sub(1)
    }

    /// Shape coefficients of an episode; empty where they are not known.
    pub fn betas(&self, episode: usize) -> &[f32] {
        self.episodes.get(episode).map_or(&[], |episode| &episode.betas)
    }

    /// The last frame of `frames` in which an episode begins.
    pub fn last_redraw(&self, frames: Range<u64>) -> Option<u64> {
        let firsts = self.episodes.iter().rev().map(|episode| episode.first_frame);
        firsts.filter(|first| frames.contains(first)).max()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_belong_to_the_episode_that_began_last() {
        let info = SequenceInfo::foreign(SensorSize::DAVIS240C, 120_000);
        let at = [0, 49_999, 50_000, 119_999].map(|frame| info.episode_of(frame));
        assert_eq!(at, [0, 0, 1, 2]);
        assert_eq!(info.last_redraw(49_900..50_001), Some(50_000));
        assert_eq!(info.last_redraw(50_001..50_100), None);
    }

    #[test]
    fn what_was_written_is_read_back() {
        let directory = tempfile::tempdir().unwrap();
        let stem = directory.path().join("0.5-hand");
        assert_eq!(SequenceInfo::beside(&stem).unwrap(), None);
        let info = SequenceInfo::foreign(SensorSize::DAVIS240C, 60_000);
        info.write(&stem).unwrap();
        assert_eq!(SequenceInfo::beside(&stem).unwrap(), Some(info));
        std::fs::write(with_ending(&stem, "toml"), "sensor = 3").unwrap();
        let message = SequenceInfo::beside(&stem).unwrap_err().to_string();
        assert!(message.contains("0.5-hand.toml"), "{message}");
    }
}
