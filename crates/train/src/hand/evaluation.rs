//! Evaluation of predictors of hands on sequences with ground truth.

use evpose_core::Micros;
use evpose_pose::HandPose;
use evpose_pose::metric::{HandEvaluation, HandPoints, SequenceScores};
use evpose_pose::stream::InferenceSchedule;

use crate::TrainError;
use crate::hand::dataset::{HandDataset, HandSequence};
use evpose_task::hand::HandConfig;
use evpose_task::hand::HandView;
use evpose_task::hand::Predictor;

/// The poses that a method predicted for a sequence.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HandPoseTrack {
    /// Frames, 1 ms each, ascending.
    pub frames: Vec<u64>,
    /// Pose at the end of each frame.
    pub poses: Vec<HandPose>,
}

impl HandPoseTrack {
    /// The pose at the end of a frame, if there is one.
    pub fn at(&self, frame: u64) -> Option<HandPose> {
        self.frames.binary_search(&frame).ok().map(|index| self.poses[index])
    }

    /// Appends a pose.
    pub(crate) fn push(&mut self, frame: u64, pose: HandPose) {
        self.frames.push(frame);
        self.poses.push(pose);
    }
}

/// A predictor with its name in tables and in `metrics.json`.
pub struct Method<'a> {
    /// `mean_pose`, `untrained`, `trained`, …
    pub name: &'static str,
    /// The network, or a constant.
    pub predictor: &'a mut dyn Predictor,
    /// Name under which its poses after the Kalman filter are evaluated as well, if at all.
    pub filtered: Option<&'static str>,
}

/// Scores and predictions of one method.
#[derive(Debug, Clone)]
pub struct MethodResults {
    /// Name of the method.
    pub name: &'static str,
    /// Scores, a sequence at a time.
    pub evaluation: HandEvaluation,
    /// Predictions, a sequence at a time.
    pub tracks: Vec<HandPoseTrack>,
}

/// Evaluates `methods` on every sequence of `data`: the poses that `evpose infer` writes of its recording, one
/// every `stride_ms`. `progress` receives the number of poses from time to time, in all about
/// [`evaluated_pose_count`].
///
/// The true hand has the shape it was recorded with; predicted hands of regressors have the neutral one, as
/// published, and those of networks of joints are their joints.
///
/// # Errors
/// If a sequence cannot be read or a prediction fails.
pub fn evaluate(
    config: &HandConfig,
    data: &HandDataset,
    methods: &mut [Method<'_>],
    stride_ms: u32,
    progress: &mut dyn FnMut(u64),
) -> Result<Vec<MethodResults>, TrainError> {
    let view = HandView::new(config)?;
    let mut results: Vec<MethodResults> = methods
        .iter()
        .flat_map(|method| [Some(method.name), method.filtered])
        .flatten()
        .map(|name| MethodResults {
            name,
            evaluation: HandEvaluation::default(),
            tracks: Vec::new(),
        })
        .collect();
    for sequence in data.sequences() {
        let tracks = infer(config, sequence, methods, stride_ms, progress)?;
        // Those of all methods: one of them may see no hand where another has a pose.
        let mut frames: Vec<u64> = tracks.iter().flat_map(|track| &track.frames).copied().collect();
        frames.sort_unstable();
        frames.dedup();
        let truth = true_points(&view, sequence, &frames)?;
        for (result, track) in results.iter_mut().zip(tracks) {
            result.evaluation.sequences.push(score(&view, sequence, &track, (&frames, &truth))?);
            result.tracks.push(track);
        }
    }
    Ok(results)
}

/// Poses that [`evaluate`] compares with the ground truth, about: a recording may begin or end without any.
pub fn evaluated_pose_count(config: &HandConfig, data: &HandDataset, stride_ms: u32) -> u64 {
    let count = |s: &HandSequence| (0..s.frames()).filter(|&k| is_scored(config, s, k)).count();
    data.sequences().iter().map(|s| count(s) as u64).sum::<u64>() / u64::from(stride_ms.max(1))
}

/// Whether a pose at the end of a frame is scored: from `evaluation.first_ms` on, and the last one of a
/// sequence that ends before. A burst of events where a simulation draws its scene anew is no motion: poses
/// whose windows hold one are left out.
pub(crate) fn is_scored(config: &HandConfig, sequence: &HandSequence, frame: u64) -> bool {
    let first = u64::from(config.evaluation.first_ms).min(sequence.frames().saturating_sub(1));
    let window = (frame + 1).saturating_sub(config.representation.window_ms.into())..frame + 1;
    (first..sequence.frames()).contains(&frame) && !sequence.is_redrawn(window)
}

/// The poses of one sequence, of each method and of each filtered one.
fn infer(
    config: &HandConfig,
    sequence: &HandSequence,
    methods: &mut [Method<'_>],
    stride_ms: u32,
    progress: &mut dyn FnMut(u64),
) -> Result<Vec<HandPoseTrack>, TrainError> {
    let schedule = InferenceSchedule::Every(Micros(1_000 * i64::from(stride_ms.max(1))));
    let mut streams = Vec::new();
    for method in methods.iter_mut() {
        streams.push(sequence.stream(config, &mut *method.predictor, schedule)?);
    }
    // Streams advance together, so that `progress` counts each frame once.
    let mut tracks = vec![[HandPoseTrack::default(), HandPoseTrack::default()]; streams.len()];
    loop {
        let mut done = None;
        for (stream, [measured, filtered]) in streams.iter_mut().zip(&mut tracks) {
            let Some(inferred) = stream.next().transpose()? else { continue };
            let before = measured.frames.len();
            for (t, estimate) in inferred.poses {
                let frame = frame_before(t);
                if is_scored(config, sequence, frame) {
                    measured.push(frame, estimate.measured);
                    filtered.push(frame, estimate.filtered);
                }
            }
            done = Some(measured.frames.len() - before);
        }
        let Some(done) = done else { break };
        progress(done as u64);
    }
    // They borrow the predictors of `methods`.
    drop(streams);
    let of = |(method, [measured, filtered]): (&Method<'_>, [HandPoseTrack; 2])| {
        [Some(measured), method.filtered.map(|_| filtered)]
    };
    Ok(methods.iter().zip(tracks).flat_map(of).flatten().collect())
}

/// The frame that ends at `t`.
pub(crate) fn frame_before(t: Micros) -> u64 {
    u64::try_from(t.0.div_euclid(1_000) - 1).unwrap_or_default()
}

/// The true points at `frames`: as recorded, or with the shapes the sequence was recorded with.
fn true_points(
    view: &HandView,
    sequence: &HandSequence,
    frames: &[u64],
) -> Result<Vec<HandPoints>, TrainError> {
    let mut points = Vec::with_capacity(frames.len());
    let mut episode = None;
    // The shape changes only between episodes: a hand of each is made once.
    let mut shaped = view.neutral().clone();
    for &frame in frames {
        let now = sequence.episode_of(frame);
        if episode != Some(now) {
            episode = Some(now);
            shaped = view.shaped(sequence.betas(now));
        }
        points.push(sequence.points(view, frame, &shaped)?);
    }
    Ok(points)
}

/// Scores of a track against the ground truth of its sequence.
pub(crate) fn score_track(
    view: &HandView,
    sequence: &HandSequence,
    track: &HandPoseTrack,
) -> Result<SequenceScores, TrainError> {
    score(view, sequence, track, (&track.frames, &true_points(view, sequence, &track.frames)?))
}

fn score(
    view: &HandView,
    sequence: &HandSequence,
    track: &HandPoseTrack,
    (frames, truth): (&[u64], &[HandPoints]),
) -> Result<SequenceScores, TrainError> {
    let mut scores = SequenceScores::default();
    let mut both = Vec::with_capacity(track.poses.len());
    for (&frame, truth) in frames.iter().zip(truth) {
        let Some(pose) = track.at(frame) else {
            scores.push_missing(truth, true);
            continue;
        };
        scores.push_parameters(&pose.params, &sequence.pose(frame)?);
        let points = view.points_seen(sequence.hand(), &pose);
        scores.push_points(&points, truth);
        both.push((frame, points, truth));
    }
    for three in both.windows(3) {
        let [(first, a, d), (second, b, e), (third, c, f)] = three else { continue };
        // A new shape of the hand is no motion.
        let is_one_episode = sequence.episode_of(*first) == sequence.episode_of(*third);
        // `push_acceleration` takes one step for both differences.
        if is_one_episode && second - first == third - second {
            let step_s = 1e-3 * (second - first) as f64;
            scores.push_acceleration([a, b, c], [d, e, f], step_s);
        }
    }
    Ok(scores)
}
