//! `evpose eval` scores the poses that `evpose infer` writes: recordings with rests, gaps and late starts.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use burn::tensor::Device;
use evpose_core::{Event, EventStream, Micros};
use evpose_io::poses::{TimedPose, read_poses};
use evpose_io::{MetaReader, MetaWriter};
use evpose_pose::metric::body::BodyPrediction;
use evpose_sim::person::PoseTable;
use evpose_task::baseline::BaselineCheckpoint;
use evpose_task::body::{BodyCheckpoint, BodyPredictor, BodyPredictorOptions};
use evpose_task::hand::HandCheckpoint;
use evpose_train::baseline::evaluate_baseline;
use evpose_train::body::{BodyRecordings, evaluate_body};
use evpose_train::{HandDataset, HandPoseTrack, Method, evaluate, evaluate_slow_motion};

use crate::baselines::{BASELINES, baseline_config};
use crate::harness::{Sandbox, shipped, tiny_body};

/// A silence that parts a recording.
const GAP: Micros = Micros(12_000_000);

/// A change of a recording: which events stay, and how much later an event or a label is.
type Change = (&'static str, fn(Micros) -> bool, fn(Micros) -> Micros);

const CHANGES: [Change; 4] = [
    ("plain", |_| true, |t| t),
    ("late", |t| t.0 >= 153_400, |t| t),
    ("rest", |t| !(250_000..420_000).contains(&t.0), |t| t),
    ("gap", |_| true, |t| if t.0 < 330_000 { t } else { t + GAP }),
];

/// Writes the recording `from` with a change to `to`.
fn change_events(from: &Path, to: &Path, (_, stays, moved): Change) {
    let events = evpose_io::open(from).unwrap().stream;
    let changed = events.iter().filter(|event| stays(event.t));
    let changed = changed.map(|event| Event { t: moved(event.t), ..event });
    let changed = EventStream::from_events(events.sensor(), changed).unwrap();
    evpose_io::FORMATS.find("evt3").unwrap().write(to, &changed).unwrap();
}

/// Writes the recording of people in `data` with a change, and its labels, to the folder `name`. The file of
/// events, and the time of the last label.
fn change_people(
    sandbox: &Sandbox,
    name: &str,
    labels: &PoseTable,
    change: Change,
) -> (PathBuf, Micros) {
    let folder = sandbox.path(name);
    std::fs::create_dir(&folder).unwrap();
    let recording = folder.join("0000.raw");
    change_events(&sandbox.path("data/0000.raw"), &recording, change);
    let mut table = labels.clone();
    // Labels move with the events.
    table.rows.iter_mut().for_each(|row| row.t = change.2(row.t));
    table.write(&folder.join("0000.poses.csv")).unwrap();
    (recording, table.rows.last().unwrap().t)
}

/// The poses that `evpose infer` writes of a recording, by their time stamps.
fn infer(
    sandbox: &Sandbox,
    network: &str,
    events: &Path,
    more: &[&str],
) -> BTreeMap<i64, TimedPose> {
    let events = events.to_str().unwrap();
    let infer = ["infer", "--checkpoint", network, "--events", events, "--out", "poses.csv"];
    sandbox.ok(&[&infer[..], more].concat());
    let poses = read_poses(&sandbox.path("poses.csv")).unwrap().poses;
    // Rows of nobody have no pose; those of people below the threshold are scored.
    let poses = poses.into_iter().filter(|pose| !pose.is_nobody() || pose.score.is_some());
    poses.map(|pose| (pose.t.0, pose)).collect()
}

/// That predictions are the poses written, to the last digit of the file, and all those from `first_us` to
/// `end`. How many joints they have.
fn same_people(
    predictions: &[BodyPrediction],
    written: &BTreeMap<i64, TimedPose>,
    first_us: i64,
    end: Micros,
) -> usize {
    let mut found = 0;
    for prediction in predictions {
        let t = Micros::from_seconds(prediction.t_s);
        let none = TimedPose::empty(evpose_io::poses::PoseKind::Body, t);
        let pose = written.get(&t.0).unwrap_or(&none);
        // The file has three decimals.
        let rounded = prediction
            .joints_px
            .map(|at| at.map(|at| at.to_array().map(|px| format!("{px:.3}").parse().unwrap())));
        assert_eq!(pose.body_px().map(|at| at.map(|at| at.to_array())), rounded, "at {t}");
        found += rounded.iter().flatten().count();
    }
    let scored = written.range(first_us..=end.0).count();
    assert!(scored <= predictions.len(), "{scored} of {}", predictions.len());
    found
}

/// A table holds every bit of a hand's parameters.
#[test]
fn hands_are_scored_by_the_poses_that_are_written() {
    let sandbox = Sandbox::new();
    let simulate = ["simulate", "quick", "--held-out", "--sequences", "1", "--seconds", "0.7"];
    sandbox.ok(&[&simulate[..], &["--out", "data"]].concat());
    let labels = MetaReader::open(sandbox.path("data/0000.meta")).unwrap();
    let mut checkpoint =
        HandCheckpoint::load(Path::new(&shipped("hand-quick.bpk")), &Device::flex()).unwrap();
    // Intervals are not compared here, and resampling them takes time.
    checkpoint.config.evaluation.bootstrap.resamples = 0;
    let config = &checkpoint.config;
    for change in CHANGES {
        let (name, _, moved) = change;
        let folder = sandbox.path(name);
        std::fs::create_dir(&folder).unwrap();
        let recording = folder.join("0000.raw");
        change_events(&sandbox.path("data/0000.evc"), &recording, change);
        // In a gap, the last pose stands.
        let mut writer = MetaWriter::create_for_hands(folder.join("0000.meta")).unwrap();
        for k in 0..labels.records() {
            let pose = labels.read_hand(k).unwrap();
            while writer.records() <= moved(Micros(1_000 * k as i64)).0 as u64 / 1_000 {
                writer.hand(&pose).unwrap();
            }
        }
        writer.finish().unwrap();
        let data = HandDataset::open(&folder, config).unwrap();
        let mut network = checkpoint.predictor(Device::flex()).unwrap();
        let same = |track: &HandPoseTrack, more: &[&str], at_least: usize| {
            let written = infer(&sandbox, &shipped("hand-quick.bpk"), &recording, more);
            assert!(track.frames.len() >= at_least, "{name}: {}", track.frames.len());
            for (frame, pose) in track.frames.iter().zip(&track.poses) {
                let t = 1_000 * (*frame as i64 + 1);
                let written = written.get(&t).and_then(|pose| pose.params);
                assert_eq!(written, Some(pose.params), "{name} at {t} {more:?}");
            }
            // All of them are scored, from the first window on.
            let first = 1_000 * (i64::from(config.evaluation.first_ms) + 1);
            let end = 1_000 * data.sequences()[0].frames() as i64;
            let scored = written.range(first..=end).count();
            assert!(scored == track.frames.len(), "{name}: {scored}");
        };
        for stride in [1, 7] {
            let mut methods = [Method {
                name: "trained",
                predictor: &mut network,
                filtered: Some("trained_kalman"),
            }];
            let stride_ms = stride.to_string();
            let results = evaluate(config, &data, &mut methods, stride, &mut |_| {}).unwrap();
            let [measured, filtered] = [0, 1].map(|k| &results[k].tracks[0]);
            let stride_args = ["--stride-ms", &stride_ms];
            same(filtered, &stride_args, 200 / stride as usize);
            same(measured, &[&stride_args[..], &["--unfiltered"]].concat(), 200 / stride as usize);
        }
        let slow = evaluate_slow_motion(config, &data, &mut network, 1, &mut |_| {}).unwrap();
        let slow_motion = ["--mode", "slow-motion"];
        let written = infer(&sandbox, &shipped("hand-quick.bpk"), &recording, &slow_motion);
        let HandPoseTrack { frames, poses } = &slow.methods[0].tracks[0];
        assert!(frames.len() > 200, "{name}: {}", frames.len());
        for (frame, pose) in frames.iter().zip(poses) {
            let newest = written.range(..1_000 * (*frame as i64 + 1)).next_back();
            assert_eq!(
                newest.and_then(|(_, pose)| pose.params),
                Some(pose.params),
                "{name} at {frame}"
            );
        }
    }
}

/// To the last digit that is written.
#[test]
fn people_are_scored_by_the_poses_that_are_written() {
    let sandbox = Sandbox::new();
    let simulate = ["simulate", "finetune", "--held-out", "--sequences", "1", "--seconds", "0.8"];
    let changes = ["--set", "simulation.step_hz=250", "--set", "simulation.label_hz=50"];
    let size = ["--set", "simulation.sensor_size={ width = 160, height = 120 }", "--out", "data"];
    sandbox.ok(&[&simulate[..], &changes, &size].concat());
    let labels = PoseTable::read(&sandbox.path("data/0000.poses.csv")).unwrap();
    let checkpoint =
        BodyCheckpoint::load(Path::new(&shipped("body-quick.bpk")), &Device::flex()).unwrap();
    let options = BodyPredictorOptions::default();
    let predictor = BodyPredictor::new(&checkpoint, options, None).unwrap();
    let first_us = 1_000 * i64::from(checkpoint.config.data.first_ms);
    for change in CHANGES {
        let name = change.0;
        let (recording, end) = change_people(&sandbox, name, &labels, change);
        let folder = sandbox.path(name);
        let recordings = BodyRecordings::open(&folder).unwrap();
        let every = Micros(20_000);
        let mean = Default::default();
        let results =
            evaluate_body(&checkpoint, &predictor, &recordings, every, None, &mean, &|_| {})
                .unwrap();
        let result = &results.recordings[0];
        let same = |predictions: &[BodyPrediction], more: &[&str]| {
            let more = [&["--stride-ms", "20"], more].concat();
            let written = infer(&sandbox, &shipped("body-quick.bpk"), &recording, &more);
            assert!(predictions.len() > 10, "{name}: {}", predictions.len());
            let found = same_people(predictions, &written, first_us, end);
            // Equal without joints would show nothing.
            assert!(found > 50, "{name}: {found} joints");
        };
        same(&result.predictions, &["--unfiltered"]);
        same(&result.filtered_predictions, &[]);
    }
}

#[test]
fn baselines_are_scored_by_the_poses_that_are_written() {
    let sandbox = Sandbox::new();
    let still = ["--set", "simulation.moving_cameras=0"];
    sandbox.ok(&[&tiny_body(&["simulate", "finetune", "--out", "data"])[..], &still].concat());
    let labels = PoseTable::read(&sandbox.path("data/0000.poses.csv")).unwrap();
    for (kind, shape) in BASELINES {
        sandbox.write("baseline.toml", baseline_config(kind, shape));
        let train = format!("train baseline.toml --data data --out {kind} --plain");
        // So short a training leaves no joint above the usual threshold.
        sandbox.run(&train, &["--set", "decoding.confidence=0"]);
        let network = sandbox.path(kind);
        let checkpoint = BaselineCheckpoint::load(&network, &Device::flex()).unwrap();
        let first_us = 1_000 * i64::from(checkpoint.config.data.first_ms);
        for change in CHANGES {
            let name = format!("{kind}-{}", change.0);
            let (recording, end) = change_people(&sandbox, &name, &labels, change);
            let recordings = BodyRecordings::open(&sandbox.path(&name)).unwrap();
            let every = Micros(20_000);
            let (_, predictions) =
                evaluate_baseline(&checkpoint, &recordings, every, &|_| {}).unwrap();
            let stride = ["--stride-ms", "20"];
            let written = infer(&sandbox, network.to_str().unwrap(), &recording, &stride);
            assert!(predictions[0].len() > 3, "{name}: {}", predictions[0].len());
            let found = same_people(&predictions[0], &written, first_us, end);
            assert!(found > 20, "{name}: {found} joints");
        }
    }
}
