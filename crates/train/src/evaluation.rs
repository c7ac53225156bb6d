//! Evaluation of predictors of hands on sequences with ground truth.

use evpose_core::Micros;
use evpose_pose::HandParams;
use evpose_pose::filter::{HandFilter, HoldAtRest};
use evpose_pose::metric::{HandEvaluation, HandPoints, SequenceScores};

use crate::TrainError;
use crate::dataset::{HandDataset, HandSequence};
use evpose_task::hand::HandConfig;
use evpose_task::hand::HandView;
use evpose_task::hand::Predictor;

/// Windows in one inference: enough to occupy every thread, few enough for the memory.
const BATCH: usize = 64;

/// The poses that a method predicted for a sequence.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HandPoseTrack {
    /// Frames, 1 ms each, ascending.
    pub frames: Vec<u64>,
    /// Pose at the end of each frame.
    pub poses: Vec<HandParams>,
}

impl HandPoseTrack {
    /// The same poses after the Kalman filter, one update for each.
    ///
    /// # Errors
    /// If the filter's settings make no sense.
    pub fn filtered(&self, config: &HandConfig) -> Result<Self, TrainError> {
        let mut filter = HandFilter::new(&config.filter)?;
        let poses = self
            .frames
            .iter()
            .zip(&self.poses)
            .map(|(&frame, pose)| filter.update(Micros(frame as i64 * 1000), pose))
            .collect();
        Ok(Self { frames: self.frames.clone(), poses })
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

/// Evaluates `methods` on every sequence of `data`, a pose every `stride_ms`. `progress` receives
/// the number of poses after each batch, in all [`evaluated_pose_count`].
///
/// The true hand has the shape it was recorded with, predicted hands the neutral one, as published.
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
        let mut tracks = Vec::new();
        for track in predict(config, data, sequence, methods, stride_ms, progress)?
            .into_iter()
            .zip(methods.iter())
            .map(|(track, method)| -> Result<_, TrainError> {
                let filtered = method.filtered.map(|_| track.filtered(config)).transpose()?;
                Ok([Some(track), filtered])
            })
        {
            tracks.extend(track?.into_iter().flatten());
        }
        let truth = true_points(&view, sequence, &tracks[0].frames)?;
        for (result, track) in results.iter_mut().zip(tracks) {
            result.evaluation.sequences.push(score(&view, sequence, &track, &truth)?);
            result.tracks.push(track);
        }
    }
    Ok(results)
}

/// Poses that [`evaluate`] compares with the ground truth.
pub fn evaluated_pose_count(config: &HandConfig, data: &HandDataset, stride_ms: u32) -> u64 {
    data.sequences().iter().map(|s| evaluated_frames(config, s, stride_ms).count() as u64).sum()
}

/// The frames of a sequence that are evaluated; of one that ends before `evaluation.first_ms`, the
/// last.
pub(crate) fn evaluated_frames(
    config: &HandConfig,
    sequence: &HandSequence,
    stride_ms: u32,
) -> impl Iterator<Item = u64> + use<> {
    let first = u64::from(config.evaluation.first_ms).min(sequence.frames().saturating_sub(1));
    (first..sequence.frames()).step_by(stride_ms.max(1) as usize)
}

/// Every method's poses for one sequence; windows are made once for all methods.
fn predict(
    config: &HandConfig,
    data: &HandDataset,
    sequence: &HandSequence,
    methods: &mut [Method<'_>],
    stride_ms: u32,
    progress: &mut dyn FnMut(u64),
) -> Result<Vec<HandPoseTrack>, TrainError> {
    let frames: Vec<u64> = evaluated_frames(config, sequence, stride_ms).collect();
    let mut tracks =
        vec![HandPoseTrack { frames: frames.clone(), poses: Vec::new() }; methods.len()];
    let mut inputs = Vec::new();
    let (height, width) = data.image_size();
    let hold = config.hold.map(|hold| HoldAtRest::new(&hold, data.sensor())).transpose()?;
    let mut holds = vec![hold; methods.len()];
    for chunk in frames.chunks(BATCH) {
        data.windows_ending_at(sequence, chunk, &mut inputs)?;
        for ((method, track), hold) in methods.iter_mut().zip(&mut tracks).zip(&mut holds) {
            let mut poses = method.predictor.predict(&inputs, (height, width))?;
            if let Some(hold) = hold {
                let windows = inputs.chunks_exact(2 * height * width);
                poses.iter_mut().zip(windows).for_each(|(pose, window)| {
                    *pose = hold.pose(window, pose);
                });
            }
            track.poses.extend(poses);
        }
        progress(chunk.len() as u64);
    }
    Ok(tracks)
}

/// The true points at `frames`, with the shapes the sequence was recorded with.
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
        points.push(view.points_of(sequence.hand(), &sequence.pose(frame)?, &shaped));
    }
    Ok(points)
}

/// Scores of a track against the ground truth of its sequence.
pub(crate) fn score_track(
    view: &HandView,
    sequence: &HandSequence,
    track: &HandPoseTrack,
) -> Result<SequenceScores, TrainError> {
    score(view, sequence, track, &true_points(view, sequence, &track.frames)?)
}

fn score(
    view: &HandView,
    sequence: &HandSequence,
    track: &HandPoseTrack,
    truth: &[HandPoints],
) -> Result<SequenceScores, TrainError> {
    let mut scores = SequenceScores::default();
    let mut predicted = Vec::with_capacity(track.poses.len());
    for ((&frame, pose), truth) in track.frames.iter().zip(&track.poses).zip(truth) {
        scores.push_parameters(pose, &sequence.pose(frame)?);
        let points = view.points_of(sequence.hand(), pose, view.neutral());
        scores.push_points(&points, truth);
        predicted.push(points);
    }
    let frames = track.frames.windows(3);
    for ((frames, predicted), truth) in frames.zip(predicted.windows(3)).zip(truth.windows(3)) {
        let ([first, second, third], [a, b, c], [d, e, f]) = (frames, predicted, truth) else {
            continue;
        };
        // A new shape of the hand is no motion.
        let is_one_episode = sequence.episode_of(*first) == sequence.episode_of(*third);
        if is_one_episode && second - first == third - second {
            let step_s = 1e-3 * (second - first) as f64;
            scores.push_acceleration([a, b, c], [d, e, f], step_s);
        }
    }
    Ok(scores)
}
