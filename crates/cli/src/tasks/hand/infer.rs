//! `evpose infer` of hands.

use std::path::Path;

use crate::progress::{note, say};
use anyhow::{Result, bail, ensure};
use evpose_camera::Calibration;
use evpose_core::{Micros, SensorSize};
use evpose_io::Windows;
use evpose_io::poses::{
    HandRotationRow, POSE_FORMATS, PoseColumns, PoseKind, TimedPose, pose_format_of,
    write_hand_rotations, write_poses_from,
};
use evpose_nn::HandHead;
use evpose_pose::stream::InferenceSchedule;
use evpose_pose::{HandJoints, HandPose, JointFrame, PoseEstimate, PoseOrigin};
use evpose_task::hand::{HandConfig, PresenceCounts, calibration_for, hand_recording};

use super::HandNetwork;
use super::args::HandInferArgs;
use crate::tasks::args::{InferArgs, format_of};
use crate::tasks::{InferenceCounts, PoseScores, infer_all};

pub(super) fn run(model: &HandNetwork, args: &InferArgs, own: &HandInferArgs) -> Result<()> {
    let mut config = model.checkpoint.config.clone();
    if let Some(min_score) = own.min_score {
        let of_joints = config.network.head == HandHead::Joints;
        ensure!(of_joints, "--min-score is for networks of joints: a regressor sees a hand in all");
        config.detection.min_presence = min_score;
    }
    let config = &config;
    if own.rotations.is_some() {
        let of_joints = config.network.head == HandHead::Joints;
        ensure!(of_joints, "--rotations is for networks of joints: a regressor has 12 parameters");
    }
    let path = &*own.recording.events;
    // Before an inference of an hour.
    let format = format_of(own.recording.format, &args.out)?;
    if let Some(joints) = &own.joints {
        let is_table = pose_format_of(joints)?.name == POSE_FORMATS[0].name;
        ensure!(is_table, "--joints {}: it is a table: name it .csv", joints.display());
    }
    let windows = Windows::open(path, &args.opening.options_with_sensor(path)?)?;
    let calibration = calibration(config, windows.sensor(), own.own.camera.as_deref())?;
    let is_slow_motion = own.mode == "slow-motion";
    if is_slow_motion && args.stride_ms.is_some() {
        bail!("--stride-ms is for --mode plain: events trigger the inputs of slow motion");
    }
    let stride_ms = i64::from(args.stride_ms.unwrap_or(1).max(1));
    let schedule = match is_slow_motion {
        true => InferenceSchedule::Triggered,
        false => InferenceSchedule::Every(Micros(1_000 * stride_ms)),
    };
    let predictor = model.predictor(own.own.precision)?;
    let mut recording = hand_recording(config, predictor, windows, &calibration, schedule)?;
    if let Some(length_m) = own.length.metres() {
        recording.stream().frontend.hand_length(length_m);
    }
    let Some([start, end]) = recording.span()? else {
        bail!("{}: no events: there is nothing to infer from", path.display());
    };
    note_if_short(config, path, end - start);
    // What was inferred alone: points of the model of a long recording would not fit the memory.
    let mut rows: Vec<Row> = Vec::new();
    let mut repeated = 0_usize;
    let counts = infer_all(&mut recording, path, [start, end], |_, inferred| {
        repeated += inferred.poses.iter().filter(|(_, estimate)| estimate.is_repeated).count();
        rows.extend(inferred.skipped.into_iter().map(|t| Row { t, pose: None, delay_s: 0.0 }));
        let delay_s = inferred.delay_s;
        rows.extend(inferred.poses.into_iter().map(|(t, estimate)| {
            let of = if own.own.unfiltered { estimate.measured } else { estimate.filtered };
            Row { t, pose: Some(of), delay_s }
        }));
    })?;
    let frontend = &recording.stream().frontend;
    let timed = |row: &Row| match row.pose {
        None => TimedPose::nobody(PoseKind::Hand, row.t),
        Some(pose) => TimedPose {
            latency_ms: args.latency_ms(row.delay_s),
            ..TimedPose::new(row.t, &frontend.pose(pose)).with_origin(PoseOrigin::Network)
        },
    };
    // Those of nobody come first from each batch.
    rows.sort_by_key(|row| row.t);
    let frame = Some(JointFrame::Camera);
    write_poses_from(&args.out, PoseKind::Hand, frame, &mut rows.iter().map(timed), format)?;
    if let Some(path) = &own.joints {
        let columns = PoseColumns::of(PoseKind::Hand).without_params();
        columns.write(path, &mut rows.iter().map(timed))?;
    }
    if let Some(path) = &own.rotations {
        let of_joints = |row: &Row| Some((row.t, row.pose?, row.pose?.joints?));
        let row = |(t, pose, joints): (Micros, HandPose, HandJoints)| {
            let PoseEstimate::Hand { params: wrist, .. } = frontend.pose(pose) else {
                unreachable!("poses of hands are of hands")
            };
            HandRotationRow { t, wrist, rotations: joints.rotations }
        };
        write_hand_rotations(path, rows.iter().filter_map(of_joints).map(row))?;
    }
    if is_slow_motion {
        say(format!("slow motion: {} inputs, {repeated} repeated at rest", counts.inferred));
    }
    let PresenceCounts { absent, best, .. } = recording.stream().frontend.presence();
    // A regressor has no score: whoever is inferred is there.
    let scores = best.map(|_| PoseScores { best, min_score: config.detection.min_presence });
    let counts = InferenceCounts {
        too_few: counts.too_few - absent,
        inferred: counts.inferred + absent,
        ..counts
    };
    counts.check([path, &args.out], absent, scores)?;
    say(format!("{} poses: {}", counts.inferred - absent, args.out.display()));
    if let Some(path) = &own.joints {
        say(format!("joints: {}", path.display()));
    }
    if let Some(path) = &own.rotations {
        say(format!("rotations: {}", path.display()));
    }
    Ok(())
}

/// A time with a hand; none without one.
struct Row {
    t: Micros,
    pose: Option<HandPose>,
    delay_s: f64,
}

/// Says that a recording that `lasts` so long holds no full window of the network.
fn note_if_short(config: &HandConfig, path: &Path, lasts: Micros) {
    let window = config.representation.window();
    if lasts < window {
        note(format!(
            "note: {} lasts {:.1} ms, and a window of the network {:.0} ms: none is full, and poses are \
             less accurate",
            path.display(),
            1e3 * lasts.as_seconds(),
            1e3 * window.as_seconds()
        ));
    }
}

/// The camera of a recording; says what it assumes.
pub(super) fn calibration(
    config: &HandConfig,
    sensor: SensorSize,
    camera: Option<&str>,
) -> Result<Calibration> {
    let calibration = calibration_for(config, sensor, camera)?;
    if let Some(assumed) = &calibration.note {
        note(format!("note: {assumed}"));
    }
    Ok(calibration)
}
