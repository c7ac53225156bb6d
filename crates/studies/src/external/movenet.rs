//! MoveNet's single-pose models.

use std::path::Path;

use anyhow::Result;
use evpose_core::Plane;
use evpose_pose::body::{BODY_JOINTS, BodyJoint, MOVENET_VALUES, movenet_joints};

use crate::external::runtime::OnnxModel;
use crate::external::{ImageNetwork, Letterbox};

/// Sides of an input whose size the file leaves open, in pixels: Lightning's.
const OPEN_SIDE_PX: usize = 192;
/// Minimum score of a keypoint: as for networks of our own, nearly all count.
const MIN_SCORE: f32 = 0.01;

/// A single-pose model of MoveNet: Lightning (192 pixels) or Thunder (256).
///
/// # Model
/// Input: a square image, 0 to 255, as floats or integers, the image in the middle and black around
/// it. Output: 17 keypoints, `[1, 1, 17, 3]`.
///
/// # Source
/// Model card of *MoveNet.SinglePose*, Google, 2021.
pub struct MoveNet {
    model: OnnxModel,
}

impl MoveNet {
    /// Opens an ONNX file.
    ///
    /// # Errors
    /// If it cannot be read, is another network, or there is no runtime.
    pub fn open(path: &Path) -> Result<Self> {
        let model = OnnxModel::open(path, [OPEN_SIDE_PX; 2])?;
        let is_movenet = |shape: &[usize]| {
            shape.ends_with(&[17, 3]) && shape.iter().product::<usize>() == MOVENET_VALUES
        };
        match model.output_shapes() {
            [shape] if is_movenet(shape) => Ok(Self { model }),
            _ => Err(model.other_outputs("MoveNet", "[1, 1, 17, 3], as of the single-pose models")),
        }
    }
}

impl ImageNetwork for MoveNet {
    fn joints(&self, image: &Plane<u8>) -> Result<[BodyJoint; BODY_JOINTS]> {
        let input_px = self.model.input_px();
        let letterbox = Letterbox::new([image.width(), image.height()], input_px);
        let outputs = self.model.run(&letterbox.input(image, input_px))?;
        let output = outputs.first().and_then(|output| output.first_chunk());
        let output = output.ok_or_else(|| self.model.other_outputs("MoveNet", "[1, 1, 17, 3]"))?;
        Ok(letterbox.joints(movenet_joints(output, MIN_SCORE)))
    }

    fn description(&self) -> String {
        let [width, height] = self.model.input_px();
        format!("MoveNet, {width}x{height} px")
    }
}
