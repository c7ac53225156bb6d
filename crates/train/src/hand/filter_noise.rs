//! Noise of the Kalman filters of hands, estimated from a network's residuals in validation.
//!
//! # Model
//! The variance of a measurement is the mean square of the network's residual, for each part of the
//! parameters. One number is left, the variance of the acceleration, or with it the cutoff of the
//! filter. Residuals of networks are correlated over time, which a Kalman filter does not assume,
//! so that the hand's own acceleration would make it trust its motion too much. Instead, of
//! [`CUTOFFS`] cutoffs from [`LOWEST_HZ`] to [`HIGHEST_HZ`], the same for all parts, it is the one
//! whose worst metric gains most: of errors of articulation, wrist and rotation, and of points in
//! space and on the image, each relative to that of the network without a filter. Cutoffs of their
//! own would let parts lag by different times, and points suffer.
//!
//! The filter of two settings takes as slow what is best for the slower half of the frames, and as
//! fast what is best for the others. The limit of the innovation between both is the one that
//! [`SLOW_SHARE`] of the slower half stay below.

use evpose_core::Micros;
use evpose_core::stats::quantile::nearest_rank;
use evpose_pose::filter::{
    AdaptiveFilterConfig, HandFilter, HandFilterConfig, HandNoise, KalmanConfig, NoiseVariances,
};
use evpose_pose::metric::{HandError, HandPoints, palm_errors_percent, root_aligned_errors_mm};
use evpose_pose::rotation::nearest_axis_angle;
use evpose_pose::{HandParams, HandSide};
use evpose_task::hand::HandView;
use rayon::prelude::*;

use crate::TrainError;

const CUTOFFS: u32 = 17;
const LOWEST_HZ: f64 = 1.5;
const HIGHEST_HZ: f64 = 150.0;
const SLOW_SHARE: f64 = 0.95;

/// Measured and true poses of a sequence, one each millisecond.
#[derive(Debug, Clone)]
pub(crate) struct MeasuredTrack {
    pub(crate) frames: Vec<u64>,
    pub(crate) measured: Vec<HandParams>,
    pub(crate) truth: Vec<HandParams>,
}

/// The settings of both filters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FilterEstimate {
    pub(crate) plain: HandFilterConfig,
    pub(crate) adaptive: AdaptiveFilterConfig,
}

/// Estimates both filters for hands of `side` in `view`. None without frames.
///
/// # Errors
/// If no filter can be made of the residuals: those of a network that is never wrong.
pub(crate) fn estimate_filters(
    view: &HandView,
    side: HandSide,
    tracks: &[MeasuredTrack],
) -> Result<Option<FilterEstimate>, TrainError> {
    let Some(residuals) = Parts::mean_square_residuals(tracks) else { return Ok(None) };
    // Slow and fast are relative to the median of these frames.
    let speeds: Vec<Vec<f64>> = tracks.iter().map(|track| speeds(track, &residuals)).collect();
    let Some(median) = sorted_quantile(speeds.concat(), 0.5) else { return Ok(None) };
    let truth: Vec<Vec<HandPoints>> = tracks
        .par_iter()
        .map(|track| track.truth.iter().map(|pose| view.points(side, pose, &[])).collect())
        .collect();
    // Errors of all frames, of slow and of fast ones.
    let errors =
        |poses: &(dyn Fn(&MeasuredTrack) -> Result<Vec<HandParams>, TrainError> + Sync)| {
            let of_track =
                |((track, points), speeds): ((&MeasuredTrack, &Vec<HandPoints>), &Vec<f64>)| {
                    let mut sums = [Errors::default(); 3];
                    for (k, pose) in poses(track)?.iter().enumerate() {
                        let error = Errors::of(view, side, pose, &track.truth[k], &points[k]);
                        sums[0].add(&error);
                        sums[if speeds[k] <= median { 1 } else { 2 }].add(&error);
                    }
                    Ok::<_, TrainError>(sums)
                };
            let sums: Vec<[Errors; 3]> = tracks
                .par_iter()
                .zip(&truth)
                .zip(&speeds)
                .map(of_track)
                .collect::<Result<_, _>>()?;
            let mut all = [Errors::default(); 3];
            for sums in &sums {
                all.iter_mut().zip(sums).for_each(|(all, sums)| all.add(sums));
            }
            Ok::<_, TrainError>(all)
        };
    // What filters must improve on.
    let unfiltered = errors(&|track| Ok(track.measured.clone()))?;
    let mut best = [(f64::INFINITY, HIGHEST_HZ); 3];
    for k in 0..CUTOFFS {
        // The lag goes with the inverse of the cut-off, so the steps are geometric.
        let share = f64::from(k) / f64::from(CUTOFFS - 1);
        let cutoff_hz = LOWEST_HZ * (HIGHEST_HZ / LOWEST_HZ).powf(share);
        let config = with_noise(residuals.noise(cutoff_hz));
        let errors = errors(&|track| filtered(&config, track))?;
        for ((best, errors), without) in best.iter_mut().zip(&errors).zip(&unfiltered) {
            let error = errors.worst_over(without);
            if error < best.0 {
                *best = (error, cutoff_hz);
            }
        }
    }
    let [all, slow, fast] = best.map(|(_, cutoff_hz)| with_noise(residuals.noise(cutoff_hz)));
    let adaptive = AdaptiveFilterConfig {
        // Below this the slow filter is used, above it the fast one.
        innovation_limit: innovation_limit(tracks, &speeds, median, &slow)?,
        unwrap_rotation: true,
        detector: slow.kalman,
        slow: slow.kalman,
        fast: fast.kalman,
    };
    Ok(Some(FilterEstimate { plain: all, adaptive }))
}

fn with_noise(noise: HandNoise) -> HandFilterConfig {
    let kalman = KalmanConfig { hand: Some(noise), ..KalmanConfig::default() };
    HandFilterConfig { kalman, unwrap_rotation: true }
}

fn filtered(
    config: &HandFilterConfig,
    track: &MeasuredTrack,
) -> Result<Vec<HandParams>, TrainError> {
    let mut filter = HandFilter::new(config)?;
    let update = |(&frame, pose): (&u64, &HandParams)| filter.update(at(frame), pose);
    Ok(track.frames.iter().zip(&track.measured).map(update).collect())
}

fn at(frame: u64) -> Micros {
    Micros(1_000 * frame as i64)
}

/// The innovation that most of the slower frames stay below.
fn innovation_limit(
    tracks: &[MeasuredTrack],
    speeds: &[Vec<f64>],
    median: f64,
    detector: &HandFilterConfig,
) -> Result<f64, TrainError> {
    let mut innovations = Vec::new();
    for (track, speeds) in tracks.iter().zip(speeds) {
        let mut filter = HandFilter::new(detector)?;
        for ((&frame, pose), speed) in track.frames.iter().zip(&track.measured).zip(speeds) {
            filter.update(at(frame), pose);
            // The slower half shows what noise alone does; larger innovations mean motion.
            if *speed <= median {
                innovations.push(filter.largest_innovation());
            }
        }
    }
    let published = AdaptiveFilterConfig::default().innovation_limit;
    Ok(sorted_quantile(innovations, SLOW_SHARE).unwrap_or(published))
}

fn sorted_quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    (!values.is_empty()).then(|| nearest_rank(&values, share))
}

/// How fast the true hand is at each frame: change per frame relative to the residuals.
fn speeds(track: &MeasuredTrack, residuals: &Parts) -> Vec<f64> {
    let step = |pair: &[HandParams]| {
        // Relative to the residuals, radians and metres add up.
        let change = Parts::squares(&pair[1], &pair[0]);
        change.0.iter().zip(&residuals.0).map(|(change, residual)| change / residual).sum()
    };
    let mut speeds: Vec<f64> = track.truth.windows(2).map(step).collect();
    // Nothing comes before the first frame: it takes the speed of the second.
    speeds.insert(0, speeds.first().copied().unwrap_or(0.0));
    speeds
}

/// A number for articulation, translation and rotation.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Parts([f64; 3]);

impl Parts {
    fn add(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(sum, value)| *sum += value);
    }

    /// Mean squares per component of the difference of two poses.
    fn squares(pose: &HandParams, truth: &HandParams) -> Self {
        let articulation: f64 = pose
            .articulation
            .iter()
            .zip(&truth.articulation)
            .map(|(pose, truth)| f64::from(pose - truth).powi(2))
            .sum();
        // A rotation has many vectors: the one nearest to the truth.
        let rotation = nearest_axis_angle(pose.rotation, truth.rotation) - truth.rotation;
        let translation = pose.translation_m - truth.translation_m;
        // Per component: there are 6, 3 and 3 of them.
        Self([
            articulation / 6.0,
            f64::from(translation.length_squared()) / 3.0,
            f64::from(rotation.length_squared()) / 3.0,
        ])
    }

    fn mean_square_residuals(tracks: &[MeasuredTrack]) -> Option<Self> {
        let (mut sum, mut count) = (Self::default(), 0u32);
        for track in tracks {
            for (pose, truth) in track.measured.iter().zip(&track.truth) {
                sum.add(&Self::squares(pose, truth));
                count += 1;
            }
        }
        (count > 0).then(|| Self(sum.0.map(|sum| sum / f64::from(count))))
    }

    /// The noise of a filter with such residuals and a cutoff.
    fn noise(&self, cutoff_hz: f64) -> HandNoise {
        let part = |i: usize| NoiseVariances::with_cutoff(cutoff_hz, self.0[i]);
        HandNoise { articulation: part(0), translation: part(1), rotation: part(2) }
    }
}

/// Sums of errors in the metrics of evaluations.
#[derive(Debug, Clone, Copy, Default)]
struct Errors([f64; 5]);

impl Errors {
    fn of(
        view: &HandView,
        side: HandSide,
        pose: &HandParams,
        truth: &HandParams,
        true_points: &HandPoints,
    ) -> Self {
        let points = view.points(side, pose, &[]);
        let error = HandError::between(pose, truth);
        let in_space = root_aligned_errors_mm(&points.world_m, &true_points.world_m);
        // Beyond the threshold of the curves, an error is as wrong as any.
        let on_image = palm_errors_percent(&points.image_px, &true_points.image_px);
        Self([
            error.articulation,
            error.translation_mm,
            error.rotation_deg,
            in_space.iter().map(|error_mm| error_mm.min(100.0)).sum(),
            on_image.map(|percent| percent.min(100.0)).sum(),
        ])
    }

    fn add(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(sum, value)| *sum += value);
    }

    /// The largest of the errors relative to others.
    fn worst_over(&self, others: &Self) -> f64 {
        let ratios = self.0.iter().zip(&others.0).map(|(error, other)| error / other);
        ratios.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::CounterRng;
    use evpose_task::hand::HandConfig;
    use glam::Vec3;

    use super::*;

    /// A hand whose wrist swings at 1 Hz by 10 cm and whose fingers rest, measured with white noise.
    fn track(seed: u64, noise: f32) -> MeasuredTrack {
        let mut rng = CounterRng::new(seed, "filter noise test", 0);
        let frames: Vec<u64> = (0..2_000).collect();
        let truth: Vec<HandParams> = frames
            .iter()
            .map(|&frame| HandParams {
                articulation: [0.3; 6],
                translation_m: Vec3::X
                    * (0.1 * (0.001 * frame as f32 * std::f32::consts::TAU).sin()),
                rotation: Vec3::Y,
            })
            .collect();
        let poses = truth.iter().map(|truth| HandParams {
            articulation: truth.articulation.map(|value| value + noise * rng.normal()),
            translation_m: truth.translation_m + 0.01 * noise * Vec3::splat(rng.normal()),
            rotation: truth.rotation + noise * Vec3::Z * rng.normal(),
        });
        MeasuredTrack { measured: poses.collect(), frames, truth }
    }

    fn estimate(tracks: &[MeasuredTrack]) -> Option<FilterEstimate> {
        let view = HandView::new(&HandConfig::default()).unwrap();
        estimate_filters(&view, HandSide::Right, tracks).unwrap()
    }

    #[test]
    fn the_estimated_filter_reduces_every_error() {
        let tracks: Vec<MeasuredTrack> = (0..3).map(|seed| track(seed, 0.3)).collect();
        let plain = estimate(&tracks).unwrap().plain;
        let held_out = track(9, 0.3);
        let errors = |poses: &[HandParams]| {
            let mut sums = [0.0; 3];
            for (pose, truth) in poses.iter().zip(&held_out.truth) {
                let error = HandError::between(pose, truth);
                let parts = [error.articulation, error.translation_mm, error.rotation_deg];
                sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
            }
            sums
        };
        let raw = errors(&held_out.measured);
        let ours = errors(&filtered(&plain, &held_out).unwrap());
        for (part, (ours, raw)) in ours.iter().zip(raw).enumerate() {
            assert!(*ours < 0.5 * raw, "part {part}: {ours} of {raw}");
        }
        // Residuals are measured: 0.3 squared, within a few percent.
        let noise = plain.kalman.hand.unwrap();
        assert!((noise.articulation.measurement / 0.09 - 1.0).abs() < 0.05, "{noise:?}");
    }

    #[test]
    fn a_lagging_filter_is_opened_for_a_network_without_noise() {
        let tracks: Vec<MeasuredTrack> = (0..2).map(|seed| track(seed, 1e-4)).collect();
        let noise = estimate(&tracks).unwrap().plain.kalman.hand.unwrap();
        assert!(noise.translation.cutoff_hz() > 10.0, "{noise:?}");
        assert!(estimate(&[]).is_none());
    }
}
