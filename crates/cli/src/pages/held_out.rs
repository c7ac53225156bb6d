//! Evaluation of a network on held-out sequences, beside its baselines.

use anyhow::{Context, Result};
use burn::tensor::Device;
use evpose_core::stats::interval::Interval;
use evpose_pose::HandParams;
use evpose_pose::metric::{HandEvaluation, HandRatios, HandSummary};
use evpose_task::hand::{ConstantPose, HandConfig, NetworkPredictor};
use evpose_train::{HandDataset, Method, MethodResults, evaluate, evaluated_pose_count, untrained};
use serde::Serialize;

use super::fingers;
use crate::machine::Machine;
use crate::progress::{bar, say};
use crate::run_info::COMMIT;

/// Content of `metrics.json`.
#[derive(Debug, Serialize)]
pub struct Metrics {
    /// A line of the table for each method, by its name.
    pub held_out: serde_json::Map<String, serde_json::Value>,
    /// Errors of the trained network over those of the mean pose, paired by sequence.
    pub trained_over_mean_pose: HandRatios,
    /// The same after the Kalman filter.
    pub trained_kalman_over_mean_pose: HandRatios,
    /// The trained network's scores on each recording.
    pub recordings: Vec<RecordingScores>,
    /// Milliseconds between evaluated poses.
    pub stride_ms: u32,
    /// Seed of the experiment.
    pub seed: u64,
    /// Commit of the program.
    pub commit: &'static str,
    /// Machine of the evaluation.
    pub machine: Machine,
    /// Anything measured along the way, such as speeds.
    pub measured: serde_json::Map<String, serde_json::Value>,
}

/// Scores on a recording.
#[derive(Debug, Serialize)]
pub struct RecordingScores {
    /// Name of the recording's files without extension.
    pub name: String,
    /// The scores.
    #[serde(flatten)]
    pub scores: HandSummary,
}

/// Every method's scores and tracks, and the metrics that follow.
pub struct HeldOutEvaluation {
    /// Scores and tracks, method by method.
    pub methods: Vec<MethodResults>,
    /// Contents of `metrics.json`.
    pub metrics: Metrics,
}

/// Evaluates `trained` beside an untrained network and the pose `mean`.
pub fn evaluate_with_baselines(
    config: &HandConfig,
    data: &HandDataset,
    mut trained: NetworkPredictor,
    mean: HandParams,
    device: &Device,
    stride_ms: u32,
) -> Result<HeldOutEvaluation> {
    let mut mean_pose = ConstantPose(mean);
    // A training draws its initial weights by the same seed of the config.
    let mut before = NetworkPredictor::new(config, untrained(config, device)?, device.clone())?;
    let mut methods = [
        Method { name: "mean_pose", predictor: &mut mean_pose, filtered: None },
        Method { name: "untrained", predictor: &mut before, filtered: None },
        Method { name: "trained", predictor: &mut trained, filtered: Some("trained_kalman") },
    ];
    let progress = bar("evaluating", evaluated_pose_count(config, data, stride_ms), "poses");
    let methods = evaluate(config, data, &mut methods, stride_ms, &mut |done| progress.inc(done))?;
    progress.finish_and_clear();

    let bootstrap = &config.evaluation.bootstrap;
    let of = |name: &str| Ok::<_, anyhow::Error>(&find(&methods, name)?.evaluation);
    let mut held_out = serde_json::Map::new();
    for method in &methods {
        let summary = method.evaluation.summary(bootstrap);
        held_out.insert(method.name.to_owned(), serde_json::to_value(summary)?);
    }
    let baseline = of("mean_pose")?;
    let sequences = data.sequences().iter().zip(&of("trained")?.sequences);
    let recordings = sequences.map(|(sequence, scores)| RecordingScores {
        name: sequence.name().to_owned(),
        scores: HandEvaluation { sequences: vec![scores.clone()] }.summary(bootstrap),
    });
    let metrics = Metrics {
        held_out,
        recordings: recordings.collect(),
        trained_over_mean_pose: of("trained")?.ratios_to(baseline, bootstrap)?,
        trained_kalman_over_mean_pose: of("trained_kalman")?.ratios_to(baseline, bootstrap)?,
        stride_ms,
        seed: config.seed,
        commit: COMMIT,
        machine: Machine::this(),
        measured: serde_json::Map::new(),
    };
    Ok(HeldOutEvaluation { methods, metrics })
}

impl HeldOutEvaluation {
    /// Adds results of further methods at the same times.
    ///
    /// # Errors
    /// If a score is not finite.
    pub fn add(&mut self, config: &HandConfig, methods: Vec<MethodResults>) -> Result<()> {
        for method in &methods {
            let summary = method.evaluation.summary(&config.evaluation.bootstrap);
            self.metrics.held_out.insert(method.name.to_owned(), serde_json::to_value(summary)?);
        }
        self.methods.extend(methods);
        Ok(())
    }
}

/// The method called `name`.
pub fn find<'a>(methods: &'a [MethodResults], name: &str) -> Result<&'a MethodResults> {
    let found = methods.iter().find(|method| method.name == name);
    found.with_context(|| format!("{name} was not evaluated"))
}

/// Columns of the table: heading, digits, and which number.
type Column = (&'static str, usize, fn(&HandSummary) -> Option<Interval>);

const COLUMNS: [Column; 7] = [
    ("translation mm", 1, |s| s.translation_mm),
    ("rotation deg", 1, |s| s.rotation_deg),
    ("articulation", 3, |s| s.articulation),
    ("AUC 3D", 3, |s| s.auc_3d),
    ("AUC 2D", 3, |s| s.auc_2d),
    ("fingers", 3, |s| s.fingers.as_ref().map(|fingers| fingers.states)),
    ("jitter m/s2", 0, |s| s.acceleration_m_s2),
];

/// Headings of the table of [`rows`].
pub fn header() -> Vec<&'static str> {
    std::iter::once("method").chain(COLUMNS.iter().map(|column| column.0)).collect()
}

/// A number and its interval as they are printed.
pub fn cell(interval: Option<Interval>, digits: usize) -> (String, String) {
    match interval {
        None => ("-".to_owned(), String::new()),
        Some(Interval { estimate, low: Some(low), high: Some(high) }) => {
            (format!("{estimate:.digits$}"), format!("[{low:.digits$}, {high:.digits$}]"))
        }
        Some(Interval { estimate, .. }) => (format!("{estimate:.digits$}"), String::new()),
    }
}

/// A row per method and two of ratios; each cell is a number and its interval.
pub fn rows(config: &HandConfig, evaluation: &HeldOutEvaluation) -> Vec<Vec<(String, String)>> {
    let name = |name: &str| (name.to_owned(), String::new());
    let mut rows: Vec<Vec<(String, String)>> = evaluation
        .methods
        .iter()
        .map(|method| {
            let summary = method.evaluation.summary(&config.evaluation.bootstrap);
            let cells = COLUMNS.iter().map(|(_, digits, get)| cell(get(&summary), *digits));
            std::iter::once(name(method.name)).chain(cells).collect()
        })
        .collect();
    for (label, ratios) in [
        ("trained / mean_pose", &evaluation.metrics.trained_over_mean_pose),
        ("trained_kalman / mean_pose", &evaluation.metrics.trained_kalman_over_mean_pose),
    ] {
        // Ratios are of errors of parameters, which the others are not.
        let cells =
            [ratios.translation, ratios.rotation, ratios.articulation, None, None, None, None];
        rows.push(
            std::iter::once(name(label)).chain(cells.map(|interval| cell(interval, 3))).collect(),
        );
    }
    rows
}

/// Prints the table.
pub fn print(config: &HandConfig, evaluation: &HeldOutEvaluation) {
    let line = |cells: &[String]| {
        let mut text = format!("{:<27}", cells[0]);
        for cell in &cells[1..] {
            text += &format!("{cell:>25}");
        }
        say(text.trim_end());
    };
    line(&header().iter().map(|&h| h.to_owned()).collect::<Vec<_>>());
    for row in rows(config, evaluation) {
        let joined: Vec<String> =
            row.iter().map(|(n, i)| format!("{n} {i}").trim_end().to_owned()).collect();
        line(&joined);
    }
    let summaries: Vec<(&str, HandSummary)> = evaluation
        .methods
        .iter()
        .map(|method| (method.name, method.evaluation.summary(&config.evaluation.bootstrap)))
        .collect();
    fingers::print(summaries.iter().map(|(name, summary)| (*name, summary)), "trained");
}
