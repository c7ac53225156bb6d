//! Images of bodies with labels, in memory: made from recordings, from photographs, or read.

use std::path::Path;

use evpose_core::{Micros, Plane, SensorSize};
use evpose_pose::body::{BODY_JOINTS, BodyLabel, BodyPoints, Keypoint, Visibility};
use evpose_repr::ErosLikeWork;
use evpose_sim::person::People;
use glam::Vec2;
use rayon::prelude::*;

use super::config::{BodyConfig, BodySourceKind};
use super::recordings::BodyRecordings;
use crate::TrainError;

/// An image and who is on it.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyFrame {
    /// What is seen, 0 to 255.
    pub image: Plane<u8>,
    /// Who is on it.
    pub label: BodyLabel,
    /// Which recording it is from, or which image it is.
    pub sequence: u64,
    /// When, in a recording.
    pub t: Micros,
}

/// Images with labels.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BodyFrames {
    /// In the order of sequences, and of time in each.
    pub frames: Vec<BodyFrame>,
}

impl BodyFrames {
    /// What `config` trains on: photographs are taken anew, all else is read from `data`. `progress` is
    /// told of every image or recording that is done.
    ///
    /// # Errors
    /// If files cannot be read, or there is nothing to train on.
    pub fn of(
        config: &BodyConfig,
        data: &Path,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Self, TrainError> {
        let mut frames = match config.data.source {
            BodySourceKind::Stills => Self::stills(config, true, progress)?,
            BodySourceKind::GreyStills => Self::stills(config, false, progress)?,
            BodySourceKind::Recordings => BodyRecordings::open(data)?.frames(config, progress)?,
            BodySourceKind::GreyRecordings => {
                BodyRecordings::open(data)?.photographs(config, data, progress)?
            }
            BodySourceKind::Annotations => super::annotated::frames(data, progress)?,
        };
        let fewest = config.data.fewest_joints;
        frames.frames.retain(|frame| {
            frame.label.keypoints.iter().filter(|keypoint| keypoint.is_labelled()).count() >= fewest
        });
        if frames.frames.is_empty() {
            let message = "no image has as many joints as data.fewest_joints".to_owned();
            return Err(TrainError::Config { path: data.to_owned(), message });
        }
        Ok(frames)
    }

    /// Photographs of simulated people.
    fn stills(
        config: &BodyConfig,
        edges: bool,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Self, TrainError> {
        let people = People::new(&config.simulation, config.seed)?;
        let sensor = config.simulation.sensor_size;
        let frame = |work: &mut ErosLikeWork, index: u64| {
            let still = people.still(index);
            let image = if edges {
                let seed = evpose_core::seed_for(config.seed, "eros-like", index);
                let mut image = Plane::filled(0, 0, 0);
                config.image.eros_like.convert_into(&still.grey, seed, work, &mut image);
                image
            } else {
                still.grey
            };
            progress(1);
            let label = label_of(&still.joints_px, sensor);
            BodyFrame { image, label, sequence: index, t: Micros(0) }
        };
        let frames = (0..config.data.stills)
            .into_par_iter()
            .map_init(ErosLikeWork::default, frame)
            .collect();
        Ok(Self { frames })
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Training and validation: of the sequences, each in its whole, the last `share` for the second.
    pub fn split(self, share: f64) -> (Self, Self) {
        let mut sequences: Vec<u64> = self.frames.iter().map(|frame| frame.sequence).collect();
        sequences.dedup();
        sequences.sort_unstable();
        sequences.dedup();
        let kept = sequences.len() - (share * sequences.len() as f64).ceil() as usize;
        let first_held = sequences.get(kept).copied().unwrap_or(u64::MAX);
        let (train, valid) = self.frames.into_iter().partition(|frame| frame.sequence < first_held);
        (Self { frames: train }, Self { frames: valid })
    }

    /// The mean position of every joint over all labels, relative to the image: what a network has to
    /// beat. None of a joint that is on no image.
    pub fn mean_pose(&self) -> BodyPoints {
        let mut sums = [(Vec2::ZERO, 0u32); BODY_JOINTS];
        for frame in &self.frames {
            for (sum, keypoint) in sums.iter_mut().zip(&frame.label.keypoints) {
                if keypoint.is_labelled() {
                    *sum = (sum.0 + keypoint.position, sum.1 + 1);
                }
            }
        }
        sums.map(|(sum, count)| (count > 0).then(|| sum / count as f32))
    }
}

/// A label of joints in pixels.
pub(super) fn label_of(joints_px: &BodyPoints, sensor: SensorSize) -> BodyLabel {
    let size = Vec2::new(f32::from(sensor.width), f32::from(sensor.height));
    let keypoint = |joint: &Option<Vec2>| match joint {
        Some(at_px) => Keypoint { position: *at_px / size, visibility: Visibility::Visible },
        None => Keypoint::default(),
    };
    let known: Vec<Vec2> = joints_px.iter().flatten().map(|at_px| *at_px / size).collect();
    let center = known.iter().sum::<Vec2>() / known.len().max(1) as f32;
    BodyLabel {
        keypoints: joints_px.iter().map(keypoint).collect(),
        center,
        ..BodyLabel::default()
    }
}
