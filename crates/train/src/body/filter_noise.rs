//! The noise of the filter of bodies, estimated from a network's residuals.
//!
//! # Model
//! The variance of a measurement goes with a power of the joint's score: the slope of a line through
//! the logarithms of squared residuals, relative to the torso. As for hands, what is left is the
//! cutoff: of [`CUTOFFS`] from [`LOWEST_HZ`] to [`HIGHEST_HZ`] the one whose worst metric gains most over the network
//! without a filter, of wrong joints at 0.2 and 0.4 of the torso and of the mean distance.

use evpose_core::Micros;
use evpose_pose::body::fusion::ScoredPoints;
use evpose_pose::body::{BODY_JOINTS, BodyPoints, torso};
use evpose_pose::filter::{BodyFilter, BodyFilterConfig};
use evpose_task::body::{BodyCheckpoint, BodyPredictor, BodyPredictorOptions};
use rayon::prelude::*;

use super::frames::{BodyFrame, BodyFrames, size_of};
use crate::TrainError;

const CUTOFFS: u32 = 17;
const LOWEST_HZ: f64 = 5.0;
const HIGHEST_HZ: f64 = 320.0;
/// Squares of relative residuals below it are as good as this: labels are not more accurate.
const MIN_SQUARE: f64 = 1e-4;
/// Lowest score that counts.
const MIN_SCORE: f32 = 0.02;
/// Bounds of the power.
const EXPONENTS: [f64; 2] = [0.0, 8.0];

/// A pose as the network finds it, and as it is.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoredPose {
    /// Time stamp.
    pub t: Micros,
    /// Joints with their scores, in pixels.
    pub pose: ScoredPoints,
    /// True joints, in pixels.
    pub truth: BodyPoints,
}

impl ScoredPose {
    /// The pose that a network finds on an image.
    pub(super) fn of(predictor: &mut BodyPredictor, frame: &BodyFrame) -> Self {
        let sensor = size_of(&frame.image);
        let pose = ScoredPoints::in_image(&predictor.joints(&frame.image), sensor);
        Self { t: frame.t, pose, truth: frame.joints_px() }
    }

    /// Distances of joints, relative to the torso, from the true ones.
    fn residuals(&self, joints: &BodyPoints) -> [Option<f64>; BODY_JOINTS] {
        let size_px = torso(&self.truth).filter(|size_px| *size_px > 0.0);
        std::array::from_fn(|k| {
            let (found, truth) = joints[k].zip(self.truth[k])?;
            Some(f64::from(found.distance(truth) / size_px?))
        })
    }
}

/// Estimates a filter from the poses of sequences, each in the order of time. None without residuals.
///
/// # Errors
/// If no filter can be made.
pub fn estimate_filter(
    sequences: &[&[ScoredPose]],
) -> Result<Option<BodyFilterConfig>, TrainError> {
    let Some(score_exponent) = score_exponent(sequences) else { return Ok(None) };
    let all = sequences.iter().copied().flatten();
    let unfiltered = Errors::of(all.map(|pose| (pose, pose.pose.points)));
    // In equal ratios, as what a filter does depends on the ratio to the motion.
    let candidate = |k: u32| {
        let share = f64::from(k) / f64::from(CUTOFFS - 1);
        let cutoff_hz = LOWEST_HZ * (HIGHEST_HZ / LOWEST_HZ).powf(share);
        let config = BodyFilterConfig { cutoff_hz, score_exponent, ..BodyFilterConfig::default() };
        let mut filtered = Vec::new();
        for sequence in sequences {
            let mut filter = BodyFilter::new(config)?;
            filtered.extend(sequence.iter().map(|pose| (pose, filter.update(pose.t, &pose.pose))));
        }
        // The worst of all errors decides: none may grow for the sake of another.
        Ok((Errors::of(filtered.into_iter()).worst_over(&unfiltered), config))
    };
    let all =
        (0..CUTOFFS).into_par_iter().map(candidate).collect::<Result<Vec<_>, TrainError>>()?;
    // Of equal ones, the least filter.
    let best = all.into_iter().rev().min_by(|(a, _), (b, _)| a.total_cmp(b));
    Ok(best.map(|(_, config)| config))
}

/// Puts a filter into a checkpoint that follows from its residuals on the first `samples` images, where
/// these are of recordings.
///
/// # Errors
/// If the network cannot be compiled.
pub(super) fn calibrate_filter(
    checkpoint: &mut BodyCheckpoint,
    frames: &BodyFrames,
    samples: usize,
) -> Result<(), TrainError> {
    let predictor = BodyPredictor::new(checkpoint, BodyPredictorOptions::default(), None)?;
    let frames = &frames.frames[..samples.min(frames.len())];
    let poses: Vec<ScoredPose> =
        frames.par_iter().map_init(|| predictor.another(), ScoredPose::of).collect();
    let mut rest = &poses[..];
    // Of one sequence, and in the order of time: a new recording starts the filter anew.
    let lengths = frames.chunk_by(|a, b| a.sequence == b.sequence && a.t < b.t).map(<[_]>::len);
    let sequences = lengths.map(|length| {
        let (sequence, after) = rest.split_at(length);
        rest = after;
        sequence
    });
    // Photographs have nothing before and after them.
    let sequences: Vec<&[ScoredPose]> = sequences.filter(|sequence| sequence.len() > 2).collect();
    if let Some(filter) = estimate_filter(&sequences)? {
        checkpoint.config.filter = filter;
    }
    Ok(())
}

/// Minus the slope of logarithmic squared residuals over logarithmic scores.
fn score_exponent(sequences: &[&[ScoredPose]]) -> Option<f64> {
    let points: Vec<[f64; 2]> = sequences
        .iter()
        .copied()
        .flatten()
        .flat_map(|pose| pose.residuals(&pose.pose.points).into_iter().zip(pose.pose.scores))
        .filter_map(|(residual, score)| {
            // An exact hit has no logarithm.
            let square = residual?.powi(2).max(MIN_SQUARE);
            Some([f64::from(score.max(MIN_SCORE)).ln(), square.ln()])
        })
        .collect();
    let count = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / count;
    let [x, y] = [mean(0), mean(1)];
    let (both, square) = points.iter().fold((0.0, 0.0), |(both, square), point| {
        (both + (point[0] - x) * (point[1] - y), square + (point[0] - x).powi(2))
    });
    // A single score has no slope.
    (square > 0.0).then(|| (-both / square).clamp(EXPONENTS[0], EXPONENTS[1]))
}

/// Sums over joints: those beyond 0.2 and 0.4 of the torso, and distances, at most a torso each.
#[derive(Debug, Clone, Copy, Default)]
struct Errors([f64; 3]);

impl Errors {
    fn of<'a>(poses: impl Iterator<Item = (&'a ScoredPose, BodyPoints)>) -> Self {
        let mut sums = [0.0; 3];
        for residual in poses.flat_map(|(pose, joints)| pose.residuals(&joints)).flatten() {
            let errors = [f64::from(residual > 0.2), f64::from(residual > 0.4), residual.min(1.0)];
            sums.iter_mut().zip(errors).for_each(|(sum, error)| *sum += error);
        }
        Self(sums)
    }

    /// The largest relative to another's; what was right without a filter has to stay so.
    fn worst_over(&self, others: &Self) -> f64 {
        let ratios = self.0.iter().zip(others.0).map(|(own, other)| (1.0 + own) / (1.0 + other));
        ratios.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::CounterRng;
    use glam::Vec2;

    use super::*;

    /// A person who sways, measured with noise of `noise / score²` torsos, each score by chance.
    fn sequence(seed: u64, noise: f32) -> Vec<ScoredPose> {
        let mut rng = CounterRng::new(seed, "filter noise test", 0);
        let pose = |k: i64| {
            let sway = 20.0 * (0.02 * k as f32 * std::f32::consts::TAU).sin();
            let truth: BodyPoints = std::array::from_fn(|joint| {
                Some(Vec2::new(100.0 + sway, 50.0 + 12.0 * joint as f32))
            });
            let size_px = torso(&truth).unwrap();
            let scores = std::array::from_fn(|_| rng.uniform(0.2, 0.9));
            let points = std::array::from_fn(|joint| {
                let sd_px = noise * size_px / (scores[joint] * scores[joint]);
                Some(truth[joint]? + sd_px * Vec2::new(rng.normal(), rng.normal()))
            });
            ScoredPose { t: Micros(20_000 * k), pose: ScoredPoints { points, scores }, truth }
        };
        (0..300).map(pose).collect()
    }

    #[test]
    fn the_power_of_the_score_is_found_again_and_the_filter_reduces_every_error() {
        let sequences: Vec<_> = (0..4).map(|seed| sequence(seed, 0.04)).collect();
        let sequences: Vec<&[ScoredPose]> = sequences.iter().map(Vec::as_slice).collect();
        let config = estimate_filter(&sequences).unwrap().unwrap();
        assert!((config.score_exponent - 4.0).abs() < 0.2, "{config:?}");
        let held_out = sequence(9, 0.04);
        let raw = Errors::of(held_out.iter().map(|pose| (pose, pose.pose.points)));
        let mut filter = BodyFilter::new(config).unwrap();
        let ours: Vec<_> =
            held_out.iter().map(|pose| (pose, filter.update(pose.t, &pose.pose))).collect();
        let ours = Errors::of(ours.into_iter());
        assert!(ours.worst_over(&raw) < 0.7, "{ours:?} of {raw:?}");
    }

    #[test]
    fn a_network_without_noise_is_filtered_least_and_nothing_without_residuals() {
        let config = estimate_filter(&[&sequence(1, 1e-6)]).unwrap().unwrap();
        assert!(config.cutoff_hz > 100.0, "{config:?}");
        assert_eq!(estimate_filter(&[]).unwrap(), None);
    }
}
