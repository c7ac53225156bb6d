//! `evpose infer` of bodies.

use std::path::Path;

use anyhow::{Result, bail, ensure};
use evpose_core::Micros;
use evpose_io::Windows;
use evpose_io::predictions::{DelayUnit, PredictionWriter, Undetected};
use evpose_io::yarp::{CoordinateFormat, YarpSkeleton, write_skeletons};
use evpose_pose::body::{file_from_network, torso};
use evpose_pose::metric::body::BodyPrediction;
use evpose_task::body::{BodyPredictorOptions, BodyRecordingStream, PropagationConfig};
use evpose_train::body::propagated_poses;
use evpose_view::Calibration;

use super::BodyModel;
use crate::args::InferArgs;
use evpose_app::progress::{bar, note, say};

/// Channel of the skeletons of a folder.
const CHANNEL: &str = "skeleton";

pub(super) fn run(model: &BodyModel, args: &InferArgs) -> Result<()> {
    let checkpoint = &model.checkpoint;
    if args.mode != "plain" || args.joints.is_some() {
        bail!("--mode and --joints are for hands; bodies have --skeletons and --fused");
    }
    let options = BodyPredictorOptions {
        precision: args.precision,
        threads: rayon::current_num_threads(),
        confidence: args.confidence,
    };
    let predictor = model.predictor(options)?;
    let opening = args.opening.options_with_sensor(&args.events)?;
    let open = |propagation: Option<&PropagationConfig>| -> Result<BodyRecordingStream> {
        let windows = Windows::open(&args.events, &opening)?;
        let calibration = Calibration::choose(args.camera.as_deref(), windows.sensor())?;
        let predictor = predictor.another();
        let of = BodyRecordingStream::of_camera;
        Ok(of(windows, &calibration, checkpoint, propagation, predictor)?)
    };
    let mut recording = open(None)?;
    let Some(start) = recording.start() else { bail!("{}: no events", args.events.display()) };
    let end = recording.end()?;
    let stride_ms = args.stride_ms.unwrap_or(checkpoint.config.evaluation.every_ms);
    let step = Micros(1_000 * i64::from(stride_ms.max(1)));
    ensure!(
        start + step <= end,
        "{} lasts {:.1} ms, and the first pose is at {stride_ms} ms: record for longer, or set a \
         smaller --stride-ms",
        args.events.display(),
        1e3 * (end - start).as_seconds()
    );
    let mut writer = PredictionWriter::create(&args.out, DelayUnit::Seconds, Undetected::MinusOne)?;
    let mut skeletons = Vec::new();
    let progress = bar("inferring", (end - start).0 as u64 / 1_000, "ms");
    let (mut t, mut count, mut delay_s) = (start + step, 0u64, 0.0);
    while t <= end {
        let prediction = recording.predict(t)?;
        writer.write(&prediction)?;
        skeletons.extend(args.skeletons.is_some().then(|| skeleton(&prediction)));
        (count, delay_s) = (count + 1, delay_s + prediction.delay_s);
        progress.set_position((t - start).0 as u64 / 1_000);
        t = t + step;
    }
    progress.finish_and_clear();
    writer.finish()?;
    for warning in recording.warnings() {
        note(format!("warning: {}: {warning}", args.events.display()));
    }
    say(format!(
        "{count} poses, {:.2} ms each: {}",
        1e3 * delay_s / count.max(1) as f64,
        args.out.display()
    ));
    if let Some(folder) = &args.skeletons {
        write_skeletons(folder, CHANNEL, &skeletons, CoordinateFormat::Whole)?;
        say(format!("skeletons: {}", folder.display()));
    }
    if let Some(path) = &args.fused {
        write_propagated(path, &args.events, &open, stride_ms)?;
    }
    Ok(())
}

/// Writes poses at the output rate, propagated by velocities from events.
fn write_propagated(
    path: &Path,
    events: &Path,
    open: &dyn Fn(Option<&PropagationConfig>) -> Result<BodyRecordingStream>,
    stride_ms: u32,
) -> Result<()> {
    let config = PropagationConfig {
        network_hz: 1e3 / f64::from(stride_ms.max(1)),
        latency_ms: 0.0,
        ..PropagationConfig::default()
    };
    let mut recording = open(Some(&config))?;
    let Some(start) = recording.start() else { bail!("{}: no events", events.display()) };
    let end = recording.end()?;
    let poses = propagated_poses(&mut recording, &config, (start, end))?;
    let mut writer = PredictionWriter::create(path, DelayUnit::Seconds, Undetected::MinusOne)?;
    for pose in &poses {
        writer.write(&BodyPrediction {
            t_s: pose.t_s,
            delay_s: 0.0,
            joints_px: pose.propagated,
        })?;
    }
    writer.finish()?;
    say(format!(
        "{} propagated poses, {} per second: {}",
        poses.len(),
        config.output_hz,
        path.display()
    ));
    Ok(())
}

fn skeleton(prediction: &BodyPrediction) -> YarpSkeleton {
    let joints = file_from_network(&prediction.joints_px);
    YarpSkeleton {
        t: Micros::from_seconds(prediction.t_s),
        joints: joints.map(|joint| joint.map_or([-1.0; 2], |at| at.to_array())),
        head_size_px: None,
        torso_size_px: torso(&prediction.joints_px),
        confidences: None,
    }
}
