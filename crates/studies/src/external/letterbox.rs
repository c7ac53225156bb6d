//! An image in the input of a network, its aspect ratio kept.

use evpose_core::Plane;
use evpose_pose::body::{BODY_JOINTS, BodyJoint};
use evpose_task::body::{Interpolation, sample};
use glam::{DAffine2, DVec2};

/// The place of an image in an input of another aspect ratio: as large as fits, in the middle, black
/// around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Letterbox {
    /// From the input to the image, both from 0 to 1 along either side.
    image_from_input: DAffine2,
    interpolation: Interpolation,
}

impl Letterbox {
    /// The place of an image of `image_px` in an input of `input_px`, both width and height.
    pub fn new(image_px: [usize; 2], input_px: [usize; 2]) -> Self {
        let [image, input] =
            [image_px, input_px].map(|[width, height]| DVec2::new(width as f64, height as f64));
        let scale = (input / image).min_element();
        let drawn = image * scale;
        let margin = 0.5 * (input - drawn);
        Self {
            image_from_input: DAffine2::from_scale_angle_translation(
                input / drawn,
                0.0,
                -margin / drawn,
            ),
            // Of a larger image every pixel counts; in a smaller one there is something between them.
            interpolation: if scale < 1.0 { Interpolation::Area } else { Interpolation::Linear },
        }
    }

    /// The input, row by row, 0 to 255.
    pub fn input(&self, image: &Plane<u8>, [width, height]: [usize; 2]) -> Vec<f32> {
        let mut input = vec![0.0; width * height];
        sample(image, self.image_from_input, self.interpolation, [width, height], &mut input);
        input
    }

    /// Joints relative to the image, of joints relative to the input.
    pub fn joints(&self, joints: [BodyJoint; BODY_JOINTS]) -> [BodyJoint; BODY_JOINTS] {
        joints.map(|joint| BodyJoint {
            position: joint
                .position
                .map(|at| self.image_from_input.transform_point2(at.as_dvec2()).as_vec2()),
            ..joint
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;

    #[test]
    fn an_image_is_in_the_middle_and_its_joints_come_back() {
        // 40 x 30 in 16 x 16: scaled by 0.4 to 16 x 12, two black rows above and below.
        let letterbox = Letterbox::new([40, 30], [16, 16]);
        let input = letterbox.input(&Plane::filled(40, 30, 200), [16, 16]);
        for (y, row) in input.chunks(16).enumerate() {
            let grey = if (2..14).contains(&y) { 200.0 } else { 0.0 };
            assert!(row.iter().all(|value| (value - grey).abs() < 1e-3), "row {y}: {row:?}");
        }
        let at = |position| BodyJoint { position: Some(position), score: 0.5 };
        let joints = letterbox.joints([at(Vec2::new(0.25, 2.0 / 16.0)); BODY_JOINTS]);
        let corner = joints[3].position.unwrap_or(Vec2::MAX);
        assert!(corner.distance(Vec2::new(0.25, 0.0)) < 1e-6, "{corner}");
        let middle = letterbox.joints([at(Vec2::splat(0.5)); BODY_JOINTS])[0].position;
        assert!(middle.unwrap_or(Vec2::MAX).distance(Vec2::splat(0.5)) < 1e-6);
    }
}
