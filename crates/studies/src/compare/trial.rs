//! One system under one seed: evaluated and timed.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use crate::ablate::{Stages, networks};
use anyhow::{Context, Result};
use evpose_cli::json::{read_result, write_result};
use evpose_cli::machine::Machine;
use evpose_cli::run_info::COMMIT;
use evpose_core::stats::bootstrap::BootstrapConfig;
use evpose_core::stats::interval::Interval;
use evpose_task::body::BodyConfig;
use evpose_train::body::{
    BodyFrame, BodyFrames, BodyRecordings, evaluate_frames_with, mean_pose_of_recordings,
};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::compare::data::Data;
use crate::compare::measure::{Measure, PERCENTS};
use crate::compare::predictor::{ReadySystem, SystemPose};
use crate::compare::spatial::SeenJoints;
use crate::compare::system::{System, Weights};

/// Poses that are timed at most, and seconds that it takes at most.
const TIMED_POSES: usize = 50;
const TIMED_S: f64 = 3.0;

/// Results of a system under a seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Trial {
    pub(crate) system: String,
    pub(crate) seed: u64,
    commit: String,
    pub(crate) machine: String,
    /// SHA-256 of the file of weights, of systems that are run from one.
    pub(crate) weights: Option<String>,
    /// Images that were evaluated.
    images: usize,
    /// Shares of correct joints at [`PERCENTS`] of the torso.
    pub(crate) pck: [f64; PERCENTS.len()],
    /// At 1 %, 2 %, …, 100 %.
    pub(crate) curve: Vec<f64>,
    pub(crate) auc: f64,
    /// None if no joint was detected.
    pub(crate) mpjpe_px: Option<f64>,
    /// Of one camera where the system estimates depth, else triangulated where the data have two
    /// calibrated cameras.
    pub(crate) mpjpe_mm: Option<f64>,
    /// Poses per second on one thread, from image to joints: the median.
    pub(crate) poses_per_s: Option<f64>,
    /// Of its own training, without those it starts from.
    pub(crate) training_s: Option<f64>,
}

impl Trial {
    /// The value of a measure.
    pub(crate) fn value(&self, measure: Measure) -> Option<f64> {
        match measure {
            Measure::Pck40 => Some(self.pck[0]),
            Measure::Pck60 => Some(self.pck[1]),
            Measure::Pck80 => Some(self.pck[2]),
            Measure::Auc => Some(self.auc),
            Measure::MpjpePx => self.mpjpe_px,
            Measure::MpjpeMm => self.mpjpe_mm,
            Measure::PosesPerS => self.poses_per_s,
        }
    }
}

/// A system to evaluate, with the file of its weights if it is run from one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate<'a> {
    pub(crate) system: &'static System,
    pub(crate) file: Option<&'a Path>,
}

/// Evaluates a system under the seed of `stages`, unless results are stored.
pub(crate) fn run(
    out: &Path,
    data: &Data,
    candidate: &Candidate<'_>,
    stages: &Stages,
) -> Result<Trial> {
    let (system, seed) = (candidate.system, stages.finetune.seed);
    let path = out.join("systems").join(system.name).join(format!("seed-{seed}.json"));
    // By digest: a file may be replaced under the same name.
    let weights = candidate.file.map(digest_of).transpose()?;
    let stored: Option<Trial> = read_result(&path)?;
    // Another file of weights is another system.
    if let Some(trial) = stored.filter(|trial| trial.weights == weights) {
        return Ok(trial);
    }
    let experiment = experiment(system, stages);
    let ready = ready(out, data, candidate, stages)?;
    let frames = data.test_frames(out, stages, experiment)?;
    // Frames are predicted on several threads.
    let (errors_m, seen) = (Mutex::new(Vec::new()), Mutex::new(Vec::new()));
    let evaluation = evaluate_frames_with(
        &frames,
        || ready.start(),
        |predictor, frame| -> Result<_> {
            let pose = predictor.predict(frame)?;
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
            mean(&data.scenes(out, stages)?.errors_m(&seen)).map(|m| 1e3 * m)
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
    let trial = Trial {
        system: system.name.to_owned(),
        seed,
        commit: COMMIT.to_owned(),
        machine: Machine::this().cpu,
        weights,
        images: frames.len(),
        pck: pck.try_into().unwrap_or_default(),
        curve: scores.curve,
        auc: estimate(scores.auc).context("no pose could be evaluated")?,
        mpjpe_px: estimate(scores.mpjpe_px),
        mpjpe_mm,
        poses_per_s: match system.weights {
            Weights::MeanPose => None,
            _ => Some(poses_per_s(&ready, &frames)?),
        },
        training_s: match directory(out, system, seed) {
            Some(run) => networks::training_s(&run)?,
            None => None,
        },
    };
    std::fs::create_dir_all(path.parent().unwrap_or(out))
        .with_context(|| format!("creating {}", path.display()))?;
    write_result(&path, &trial)?;
    Ok(trial)
}

/// The run directory of a system that is trained here.
fn directory(out: &Path, system: &System, seed: u64) -> Option<PathBuf> {
    match system.weights {
        Weights::MoveEnet(network) => Some(networks::directory(out, network.name(), seed)),
        Weights::Baseline(_) => Some(networks::directory(out, system.name, seed)),
        Weights::File(_) | Weights::MeanPose => None,
    }
}

/// The experiment whose images a system is evaluated on.
fn experiment(system: &System, stages: &Stages) -> BodyConfig {
    match system.weights {
        Weights::Baseline(kind) => kind.config(stages).body(),
        _ => system.experiment(stages),
    }
}

fn ready(
    out: &Path,
    data: &Data,
    candidate: &Candidate<'_>,
    stages: &Stages,
) -> Result<ReadySystem> {
    let (system, seed) = (candidate.system, stages.finetune.seed);
    match (system.weights, directory(out, system, seed), candidate.file) {
        (Weights::MoveEnet(_), Some(run), _) => ReadySystem::move_enet(&run),
        (Weights::Baseline(_), Some(run), _) => ReadySystem::baseline(&run),
        (Weights::File(kind), _, Some(path)) => ReadySystem::file(kind, path),
        (Weights::MeanPose, ..) => {
            // The mean pose is that of the recordings that networks are trained on.
            if data.given_train().is_none() {
                evpose_cli::recorded::prepare(&stages.finetune, &data.train(out, seed))?;
            }
            let recordings = BodyRecordings::open(&data.train(out, seed))?;
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
            predictor.predict(frame)?;
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

/// SHA-256 of a file.
pub(crate) fn digest_of(path: &Path) -> Result<String> {
    let bytes = std::fs::read(path).with_context(|| format!("reading {}", path.display()))?;
    Ok(Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
pub(crate) mod tests {
    use evpose_core::{Micros, Plane};
    use evpose_pose::body::{BODY_JOINTS, BodyLabel};
    use evpose_pose::metric::body::BodyPrediction;
    use evpose_train::body::CameraJoints;
    use glam::Vec3;

    use super::*;

    /// A trial at a PCK@0.4.
    pub(crate) fn trial(system: &str, seed: u64, pck_40: f64) -> Trial {
        Trial {
            system: system.to_owned(),
            seed,
            commit: String::new(),
            machine: "a processor".to_owned(),
            weights: None,
            images: 10,
            pck: [pck_40, pck_40 + 0.1, pck_40 + 0.15],
            curve: vec![pck_40; 100],
            auc: pck_40,
            mpjpe_px: Some(6.5),
            mpjpe_mm: None,
            poses_per_s: Some(120.0),
            training_s: Some(60.0),
        }
    }

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
