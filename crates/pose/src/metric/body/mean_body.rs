//! The mean of many bodies: the best guess without looking, and so the predictor to beat.
//!
//! # Model
//! The mean of each joint's labelled positions relative to the image, times the size of an image.

use glam::{DVec2, Vec2};

use crate::body::{BODY_JOINTS, BodyLabel, BodyPoints};

/// An accumulator of bodies.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeanBody {
    sums: [DVec2; BODY_JOINTS],
    counts: [u64; BODY_JOINTS],
}

impl MeanBody {
    /// Adds the joints of a body that are labelled; those beyond the thirteenth are not looked at.
    pub fn push(&mut self, label: &BodyLabel) {
        for (joint, keypoint) in label.keypoints.iter().enumerate().take(BODY_JOINTS) {
            if keypoint.is_labelled() {
                self.sums[joint] += keypoint.position.as_dvec2();
                self.counts[joint] += 1;
            }
        }
    }

    /// The mean in an image of this size, in pixels; none for joints that were never labelled.
    pub fn mean_px(&self, image_px: Vec2) -> BodyPoints {
        std::array::from_fn(|joint| {
            let mean = self.sums[joint] / self.counts[joint] as f64;
            (self.counts[joint] > 0).then(|| mean.as_vec2() * image_px)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Keypoint, Visibility};

    #[test]
    fn joints_are_averaged_where_they_are_labelled() {
        let mut mean = MeanBody::default();
        for k in 0..4_u16 {
            let at = |joint: usize| {
                let is_known = joint == 0 || (joint == 5 && k < 2);
                let visibility = if is_known { Visibility::Hidden } else { Visibility::Unlabelled };
                Keypoint { position: Vec2::new(0.25 * f32::from(k), 0.5), visibility }
            };
            mean.push(&BodyLabel { keypoints: (0..17).map(at).collect(), ..BodyLabel::default() });
        }
        let joints = mean.mean_px(Vec2::new(640.0, 480.0));
        assert_eq!(joints[0], Some(Vec2::new(240.0, 240.0)));
        assert_eq!(joints[5], Some(Vec2::new(80.0, 240.0)));
        assert_eq!(joints.iter().flatten().count(), 2);
    }
}
