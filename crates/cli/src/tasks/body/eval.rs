//! `evpose eval` of bodies.

use std::path::Path;

use anyhow::Result;
use evpose_core::Micros;
use evpose_core::stats::bootstrap::BootstrapConfig;
use evpose_core::stats::interval::Interval;
use evpose_pose::filter::BodyFilterConfig;
use evpose_pose::metric::body::{BodyEvaluation, BodyScores, BodySummary};
use evpose_task::body::{BodyCheckpoint, BodyPredictor, BodyPredictorOptions, PropagationConfig};
use evpose_train::body::{
    BodyRecordingResult, BodyRecordings, BodyResults, DetectionCounts, evaluate_body,
    evaluate_propagation, mean_pose_of_recordings,
};
use serde::Serialize;

use super::args::BodyEvalArgs;
use super::world::{self, WorldScores};
use super::{BodyNetwork, images};
use crate::json::write_json;
use crate::outputs::write_file;
use crate::pages::people;
use crate::progress::{bar, say};
use crate::provenance::Provenance;
use crate::tasks::args::EvalArgs;
use evpose_report::chart::{self, Series};
use evpose_report::colour::PALETTE;

/// Thresholds of the PCK that are printed, in percent of the torso.
pub(in crate::tasks) const PERCENTS: [usize; 4] = [20, 40, 60, 80];

/// Results, as written to JSON.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    provenance: Provenance,
    network: BodySummary,
    /// The network's poses through the temporal filter.
    filtered: BodySummary,
    /// The filter of the checkpoint, and the one that residuals on these recordings would have.
    filter: BodyFilterConfig,
    #[serde(skip_serializing_if = "Option::is_none")]
    estimated_filter: Option<BodyFilterConfig>,
    recordings: Vec<RecordingScores>,
    mean_pose: BodySummary,
    /// Whether somebody is reported where somebody is.
    detections: DetectionCounts,
    #[serde(skip_serializing_if = "Option::is_none")]
    fusion: Option<Fusion>,
    /// Joints in the world, where several calibrated cameras saw a scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    world: Option<WorldScores>,
}

/// Scores of poses at the output rate: held constant after each inference, and propagated.
#[derive(Debug, Serialize)]
struct Fusion {
    /// The newest inferred pose, held constant.
    last_detection: BodySummary,
    propagated: BodySummary,
    /// On the joints that both predict.
    last_detection_on_common_joints: BodySummary,
    propagated_on_common_joints: BodySummary,
}

#[derive(Debug, Serialize)]
pub(super) struct RecordingScores {
    pub(super) file: String,
    #[serde(flatten)]
    pub(super) scores: BodyScores,
}

pub(super) fn run(model: &BodyNetwork, args: &EvalArgs, own: &BodyEvalArgs) -> Result<()> {
    let outputs = Outputs {
        json: args.json.as_deref(),
        preview: own.preview.as_deref(),
        curves: own.curves.as_deref(),
    };
    if let Some(data) = &args.data {
        let clips = images::clips(data);
        if clips.is_empty() {
            evaluate(model, args, own, data, &outputs)?;
        } else {
            images::run(model, args, own, &clips)?;
        }
    }
    if let Some(foreign) = &own.own.foreign {
        // Files are those of --data, where both are given.
        let outputs = if args.data.is_some() { Outputs::default() } else { outputs };
        evaluate(model, args, own, &foreign.join("bodies"), &outputs)?;
    }
    Ok(())
}

/// Files to write.
#[derive(Default)]
struct Outputs<'a> {
    json: Option<&'a Path>,
    preview: Option<&'a Path>,
    curves: Option<&'a Path>,
}

/// Evaluates a model on the recordings of a directory.
fn evaluate(
    model: &BodyNetwork,
    args: &EvalArgs,
    own: &BodyEvalArgs,
    data: &Path,
    outputs: &Outputs<'_>,
) -> Result<()> {
    // It holds the load of the machine, which has to be that before the evaluation.
    let provenance = Provenance::this();
    let checkpoint = &model.checkpoint;
    let options = BodyPredictorOptions {
        precision: own.own.precision,
        consensus: own.consensus,
        ..BodyPredictorOptions::default()
    };
    let predictor = model.predictor(options)?;
    let recordings = BodyRecordings::open(data)?;
    // Weights of others come without the mean of their training.
    let mean = checkpoint.mean_pose.map_or_else(|| mean_pose_of_recordings(&recordings), Ok)?;
    let every_ms = args.stride_ms.unwrap_or(checkpoint.config.evaluation.every_ms);
    let every = Micros(1_000 * i64::from(every_ms));
    let progress = bar("evaluating", recordings.files.len() as u64, "recordings");
    let advance = |done| progress.inc(done);
    let camera = own.own.camera.as_deref();
    let evaluated =
        evaluate_body(checkpoint, &predictor, &recordings, every, camera, &mean, &advance)?;
    progress.finish_and_clear();
    let bootstrap = &checkpoint.config.evaluation.bootstrap;
    let summary = |evaluation: BodyEvaluation| evaluation.summary(&PERCENTS, bootstrap);
    let (network, mean_pose) = (summary(evaluated.network())?, summary(evaluated.mean_pose())?);
    let filtered = summary(evaluated.filtered())?;
    say(format!("{} recordings of {}", network.sequences, data.display()));
    print("network", &network.raw);
    print("filtered", &filtered.raw);
    print("mean pose", &mean_pose.raw);
    let estimated_filter = evaluated.estimated_filter()?;
    print_filter([&network, &filtered], &checkpoint.config.filter, estimated_filter.as_ref());
    print_joints(&network);
    print_detections(&evaluated.detections());
    let scores = by_recording(&evaluated, bootstrap)?;
    print_lowest(&scores);
    if let Some((delay, rate)) = network.delay_s.zip(network.rate_hz) {
        say(format!(
            "{:.2} ms per prediction, {:.0} predictions per second of a recording",
            1e3 * delay.estimate,
            rate.estimate
        ));
    }
    let mut report = Report {
        provenance,
        network,
        filtered,
        filter: checkpoint.config.filter,
        estimated_filter,
        recordings: scores,
        mean_pose,
        detections: evaluated.detections(),
        fusion: None,
        world: world::evaluate(checkpoint, &predictor, &recordings, every)?,
    };
    if own.fusion {
        report.fusion = Some(evaluate_fusion(checkpoint, &predictor, &recordings)?);
    }
    if let Some(path) = outputs.preview {
        people::of_predictions(checkpoint, &evaluated, path)?;
    }
    write_json(outputs.json, &report)?;
    // The figure comes last, so that an error of drawing does not cost the scores.
    if let Some(path) = outputs.curves {
        draw(path, &report)?;
    }
    Ok(())
}

/// Evaluates and prints the poses at the output rate.
fn evaluate_fusion(
    checkpoint: &BodyCheckpoint,
    predictor: &BodyPredictor,
    recordings: &BodyRecordings,
) -> Result<Fusion> {
    let bootstrap = &checkpoint.config.evaluation.bootstrap;
    let config = PropagationConfig { output_hz: 1e3, ..PropagationConfig::default() };
    let progress = bar("fusing", recordings.files.len() as u64, "recordings");
    let advance = |done| progress.inc(done);
    let propagated = evaluate_propagation(checkpoint, predictor, recordings, &config, &advance)?;
    progress.finish_and_clear();
    let [held, fused, held_where_both, fused_where_both] = [
        propagated.last_detection,
        propagated.propagated,
        propagated.last_detection_on_common_joints,
        propagated.propagated_on_common_joints,
    ]
    .map(|evaluation| evaluation.summary(&PERCENTS, bootstrap));
    let fusion = Fusion {
        last_detection: held?,
        propagated: fused?,
        last_detection_on_common_joints: held_where_both?,
        propagated_on_common_joints: fused_where_both?,
    };
    say(format!(
        "at {} Hz, from {} inferences/s with a latency of {} ms:",
        config.output_hz, config.network_hz, config.latency_ms
    ));
    print("last pose", &fusion.last_detection.raw);
    print("propagated", &fusion.propagated.raw);
    // Means over joints that only one of them has cannot be compared.
    say("on the joints that both predict:");
    print("last pose", &fusion.last_detection_on_common_joints.raw);
    print("propagated", &fusion.propagated_on_common_joints.raw);
    Ok(fusion)
}

/// A value with its confidence interval.
pub(super) fn cell(interval: Option<Interval>, digits: usize) -> String {
    match interval {
        None => "-".to_owned(),
        Some(Interval { estimate, low: Some(low), high: Some(high) }) => {
            format!("{estimate:.digits$} [{low:.digits$}, {high:.digits$}]")
        }
        Some(Interval { estimate, .. }) => format!("{estimate:.digits$}"),
    }
}

pub(in crate::tasks) fn print(method: &str, scores: &BodyScores) {
    let shares: Vec<String> = PERCENTS
        .iter()
        .zip(&scores.pck)
        .map(|(percent, pck)| format!("PCK@0.{} {}", percent / 10, cell(*pck, 3)))
        .collect();
    say(format!(
        "{method:<10} {}  AUC {}  MPJPE {} px",
        shares.join("  "),
        cell(scores.auc, 3),
        cell(scores.mpjpe_px, 2)
    ));
}

/// Prints jitter without and with the filter, and its settings.
fn print_filter(
    [network, filtered]: [&BodySummary; 2],
    filter: &BodyFilterConfig,
    estimated: Option<&BodyFilterConfig>,
) {
    let of = |filter: &BodyFilterConfig| {
        format!("{:.1} Hz, exponent {:.1}", filter.cutoff_hz, filter.score_exponent)
    };
    say(format!(
        "jitter     network {} px/s², filtered {} px/s²; filter {}, estimated here {}",
        cell(network.acceleration_px_s2, 0),
        cell(filtered.acceleration_px_s2, 0),
        of(filter),
        estimated.map_or_else(|| "-".to_owned(), of)
    ));
}

/// Prints what is reported of nobody, of people, and of joints out of view.
fn print_detections(counts: &DetectionCounts) {
    let share = |part: u64, all: u64| 100.0 * part as f64 / all.max(1) as f64;
    if let Some(rate) = counts.false_per_minute() {
        say(format!(
            "nobody in view for {:.1} min: {rate:.1} false detections per minute, {:.1}% of the poses",
            counts.empty_min,
            share(counts.false_poses, counts.empty)
        ));
    }
    if counts.people > 0 {
        say(format!(
            "people not found: {:.1}% of the poses; joints out of view left out: {:.1}% of {}",
            share(counts.missed_poses, counts.people),
            share(counts.joints_left_out, counts.joints_out_of_view),
            counts.joints_out_of_view
        ));
    }
}

fn print_joints(summary: &BodySummary) {
    say(format!(
        "{:<12}{:>9}{:>9}{:>10}{:>9}",
        "joint", "PCK@0.4", "PCK@0.8", "MPJPE px", "missing"
    ));
    let formatted =
        |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3}"));
    for joint in summary.raw.joints.iter().filter(|joint| joint.labelled > 0) {
        let at = |percent: usize| {
            let place = summary.percents.iter().position(|p| *p == percent)?;
            joint.pck.get(place).copied().flatten()
        };
        say(format!(
            "{:<12}{:>9}{:>9}{:>10}{:>8.1}%",
            joint.joint,
            formatted(at(40)),
            formatted(at(80)),
            joint.mpjpe_px.map_or_else(|| "-".to_owned(), |px| format!("{px:.2}")),
            100.0 * joint.missing as f64 / joint.labelled as f64,
        ));
    }
    let without = summary.raw.joints.iter().filter(|joint| joint.labelled == 0);
    let without: Vec<&str> = without.map(|joint| joint.joint.as_str()).collect();
    if !without.is_empty() {
        say(format!("no label of {}: left out of all means", without.join(", ")));
    }
    let (all, found) = summary
        .raw
        .joints
        .iter()
        .fold((0, 0), |(all, found), joint| (all + joint.unlabelled, found + joint.spurious));
    if all > 0 {
        say(format!(
            "{all} joints without a label, which are out of view: {:.1}% found nevertheless",
            100.0 * found as f64 / all as f64
        ));
    }
}

/// Plots PCK against its threshold.
fn draw(path: &Path, report: &Report) -> Result<()> {
    let curve = |(name, summary): (&str, &BodySummary), colour| {
        let points = (1..).zip(&summary.raw.curve).map(|(p, y)| (f64::from(p) / 100.0, *y));
        Series::line(name, colour, points.collect())
    };
    let both = [("network", &report.network), ("mean pose", &report.mean_pose)];
    let all = both.into_iter().zip(PALETTE).map(|(both, colour)| curve(both, colour)).collect();
    let svg = chart::pck("Correct joints", "threshold, fraction of the torso's diagonal", all)?;
    write_file(path, svg)?;
    say(format!("curves: {}", path.display()));
    Ok(())
}

/// Number of the recordings with the lowest scores that are printed.
const LOWEST: usize = 5;

fn by_recording(
    evaluated: &BodyResults,
    bootstrap: &BootstrapConfig,
) -> Result<Vec<RecordingScores>> {
    let scores_of = |recording: &BodyRecordingResult| {
        let alone = BodyEvaluation { sequences: vec![recording.network.clone()] };
        let name = recording.events.file_name().unwrap_or_default();
        Ok(RecordingScores {
            file: name.to_string_lossy().into_owned(),
            scores: alone.summary(&PERCENTS, bootstrap)?.raw,
        })
    };
    evaluated.recordings.iter().map(scores_of).collect()
}

fn print_lowest(recordings: &[RecordingScores]) {
    let share = |recording: &RecordingScores| {
        let at = PERCENTS.iter().position(|percent| *percent == 40)?;
        recording.scores.pck.get(at).copied().flatten().map(|pck| pck.estimate)
    };
    let mut ordered: Vec<&RecordingScores> = recordings.iter().collect();
    // What has no score comes last: no share is above 1.
    ordered.sort_by(|a, b| share(a).unwrap_or(2.0).total_cmp(&share(b).unwrap_or(2.0)));
    say(format!("lowest PCK@0.4 of {} recordings:", recordings.len()));
    for recording in ordered.into_iter().take(LOWEST) {
        print(&recording.file, &recording.scores);
    }
}
