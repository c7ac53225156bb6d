//! The network of DHP19 alone: the published setting, the weights as distributed, joints of heatmaps.
//!
//! # Source
//! Calabrese et al.: *DHP19*, CVPRW 2019.

use std::path::{Path, PathBuf};

use burn::tensor::Device;
use evpose_nn::{BaselineNetwork, BaselineNetworkConfig, Dhp19CnnConfig, weights};
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use glam::Vec2;

use super::config::{
    BaselineConfig, BaselineDecodingConfig, BaselineImageConfig, BaselineLossConfig, EVENTS,
};
use crate::body::{BodyDataConfig, BodyTrainingConfig, BodyViewKind, Interpolation, LabelTime};
use crate::schedule::{EarlyStop, Schedule};
use crate::{Experiment as _, TaskError};

/// Columns and rows of the input, as published.
const SIZE_PX: [usize; 2] = [344, 260];
/// Standard deviation of the heatmaps in pixels, as published.
const SIGMA_PX: f32 = 4.0;
/// The smallest score of a joint that is believed.
const CONFIDENCE: f32 = 0.1;

impl Default for BaselineConfig {
    /// [`Self::dhp19_cnn`].
    fn default() -> Self {
        Self {
            task: Self::TASK.to_owned(),
            seed: 1,
            out: PathBuf::from("runs/body/dhp19-cnn"),
            start_from: None,
            data: BodyDataConfig {
                label_at: LabelTime::MeanOf(EVENTS),
                ..BodyDataConfig::default()
            },
            image: BaselineImageConfig::default(),
            network: BaselineNetworkConfig::default(),
            loss: BaselineLossConfig::default(),
            decoding: BaselineDecodingConfig::default(),
            training: BodyTrainingConfig {
                batch_size: 16,
                learning_rate: 1e-3,
                schedule: Schedule::constant(),
                weight_decay: 0.0,
                early_stop: EarlyStop::default(),
                ..BodyTrainingConfig::default()
            },
        }
    }
}

impl Default for BaselineImageConfig {
    fn default() -> Self {
        let [width_px, height_px] = SIZE_PX;
        Self {
            representation: format!("fixed-count:n={EVENTS}"),
            view: BodyViewKind::Sensor,
            denoise: None,
            interpolation: Interpolation::Area,
            width_px,
            height_px,
        }
    }
}

impl Default for BaselineLossConfig {
    fn default() -> Self {
        Self { sigma_px: SIGMA_PX }
    }
}

impl Default for BaselineDecodingConfig {
    fn default() -> Self {
        Self { confidence: CONFIDENCE }
    }
}

impl BaselineConfig {
    /// The network of DHP19 as published.
    pub fn dhp19_cnn() -> Self {
        Self::default()
    }
}

/// The network as distributed, `DHP_CNN.model`.
pub(super) fn load(path: &Path, device: &Device) -> Result<BaselineNetwork, TaskError> {
    let network = weights::load_dhp19_cnn(path, &Dhp19CnnConfig::default(), device)?;
    Ok(BaselineNetwork::Dhp19Cnn(network))
}

/// Moves joints to where their heatmaps are largest, relative to the input, and returns their scores. A joint of a low
/// score stays: limbs that rest make no events.
pub(super) fn peaks(
    maps: &[f32],
    size_px: [usize; 2],
    confidence: f32,
    joints: &mut BodyPoints,
) -> [f32; BODY_JOINTS] {
    let mut scores = [0.0; BODY_JOINTS];
    let maps = maps.chunks_exact(size_px[0] * size_px[1]);
    for (joint, map) in maps.enumerate().take(BODY_JOINTS) {
        let (at, score) = peak(map, size_px);
        scores[joint] = score.clamp(0.0, 1.0);
        // At a confidence of 0, an empty map would move the joint to its first pixel.
        if score > 0.0 && score >= confidence {
            joints[joint] = Some(at);
        }
    }
    scores
}

/// The middle of the cell of the largest value, relative to the map, and that value; the first one
/// of equal values.
fn peak(map: &[f32], [width, height]: [usize; 2]) -> (Vec2, f32) {
    let largest = map.iter().enumerate().fold((0, f32::NEG_INFINITY), |best, (k, &value)| {
        if value > best.1 { (k, value) } else { best }
    });
    let (index, value) = largest;
    let cell = Vec2::new((index % width) as f32, (index / width) as f32);
    ((cell + 0.5) / Vec2::new(width as f32, height as f32), value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_that_is_not_sure_stays_where_it_was() {
        let mut last = BodyPoints::default();
        let mut found = |height: f32, index: usize| {
            let mut maps = vec![0.0; BODY_JOINTS * 32 * 24];
            maps[2 * 32 * 24 + index] = height;
            let scores = peaks(&maps, [32, 24], 0.5, &mut last);
            (last[2], scores[2])
        };
        assert_eq!(found(0.4, 35), (None, 0.4));
        let at = Some(Vec2::new(3.5 / 32.0, 1.5 / 24.0));
        assert_eq!(found(0.9, 35).0, at);
        assert_eq!(found(0.3, 400), (at, 0.3));
        assert_ne!(found(0.5, 400).0, at);
    }
}
