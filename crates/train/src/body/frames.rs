//! Images of bodies with labels, in memory: made from recordings, from photographs, or read.

use std::path::Path;

use evpose_core::{LensCamera, Micros, Plane, SensorSize};
use evpose_pose::body::{BODY_JOINTS, BodyLabel, BodyPoints, JOINT_NAMES, Keypoint, Visibility};
use evpose_pose::metric::body::MeanBody;
use evpose_repr::ErosLikeWork;
use evpose_sim::person::People;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use sha2::{Digest as _, Sha256};

use super::recordings::BodyRecordings;
use crate::TrainError;
use evpose_task::body::{BodyConfig, BodySourceKind};

/// A labelled image.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyFrame {
    /// The image, 0 to 255.
    pub image: Plane<u8>,
    /// The label of the person.
    pub label: BodyLabel,
    /// Index of its recording, or of the image.
    pub sequence: u64,
    /// Time stamp in its recording.
    pub t: Micros,
    /// The joints in the camera, where the recording says where it stands.
    pub camera: Option<CameraJoints>,
}

/// The joints of a person in a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraJoints {
    /// Joints in metres in camera space: x right, y up, looking along -z; not finite where they are
    /// not known.
    pub joints_m: [Vec3; BODY_JOINTS],
    /// Camera with its lens.
    pub lens: LensCamera,
    /// Size of the sensor behind it.
    pub sensor: SensorSize,
}

impl BodyFrame {
    /// Width and height of the image, in pixels.
    pub fn size_px(&self) -> Vec2 {
        Vec2::new(self.image.width() as f32, self.image.height() as f32)
    }

    /// Labelled joints in pixels of the image.
    pub fn joints_px(&self) -> BodyPoints {
        let mut joints_px = [None; BODY_JOINTS];
        for (joint, keypoint) in joints_px.iter_mut().zip(&self.label.keypoints) {
            *joint = keypoint.is_labelled().then(|| keypoint.position * self.size_px());
        }
        joints_px
    }
}

/// Images with labels.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BodyFrames {
    /// In the order of sequences, and of time in each.
    pub frames: Vec<BodyFrame>,
}

impl BodyFrames {
    /// The training data of `config`: photographs are simulated, all else is read from `data`, which
    /// for recordings may also be of annotated images, to train on both. `progress` receives 1 after
    /// each image or recording.
    ///
    /// # Errors
    /// If files cannot be read, or there is nothing to train on.
    pub fn load(
        config: &BodyConfig,
        data: &Path,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Self, TrainError> {
        let mut frames = match config.data.source {
            BodySourceKind::Stills => Self::stills(config, true, progress)?,
            BodySourceKind::GreyStills => Self::stills(config, false, progress)?,
            BodySourceKind::Recordings if super::holds_annotations(data) => {
                super::annotated::frames(data, progress)?
            }
            BodySourceKind::Recordings => BodyRecordings::open(data)?.frames(config, progress)?,
            BodySourceKind::GreyRecordings => {
                BodyRecordings::open(data)?.photographs(config, data, progress)?
            }
            BodySourceKind::Annotations => super::annotated::frames(data, progress)?,
        };
        let min_joints = config.data.min_joints;
        frames.frames.retain(|frame| {
            frame.label.keypoints.iter().filter(|keypoint| keypoint.is_labelled()).count()
                >= min_joints
        });
        if frames.frames.is_empty() {
            let message = "no image has as many joints as data.min_joints".to_owned();
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
        let frame = |work: &mut ErosLikeWork, index: u64| -> Result<BodyFrame, TrainError> {
            let still = people.still(index)?;
            let sensor = size_of(&still.grey);
            let image = if edges {
                // By number of the still: threads draw them in any order.
                let seed = evpose_core::seed_for(config.seed, "eros-like", index);
                let mut image = Plane::filled(0, 0, 0);
                config.image.eros_like.convert_into(&still.grey, seed, work, &mut image);
                image
            } else {
                still.grey
            };
            progress(1);
            let label = label_of(&still.joints_px, sensor);
            Ok(BodyFrame { image, label, sequence: index, t: Micros(0), camera: None })
        };
        let frames = (0..config.data.stills)
            .into_par_iter()
            // Rayon makes working memory for a run of stills, not for each.
            .map_init(ErosLikeWork::default, frame)
            .collect::<Result<_, TrainError>>()?;
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

    /// Adds the images of another set: its sequences come last.
    pub fn append(&mut self, mut other: Self) {
        let next = self.frames.iter().map(|frame| frame.sequence + 1).max().unwrap_or(0);
        other.frames.iter_mut().for_each(|frame| frame.sequence += next);
        self.frames.append(&mut other.frames);
    }

    /// Training and validation: of the sequences, each in its whole, the last `share` for the
    /// second.
    pub fn split(self, share: f64) -> (Self, Self) {
        let mut sequences: Vec<u64> = self.frames.iter().map(|frame| frame.sequence).collect();
        // Frames of a sequence stand together: this leaves few to sort.
        sequences.dedup();
        sequences.sort_unstable();
        sequences.dedup();
        // Rounded up, so that a small set still has a sequence to validate with.
        let kept = sequences.len() - (share * sequences.len() as f64).ceil() as usize;
        let first_held = sequences.get(kept).copied().unwrap_or(u64::MAX);
        let (train, valid) = self.frames.into_iter().partition(|frame| frame.sequence < first_held);
        (Self { frames: train }, Self { frames: valid })
    }

    /// As [`Self::split`], for a training.
    ///
    /// # Errors
    /// As [`Self::for_training`].
    pub(crate) fn split_for_training(self, share: f64) -> Result<[Self; 2], TrainError> {
        Self::for_training(self.split(share).into())
    }

    /// Frames to train on and to validate with: a training needs both.
    ///
    /// # Errors
    /// If there are none of one part.
    pub(crate) fn for_training(parts: [Self; 2]) -> Result<[Self; 2], TrainError> {
        if parts.iter().any(Self::is_empty) {
            let message = format!(
                "{} images to train on and {} to validate with: more recordings are needed",
                parts[0].len(),
                parts[1].len()
            );
            return Err(TrainError::Field { field: "data.validation_share", message });
        }
        for (part, name) in parts.iter().zip(["training", "validation"]) {
            if part.unlabelled_joints().len() == JOINT_NAMES.len() {
                let message = format!(
                    "none of the {} images for {name} has a label: label more recordings, or name \
                     those with labels last, from which validation is taken",
                    part.len()
                );
                return Err(TrainError::Field { field: "data.validation_share", message });
            }
        }
        Ok(parts)
    }

    /// Names of the joints that have a label on no image: they are neither learnt nor evaluated.
    pub fn unlabelled_joints(&self) -> Vec<&'static str> {
        let is_labelled = |joint: usize| {
            let mut labels =
                self.frames.iter().filter_map(|frame| frame.label.keypoints.get(joint));
            labels.any(|keypoint| keypoint.is_labelled())
        };
        let joints = JOINT_NAMES.iter().enumerate();
        joints.filter(|(joint, _)| !is_labelled(*joint)).map(|(_, name)| *name).collect()
    }

    /// A digest of all images and labels.
    pub fn digest(&self) -> String {
        let mut hash = Sha256::new();
        for frame in &self.frames {
            hash.update(frame.image.data());
            for keypoint in &frame.label.keypoints {
                hash.update(keypoint.position.x.to_le_bytes());
                hash.update(keypoint.position.y.to_le_bytes());
            }
        }
        let bytes = hash.finalize();
        bytes.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// The mean position of every joint over all labels, relative to the image: what a network has
    /// to beat. None of a joint that is on no image.
    pub fn mean_pose(&self) -> BodyPoints {
        let mut mean = MeanBody::default();
        self.frames.iter().for_each(|frame| mean.push(&frame.label));
        mean.mean_px(Vec2::ONE)
    }
}

/// The size of an image of a sensor.
pub(super) fn size_of(image: &Plane<u8>) -> SensorSize {
    SensorSize { width: image.width() as u16, height: image.height() as u16 }
}

/// A label of joints in pixels.
pub(super) fn label_of(joints_px: &BodyPoints, sensor: SensorSize) -> BodyLabel {
    let size = Vec2::new(f32::from(sensor.width), f32::from(sensor.height));
    let keypoint = |joint: &Option<Vec2>| match joint {
        Some(at_px) => Keypoint { position: *at_px / size, visibility: Visibility::Visible },
        None => Keypoint::default(),
    };
    let known: Vec<Vec2> = joints_px.iter().flatten().map(|at_px| *at_px / size).collect();
    // Without a joint the centre is zero, not NaN.
    let center = known.iter().sum::<Vec2>() / known.len().max(1) as f32;
    BodyLabel {
        keypoints: joints_px.iter().map(keypoint).collect(),
        center,
        ..BodyLabel::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(sequences: &[u64]) -> BodyFrames {
        let frame = |(k, &sequence): (usize, &u64)| {
            let mut joints_px = [Some(Vec2::new(8.0 * k as f32, 12.0)); BODY_JOINTS];
            joints_px[3] = None;
            let sensor = SensorSize { width: 32, height: 24 };
            BodyFrame {
                image: Plane::filled(1, 1, 0),
                label: label_of(&joints_px, sensor),
                sequence,
                t: Micros(k as i64),
                camera: None,
            }
        };
        BodyFrames { frames: sequences.iter().enumerate().map(frame).collect() }
    }

    #[test]
    fn no_sequence_is_trained_on_and_validated_with() {
        let (train, valid) = frames(&[0, 0, 1, 2, 2, 3]).split(0.25);
        let indices = |frames: &BodyFrames| -> Vec<u64> {
            frames.frames.iter().map(|frame| frame.sequence).collect()
        };
        assert_eq!((indices(&train), indices(&valid)), (vec![0, 0, 1, 2, 2], vec![3]));
        let (train, valid) = frames(&[0, 1]).split(0.0);
        assert_eq!((train.len(), valid.len()), (2, 0));
    }

    #[test]
    fn a_training_needs_labels_in_both_parts_and_joints_without_any_are_named() {
        let labelled = frames(&[0, 1]);
        assert_eq!(labelled.unlabelled_joints(), [JOINT_NAMES[3]]);
        let mut unlabelled = frames(&[2, 2]);
        for frame in &mut unlabelled.frames {
            frame.label = label_of(&[None; BODY_JOINTS], SensorSize { width: 32, height: 24 });
        }
        assert!(BodyFrames::for_training([labelled, frames(&[2])]).is_ok());
        let error = BodyFrames::for_training([frames(&[0, 1]), unlabelled]).unwrap_err();
        let error = error.to_string();
        assert!(error.contains("none of the 2 images for validation has a label"), "{error}");
    }

    #[test]
    fn sequences_of_sets_stay_apart_and_the_last_set_is_held_back() {
        let mut all = BodyFrames::default();
        for set in [&[0, 0][..], &[0, 2], &[0, 0, 0]] {
            all.append(frames(set));
        }
        let of = |frames: &BodyFrames| frames.frames.iter().map(|f| f.sequence).collect::<Vec<_>>();
        assert_eq!(of(&all), [0, 0, 1, 3, 4, 4, 4]);
        let (train, valid) = all.split(0.25);
        assert_eq!((of(&train), of(&valid)), (vec![0, 0, 1, 3], vec![4, 4, 4]));
    }

    #[test]
    fn labels_are_relative_to_the_image_and_the_mean_pose_with_them() {
        let frames = frames(&[0, 0, 0]);
        let label = &frames.frames[2].label;
        assert_eq!(label.keypoints[0].position, Vec2::new(0.5, 0.5));
        assert!(!label.keypoints[3].is_labelled());
        assert_eq!(label.center, Vec2::new(0.5, 0.5));
        let mean = frames.mean_pose();
        assert_eq!((mean[0], mean[3]), (Some(Vec2::new(0.25, 0.5)), None));
    }
}
