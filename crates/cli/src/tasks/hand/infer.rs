//! `evpose infer` of hands.

use std::path::Path;

use crate::progress::{bar, note, say};
use anyhow::{Context, Result, bail};
use evpose_camera::ViewAdaptor;
use evpose_core::{EventStream, Micros, SensorSize, TimeWindow, atomic_write};
use evpose_io::Recording;
use evpose_io::poses::{PoseColumns, PoseKind, PoseSequence, TimedPose, write_poses};
use evpose_pose::{HandParams, PoseOrigin};
use evpose_task::hand::{
    HandConfig, HandEstimate, HandView, NetworkPredictor, SlowMotionTracker, calibration_for,
    canonical_view, poses_every_ms,
};

use super::HandModel;
use crate::tasks::args::InferArgs;

/// Event time of the packets of the slow-motion mode.
const PACKET: Micros = Micros(100_000);

pub(super) fn run(model: &HandModel, args: &InferArgs) -> Result<()> {
    let config = &model.checkpoint.config;
    let path = args.recording()?;
    let recording = evpose_io::open_as(path, &args.opening.options_with_sensor(path)?)?;
    warn(path, &recording);
    note_if_short(config, path, &recording.stream)?;
    let mut adaptor = adaptor(config, recording.stream.sensor(), args.camera.as_deref())?;
    let mut events = EventStream::empty(adaptor.view().sensor);
    adaptor.push(&recording.stream, &mut events);
    if adaptor.has_lost_polarities() {
        note(format!(
            "warning: {}: polarities say nothing, and a network of hands sees ON and OFF apart: poses \
             are less accurate",
            path.display()
        ));
    }
    let mut predictor = model.predictor(args.precision)?;
    let estimates = if args.mode == "slow-motion" {
        slow_motion(config, &events, &mut predictor)?
    } else {
        every_ms(config, &events, &mut predictor)?
    };
    let pose = |estimate: &HandEstimate| {
        (estimate.t, if args.unfiltered { estimate.measured } else { estimate.filtered })
    };
    let poses: Vec<(Micros, HandParams)> = estimates.iter().map(pose).collect();
    if poses.is_empty() {
        bail!(
            "{}: no pose: no window of {} ms has the events that {} needs",
            path.display(),
            config.representation.window_ms,
            args.mode
        );
    }

    let view = HandView::new(config)?.seen_by(&adaptor);
    // A network of both hands does not predict the side.
    let side = config.simulation.hands.side(0);
    let mut sequence = PoseSequence::new(PoseKind::Hand);
    for (t, params) in poses {
        let estimate = view.estimate(side, params);
        sequence
            .poses
            .push(TimedPose { origin: Some(PoseOrigin::Network), ..TimedPose::new(t, &estimate) });
    }
    write_poses(&args.out, &sequence, args.format)?;
    say(format!("{} poses: {}", sequence.poses.len(), args.out.display()));

    if let Some(path) = &args.joints {
        let columns = PoseColumns::of(PoseKind::Hand).without_params();
        let mut csv = columns.header();
        sequence.poses.iter().for_each(|pose| columns.push_line(&mut csv, pose));
        atomic_write(path, csv.as_bytes())
            .with_context(|| format!("writing {}", path.display()))?;
        say(format!("joints: {}", path.display()));
    }
    Ok(())
}

/// Says what was left out of a recording.
fn warn(path: &Path, recording: &Recording) {
    let (path, rejected) = (path.display(), recording.rejected);
    if rejected.total() > 0 {
        note(format!(
            "warning: {path}: left out {} events outside the sensor and {} out of order",
            rejected.outside_sensor, rejected.out_of_order
        ));
    }
    for remark in &recording.remarks {
        note(format!("warning: {path}: {remark}"));
    }
}

/// Says that a recording holds no full window of the network.
///
/// # Errors
/// If it holds no event.
fn note_if_short(config: &HandConfig, path: &Path, events: &EventStream) -> Result<()> {
    let path = path.display();
    let (Some(&first), Some(&last)) = (events.t().first(), events.t().last()) else {
        bail!("{path}: no events: there is nothing to infer from");
    };
    let (lasts, window) = (last - first, config.representation.window());
    if lasts < window {
        note(format!(
            "note: {path} lasts {:.1} ms, and a window of the network {:.0} ms: none is full, and \
             poses are less accurate",
            1e3 * lasts.as_seconds(),
            1e3 * window.as_seconds()
        ));
    }
    Ok(())
}

/// The map from a recording's camera to the view of the network; says what it assumes.
pub(super) fn adaptor(
    config: &HandConfig,
    sensor: SensorSize,
    camera: Option<&str>,
) -> Result<ViewAdaptor> {
    let calibration = calibration_for(config, sensor, camera)?;
    if let Some(assumed) = &calibration.note {
        note(format!("note: {assumed}"));
    }
    Ok(ViewAdaptor::new(&calibration, &canonical_view(config)))
}

/// Infers every millisecond.
fn every_ms(
    config: &HandConfig,
    events: &EventStream,
    predictor: &mut NetworkPredictor,
) -> Result<Vec<HandEstimate>> {
    let span_us = match (events.t().first(), events.t().last()) {
        (Some(&first), Some(&last)) => (last - first).0 as u64,
        _ => 0,
    };
    let poses = (span_us / 1000).saturating_sub(config.representation.window_ms.into());
    let progress = bar("inferring", poses, "poses");
    let mut done = |count| progress.inc(count as u64);
    let poses = poses_every_ms(config, events, predictor, &mut done)?;
    progress.finish_and_clear();
    Ok(poses)
}

/// Infers in the slow-motion mode; each pose has the time stamp of its input.
fn slow_motion(
    config: &HandConfig,
    events: &EventStream,
    predictor: &mut NetworkPredictor,
) -> Result<Vec<HandEstimate>> {
    let (Some(&first), Some(&last)) = (events.t().first(), events.t().last()) else {
        return Ok(Vec::new());
    };
    let mut tracker = SlowMotionTracker::new(config, events.sensor())?;
    let mut poses = Vec::new();
    let progress = bar("inferring", (last - first).0 as u64 / 1000, "ms");
    let mut start = first;
    while start <= last {
        let end = start + PACKET;
        tracker.push(&events.slice(TimeWindow { start, end }), predictor, &mut poses)?;
        start = end;
        progress.inc(PACKET.0 as u64 / 1000);
    }
    tracker.finish(predictor, &mut poses)?;
    progress.finish_and_clear();
    let repeated = poses.iter().filter(|pose| pose.is_repeated).count();
    say(format!("slow motion: {} inputs, {repeated} repeated at rest", poses.len()));
    Ok(poses)
}
