//! A system ready to predict poses.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Result, anyhow};
use burn::tensor::Device;
use evpose_external::{ImageNetwork, MoveNet, OpenPose};
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use evpose_pose::metric::body::BodyPrediction;
use evpose_task::baseline::{
    BaselineCheckpoint, BaselinePredictor, LiftGeometry, PUBLISHED_TORSO_M,
};
use evpose_task::body::{BodyCheckpoint, BodyPredictor, BodyPredictorOptions};
use evpose_train::body::BodyFrame;
use glam::{Vec2, Vec3};

use crate::system::FileKind;

/// A pose that a system predicted.
pub(crate) struct SystemPose {
    pub(crate) prediction: BodyPrediction,
    /// Joints in the camera, in metres; none of systems that know no depth.
    pub(crate) joints_m: [Option<Vec3>; BODY_JOINTS],
}

/// A system at work on the images of one sequence, in their order.
pub(crate) trait SystemPredictor {
    /// The pose on an image.
    fn predict(&mut self, frame: &BodyFrame) -> Result<SystemPose>;
}

/// A system with its weights: starts a predictor for each sequence.
pub(crate) struct ReadySystem(Box<dyn Fn() -> Box<dyn SystemPredictor> + Send + Sync>);

impl ReadySystem {
    /// A predictor for another sequence.
    pub(crate) fn start(&self) -> Box<dyn SystemPredictor> {
        (self.0)()
    }

    /// A network of MoveEnet, of its run directory.
    pub(crate) fn move_enet(run: &Path) -> Result<Self> {
        let checkpoint = BodyCheckpoint::load(run, &Device::flex())?;
        let predictor = BodyPredictor::new(&checkpoint, BodyPredictorOptions::default(), None)?;
        Ok(Self(Box::new(move || Box::new(MoveEnet(predictor.another())))))
    }

    /// A network of others that was trained here, of its run directory.
    pub(crate) fn baseline(run: &Path) -> Result<Self> {
        let checkpoint = BaselineCheckpoint::load(run, &Device::flex())?;
        let torso_m = checkpoint.torso_m.unwrap_or(PUBLISHED_TORSO_M);
        let depths_m = checkpoint.depths_m;
        let mut predictor = BaselinePredictor::new(&checkpoint);
        predictor.forget();
        Ok(Self(Box::new(move || {
            Box::new(Baseline { predictor: predictor.clone(), torso_m, depths_m })
        })))
    }

    /// A network from an ONNX file.
    pub(crate) fn file(kind: FileKind, path: &Path) -> Result<Self> {
        let network: Arc<dyn ImageNetwork> = match kind {
            FileKind::OpenPose => Arc::new(OpenPose::open(path)?),
            FileKind::MoveNet => Arc::new(MoveNet::open(path)?),
        };
        Ok(Self(Box::new(move || Box::new(External(Arc::clone(&network))))))
    }

    /// The same pose on every image, relative to it.
    pub(crate) fn constant(pose: BodyPoints) -> Self {
        Self(Box::new(move || Box::new(Constant(pose))))
    }
}

struct MoveEnet(BodyPredictor);

impl SystemPredictor for MoveEnet {
    fn predict(&mut self, frame: &BodyFrame) -> Result<SystemPose> {
        let prediction = self.0.predict(frame.t.as_seconds(), &frame.image);
        Ok(SystemPose { prediction, joints_m: [None; BODY_JOINTS] })
    }
}

struct Baseline {
    predictor: BaselinePredictor,
    torso_m: f32,
    /// Depths of heads in the training, in metres.
    depths_m: Option<[f32; 2]>,
}

impl SystemPredictor for Baseline {
    fn predict(&mut self, frame: &BodyFrame) -> Result<SystemPose> {
        let begin = Instant::now();
        let joints = self.predictor.predict(&frame.image);
        let pose = on_image(frame, begin, joints.points);
        let camera = frame.camera.filter(|camera| {
            // Elsewhere, pixels of the image are not those of the sensor.
            let sensor = [camera.sensor.width, camera.sensor.height].map(usize::from);
            sensor == [frame.image.width(), frame.image.height()]
        });
        let joints_m = match camera.zip(joints.depths) {
            Some((camera, depths)) => {
                let geometry = LiftGeometry::new(camera.lens, camera.sensor);
                let geometry = match self.depths_m {
                    Some(depths_m) => geometry.within_depths(depths_m),
                    None => geometry,
                };
                geometry.joints_m(&pose.joints_px, &depths, self.torso_m)
            }
            None => [None; BODY_JOINTS],
        };
        Ok(SystemPose { prediction: pose, joints_m })
    }
}

struct External(Arc<dyn ImageNetwork>);

impl SystemPredictor for External {
    fn predict(&mut self, frame: &BodyFrame) -> Result<SystemPose> {
        let begin = Instant::now();
        let joints = self.0.joints(&frame.image).map_err(|error| anyhow!(error))?;
        let prediction = on_image(frame, begin, joints.map(|joint| joint.position));
        Ok(SystemPose { prediction, joints_m: [None; BODY_JOINTS] })
    }
}

struct Constant(BodyPoints);

impl SystemPredictor for Constant {
    fn predict(&mut self, frame: &BodyFrame) -> Result<SystemPose> {
        let prediction = on_image(frame, Instant::now(), self.0);
        Ok(SystemPose { prediction, joints_m: [None; BODY_JOINTS] })
    }
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
