//! The networks that MoveEnet is compared with: trained, resumed and evaluated on simulated people.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use burn::tensor::Device;
use evpose_core::{Micros, SensorSize};
use evpose_io::{OpenOptions, Windows};
use evpose_nn::{BaselineNetworkConfig, DeviceKind, Dhp19CnnConfig, LiftMonoConfig};
use evpose_pose::stream::InferenceSchedule;
use evpose_sim::Shard;
use evpose_sim::person::{People, PeopleConfig, record_people};
use evpose_task::RecordingStream;
use evpose_task::baseline::{BaselineCheckpoint, BaselineConfig, baseline_stream};
use evpose_task::body::LabelTime;
use evpose_train::baseline::{baseline_frames, train_baseline};
use evpose_train::body::BodyRecordings;
use evpose_train::{HistorySplit, TrainOptions, read_history};

/// Three recordings of 0.5 s from cameras that stand still, and one directory with one that moves.
fn recordings() -> &'static (tempfile::TempDir, PathBuf, PathBuf) {
    static RECORDINGS: OnceLock<(tempfile::TempDir, PathBuf, PathBuf)> = OnceLock::new();
    RECORDINGS.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let simulate = |name: &str, sequences: usize, moving_cameras: f32| {
            let config = PeopleConfig {
                sequences,
                seconds: 0.5,
                sensor_size: SensorSize { width: 64, height: 48 },
                moving_cameras,
                ..PeopleConfig::default()
            };
            let directory = folder.path().join(name);
            let people = People::new(&config, 5).unwrap();
            record_people(&people, &directory, Shard::WHOLE, &|_| {}).unwrap();
            directory
        };
        let (still, moving) = (simulate("still", 3, 0.0), simulate("moving", 1, 1.0));
        (folder, still, moving)
    })
}

fn small(config: BaselineConfig, network: BaselineNetworkConfig, steps: u64) -> BaselineConfig {
    let mut config = config.with_size(64, 48);
    config.network = network;
    config.image.representation = "fixed-count:n=400".to_owned();
    config.data.label_at = LabelTime::MeanOf(400);
    (config.data.first_ms, config.data.every_ms) = (100, 20);
    config.data.validation_share = 0.3;
    config.training.batch_size = 4;
    config.training.validation_samples = 8;
    (config.training.steps, config.training.steps_per_validation) = (steps, steps / 2);
    config
}

fn cnn(steps: u64) -> BaselineConfig {
    let network = Dhp19CnnConfig { width: 0.25, ..Dhp19CnnConfig::default() };
    small(BaselineConfig::dhp19_cnn(), BaselineNetworkConfig::Dhp19Cnn(network), steps)
}

fn lift(steps: u64) -> BaselineConfig {
    let network = LiftMonoConfig { width: 0.125, stages: 2, ..LiftMonoConfig::default() };
    let mut config =
        small(BaselineConfig::lift_mono(), BaselineNetworkConfig::LiftMono(network), steps);
    config.training.learning_rate = 3e-3;
    config
}

fn train(config: &BaselineConfig, run: &Path, resume: bool) -> BaselineCheckpoint {
    let (_, data, _) = recordings();
    let frames = baseline_frames(config, data, &|_| {}).unwrap();
    let options = TrainOptions { resume, ..TrainOptions::new(DeviceKind::Flex) };
    train_baseline(config, frames, run, &options).unwrap().best
}

/// The mean of a logged value over the training samples of the first and of the second interval.
fn in_training(run: &Path, field: &str) -> [f64; 2] {
    let history = read_history(&run.join("metrics.jsonl")).unwrap();
    [1, 2].map(|interval| {
        let lines = history
            .iter()
            .filter(|line| line.part == HistorySplit::Train && line.interval == interval);
        let (sum, samples) = lines.fold((0.0, 0.0), |(sum, samples), line| {
            let weight = line.samples as f64;
            (sum + weight * line.values[field], samples + weight)
        });
        sum / samples
    })
}

#[test]
fn a_network_of_dhp19_learns_and_finds_joints_on_the_sensor() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("cnn");
    train(&cnn(16), &run, false);
    // Black heatmaps are nearly right: what is learnt first shows in where they are largest.
    let [first, second] = in_training(&run, "error_px");
    assert!(second < first, "{first} to {second}");
    let mut checkpoint = BaselineCheckpoint::load(&run, &Device::flex()).unwrap();
    assert_eq!(checkpoint.config, cnn(16));
    // After so few steps no heatmap reaches its threshold.
    checkpoint.config.decoding.confidence = 0.0;
    let (_, data, _) = recordings();
    let recordings = BodyRecordings::open(data).unwrap();
    let mut poses = Vec::new();
    for (events, _) in &recordings.files {
        let windows = Windows::open(events, &OpenOptions::default()).unwrap();
        let stream = baseline_stream(&checkpoint, windows.sensor(), None).unwrap();
        let every = InferenceSchedule::Every(Micros(100_000));
        for inferred in RecordingStream::new(windows, stream, every) {
            poses.extend(inferred.unwrap().poses.into_iter().map(|(_, pose)| pose));
        }
    }
    assert!(poses.iter().all(|pose| pose.joints_m.iter().all(Option::is_none)), "no depth");
    let mut found = poses.iter().flat_map(|pose| pose.joints_px.iter().flatten()).peekable();
    assert!(found.peek().is_some());
    assert!(found.all(|at| (0.0..=64.0).contains(&at.x) && (0.0..=48.0).contains(&at.y)));
}

#[test]
fn lift_mono_learns_and_places_joints_in_metres() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("lift");
    let best = train(&lift(24), &run, false);
    let [first, second] = in_training(&run, "loss");
    assert!(second < first, "{first} to {second}");
    assert!(best.torso_m.is_some_and(|torso_m| (0.3..0.7).contains(&torso_m)), "{best:?}");
    let [nearest_m, farthest_m] = best.depths_m.unwrap();
    assert!(1.0 < nearest_m && nearest_m <= farthest_m && farthest_m < 10.0, "{best:?}");
    let (_, data, _) = recordings();
    let recordings = BodyRecordings::open(data).unwrap();
    let frames = baseline_frames(&lift(24), data, &|_| {}).unwrap();
    let camera = frames.frames[0].camera.unwrap();
    // Without a camera the same joints on the image, in metres by a guess.
    let [pose, guess] = [Some(camera.lens), None].map(|lens| {
        let windows = Windows::open(&recordings.files[0].0, &OpenOptions::default()).unwrap();
        let stream = baseline_stream(&best, windows.sensor(), lens).unwrap();
        let every = InferenceSchedule::Every(Micros(100_000));
        let inferred = RecordingStream::new(windows, stream, every).next().unwrap().unwrap();
        inferred.poses[0].1
    });
    assert_eq!(pose.joints_px, guess.joints_px);
    assert_ne!(pose.joints_m, guess.joints_m);
    // The depths of the training bound the error of whatever was learnt.
    let pairs = pose.joints_m.iter().zip(camera.joints_m);
    let errors: Vec<f32> = pairs.filter_map(|(at, truth)| Some((*at)?.distance(truth))).collect();
    let mpjpe_m = errors.iter().sum::<f32>() / errors.len() as f32;
    assert!((0.01..5.0).contains(&mpjpe_m), "{mpjpe_m}");
}

#[test]
fn a_run_that_was_stopped_ends_with_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for (name, config) in [("cnn", cnn(4)), ("lift", lift(2))] {
        let [whole, stopped] = ["whole", "stopped"].map(|kind| folder.path().join(name).join(kind));
        train(&config, &whole, false);
        std::fs::create_dir_all(stopped.join("checkpoint")).unwrap();
        let copy = |name: &str| std::fs::copy(whole.join(name), stopped.join(name)).unwrap();
        copy("config.toml");
        copy("metrics.jsonl");
        copy("loading.jsonl");
        for entry in std::fs::read_dir(whole.join("checkpoint")).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            // Without the second interval, a run stands where a crash after the first leaves it.
            if !name.contains("-2.") {
                copy(&format!("checkpoint/{name}"));
            }
        }
        train(&config, &stopped, true);
        for file in ["best.bpk", "last.bpk"] {
            let bytes = [&whole, &stopped].map(|run| std::fs::read(run.join(file)).unwrap());
            assert!(bytes[0] == bytes[1], "{name}: {file}");
        }
    }
}

#[test]
fn lift_mono_needs_cameras_that_stand_still() {
    let (_, still, moving) = recordings();
    let error = baseline_frames(&lift(4), moving, &|_| {}).unwrap_err().to_string();
    assert!(error.contains("simulation.moving_cameras = 0"), "{error}");
    assert!(!baseline_frames(&cnn(4), moving, &|_| {}).unwrap().is_empty());
    let frames = baseline_frames(&lift(4), still, &|_| {}).unwrap();
    let frame = &frames.frames[0];
    // The joints in the camera are those on the image.
    let camera = frame.camera.unwrap();
    for (joint_m, keypoint) in camera.joints_m.iter().zip(&frame.label.keypoints) {
        let at = camera.lens.image_from_camera(joint_m.as_dvec3()).unwrap().as_vec2();
        let label_px = keypoint.position * glam::Vec2::new(64.0, 48.0);
        assert!(!keypoint.is_labelled() || at.distance(label_px) < 0.1, "{at} {label_px}");
    }
}
