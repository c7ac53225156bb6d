//! `evpose infer` of bodies with several calibrated cameras: joints in the world.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use evpose_camera::read_rig;
use evpose_core::{Micros, PlacedCamera};
use evpose_io::Windows;
use evpose_io::poses::{PoseKind, PoseSequence, TimedPose, write_poses};
use evpose_pose::body::BODY_JOINTS;
use evpose_pose::{JointFrame, PoseOrigin};
use evpose_sim::person::RecordingPlace;
use evpose_task::body::{
    BodyPredictorOptions, PlacedRecording, SpatialConfig, SpatialPose, SpatialRecordings,
};

use super::BodyNetwork;
use super::args::BodyInferArgs;
use crate::bad_input::NobodyInView;
use crate::progress::{bar, note, say};
use crate::tasks::args::{InferArgs, format_of};

pub(super) fn run(model: &BodyNetwork, args: &InferArgs, own: &BodyInferArgs) -> Result<()> {
    let is_for_one = own.skeletons.is_some()
        || own.fused.is_some()
        || own.own.camera.is_some()
        || own.batch.is_some();
    if is_for_one {
        bail!(
            "--skeletons, --fused, --batch and --camera are for one recording; several have \
             --cameras, a file of calibrated cameras"
        );
    }
    let format = format_of(own.format, &args.out)?;
    let checkpoint = &model.checkpoint;
    let cameras = cameras(own)?;
    let predictor = model.predictor(BodyPredictorOptions {
        precision: own.own.precision,
        // The cameras are computed at once, each by one thread.
        threads: 1,
        confidence: own.confidence,
        consensus: own.consensus,
    })?;
    let mut recordings = Vec::new();
    for (events, camera) in own.events.iter().zip(&cameras) {
        let opening = args.opening.options_with_sensor(events)?;
        let windows = Windows::open(events, &opening)?;
        let (min_score, predictor) = (own.min_score, predictor.another());
        recordings.push(PlacedRecording::new(windows, *camera, checkpoint, min_score, predictor)?);
    }
    let config =
        if own.own.unfiltered { SpatialConfig::default() } else { SpatialConfig::filtered() };
    let stride_ms = args.stride_ms.unwrap_or(checkpoint.config.evaluation.every_ms);
    let step = Micros(1_000 * i64::from(stride_ms.max(1)));
    let mut people = SpatialRecordings::new(recordings, config, step)?;
    let [start, end] = people.span().context("the recordings have no time in common")?;
    ensure!(
        start + step <= end,
        "the recordings have {:.1} ms in common, and the first pose is at {stride_ms} ms: set a \
         smaller --stride-ms",
        1e3 * (end - start).as_seconds()
    );
    let mut poses =
        PoseSequence { frame: Some(JointFrame::World), ..PoseSequence::new(PoseKind::Body) };
    let progress = bar("inferring", (end - start).0 as u64 / 1_000, "ms");
    let mut delay_s = 0.0;
    let (mut joints, mut errors_px) = (0_usize, Vec::new());
    for pose in &mut people {
        let pose = pose?;
        delay_s += pose.delay_s;
        joints += pose.joints_m.iter().flatten().count();
        errors_px.extend(pose.points.iter().flatten().map(|point| point.error_px));
        let latency_ms = args.latency_ms(pose.delay_s);
        poses.poses.push(TimedPose { latency_ms, ..timed(&pose, &cameras[0]) });
        progress.set_position((pose.t - start).0 as u64 / 1_000);
    }
    progress.finish_and_clear();
    // Rows are written before the error below, since those of nobody say at which times it was.
    write_poses(&args.out, &poses, format)?;
    for (index, warning) in people.warnings() {
        note(format!("warning: {}: {warning}", own.events[index].display()));
    }
    let count = poses.poses.len();
    if joints == 0 {
        bail!(NobodyInView(format!(
            "no joint is seen by two cameras, as the {count} rows of {} say: see with one recording alone \
             whether somebody is in view, and whether the cameras are those of the recordings, in this order",
            args.out.display()
        )));
    }
    let mean_px = errors_px.iter().sum::<f64>() / errors_px.len().max(1) as f64;
    say(format!(
        "{count} poses in the world from {} cameras, {:.1} of {BODY_JOINTS} joints each, {:.2} ms \
         each: {}",
        cameras.len(),
        joints as f64 / count.max(1) as f64,
        1e3 * delay_s / count.max(1) as f64,
        args.out.display()
    ));
    say(format!("mean reprojection error {mean_px:.1} px"));
    Ok(())
}

/// The cameras of the recordings: of `--cameras`, or of the metadata beside each.
fn cameras(own: &BodyInferArgs) -> Result<Vec<PlacedCamera>> {
    let Some(path) = &own.cameras else {
        return own.events.iter().map(|events| camera_beside(events)).collect();
    };
    let cameras = read_rig(path)?;
    ensure!(
        cameras.len() == own.events.len(),
        "{} has {} cameras for {} recordings: one [[camera]] for each --events, in their order",
        path.display(),
        cameras.len(),
        own.events.len()
    );
    Ok(cameras)
}

fn camera_beside(events: &Path) -> Result<PlacedCamera> {
    let path = events.with_extension("toml");
    let needed = || {
        format!(
            "several recordings need calibrated cameras: {} has none, and --cameras FILE is not given",
            path.display()
        )
    };
    RecordingPlace::read(&path)?.camera.with_context(needed)
}

/// A pose with the mean score of the cameras that saw each joint; positions on the image are those of
/// the first camera.
fn timed(pose: &SpatialPose, first: &PlacedCamera) -> TimedPose {
    let t = pose.t;
    let seen: Vec<TimedPose> =
        pose.estimates.iter().flatten().map(|estimate| TimedPose::new(t, estimate)).collect();
    let mut timed = TimedPose::empty(PoseKind::Body, t);
    let mean = |scores: Vec<f32>| {
        (!scores.is_empty()).then(|| scores.iter().sum::<f32>() / scores.len() as f32)
    };
    timed.score = mean(seen.iter().filter_map(|one| one.score).collect());
    for (k, (joint, at_m)) in timed.joints.iter_mut().zip(pose.joints_m).enumerate() {
        joint.position_m = at_m.map(|at_m| at_m.as_vec3());
        // The joint is projected, since the first camera may not have detected it at all.
        joint.image_px =
            at_m.and_then(|at_m| first.image_from_world(at_m)).map(|at_px| at_px.as_vec2());
        joint.score = mean(seen.iter().filter_map(|one| one.joints[k].score).collect());
    }
    timed.with_origin(PoseOrigin::Network)
}
