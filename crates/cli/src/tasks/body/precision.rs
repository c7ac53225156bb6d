//! Accuracy and latency of a body network in each precision.

use std::path::Path;

use crate::progress::bar;
use anyhow::Result;
use evpose_core::Micros;
use evpose_infer::{CalibrationRanges, Precision};
use evpose_task::body::{BodyCheckpoint, BodyPredictor, BodyPredictorOptions};
use evpose_train::body::{BodyRecordings, evaluate_body, mean_pose_of_recordings};

use super::eval::cell;
use crate::tasks::task::PrecisionScores;

/// Thresholds of the PCK, in percent of the torso.
const PERCENTS: [usize; 2] = [40, 80];

pub(super) fn evaluate(
    checkpoint: &BodyCheckpoint,
    data: &Path,
    ranges: &CalibrationRanges,
    stride_ms: u32,
) -> Result<Vec<PrecisionScores>> {
    let recordings = BodyRecordings::open(data)?;
    let mean = checkpoint.mean_pose.map_or_else(|| mean_pose_of_recordings(&recordings), Ok)?;
    let stride = Micros(1_000 * i64::from(stride_ms.max(1)));
    let all = (Precision::ALL.len() * recordings.files.len()) as u64;
    let progress = bar("evaluating", all, "recordings");
    let mut scores = Vec::new();
    // All precisions infer the same images, so that rounding is all that differs.
    for precision in Precision::ALL {
        let options = BodyPredictorOptions { precision, ..BodyPredictorOptions::default() };
        let predictor = BodyPredictor::new(checkpoint, options, Some(ranges))?;
        let done = |count| progress.inc(count);
        let evaluated =
            evaluate_body(checkpoint, &predictor, &recordings, stride, None, &mean, &done)?;
        let bootstrap = &checkpoint.config.evaluation.bootstrap;
        let summary = evaluated.network().summary(&PERCENTS, bootstrap)?;
        let pck = |index: usize| cell(summary.raw.pck.get(index).copied().flatten(), 3);
        scores.push(PrecisionScores {
            precision,
            latency_ms: summary.delay_s.map_or(f64::NAN, |delay| 1e3 * delay.estimate),
            cells: vec![
                ("PCK@0.4", pck(0)),
                ("PCK@0.8", pck(1)),
                ("MPJPE px", cell(summary.raw.mpjpe_px, 2)),
            ],
            held_out: serde_json::to_value(&summary)?,
        });
    }
    progress.finish_and_clear();
    Ok(scores)
}
