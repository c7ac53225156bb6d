//! Accuracy and latency of a hand network in each precision.

use std::path::Path;
use std::time::Instant;

use crate::pages::held_out::cell;
use crate::progress::bar;
use anyhow::Result;
use evpose_core::stats::quantile::nearest_rank;
use evpose_infer::{CalibrationRanges, Precision};
use evpose_task::hand::{HandCheckpoint, NetworkPredictor};
use evpose_train::{HandDataset, Method, evaluate as evaluate_methods, evaluated_pose_count};

use crate::tasks::task::PrecisionScores;

/// Timed inferences of one input each: enough for a median.
const TIMED: usize = 50;

pub(super) fn evaluate(
    HandCheckpoint { config, network, .. }: &HandCheckpoint,
    data: &Path,
    ranges: &CalibrationRanges,
    stride_ms: u32,
) -> Result<Vec<PrecisionScores>> {
    let data = HandDataset::open(data, config)?;
    let predictor =
        |precision| NetworkPredictor::compiled(config, network, precision, Some(ranges.clone()));
    let mut predictors =
        Precision::ALL.into_iter().map(predictor).collect::<Result<Vec<_>, _>>()?;
    let mut methods = Vec::new();
    for (name, predictor) in ["f32", "bf16", "int8"].into_iter().zip(&mut predictors) {
        methods.push(Method { name, predictor, filtered: None });
    }
    let progress = bar("evaluating", evaluated_pose_count(config, &data, stride_ms), "poses");
    let mut done = |count| progress.inc(count);
    let evaluated = evaluate_methods(config, &data, &mut methods, stride_ms, &mut done)?;
    progress.finish_and_clear();
    let sequence = &data.sequences()[0];
    // The last window of a sequence is full, as those of a stream are.
    let window = data.evaluation_input(sequence, sequence.frames() - 1)?;
    let mut scores = Vec::new();
    for (precision, (method, evaluated)) in
        Precision::ALL.into_iter().zip(methods.into_iter().zip(&evaluated))
    {
        let mut times_ms = Vec::with_capacity(TIMED);
        for _ in 0..TIMED {
            let begin = Instant::now();
            method.predictor.predict(&window, data.image_size())?;
            times_ms.push(begin.elapsed().as_secs_f64() * 1e3);
        }
        times_ms.sort_by(f64::total_cmp);
        let held_out = evaluated.evaluation.summary(&config.evaluation.bootstrap);
        let error = |interval, digits| {
            let (value, interval) = cell(interval, digits);
            format!("{value} {interval}")
        };
        scores.push(PrecisionScores {
            precision,
            latency_ms: nearest_rank(&times_ms, 0.5),
            cells: vec![
                ("translation mm", error(held_out.translation_mm, 2)),
                ("rotation deg", error(held_out.rotation_deg, 2)),
                ("articulation", error(held_out.articulation, 3)),
            ],
            held_out: serde_json::to_value(held_out)?,
        });
    }
    Ok(scores)
}
