//! Settings of the augmentation of images and labels of bodies.

use evpose_pose::body::MIRRORED;
use serde::{Deserialize, Serialize};

use super::resample::Interpolation;
use crate::TaskError;

/// Pixels of the published network's input, along either side.
const PUBLISHED_SIDE: f32 = 192.0;
/// Rounding of probabilities that add up to 1.
const ROUNDING: f32 = 1e-5;

/// Probabilities and ranges of the augmentation. Lengths are relative to the image.
///
/// # Model
/// 1. Some images are mirrored, left and right joints exchanged.
/// 2. Some are cut to a square about the person, as in the second pass of inference
///    (`person_crop`). To the others, at most one of the following is done: the image becomes smaller inside of a black border
///    (`pad`), a part of it larger (`crop`), or it is skewed (`affine`), rotated about its middle
///    (`rotate`) or moved (`shift`). Beside other persons it is neither skewed nor moved, and the
///    part is the middle.
/// 3. If too many joints leave the image by that, neither 1 nor 2 is done.
/// 4. Some images change in contrast, then in brightness (`light`), some get noise (`noise`), and
///    in some a square of one grey hides a joint (`blank`).
/// 5. Before 4, limbs of some persons vanish, as those at rest do from an EROS (`rest`), and some
///    images get single bright pixels (`speckle`).
///
/// Joints outside of the image become unlabelled, other persons there are forgotten, and a middle
/// there is moved onto the border. 1 and 2 are one affine map, along which the network's input is
/// sampled from the image once: thin edges stay thin.
///
/// # Source
/// Goyal et al.: *MoveEnet*, CVPRW 2023, and its published code. It differs in this: it resizes to
/// the network's input first, in validation too by one of five interpolations at random, and
/// samples again for 2, in 8 bits, rotations by cubics; when it skews or rotates, positions of
/// joints are cut to whole pixels; other persons do not move with `shift`, and in a mirror their
/// joints change indices from first to last. Its changes of hue and saturation do nothing to grey
/// images, and noise is drawn for each of three equal channels, here once.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BodyAugmentation {
    /// Interpolations of the image, one of which is drawn.
    pub interpolation: Vec<Interpolation>,
    /// Probability of a horizontal flip.
    pub mirror_probability: f32,
    /// Probability of a crop about the person.
    pub person_crop_probability: f32,
    /// Side of that crop, relative to the longer side of the person's bounding box.
    pub person_crop: [f32; 2],
    /// Probability of a border.
    pub pad_probability: f32,
    /// Width of the border.
    pub pad: [f32; 2],
    /// Probability of a crop.
    pub crop_probability: f32,
    /// Length cut off at either side, on average of both sides.
    pub crop: [f32; 2],
    /// Length cut off on the left and above, relative to that average.
    pub crop_start: [f32; 2],
    /// Probability of a skew.
    pub affine_probability: f32,
    /// How far each of three points is from where it will be, along either side.
    pub affine: [f32; 2],
    /// Probability of a rotation.
    pub rotate_probability: f32,
    /// Angle of the rotation in degrees.
    pub rotate_deg: [f32; 2],
    /// Probability of a shift.
    pub shift_probability: f32,
    /// The longest one, along either side; at least half of it is done.
    pub shift: [f32; 2],
    /// Joints that may become unlabelled by leaving the image.
    // The card of the shipped `body-quick` spells it so.
    #[serde(alias = "most_lost")]
    pub max_lost: usize,
    /// Joints that may be unlabelled then.
    #[serde(alias = "most_unlabelled")]
    pub max_unlabelled: usize,
    /// Probability of a change of contrast and brightness.
    pub light_probability: f32,
    /// Factor of the differences to the mean grey.
    pub contrast: [f32; 2],
    /// Offset of the grey values, relative to white.
    pub brightness: [f32; 2],
    /// Probability of noise.
    pub noise_probability: f32,
    /// The largest change of a pixel, of 255 levels of grey.
    pub noise_grey: f32,
    /// Probability of a square.
    pub blank_probability: f32,
    /// Half of the side of the square.
    pub blank: [f32; 2],
    /// Probability that limbs vanish, legs most often; not published.
    pub rest_probability: f32,
    /// How far from a limb, relative to the longer side of the person's bounding box.
    pub rest_width: [f32; 2],
    /// Probability of single bright pixels; not published.
    pub speckle_probability: f32,
    /// Their share of all pixels.
    pub speckle: [f32; 2],
}

impl Default for BodyAugmentation {
    /// As published, but for the interpolation, which is that of running networks.
    fn default() -> Self {
        Self {
            interpolation: vec![Interpolation::Linear],
            mirror_probability: 0.5,
            person_crop_probability: 0.0,
            person_crop: [1.1, 2.2],
            pad_probability: 0.5 * 0.2,
            pad: [0.06, 0.12],
            crop_probability: 0.5 * 0.8,
            crop: [0.1, 0.3],
            crop_start: [0.5, 1.0],
            affine_probability: 0.15 * 0.7,
            affine: [-40.0 / PUBLISHED_SIDE, 0.0],
            rotate_probability: 0.15 * 0.3,
            rotate_deg: [-24.0, 24.0],
            shift_probability: 0.2 * 0.5,
            shift: [0.1, 0.2],
            max_lost: 3,
            max_unlabelled: 5,
            light_probability: 0.4,
            contrast: [0.8, 1.2],
            brightness: [-0.2, 0.2],
            noise_probability: 0.4,
            noise_grey: 5.0,
            blank_probability: 0.3,
            blank: [3.0 / PUBLISHED_SIDE, 6.0 / PUBLISHED_SIDE],
            rest_probability: 0.0,
            rest_width: [0.05, 0.11],
            speckle_probability: 0.0,
            speckle: [0.01, 0.15],
        }
    }
}

impl BodyAugmentation {
    /// No augmentation.
    pub fn none() -> Self {
        Self {
            mirror_probability: 0.0,
            person_crop_probability: 0.0,
            pad_probability: 0.0,
            crop_probability: 0.0,
            affine_probability: 0.0,
            rotate_probability: 0.0,
            shift_probability: 0.0,
            light_probability: 0.0,
            noise_probability: 0.0,
            blank_probability: 0.0,
            rest_probability: 0.0,
            speckle_probability: 0.0,
            ..Self::default()
        }
    }

    /// Interpolations as published.
    pub fn published() -> Self {
        Self { interpolation: Interpolation::ALL.to_vec(), ..Self::default() }
    }

    /// Whether bodies of so many joints can be varied like this.
    ///
    /// # Errors
    /// [`TaskError::Field`] for what is no probability, no range, or larger than the image, and
    /// for joints without those of the other side, which cannot be mirrored.
    pub fn validate(&self, joints: usize) -> Result<(), TaskError> {
        let wrong = |field, message: String| Err(TaskError::Field { field, message });
        if self.interpolation.is_empty() {
            return wrong("augmentation.interpolation", "name at least one".to_owned());
        }
        let steps = [
            ("augmentation.pad_probability", self.pad_probability),
            ("augmentation.crop_probability", self.crop_probability),
            ("augmentation.affine_probability", self.affine_probability),
            ("augmentation.rotate_probability", self.rotate_probability),
            ("augmentation.shift_probability", self.shift_probability),
        ];
        let others = [
            ("augmentation.mirror_probability", self.mirror_probability),
            ("augmentation.person_crop_probability", self.person_crop_probability),
            ("augmentation.light_probability", self.light_probability),
            ("augmentation.noise_probability", self.noise_probability),
            ("augmentation.blank_probability", self.blank_probability),
            ("augmentation.rest_probability", self.rest_probability),
            ("augmentation.speckle_probability", self.speckle_probability),
        ];
        for (field, probability) in steps.into_iter().chain(others) {
            if !(0.0..=1.0).contains(&probability) {
                return wrong(field, format!("{probability} is not between 0 and 1"));
            }
        }
        // One draw chooses among these or none, so that their probabilities share it.
        let sum: f32 = steps.iter().map(|(_, probability)| probability).sum();
        if sum > 1.0 + ROUNDING {
            let message =
                format!("with those of crop, affine, rotate and shift it is {sum}, above 1");
            return wrong(steps[0].0, message);
        }
        let ranges = [
            ("augmentation.person_crop", self.person_crop, [0.5, 8.0]),
            ("augmentation.pad", self.pad, [0.0, 4.0]),
            ("augmentation.crop", self.crop, [0.0, 0.45]),
            ("augmentation.crop_start", self.crop_start, [0.0, 2.0]),
            ("augmentation.affine", self.affine, [-1.0, 1.0]),
            ("augmentation.rotate_deg", self.rotate_deg, [-180.0, 180.0]),
            ("augmentation.shift", self.shift, [0.0, 1.0]),
            ("augmentation.contrast", self.contrast, [0.0, 16.0]),
            ("augmentation.brightness", self.brightness, [-1.0, 1.0]),
            ("augmentation.blank", self.blank, [0.0, 1.0]),
            ("augmentation.rest_width", self.rest_width, [0.0, 1.0]),
            ("augmentation.speckle", self.speckle, [0.0, 1.0]),
            ("augmentation.noise_grey", [self.noise_grey; 2], [0.0, 255.0]),
        ];
        for (field, [low, high], [least, most]) in ranges {
            // Written as a negation, since NaN fails every comparison.
            if !(least <= low && low <= high && high <= most) {
                let message =
                    format!("{low} to {high}: a range within {least} to {most} is expected");
                return wrong(field, message);
            }
        }
        let has_other_side =
            (0..joints).all(|joint| MIRRORED.get(joint).is_some_and(|m| *m < joints));
        if self.mirror_probability > 0.0 && !has_other_side {
            let message =
                format!("{joints} joints have no mirror: take 1, 3, .. 13 of them, or 0 here");
            return wrong(others[0].0, message);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_valid_and_an_empty_table_is_the_defaults() {
        for augmentation in
            [BodyAugmentation::default(), BodyAugmentation::none(), BodyAugmentation::published()]
        {
            augmentation.validate(13).unwrap();
            let text = toml::to_string(&augmentation).unwrap();
            assert_eq!(toml::from_str::<BodyAugmentation>(&text).unwrap(), augmentation);
        }
        assert_eq!(toml::from_str::<BodyAugmentation>("").unwrap(), BodyAugmentation::default());
        assert!(toml::from_str::<BodyAugmentation>("crops = 1").is_err());
    }

    #[test]
    fn what_cannot_be_is_refused_by_name() {
        let refused = |text: &str, joints: usize| {
            let augmentation: BodyAugmentation = toml::from_str(text).unwrap();
            augmentation.validate(joints).unwrap_err().to_string()
        };
        for (text, field) in [
            ("interpolation = []", "interpolation"),
            ("blank_probability = -0.1", "blank_probability"),
            ("noise_probability = nan", "noise_probability"),
            ("pad_probability = 0.5", "pad_probability"),
            ("crop = [0.3, 0.1]", "crop"),
            ("crop = [0.1, 0.5]", "crop"),
            ("shift = [0.1, nan]", "shift"),
            ("noise_grey = 300.0", "noise_grey"),
        ] {
            let message = refused(text, 13);
            assert!(message.contains(&format!("`augmentation.{field}`")), "{text}: {message}");
        }
        assert!(refused("", 8).contains("mirror_probability"));
        assert!(refused("", 17).contains("mirror_probability"));
        BodyAugmentation::default().validate(7).unwrap();
        BodyAugmentation::none().validate(17).unwrap();
    }
}
