//! Poses between those of the network: how much velocities of events are worth.
//!
//! # Model
//! The network is asked at a pace of its own, and what it says of a moment is known a latency later.
//! Held, its last answer stands until the next; fused, events since then carry each joint on. Both are
//! compared with the truth at the same instants.

use std::path::{Path, PathBuf};

use evpose_core::{EventStream, Micros};
use evpose_pose::body::fusion::ScoredPoints;
use evpose_pose::body::{BODY_JOINTS, BodyFollower, BodyPoints};
use evpose_pose::metric::body::{BodyEvaluation, BodyPrediction, BodyProtocol, BodySequence};
use evpose_sim::person::PoseTable;
use rayon::prelude::*;

use super::evaluation::truth_of;
use super::recordings::BodyRecordings;
use crate::TrainError;
use evpose_task::body::BodyCheckpoint;
use evpose_task::body::BodyPredictor;
use evpose_task::body::{PropagationConfig, RepresentationReader};

/// Two answers to where somebody is at a moment.
#[derive(Debug, Clone, PartialEq)]
pub struct BetweenPose {
    /// When, in seconds.
    pub t_s: f64,
    /// The network's last answer.
    pub held: BodyPoints,
    /// The same carried on.
    pub fused: BodyPoints,
}

/// Poses of a recording at an even pace, from `first` to `end`.
///
/// # Errors
/// If the recording cannot be read, or the settings are out of their range.
pub fn poses_between(
    film: &mut RepresentationReader,
    predictor: &mut BodyPredictor,
    config: &PropagationConfig,
    (first, end): (Micros, Micros),
) -> Result<Vec<BetweenPose>, TrainError> {
    let sensor = film.sensor();
    let PropagationConfig { velocity, fusion, min_samples, .. } = config;
    let mut follower = BodyFollower::new(sensor, *velocity, fusion, *min_samples)?;
    let micros = |seconds: f64| Micros((seconds * 1e6).round() as i64);
    let (step, pace) = (micros(1.0 / config.output_hz), micros(1.0 / config.network_hz));
    let latency = micros(1e-3 * config.latency_ms);
    let (mut held, mut next_asked) = ([None; BODY_JOINTS], first);
    let mut on_their_way: Vec<(Micros, ScoredPoints)> = Vec::new();
    let mut poses = Vec::new();
    let mut t = first;
    while t <= end {
        let image = film.at_if(t, t >= next_asked, |events: &EventStream| follower.push(events))?;
        if let Some(image) = image {
            let joints = predictor.joints(&image);
            on_their_way.push((t, ScoredPoints::in_image(&joints, sensor)));
            next_asked = next_asked + pace;
            if next_asked <= t {
                next_asked = t + pace;
            }
        }
        while let Some((described, _)) = on_their_way.first().filter(|(at, _)| *at + latency <= t) {
            let described = *described;
            let (_, pose) = on_their_way.remove(0);
            held = pose.points;
            follower.detection(described, &pose, t);
        }
        poses.push(BetweenPose { t_s: t.as_seconds(), held, fused: follower.at(t) });
        t = t + step;
    }
    Ok(poses)
}

/// How good held and fused poses are on recordings.
///
/// A filter leaves joints out of which the network was not sure. A mean error over what is left would
/// flatter it, so both are also compared on the joints that both tell of.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BetweenEvaluated {
    /// The network's last answers.
    pub held: BodyEvaluation,
    /// The same carried on.
    pub fused: BodyEvaluation,
    /// As `held`, where fused poses have the joint, too.
    pub held_where_both: BodyEvaluation,
    /// As `fused`, where held poses have the joint, too.
    pub fused_where_both: BodyEvaluation,
}

/// Compares held and fused poses with the truth of recordings.
///
/// # Errors
/// As [`poses_between`].
pub fn evaluate_between(
    checkpoint: &BodyCheckpoint,
    predictor: &BodyPredictor,
    recordings: &BodyRecordings,
    config: &PropagationConfig,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<BetweenEvaluated, TrainError> {
    let one = |predictor: &mut BodyPredictor, (events, poses): &(PathBuf, PathBuf)| {
        let judged = judge(checkpoint, predictor, events, poses, config);
        progress(1);
        judged
    };
    let judged: Vec<[BodySequence; 4]> = recordings
        .files
        .par_iter()
        .map_init(|| predictor.another(), one)
        .collect::<Result<_, TrainError>>()?;
    let mut all = BetweenEvaluated::default();
    for [held, fused, held_where_both, fused_where_both] in judged {
        all.held.sequences.push(held);
        all.fused.sequences.push(fused);
        all.held_where_both.sequences.push(held_where_both);
        all.fused_where_both.sequences.push(fused_where_both);
    }
    Ok(all)
}

fn judge(
    checkpoint: &BodyCheckpoint,
    predictor: &mut BodyPredictor,
    events: &Path,
    poses: &Path,
    config: &PropagationConfig,
) -> Result<[BodySequence; 4], TrainError> {
    let truth = truth_of(&PoseTable::read(poses)?);
    let mut film = RepresentationReader::open(events, &checkpoint.config.image)?;
    let first = Micros(1_000 * i64::from(checkpoint.config.data.first_ms));
    let end = Micros::from_seconds(truth.last().map_or(0.0, |last| last.t_s));
    let poses = poses_between(&mut film, predictor, config, (first, end))?;
    let protocol = BodyProtocol { rate_hz: config.output_hz, ..BodyProtocol::default() };
    let sequence = |joints: fn(&BetweenPose) -> BodyPoints| {
        let found: Vec<BodyPrediction> = poses
            .iter()
            .map(|pose| BodyPrediction { t_s: pose.t_s, delay_s: 0.0, joints_px: joints(pose) })
            .collect();
        BodySequence::evaluate(&truth, &found, &protocol)
    };
    Ok([
        sequence(|pose| pose.held)?,
        sequence(|pose| pose.fused)?,
        sequence(|pose| where_both(&pose.held, &pose.fused))?,
        sequence(|pose| where_both(&pose.fused, &pose.held))?,
    ])
}

/// Those of `joints` that `others` have, too.
fn where_both(joints: &BodyPoints, others: &BodyPoints) -> BodyPoints {
    std::array::from_fn(|joint| joints[joint].filter(|_| others[joint].is_some()))
}
