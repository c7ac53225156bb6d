//! `evpose infer` of bodies.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use burn::tensor::Device;
use evpose_camera::Calibration;
use evpose_core::Micros;
use evpose_io::Windows;
use evpose_io::poses::{
    POSE_FORMATS, PoseFormat, PoseKind, PoseSequence, TimedPose, write_poses, write_poses_from,
};
use evpose_pose::PoseOrigin;
use evpose_pose::stream::{InferenceSchedule, StreamFrontend as _};
use evpose_task::body::{
    BodyFrontend, BodyPredictorOptions, BodyWorker, PropagationConfig, body_stream,
};
use evpose_task::{InferredPoses, RecordingStream};
use evpose_train::body::{PropagatedPose, propagated_poses};

use super::args::BodyInferArgs;
use super::{BodyNetwork, infer_cameras};
use crate::progress::say;
use crate::tasks::args::{InferArgs, format_of};
use crate::tasks::{PoseScores, infer_all, online};

type BodyRecording = RecordingStream<BodyFrontend, BodyWorker>;

pub(super) fn run(model: &BodyNetwork, args: &InferArgs, own: &BodyInferArgs) -> Result<()> {
    let checkpoint = &model.checkpoint;
    let [events] = &own.events[..] else { return infer_cameras::run(model, args, own) };
    // Before an inference of an hour.
    let format = format_of(own.format, &args.out)?;
    own.fused.as_deref().map(|path| format_of(own.format, path)).transpose()?;
    ensure!(
        own.cameras.is_none(),
        "--cameras is for several recordings, and one recording is given"
    );
    let options = BodyPredictorOptions {
        precision: own.own.precision,
        threads: rayon::current_num_threads(),
        confidence: own.confidence,
        consensus: own.consensus,
    };
    let mut predictor = model.predictor(options)?;
    let batch = online::batch(own.batch, &model.device);
    if model.device != Device::flex() {
        // A GPU compiles its kernels at the first call, which is no latency of a pose.
        predictor.warm_up(batch);
    }
    let opening = args.opening.options_with_sensor(events)?;
    let stride_ms = args.stride_ms.unwrap_or(checkpoint.config.evaluation.every_ms);
    let step = Micros(1_000 * i64::from(stride_ms.max(1)));
    // Propagated poses take a second pass over the recording, which opens it again.
    let open = |propagation: Option<&PropagationConfig>| -> Result<BodyRecording> {
        let windows = Windows::open(events, &opening)?;
        let calibration = Calibration::choose(own.own.camera.as_deref(), windows.sensor())?;
        let mut stream = body_stream(checkpoint, &calibration, propagation, predictor.another())?;
        if propagation.is_none() {
            // Propagation goes on from one pose to the next.
            stream.frontend = stream.frontend.with_batch(batch);
        }
        if let Some(min_score) = own.min_score {
            stream.frontend = stream.frontend.with_min_score(min_score);
        }
        if !own.own.unfiltered {
            stream.frontend = stream.frontend.with_filter(checkpoint.config.filter)?;
        }
        Ok(RecordingStream::new(windows, stream, InferenceSchedule::Every(step)))
    };
    let mut recording = open(None)?;
    let Some([start, end]) = recording.span()? else { bail!("{}: no events", events.display()) };
    ensure!(
        start + step <= end,
        "{} lasts {:.1} ms, and the first pose is at {stride_ms} ms: record for longer, or set a \
         smaller --stride-ms",
        events.display(),
        1e3 * (end - start).as_seconds()
    );
    let mut poses = PoseSequence::new(PoseKind::Body);
    let mut delay_s = 0.0;
    let counts = infer_all(&mut recording, events, [start, end], |frontend, inferred| {
        let InferredPoses { poses: inferred, skipped, delay_s: own_s, .. } = inferred;
        delay_s += own_s;
        let nobody = skipped.into_iter().map(|t| TimedPose::nobody(PoseKind::Body, t));
        poses.poses.extend(nobody);
        poses.poses.extend(inferred.iter().map(|(t, pose)| TimedPose {
            // A pose is known when its whole batch is.
            latency_ms: args.latency_ms(own_s),
            ..TimedPose::new(*t, &frontend.estimate(pose)).with_origin(PoseOrigin::Network)
        }));
    })?;
    write_poses(&args.out, &poses, format)?;
    let scored = poses.poses.iter().filter(|pose| pose.score.is_some());
    let nobody = scored.filter(|pose| pose.is_nobody()).count() as u64;
    let scores = PoseScores {
        best: poses.poses.iter().filter_map(|pose| pose.score).reduce(f32::max),
        min_score: own.min_score.unwrap_or(checkpoint.config.detection.min_score),
    };
    let of_nobody = match nobody {
        0 => String::new(),
        nobody => format!(", {nobody} of them of nobody"),
    };
    let together = if batch > 1 { format!(" in batches of {batch}") } else { String::new() };
    say(format!(
        "{} poses{of_nobody}, {:.2} ms each{together}: {}",
        counts.inferred,
        1e3 * delay_s / counts.inferred.max(1) as f64,
        args.out.display()
    ));
    if let Some(folder) = &own.skeletons {
        write_poses(folder, &poses, skeletons_format()?)?;
        say(format!("skeletons: {}", folder.display()));
    }
    if let Some(path) = &own.fused {
        write_propagated((path, format_of(own.format, path)?), args, &open, stride_ms)?;
    }
    // Behind all that was to be written: nobody in view is an error.
    counts.check([events, &args.out], nobody, Some(scores))
}

fn skeletons_format() -> Result<&'static PoseFormat> {
    POSE_FORMATS.find("yarp").context("no format of skeletons")
}

/// Writes poses at the output rate, propagated by velocities from events.
fn write_propagated(
    (path, format): (&Path, &PoseFormat),
    args: &InferArgs,
    open: &dyn Fn(Option<&PropagationConfig>) -> Result<BodyRecording>,
    stride_ms: u32,
) -> Result<()> {
    let config = PropagationConfig {
        network_hz: 1e3 / f64::from(stride_ms.max(1)),
        // Offline, an inference counts at its own time: there is no latency to bridge.
        latency_ms: 0.0,
        ..PropagationConfig::default()
    };
    let mut recording = open(Some(&config))?;
    let [start, end] = recording.span()?.context("no events")?;
    let (mut count, mut failed) = (0_u64, None);
    // An hour of them would not fit the memory: they are made while they are written.
    let poses = propagated_poses(&mut recording, &config, (start, end));
    let poses = poses.map_while(|pose| pose.map_err(|error| failed = Some(error)).ok());
    let timed = |pose: PropagatedPose| {
        count += 1;
        let t = Micros::from_seconds(pose.t_s);
        // There is nothing to propagate before the first inference.
        pose.estimate.map_or_else(
            || TimedPose::nobody(PoseKind::Body, t),
            |estimate| TimedPose {
                latency_ms: args.latency_ms(0.0),
                origin: Some(PoseOrigin::Propagated),
                ..TimedPose::new(t, &estimate)
            },
        )
    };
    write_poses_from(path, PoseKind::Body, None, &mut poses.map(timed), format)?;
    if let Some(error) = failed {
        let path = path.display();
        return Err(error).with_context(|| format!("after {count} poses, which are in {path}"));
    }
    say(format!("{count} propagated poses, {} per second: {}", config.output_hz, path.display()));
    Ok(())
}
