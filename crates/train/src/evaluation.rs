//! How good predictors are on sequences with known poses.

use evpose_core::Micros;
use evpose_pose::HandParams;
use evpose_pose::filter::HandFilter;
use evpose_pose::metric::{HandEvaluation, HandPoints, SequenceScores};

use crate::TrainError;
use crate::dataset::{HandDataset, HandSequence};
use evpose_task::hand::HandConfig;
use evpose_task::hand::HandView;
use evpose_task::hand::Predictor;

/// Windows predicted at once.
const BATCH: usize = 64;

/// The poses a method predicted for a sequence.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Track {
    /// Frames, 1 ms each, ascending.
    pub frames: Vec<u64>,
    /// Pose at the end of each frame.
    pub poses: Vec<HandParams>,
}

impl Track {
    /// The same poses filtered, measurement by measurement.
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
    /// What predicts.
    pub predictor: &'a mut dyn Predictor,
    /// Also judge its poses after the Kalman filter, under this name.
    pub filtered: Option<&'static str>,
}

/// What one method scored and predicted.
#[derive(Debug, Clone)]
pub struct Evaluated {
    /// Name of the method.
    pub name: &'static str,
    /// Scores, a sequence at a time.
    pub evaluation: HandEvaluation,
    /// Predictions, a sequence at a time.
    pub tracks: Vec<Track>,
}

/// Judges `methods` on every sequence of `data`, a pose every `stride_ms`. `progress` is told how
/// many poses are done, of [`poses_to_judge`].
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
) -> Result<Vec<Evaluated>, TrainError> {
    let stage = HandView::new(config)?;
    let mut results: Vec<Evaluated> = methods
        .iter()
        .flat_map(|method| [Some(method.name), method.filtered])
        .flatten()
        .map(|name| Evaluated { name, evaluation: HandEvaluation::default(), tracks: Vec::new() })
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
        let truth = true_points(&stage, sequence, &tracks[0].frames)?;
        for (result, track) in results.iter_mut().zip(tracks) {
            result.evaluation.sequences.push(judge(&stage, sequence, &track, &truth)?);
            result.tracks.push(track);
        }
    }
    Ok(results)
}

/// How many poses [`evaluate`] judges.
pub fn poses_to_judge(config: &HandConfig, data: &HandDataset, stride_ms: u32) -> u64 {
    data.sequences().iter().map(|s| judged_frames(config, s, stride_ms).count() as u64).sum()
}

/// The frames of a sequence that are judged; the last of one that ends before the first.
pub(crate) fn judged_frames(
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
) -> Result<Vec<Track>, TrainError> {
    let frames: Vec<u64> = judged_frames(config, sequence, stride_ms).collect();
    let mut tracks = vec![Track { frames: frames.clone(), poses: Vec::new() }; methods.len()];
    let mut surfaces = Vec::new();
    for chunk in frames.chunks(BATCH) {
        data.windows_ending_at(sequence, chunk, &mut surfaces)?;
        for (method, track) in methods.iter_mut().zip(&mut tracks) {
            track.poses.extend(method.predictor.predict(&surfaces, data.image_size())?);
        }
        progress(chunk.len() as u64);
    }
    Ok(tracks)
}

/// The true points at `frames`, with the shapes the sequence was recorded with.
fn true_points(
    stage: &HandView,
    sequence: &HandSequence,
    frames: &[u64],
) -> Result<Vec<HandPoints>, TrainError> {
    let mut points = Vec::with_capacity(frames.len());
    let mut episode = None;
    let mut shaped = stage.neutral().clone();
    for &frame in frames {
        let now = sequence.episode_of(frame);
        if episode != Some(now) {
            episode = Some(now);
            shaped = stage.shaped(sequence.betas(now));
        }
        points.push(stage.points_of(sequence.hand(), &sequence.pose(frame)?, &shaped));
    }
    Ok(points)
}

/// Judges a track that was made elsewhere.
pub(crate) fn judge_track(
    stage: &HandView,
    sequence: &HandSequence,
    track: &Track,
) -> Result<SequenceScores, TrainError> {
    judge(stage, sequence, track, &true_points(stage, sequence, &track.frames)?)
}

fn judge(
    stage: &HandView,
    sequence: &HandSequence,
    track: &Track,
    truth: &[HandPoints],
) -> Result<SequenceScores, TrainError> {
    let mut scores = SequenceScores::default();
    for ((&frame, pose), truth) in track.frames.iter().zip(&track.poses).zip(truth) {
        scores.push_parameters(pose, &sequence.pose(frame)?);
        scores.push_points(&stage.points_of(sequence.hand(), pose, stage.neutral()), truth);
    }
    Ok(scores)
}
