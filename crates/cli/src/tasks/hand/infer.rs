//! `evpose infer` of hands.

use std::path::Path;

use crate::progress::{note, say};
use anyhow::{Result, bail};
use evpose_camera::Calibration;
use evpose_core::{Micros, SensorSize};
use evpose_io::Windows;
use evpose_io::poses::{PoseColumns, PoseKind, TimedPose, write_poses_from};
use evpose_pose::stream::InferenceSchedule;
use evpose_pose::{HandParams, JointFrame, PoseOrigin};
use evpose_task::hand::{HandConfig, calibration_for, hand_recording};

use super::HandModel;
use super::args::HandInferArgs;
use crate::tasks::args::InferArgs;
use crate::tasks::infer_all;

pub(super) fn run(model: &HandModel, args: &InferArgs, own: &HandInferArgs) -> Result<()> {
    let config = &model.checkpoint.config;
    let path = args.recording()?;
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
    let Some([start, end]) = recording.span()? else {
        bail!("{}: no events: there is nothing to infer from", path.display());
    };
    note_if_short(config, path, end - start);
    // Parameters alone: joints of a long recording would not fit the memory.
    let mut poses: Vec<(Micros, HandParams)> = Vec::new();
    let mut repeated = 0_usize;
    infer_all(&mut recording, path, [start, end], |_, inferred| {
        repeated += inferred.poses.iter().filter(|(_, estimate)| estimate.is_repeated).count();
        poses.extend(inferred.poses.into_iter().map(|(t, estimate)| {
            (t, if own.own.unfiltered { estimate.measured } else { estimate.filtered })
        }));
    })?;
    if poses.is_empty() {
        bail!(
            "{}: no pose: no window of {} ms has the events that {} needs",
            path.display(),
            config.representation.window_ms,
            own.mode
        );
    }
    if is_slow_motion {
        say(format!("slow motion: {} inputs, {repeated} repeated at rest", poses.len()));
    }
    let frontend = &recording.stream().frontend;
    let timed = |(t, params): &(Micros, HandParams)| TimedPose {
        origin: Some(PoseOrigin::Network),
        ..TimedPose::new(*t, &frontend.pose(*params))
    };
    let frame = Some(JointFrame::Camera);
    write_poses_from(&args.out, PoseKind::Hand, frame, &mut poses.iter().map(timed), args.format)?;
    say(format!("{} poses: {}", poses.len(), args.out.display()));
    if let Some(path) = &own.joints {
        let columns = PoseColumns::of(PoseKind::Hand).without_params();
        columns.write(path, &mut poses.iter().map(timed))?;
        say(format!("joints: {}", path.display()));
    }
    Ok(())
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
