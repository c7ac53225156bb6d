//! The presence of a trained network of joints, fitted to images with and without a hand.
//!
//! # Model
//! Heatmaps and depths stay as they were trained; the presence is a logistic function of the same features, for which
//! images with a hand count as much as those without. Of these, a part are moving lines: with them in the
//! training itself, features changed from batch to batch, and validation became unsteady.

use burn::tensor::{Device, Tensor, TensorData};
use evpose_core::SensorSize;
use evpose_core::stats::linear::solve;
use evpose_nn::JointNet;
use rayon::prelude::*;

use super::no_hand::draw_lines;
use crate::TrainError;
use crate::hand::dataset::{HandDataset, SampleError};

/// Every which image is lines.
const LINES_EVERY: u64 = 3;
/// Images in a call of the network.
const BATCH: u64 = 64;
/// Newton steps; most of them change nothing any more.
const STEPS: usize = 15;
/// Ridge, for features that go together.
const RIDGE: f64 = 1e-4;

/// `network` with the presence that separates `samples` images of `data` best.
///
/// # Errors
/// If a recording cannot be read.
pub(super) fn with_fitted_presence(
    network: JointNet,
    data: &HandDataset,
    (samples, seed): (u64, u64),
    device: &Device,
) -> Result<JointNet, TrainError> {
    let (height, width) = data.sample_size();
    let size = SensorSize { width: width as u16, height: height as u16 };
    let (mut rows, mut is_hand) = (Vec::new(), Vec::new());
    for first in (0..samples).step_by(BATCH as usize) {
        let image = |position: u64| -> Result<_, SampleError> {
            let mut sample = data.training_sample(position)?;
            let mut presence = sample.joints.as_deref().and_then(|label| label.presence);
            if position.is_multiple_of(LINES_EVERY) {
                draw_lines(&mut sample.input, size, seed, position);
                presence = Some(false);
            }
            Ok(presence.map(|presence| (sample.input, presence)))
        };
        let positions = (first..samples.min(first + BATCH)).into_par_iter();
        let images = positions.map(image).collect::<Result<Vec<_>, _>>()?;
        let (inputs, labels): (Vec<_>, Vec<bool>) = images.into_iter().flatten().unzip();
        let inputs = TensorData::new(inputs.concat(), [labels.len(), 2, height, width]);
        let features = network.presence_features(Tensor::from_data(inputs, device));
        let [_, count] = features.dims();
        let features: Vec<f64> = features.into_data().iter().collect();
        rows.extend(features.chunks_exact(count).map(<[f64]>::to_vec));
        is_hand.extend(labels);
    }
    Ok(match logistic(&rows, &is_hand) {
        Some((weights, constant)) => network.with_presence(weights, constant),
        None => network,
    })
}

/// Weights and constant of the logistic function that separates the rows, both kinds weighing the same; none if there
/// is one kind alone.
///
/// # Source
/// Iteratively reweighted least squares: Hastie, Tibshirani, Friedman: *The Elements of Statistical Learning*, 4.4.1.
fn logistic(rows: &[Vec<f64>], is_hand: &[bool]) -> Option<(Vec<f32>, f32)> {
    let hands = is_hand.iter().filter(|is_hand| **is_hand).count();
    let others = is_hand.len() - hands;
    if hands == 0 || others == 0 {
        return None;
    }
    let rows: Vec<Vec<f64>> =
        rows.iter().map(|row| row.iter().copied().chain([1.0]).collect()).collect();
    let columns = rows[0].len();
    let mut weights = vec![0.0; columns];
    for _ in 0..STEPS {
        let mut gradient: Vec<f64> = weights.iter().map(|weight| -RIDGE * weight).collect();
        let mut curvature = vec![vec![0.0; columns]; columns];
        for (row, &is_hand) in rows.iter().zip(is_hand) {
            let logit: f64 = row.iter().zip(&weights).map(|(x, weight)| x * weight).sum();
            let likelihood = 1.0 / (1.0 + (-logit).exp());
            let share = 0.5 / if is_hand { hands as f64 } else { others as f64 };
            let missing = share * (f64::from(u8::from(is_hand)) - likelihood);
            let bend = share * likelihood * (1.0 - likelihood);
            for (i, x) in row.iter().enumerate() {
                gradient[i] += missing * x;
                for (sum, y) in curvature[i].iter_mut().zip(row) {
                    *sum += bend * x * y;
                }
            }
        }
        (0..columns).for_each(|i| curvature[i][i] += RIDGE);
        let step = solve(curvature, gradient)?;
        weights.iter_mut().zip(step).for_each(|(weight, step)| *weight += step);
    }
    let constant = weights.pop()? as f32;
    Some((weights.into_iter().map(|weight| weight as f32).collect(), constant))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_separates_both_kinds_gets_the_weight_and_rare_hands_count_as_much() {
        let waves = |k: usize| [(k as f64).sin(), (2.3 * k as f64).cos()];
        let is_hand: Vec<bool> = (0..300).map(|k| k % 10 == 0).collect();
        let row = |(k, is_hand): (usize, &bool)| {
            let [a, b] = waves(k);
            vec![a + if *is_hand { 3.0 } else { 0.0 }, b]
        };
        let rows: Vec<Vec<f64>> = is_hand.iter().enumerate().map(row).collect();
        let (weights, constant) = logistic(&rows, &is_hand).unwrap();
        assert!(weights[0] > 3.0 && weights[1].abs() < 0.3 * weights[0], "{weights:?}");
        // The border lies in the middle between the kinds.
        assert!((-constant / weights[0] - 1.5).abs() < 0.2, "{constant}");
        assert!(logistic(&rows, &vec![true; 300]).is_none());
    }
}
