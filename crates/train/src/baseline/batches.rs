//! Images with targets as batches, as they are.

use std::ops::Range;
use std::sync::Arc;

use burn::data::dataset::DatasetError;
use burn::tensor::{Device, Tensor, TensorData};
use evpose_core::seed_for;
use evpose_nn::{BaselineNetworkConfig, HeatmapTargets, MarginalTargets};
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use evpose_task::baseline::{BaselineConfig, BaselineInput};
use glam::Vec2;
use rayon::prelude::*;

use super::{dhp19, lift_mono};
use crate::batch_loader::BatchSource;
use crate::body::{BodyFrame, BodyFrames};
use crate::order::SampleOrder;
use crate::passes::Passes;

/// Images with targets and labels.
#[derive(Debug, Clone)]
pub(super) struct BaselineItem {
    /// `[batch, 1, height, width]`, 0 to 255.
    pub(super) images: Tensor<4>,
    pub(super) targets: BaselineTargets,
    /// Joints in pixels of the input; none where they are not in view.
    pub(super) joints_px: Vec<BodyPoints>,
}

/// The targets of a network.
#[derive(Debug, Clone)]
pub(super) enum BaselineTargets {
    /// Of `dhp19-cnn`.
    Heatmaps(HeatmapTargets),
    /// Of `lift-mono`.
    Marginals(MarginalTargets),
}

/// Images that become batches.
#[derive(Clone)]
pub(super) struct BaselineBatches {
    data: Arc<BodyFrames>,
    input: BaselineInput,
    kind: Kind,
    order: SampleOrder,
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    Heatmaps { sigma_px: f32 },
    Marginals,
}

struct HostSample {
    image: Vec<f32>,
    joints_px: BodyPoints,
    targets: SampleTargets,
}

enum SampleTargets {
    /// Profiles along rows and along columns, joint by joint.
    Heatmaps([Vec<f32>; 2]),
    /// Positions, -1 to 1, and whether they are known.
    Marginals([[f32; 3]; BODY_JOINTS], [f32; BODY_JOINTS]),
}

/// A batch in the memory of the host, not yet on the device.
pub(super) struct HostBatch(Vec<HostSample>);

impl BaselineBatches {
    pub(super) fn new(data: Arc<BodyFrames>, config: &BaselineConfig) -> Self {
        let kind = match config.network {
            BaselineNetworkConfig::Dhp19Cnn(_) => Kind::Heatmaps { sigma_px: config.loss.sigma_px },
            BaselineNetworkConfig::LiftMono(_) => Kind::Marginals,
        };
        let seed = seed_for(config.seed, "baseline order", 0);
        let order = SampleOrder::new(data.len() as u64, seed);
        Self { data, input: BaselineInput::new(&config.image), kind, order }
    }

    fn sample(&self, frame: &BodyFrame) -> HostSample {
        let mut image = vec![0.0; self.input.pixels()];
        self.input.fill(&frame.image, &mut image);
        let points = points_in(&self.input, frame);
        let [width, height] = self.input.size_px();
        let size_px = Vec2::new(width as f32, height as f32);
        let targets = match self.kind {
            Kind::Heatmaps { sigma_px } => {
                SampleTargets::Heatmaps(dhp19::profiles(&points, self.input.size_px(), sigma_px))
            }
            Kind::Marginals => {
                let (positions, known) = lift_mono::positions(&points, frame);
                SampleTargets::Marginals(positions, known)
            }
        };
        HostSample { image, joints_px: points.map(|point| Some(point? * size_px)), targets }
    }
}

/// Labelled joints relative to the input; none outside of it.
fn points_in(input: &BaselineInput, frame: &BodyFrame) -> BodyPoints {
    let shown = input.shown([frame.image.width(), frame.image.height()]);
    let mut points = BodyPoints::default();
    for (point, keypoint) in points.iter_mut().zip(&frame.label.keypoints) {
        let at = keypoint.position / shown;
        // A joint beyond the input has no pixel at which a heatmap could peak.
        let is_inside = at.cmpge(Vec2::ZERO).all() && at.cmplt(Vec2::ONE).all();
        *point = (keypoint.is_labelled() && is_inside).then_some(at);
    }
    points
}

impl BatchSource for BaselineBatches {
    type Host = HostBatch;
    type Item = BaselineItem;

    fn host_batch(
        &self,
        passes: &Passes,
        positions: Range<u64>,
    ) -> Result<HostBatch, DatasetError> {
        let sample = |position: u64| {
            let index = passes.sample(&self.order, self.data.len(), position);
            self.sample(&self.data.frames[index])
        };
        Ok(HostBatch(positions.into_par_iter().map(sample).collect()))
    }

    fn item(&self, host: HostBatch, device: &Device) -> BaselineItem {
        let [width, height] = self.input.size_px();
        let count = host.0.len();
        // One after the other, so that each tensor of a batch is one copy to the device.
        let (mut images, mut joints_px) = (Vec::new(), Vec::with_capacity(count));
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for sample in host.0 {
            images.extend(sample.image);
            joints_px.push(sample.joints_px);
            match sample.targets {
                SampleTargets::Heatmaps([rows, columns]) => {
                    first.extend(rows);
                    second.extend(columns);
                }
                SampleTargets::Marginals(positions, known) => {
                    first.extend(positions.into_iter().flatten());
                    second.extend(known);
                }
            }
        }
        let profiles = |values: Vec<f32>, length: usize| {
            Tensor::from_data(TensorData::new(values, [count, BODY_JOINTS, length]), device)
        };
        // A heatmap is the product of two profiles, which are far smaller to copy.
        let targets = match self.kind {
            Kind::Heatmaps { .. } => BaselineTargets::Heatmaps(HeatmapTargets {
                rows: profiles(first, height),
                columns: profiles(second, width),
            }),
            Kind::Marginals => {
                let known = TensorData::new(second, [count, BODY_JOINTS]);
                let known = Tensor::from_data(known, device);
                BaselineTargets::Marginals(MarginalTargets { positions: profiles(first, 3), known })
            }
        };
        let images = Tensor::from_data(TensorData::new(images, [count, 1, height, width]), device);
        BaselineItem { images, targets, joints_px }
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Distortion, LensCamera, Micros, Plane, SensorSize};
    use evpose_pose::body::{BodyLabel, Keypoint, Visibility};
    use glam::{DVec2, Vec3};

    use super::*;
    use crate::body::CameraJoints;

    const SENSOR: SensorSize = SensorSize { width: 346, height: 260 };

    fn frame() -> BodyFrame {
        let mut label =
            BodyLabel { keypoints: vec![Keypoint::default(); 13], ..BodyLabel::default() };
        let at = |x: f32, y: f32| Keypoint {
            position: Vec2::new(x / 346.0, y / 260.0),
            visibility: Visibility::Visible,
        };
        label.keypoints[0] = at(100.9, 30.2);
        label.keypoints[1] = at(345.0, 200.0);
        label.keypoints[5] = at(10.5, 259.9);
        let lens = LensCamera {
            focal_px: DVec2::splat(300.0),
            principal_px: DVec2::new(173.0, 130.0),
            distortion: Distortion::default(),
        };
        let mut joints_m = [Vec3::NAN; BODY_JOINTS];
        joints_m[0] = Vec3::new(0.1, 0.2, -3.0);
        joints_m[1] = Vec3::new(0.1, 0.2, -3.5);
        let camera = Some(CameraJoints { joints_m, lens, sensor: SENSOR });
        let image = Plane::for_sensor(SENSOR, 0);
        BodyFrame { image, label, sequence: 0, t: Micros(0), camera }
    }

    fn sample(config: &BaselineConfig) -> HostSample {
        let data = Arc::new(BodyFrames { frames: vec![frame()] });
        BaselineBatches::new(data, config).sample(&frame())
    }

    #[test]
    fn heatmaps_are_about_the_pixel_of_each_joint_and_black_for_those_out_of_view() {
        let sample = sample(&BaselineConfig::dhp19_cnn());
        let SampleTargets::Heatmaps([rows, columns]) = sample.targets else { panic!("heatmaps") };
        let peak = |profiles: &[f32], joint: usize, length: usize| {
            profiles[joint * length..][..length].iter().position(|&value| value == 1.0)
        };
        assert_eq!((peak(&rows, 0, 260), peak(&columns, 0, 344)), (Some(30), Some(100)));
        // In the two columns that are cut off.
        assert_eq!((peak(&rows, 1, 260), sample.joints_px[1]), (None, None));
        assert_eq!((peak(&columns, 5, 344), peak(&columns, 6, 344)), (Some(10), None));
        assert!(sample.joints_px[0].is_some_and(|at| at.distance(Vec2::new(100.9, 30.2)) < 1e-3));
    }

    #[test]
    fn positions_are_known_where_image_and_depth_are() {
        let sample = sample(&BaselineConfig::lift_mono());
        let SampleTargets::Marginals(positions, known) = sample.targets else { panic!("planes") };
        assert_eq!(known.iter().sum::<f32>(), 2.0, "{known:?}");
        let [x, y, z] = positions[0];
        let want = [2.0 * 100.9 / 346.0 - 1.0, 2.0 * 30.2 / 260.0 - 1.0];
        assert!((x - want[0]).abs() < 1e-5 && (y - want[1]).abs() < 1e-5, "{x} {y}");
        assert!(z == 0.0 && positions[1][2] > 0.1, "{positions:?}");
        assert_eq!((known[5], positions[5]), (0.0, [0.0; 3]), "no depth");
    }
}
