//! One system under one seed: evaluated and timed.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use anyhow::{Context, Result};
use evpose_cli::machine::Machine;
use evpose_cli::run_info::COMMIT;
use evpose_core::stats::bootstrap::BootstrapConfig;
use evpose_core::stats::interval::Interval;
use evpose_task::body::BodyConfig;
use evpose_train::body::{
    BodyFrame, BodyFrames, BodyRecordings, evaluate_frames_with, mean_pose_of_recordings,
};
use serde::{Deserialize, Serialize};

use crate::compare::data::Data;
use crate::compare::networks;
use crate::compare::predictor::{ReadySystem, SystemPose};
use crate::compare::spatial::SeenJoints;
use crate::compare::stages::Stages;
use crate::compare::system::{System, Weights};
use crate::study::{Measure, Measured, StudyDirectory, measure, training_s};

/// Thresholds of the PCK, in percent of the torso's diagonal.
const PERCENTS: [usize; 3] = [40, 60, 80];
/// Poses that are timed at most, and seconds that it takes at most.
const TIMED_POSES: usize = 50;
const TIMED_S: f64 = 3.0;

/// Results of a system under a seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Trial {
    system: String,
    seed: u64,
    commit: String,
    machine: String,
    /// SHA-256 of the file of weights, of systems that are run from one.
    pub(crate) weights: Option<String>,
    /// Images that were evaluated.
    images: usize,
    /// Shares of correct joints at [`PERCENTS`] of the torso.
    pub(crate) pck: [f64; PERCENTS.len()],
    /// At 1 %, 2 %, …, 100 %.
    curve: Vec<f64>,
    auc: f64,
    /// None if no joint was detected.
    mpjpe_px: Option<f64>,
    /// Of one camera where the system estimates depth, else triangulated where the data have two
    /// calibrated cameras.
    mpjpe_mm: Option<f64>,
    /// Poses per second on one thread, from image to joints: the median.
    poses_per_s: Option<f64>,
    /// Of its own training, without those it starts from.
    training_s: Option<f64>,
}

impl Measured for Trial {
    const MEASURES: &'static [Measure<Self>] = &[
        measure(("pck_40", "PCK@0.4", 3, false), |trial| Some(trial.pck[0])),
        measure(("pck_60", "PCK@0.6", 3, false), |trial| Some(trial.pck[1])),
        measure(("pck_80", "PCK@0.8", 3, false), |trial| Some(trial.pck[2])),
        measure(("auc", "AUC", 3, false), |trial| Some(trial.auc)),
        measure(("mpjpe_px", "MPJPE px", 1, true), |trial| trial.mpjpe_px),
        measure(("mpjpe_mm", "MPJPE mm", 1, true), |trial| trial.mpjpe_mm),
        measure(("poses_per_s", "poses/s", 0, false), |trial| trial.poses_per_s),
        measure(("training_s", "training s", 0, true), |trial| trial.training_s),
    ];

    fn timed_on(&self) -> String {
        self.machine.clone()
    }

    fn curves(&self) -> Vec<(&'static str, &[f64])> {
        vec![("curve", &self.curve[..])]
    }
}

/// A system to evaluate under a seed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate<'a> {
    pub(crate) study: &'a StudyDirectory,
    pub(crate) data: &'a Data,
    pub(crate) system: &'static System,
    /// The file of its weights if it is run from one.
    pub(crate) file: Option<&'a Path>,
    pub(crate) stages: &'a Stages,
}

/// Evaluates a system, which is trained; `weights` is the digest of its file.
pub(crate) fn run(candidate: &Candidate<'_>, weights: Option<String>) -> Result<Trial> {
    let Candidate { study, data, system, stages, .. } = *candidate;
    let seed = stages.finetune.seed;
    let ready = ready(candidate)?;
    let frames = data.test_frames(study, stages, system.test, experiment(system, stages))?;
    // Frames are predicted on several threads.
    let (errors_m, seen) = (Mutex::new(Vec::new()), Mutex::new(Vec::new()));
    let evaluation = evaluate_frames_with(
        &frames,
        || ready.start(),
        |predictor, frame| -> Result<_> {
            let pose = predictor(frame)?;
            let mut errors_m = errors_m.lock().unwrap_or_else(PoisonError::into_inner);
            errors_m.extend(errors_of(frame, &pose));
            // Released first: no thread holds one lock while it waits for the other.
            drop(errors_m);
            let mut seen = seen.lock().unwrap_or_else(PoisonError::into_inner);
            seen.extend(SeenJoints::new(frame, pose.prediction.joints_px));
            Ok(pose.prediction)
        },
    )?;
    // Depths of one camera, where the system has them; otherwise several cameras are needed.
    let of_one_camera = mean_mm(errors_m.into_inner().unwrap_or_else(PoisonError::into_inner));
    let mpjpe_mm = match of_one_camera {
        Some(mm) => Some(mm),
        None => {
            let seen = seen.into_inner().unwrap_or_else(PoisonError::into_inner);
            mean(&data.scenes(study, stages, system.test)?.errors_m(&seen)).map(|m| 1e3 * m)
        }
    };
    // Intervals come from seeds, not from sequences.
    let bootstrap = BootstrapConfig { resamples: 0, seed: 0 };
    let scores = evaluation.summary(&PERCENTS, &bootstrap)?.raw;
    let estimate = |interval: Option<Interval>| interval.map(|interval| interval.estimate);
    let pck: Vec<f64> = scores
        .pck
        .iter()
        .map(|pck| estimate(*pck).context("no pose could be evaluated"))
        .collect::<Result<_>>()?;
    Ok(Trial {
        system: system.name.to_owned(),
        seed,
        commit: COMMIT.to_owned(),
        // Speeds are of one thread: whether two compare depends on the processor alone.
        machine: Machine::this().cpu,
        weights,
        images: frames.len(),
        pck: pck.try_into().unwrap_or_default(),
        curve: scores.curve,
        auc: estimate(scores.auc).context("no pose could be evaluated")?,
        mpjpe_px: estimate(scores.mpjpe_px),
        mpjpe_mm,
        poses_per_s: match system.weights {
            // A constant takes no time, and would lead the table of speeds.
            Weights::MeanPose => None,
            _ => Some(poses_per_s(&ready, &frames)?),
        },
        training_s: match directory(candidate) {
            Some(run) => training_s(&run)?,
            None => None,
        },
    })
}

/// The run directory of a system that is trained here.
fn directory(candidate: &Candidate<'_>) -> Option<PathBuf> {
    let Candidate { study, system, stages, .. } = candidate;
    let of = |name: &str| Some(networks::directory(study, name, stages.finetune.seed));
    match system.weights {
        Weights::MoveEnet(network) => of(network.name()),
        Weights::Baseline(_) => of(system.name),
        Weights::File(_) | Weights::MeanPose => None,
    }
}

fn experiment(system: &System, stages: &Stages) -> BodyConfig {
    match system.weights {
        Weights::Baseline(kind) => kind.config(stages).body(),
        _ => system.experiment(stages),
    }
}

fn ready(candidate: &Candidate<'_>) -> Result<ReadySystem> {
    let Candidate { study, data, system, file, stages } = *candidate;
    match (system.weights, directory(candidate), file) {
        (Weights::MoveEnet(_), Some(run), _) => ReadySystem::move_enet(&run),
        (Weights::Baseline(_), Some(run), _) => ReadySystem::baseline(&run),
        (Weights::File(kind), _, Some(path)) => ReadySystem::file(kind, path),
        (Weights::MeanPose, ..) => {
            // The mean pose is that of the recordings that networks are trained on.
            let recordings = BodyRecordings::open(&data.train(study, stages)?)?;
            Ok(ReadySystem::constant(mean_pose_of_recordings(&recordings)?))
        }
        _ => anyhow::bail!("{}: no weights", system.name),
    }
}

/// Distances of joints from the truth in the camera, in metres, with the index of the image, where both
/// are known.
fn errors_of(frame: &BodyFrame, pose: &SystemPose) -> Vec<((u64, i64), Vec<f32>)> {
    let Some(camera) = frame.camera else { return Vec::new() };
    let errors: Vec<f32> = pose
        .joints_m
        .iter()
        .zip(camera.joints_m)
        .filter_map(|(joint, truth)| Some(joint.as_ref()?.distance(truth)))
        // A joint without a label is NaN.
        .filter(|error| error.is_finite())
        .collect();
    if errors.is_empty() { Vec::new() } else { vec![((frame.sequence, frame.t.0), errors)] }
}

/// Mean in millimetres, in the order of images: the same on any number of threads.
fn mean_mm(mut errors_m: Vec<((u64, i64), Vec<f32>)>) -> Option<f64> {
    errors_m.sort_by_key(|(image, _)| *image);
    let errors_m: Vec<f32> = errors_m.into_iter().flat_map(|(_, errors)| errors).collect();
    mean(&errors_m).map(|m| 1e3 * m)
}

fn mean(values: &[f32]) -> Option<f64> {
    let sum: f64 = values.iter().map(|&value| f64::from(value)).sum();
    (!values.is_empty()).then(|| sum / values.len() as f64)
}

/// Poses per second on one thread, from the median of some poses.
fn poses_per_s(ready: &ReadySystem, frames: &BodyFrames) -> Result<f64> {
    let time = || -> Result<f64> {
        let mut predictor = ready.start();
        let mut seconds = Vec::new();
        let begin = Instant::now();
        for frame in frames.frames.iter().cycle().take(TIMED_POSES + 1) {
            let start = Instant::now();
            predictor(frame)?;
            seconds.push(start.elapsed().as_secs_f64());
            // A slow system is timed on fewer poses.
            if begin.elapsed().as_secs_f64() > TIMED_S && seconds.len() > 1 {
                break;
            }
        }
        // The first one touches memory for the first time.
        let timed = seconds.get_mut(1..).context("no image to time")?;
        timed.sort_by(f64::total_cmp);
        let median = timed.get(timed.len() / 2).context("no image to time")?;
        Ok(1.0 / median.max(f64::MIN_POSITIVE))
    };
    rayon::ThreadPoolBuilder::new().num_threads(1).build()?.install(time)
}

#[cfg(test)]
mod tests {
    use evpose_core::{Micros, Plane};
    use evpose_pose::body::{BODY_JOINTS, BodyLabel};
    use evpose_pose::metric::body::BodyPrediction;
    use evpose_train::body::CameraJoints;
    use glam::Vec3;

    use super::*;

    #[test]
    fn errors_in_space_are_means_over_joints_that_are_known() {
        let lens = evpose_core::LensCamera {
            focal_px: glam::DVec2::splat(300.0),
            principal_px: glam::DVec2::new(173.0, 130.0),
            distortion: evpose_core::Distortion::default(),
        };
        let sensor = evpose_core::SensorSize { width: 346, height: 260 };
        let mut joints_m = [Vec3::ZERO; BODY_JOINTS];
        joints_m[2] = Vec3::NAN;
        let frame = BodyFrame {
            image: Plane::for_sensor(sensor, 0),
            label: BodyLabel::default(),
            sequence: 3,
            t: Micros(5),
            camera: Some(CameraJoints { joints_m, lens, sensor }),
        };
        let prediction = BodyPrediction { t_s: 0.0, delay_s: 0.0, joints_px: [None; BODY_JOINTS] };
        let mut pose = SystemPose { prediction, joints_m: [None; BODY_JOINTS] };
        assert!(errors_of(&frame, &pose).is_empty());
        assert_eq!(mean_mm(Vec::new()), None);
        pose.joints_m[0] = Some(Vec3::new(0.0, 0.3, 0.4));
        pose.joints_m[1] = Some(Vec3::new(0.1, 0.0, 0.0));
        pose.joints_m[2] = Some(Vec3::ONE);
        let errors = errors_of(&frame, &pose);
        assert!(mean_mm(errors).is_some_and(|mm| (mm - 300.0).abs() < 1e-3));
    }
}
