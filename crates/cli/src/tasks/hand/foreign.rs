//! `evpose eval --foreign` of hands.

use std::path::Path;

use crate::pages::fingers;
use crate::pages::held_out::{RecordingScores, cell};
use crate::progress::{bar, say};
use crate::provenance::Provenance;
use anyhow::{Context, Result};
use evpose_pose::metric::{HandEvaluation, HandSummary};
use evpose_train::foreign::{evaluate_foreign_hands, foreign_hands};
use serde::Serialize;

use super::args::HandEvalArgs;
use super::{HandNetwork, foreign_preview};

/// Results, as written to JSON.
#[derive(Debug, Serialize)]
pub(super) struct ForeignReport {
    #[serde(flatten)]
    provenance: Provenance,
    network: HandSummary,
    filtered: HandSummary,
    mean_pose: HandSummary,
    recordings: Vec<RecordingScores>,
}

/// Evaluates a model on the recordings of `directory` and prints a table.
pub(super) fn run(
    model: &HandNetwork,
    args: &HandEvalArgs,
    directory: &Path,
) -> Result<ForeignReport> {
    let provenance = Provenance::this();
    let config = &model.checkpoint.config;
    let recordings = foreign_hands(directory)?;
    let mean_pose = model.checkpoint.mean_pose.context(
        "the checkpoint has no mean pose: weights of others are evaluated on --data alone",
    )?;
    let mut predictor = model.predictor(args.own.precision)?;
    let progress = bar("evaluating", recordings.len() as u64, "recordings");
    let mut done = |count| progress.inc(count);
    let results =
        evaluate_foreign_hands(config, &recordings, &mut predictor, &mean_pose, &mut done)?;
    progress.finish_and_clear();
    let summary = |evaluation: &HandEvaluation| evaluation.summary(&config.evaluation.bootstrap);
    say(format!(
        "{} recordings of {}, no simulation of ours",
        recordings.len(),
        directory.display()
    ));
    let report = ForeignReport {
        provenance,
        network: summary(&results.network),
        filtered: summary(&results.filtered),
        mean_pose: summary(&results.mean_pose),
        recordings: recordings
            .iter()
            .zip(&results.network.sequences)
            .map(|(recording, scores)| RecordingScores {
                name: recording.name.clone(),
                scores: summary(&HandEvaluation { sequences: vec![scores.clone()] }),
            })
            .collect(),
    };
    say(format!("{:<16}{:>24}{:>24}{:>26}", "", "AUC 2D", "AUC 3D", "MPJPE mm"));
    for (name, summary) in [
        ("mean pose", &report.mean_pose),
        ("network", &report.network),
        ("filtered", &report.filtered),
    ] {
        let column = |interval, digits| {
            let (value, range) = cell(interval, digits);
            format!("{value} {range}")
        };
        let (auc_2d, auc_3d) = (column(summary.auc_2d, 3), column(summary.auc_3d, 3));
        let mpjpe_mm = column(summary.mpjpe_mm, 1);
        say(format!("{name:<16}{auc_2d:>24}{auc_3d:>24}{mpjpe_mm:>26}"));
    }
    let rows = [("mean pose", &report.mean_pose), ("network", &report.network)];
    fingers::print(rows, "network");
    for one in &report.recordings {
        let (auc_2d, auc_3d) = (cell(one.scores.auc_2d, 3).0, cell(one.scores.auc_3d, 3).0);
        say(format!("  {:<14}{auc_2d:>24}{auc_3d:>24}", one.name));
    }
    if let Some(path) = &args.preview {
        // A recording without a score counts as the worst.
        let auc = |one: &RecordingScores| one.scores.auc_2d.map_or(0.0, |auc| auc.estimate);
        let scores: Vec<f64> = report.recordings.iter().map(auc).collect();
        let rows = foreign_preview::write(config, &recordings, &scores, &mut predictor, path)?;
        say(format!("worst, median and best in {}: {}", path.display(), rows.join(", ")));
    }
    Ok(report)
}
