//! A system ready to predict poses.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use crate::external::{ImageNetwork, MoveNet, OpenPose};
use anyhow::Result;
use burn::tensor::Device;
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use evpose_pose::metric::body::BodyPrediction;
use evpose_task::baseline::{
    BaselineCheckpoint, BaselinePredictor, LiftGeometry, PUBLISHED_TORSO_M,
};
use evpose_task::body::{BodyCheckpoint, BodyPredictor, BodyPredictorOptions};
use evpose_train::body::BodyFrame;
use glam::{Vec2, Vec3};

use crate::compare::system::FileKind;

pub(crate) struct SystemPose {
    pub(crate) prediction: BodyPrediction,
    /// Joints in the camera, in metres; none of systems that know no depth.
    pub(crate) joints_m: [Option<Vec3>; BODY_JOINTS],
}

/// A system at work on the images of one sequence, in their order.
pub(crate) type SystemPredictor = Box<dyn FnMut(&BodyFrame) -> Result<SystemPose>>;

/// A system with its weights: starts a predictor for each sequence.
pub(crate) struct ReadySystem(Box<dyn Fn() -> SystemPredictor + Send + Sync>);

impl ReadySystem {
    /// A predictor for another sequence.
    pub(crate) fn start(&self) -> SystemPredictor {
        (self.0)()
    }

    pub(crate) fn move_enet(run: &Path) -> Result<Self> {
        let checkpoint = BodyCheckpoint::load(run, &Device::flex())?;
        let predictor = BodyPredictor::new(&checkpoint, BodyPredictorOptions::default(), None)?;
        Ok(Self(Box::new(move || {
            let mut predictor = predictor.another();
            Box::new(move |frame: &BodyFrame| {
                Ok(in_image(predictor.predict(frame.t.as_seconds(), &frame.image)))
            })
        })))
    }

    /// A network of others that was trained here, of its run directory.
    pub(crate) fn baseline(run: &Path) -> Result<Self> {
        let checkpoint = BaselineCheckpoint::load(run, &Device::flex())?;
        let torso_m = checkpoint.torso_m.unwrap_or(PUBLISHED_TORSO_M);
        // Depths of heads in the training, in metres.
        let depths_m = checkpoint.depths_m;
        let mut predictor = BaselinePredictor::new(&checkpoint);
        // Clones begin without a last pose, each at the start of its own sequence.
        predictor.forget();
        Ok(Self(Box::new(move || {
            let mut predictor = predictor.clone();
            Box::new(move |frame: &BodyFrame| {
                let begin = Instant::now();
                let joints = predictor.predict(&frame.image);
                let mut pose = in_image(on_image(frame, begin, joints.points));
                let camera = frame.camera.filter(|camera| {
                    // Elsewhere, pixels of the image are not those of the sensor.
                    let sensor = [camera.sensor.width, camera.sensor.height].map(usize::from);
                    sensor == [frame.image.width(), frame.image.height()]
                });
                if let Some((camera, depths)) = camera.zip(joints.depths) {
                    let mut geometry = LiftGeometry::new(camera.lens, camera.sensor);
                    if let Some(depths_m) = depths_m {
                        geometry = geometry.within_depths(depths_m);
                    }
                    pose.joints_m = geometry.joints_m(&pose.prediction.joints_px, &depths, torso_m);
                }
                Ok(pose)
            })
        })))
    }

    /// A network from an ONNX file.
    pub(crate) fn file(kind: FileKind, path: &Path) -> Result<Self> {
        let network: Arc<dyn ImageNetwork> = match kind {
            FileKind::OpenPose => Arc::new(OpenPose::open(path)?),
            FileKind::MoveNet => Arc::new(MoveNet::open(path)?),
        };
        Ok(Self(Box::new(move || {
            let network = Arc::clone(&network);
            Box::new(move |frame: &BodyFrame| {
                let begin = Instant::now();
                let joints = network.joints(&frame.image)?;
                Ok(in_image(on_image(frame, begin, joints.map(|joint| joint.position))))
            })
        })))
    }

    /// The same pose on every image, relative to it.
    pub(crate) fn constant(pose: BodyPoints) -> Self {
        Self(Box::new(move || {
            Box::new(move |frame: &BodyFrame| Ok(in_image(on_image(frame, Instant::now(), pose))))
        }))
    }
}

/// A pose of a system that knows no depth.
fn in_image(prediction: BodyPrediction) -> SystemPose {
    SystemPose { prediction, joints_m: [None; BODY_JOINTS] }
}

/// A prediction of joints relative to the image.
fn on_image(frame: &BodyFrame, begin: Instant, joints: BodyPoints) -> BodyPrediction {
    let size_px: Vec2 = frame.size_px();
    BodyPrediction {
        t_s: frame.t.as_seconds(),
        delay_s: begin.elapsed().as_secs_f64(),
        joints_px: joints.map(|joint| joint.map(|at| at * size_px)),
    }
}
