//! A baseline at work: images in, joints out.

use burn::module::Module;
use burn::tensor::{Device, Tensor, TensorData};
use evpose_core::Plane;
use evpose_nn::BaselineNetwork;
use evpose_pose::body::{BODY_JOINTS, BodyPoints};

use super::checkpoint::BaselineCheckpoint;
use super::input::BaselineInput;
use super::{dhp19, lift_mono};

/// The joints of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaselineJoints {
    /// Positions relative to the image, 0 to 1; none where a joint was never found.
    pub points: BodyPoints,
    /// Scores, 0 to 1.
    pub scores: [f32; BODY_JOINTS],
    /// Depth coordinates, see [`LiftGeometry`](super::LiftGeometry); of `lift-mono` only.
    pub depths: Option<[f32; BODY_JOINTS]>,
}

/// Finds joints on images.
///
/// # Model
/// `dhp19-cnn`: a joint is where its heatmap is largest, and that is its score. A joint whose score
/// is below the confidence of the config stays where it was found last, since limbs that rest make
/// no events. `lift-mono`: a joint is the expected position of its heatmaps.
///
/// # Source
/// Calabrese et al.: *DHP19*, CVPRW 2019, section 4; Scarpellini et al.: *Lifting Monocular Events
/// to 3D Human Poses*, CVPRW 2021.
#[derive(Debug, Clone)]
pub struct BaselinePredictor {
    network: BaselineNetwork,
    device: Device,
    image: BaselineInput,
    confidence: f32,
    last: BodyPoints,
    input: Vec<f32>,
}

impl BaselinePredictor {
    /// Of a network, on the device that it was loaded to.
    pub fn new(checkpoint: &BaselineCheckpoint) -> Self {
        let image = BaselineInput::new(&checkpoint.config.image);
        let network = checkpoint.network.clone();
        let device = network.devices().into_iter().next().unwrap_or_else(Device::flex);
        Self {
            network,
            device,
            image,
            confidence: checkpoint.config.decoding.confidence,
            last: BodyPoints::default(),
            input: vec![0.0; image.pixels()],
        }
    }

    /// Forgets where joints were found last.
    pub fn forget(&mut self) {
        self.last = BodyPoints::default();
    }

    /// The joints of the person on an image.
    pub fn predict(&mut self, image: &Plane<u8>) -> BaselineJoints {
        self.image.fill(image, &mut self.input);
        let [width, height] = self.image.size_px();
        let data = TensorData::new(self.input.clone(), [1, 1, height, width]);
        let images = Tensor::<4>::from_data(data, &self.device);
        let shown = self.image.shown([image.width(), image.height()]);
        let mut joints = match &self.network {
            BaselineNetwork::Dhp19Cnn(network) => {
                let maps: Vec<f32> = network.forward(images).into_data().iter().collect();
                let size_px = self.image.size_px();
                let scores = dhp19::peaks(&maps, size_px, self.confidence, &mut self.last);
                BaselineJoints { points: self.last, scores, depths: None }
            }
            BaselineNetwork::LiftMono(network) => {
                let stages = network.forward(images);
                // Every stage refines the one before, so that only the last counts.
                let maps = stages.last().unwrap_or_else(|| unreachable!("a stage at least"));
                let positions: Vec<f32> = maps.positions().into_data().iter().collect();
                let (points, depths) = lift_mono::expected(&positions);
                let of_maps: Vec<f32> = maps.scores().into_data().iter().collect();
                let score = |joint: usize| of_maps.get(joint).copied().unwrap_or_default();
                let scores = std::array::from_fn(score);
                BaselineJoints { points, scores, depths: Some(depths) }
            }
        };
        // Positions are relative to the input, which may be only a part of the image.
        joints.points = joints.points.map(|point| Some(point? * shown));
        joints
    }
}

#[cfg(test)]
mod tests {
    use evpose_nn::{BaselineNetworkConfig, Dhp19CnnConfig, LiftMonoConfig};
    use glam::Vec2;

    use super::*;
    use crate::baseline::BaselineConfig;

    fn predictor(config: BaselineConfig) -> BaselinePredictor {
        let network = config.network.init(5, &Device::flex()).unwrap();
        BaselinePredictor::new(&BaselineCheckpoint {
            config,
            network,
            torso_m: None,
            depths_m: None,
            mean_pose: None,
            data: None,
        })
    }

    #[test]
    fn a_black_image_has_no_joints_for_dhp19_at_any_confidence() {
        let mut config = BaselineConfig::dhp19_cnn().with_size(32, 24);
        config.decoding.confidence = 0.0;
        let network = Dhp19CnnConfig { width: 0.125, ..Dhp19CnnConfig::default() };
        config.network = BaselineNetworkConfig::Dhp19Cnn(network);
        // No layer has a bias: nothing in, nothing out.
        let joints = predictor(config).predict(&Plane::filled(32, 24, 0));
        assert_eq!((joints.points, joints.scores), (BodyPoints::default(), [0.0; BODY_JOINTS]));
    }

    #[test]
    fn lift_mono_finds_every_joint_within_the_image_and_its_depth() {
        let mut config = BaselineConfig::lift_mono().with_size(64, 48);
        let network = LiftMonoConfig { width: 0.0625, stages: 2, ..LiftMonoConfig::default() };
        config.network = BaselineNetworkConfig::LiftMono(network);
        let mut predictor = predictor(config);
        let joints = predictor.predict(&Plane::filled(320, 240, 90));
        let within = |at: Vec2| at.cmpge(Vec2::ZERO).all() && at.cmple(Vec2::ONE).all();
        assert!(joints.points.iter().all(|point| point.is_some_and(within)), "{joints:?}");
        assert!(joints.depths.unwrap().iter().all(|depth| depth.abs() <= 1.0));
        assert!(joints.scores.iter().all(|score| (0.0..=1.0).contains(score)));
        assert_eq!(predictor.predict(&Plane::filled(320, 240, 90)), joints);
    }
}
