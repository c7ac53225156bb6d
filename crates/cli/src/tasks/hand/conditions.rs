//! `evpose eval --conditions`: evaluation on sequences simulated under several conditions, such as
//! low light.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use evpose_core::stats::interval::Interval;
use evpose_pose::HandParams;
use evpose_pose::metric::{HandRatios, HandSummary};
use evpose_task::Experiment as _;
use evpose_task::hand::{ConstantPose, HandConfig, NetworkPredictor};
use evpose_train::{
    Condition, HandDataset, Method, MethodResults, SlowMotionResults, SlowMotionUsage, evaluate,
    evaluate_slow_motion, evaluated_pose_count,
};
use serde::Serialize;
use serde_json::{Map, Value};

use super::HandNetwork;
use super::args::HandEvalArgs;
use crate::json::write_result;
use crate::machine::Machine;
use crate::outputs::write_file;
use crate::pages::hand as report;
use crate::pages::held_out::{cell, find};
use crate::progress::{bar, say};
use crate::recorded;
use crate::run_info::{self, COMMIT};
use crate::tasks::args::EvalArgs;
use evpose_report::canvas::{PREDICTION, SLOW_MOTION};
use evpose_report::png::png;

/// Contents of `conditions.json`.
#[derive(Debug, Serialize)]
struct Report {
    conditions: Map<String, Value>,
    sequences: usize,
    /// Length of each sequence.
    seconds: f64,
    stride_ms: u32,
    seed: u64,
    commit: &'static str,
    machine: Machine,
}

#[derive(Debug, Serialize)]
struct Entry<'a> {
    about: String,
    /// Metrics of each method, by its name.
    methods: Map<String, Value>,
    /// Errors of the slow-motion mode over those of the plain pipeline, paired by sequence.
    slow_motion_over_trained_kalman: HandRatios,
    usage: &'a SlowMotionUsage,
    /// Config of the simulation as TOML.
    config: String,
}

struct ConditionEvaluation {
    condition: Condition,
    config: HandConfig,
    methods: Vec<MethodResults>,
    usage: SlowMotionUsage,
}

pub(super) fn run(model: &HandNetwork, args: &EvalArgs, own: &HandEvalArgs) -> Result<()> {
    let checkpoint = &model.checkpoint;
    // All configs are validated first: an error in the last should not wait for the others.
    let conditions = own
        .conditions
        .iter()
        .map(|source| {
            let condition = Condition::load(source)?;
            let mut config = condition.apply(&checkpoint.config)?.held_out();
            config.simulation.sequences = own.sequences;
            config.simulation.seconds = own.seconds;
            config.simulation.validate()?;
            Ok((condition, config))
        })
        .collect::<Result<Vec<_>>>()?;
    // Names are directories: two of one name would share their sequences.
    for (i, (condition, _)) in conditions.iter().enumerate() {
        if conditions[..i].iter().any(|(earlier, _)| earlier.name == condition.name) {
            bail!("--conditions names `{}` twice", condition.name);
        }
    }
    // It outlives the match, or the directory would be removed before it is used.
    let scratch;
    let out: &Path = match &own.out {
        Some(out) if out.read_dir().is_ok_and(|mut entries| entries.next().is_some()) => {
            bail!("{} is not empty: choose another --out", out.display())
        }
        Some(out) => out,
        None => {
            scratch = tempfile::tempdir().context("making a directory for the sequences")?;
            scratch.path()
        }
    };

    let mut all = Vec::new();
    for (condition, config) in conditions {
        say(format!("{}: {}", condition.name, condition.about()));
        let dir = out.join(&condition.name);
        say(format!("    {}", recorded::record(&config, &dir, &condition.name)?));
        let data = HandDataset::open(&dir, &config)?;
        let (network, mean) = (model.predictor(own.own.precision)?, model.mean_pose(&data)?);
        let (methods, usage) =
            evaluate_methods(&config, &data, network, mean, args.stride_ms.unwrap_or(1))?;
        if own.out.is_some() {
            let plain = find(&methods, "trained_kalman")?;
            let slow = find(&methods, "slow_motion")?;
            let sheet = report::strip(&config, &data, &[(plain, PREDICTION), (slow, SLOW_MOTION)])?;
            let path = figure_path(out, &condition);
            write_file(&path, &png(&sheet)?)?;
        }
        all.push(ConditionEvaluation { condition, config, methods, usage });
    }

    let report = report_of(&all, args, own)?;
    let mut files: Vec<PathBuf> = args.json.iter().map(|path| path.to_path_buf()).collect();
    if own.out.is_some() {
        run_info::write(out, checkpoint.config.seed, Some(&checkpoint.config))?;
        files.push(out.join("conditions.json"));
    }
    for path in &files {
        write_result(path, &report)?;
    }
    say("");
    print_scores(&all);
    say("");
    print_usage(&all);
    for path in &files {
        say(format!("written to {}", path.display()));
    }
    if own.out.is_some() {
        for evaluation in &all {
            say(format!("figure: {}", figure_path(out, &evaluation.condition).display()));
        }
    }
    Ok(())
}

fn figure_path(out: &Path, condition: &Condition) -> PathBuf {
    out.join(format!("{}.png", condition.name))
}

/// The mean pose, the plain pipeline without and with its filter, and the slow-motion mode.
fn evaluate_methods(
    config: &HandConfig,
    data: &HandDataset,
    mut network: NetworkPredictor,
    mean: HandParams,
    stride_ms: u32,
) -> Result<(Vec<MethodResults>, SlowMotionUsage)> {
    let mut constant = ConstantPose(mean);
    let mut methods = [
        Method { name: "mean_pose", predictor: &mut constant, filtered: None },
        Method { name: "trained", predictor: &mut network, filtered: Some("trained_kalman") },
    ];
    let progress = bar("evaluating", evaluated_pose_count(config, data, stride_ms), "poses");
    let mut evaluated =
        evaluate(config, data, &mut methods, stride_ms, &mut |done| progress.inc(done))?;
    progress.finish_and_clear();

    let total_ms = data.sequences().iter().map(|sequence| sequence.frames()).sum();
    let progress = bar("slow motion", total_ms, "ms");
    let mut advance = |ms| progress.inc(ms);
    let SlowMotionResults { methods, usage } =
        evaluate_slow_motion(config, data, &mut network, stride_ms, &mut advance)?;
    progress.finish_and_clear();
    evaluated.extend(methods);
    Ok((evaluated, usage))
}

fn report_of(all: &[ConditionEvaluation], args: &EvalArgs, own: &HandEvalArgs) -> Result<Report> {
    let mut conditions = Map::new();
    for ConditionEvaluation { condition, config, methods, usage } in all {
        let bootstrap = &config.evaluation.bootstrap;
        let mut lines = Map::new();
        for method in methods {
            let summary = method.evaluation.summary(bootstrap);
            lines.insert(method.name.to_owned(), serde_json::to_value(summary)?);
        }
        let plain = &find(methods, "trained_kalman")?.evaluation;
        let slow = &find(methods, "slow_motion")?.evaluation;
        let entry = Entry {
            about: condition.about(),
            methods: lines,
            slow_motion_over_trained_kalman: slow.ratios_to(plain, bootstrap)?,
            usage,
            config: config.to_toml()?,
        };
        conditions.insert(condition.name.clone(), serde_json::to_value(entry)?);
    }
    Ok(Report {
        conditions,
        sequences: own.sequences,
        seconds: own.seconds,
        stride_ms: args.stride_ms.unwrap_or(1),
        seed: all.first().map_or(0, |evaluation| evaluation.config.seed),
        commit: COMMIT,
        machine: Machine::this(),
    })
}

/// A column of the table: heading, digits, and metric.
type Column = (&'static str, usize, fn(&HandSummary) -> Option<Interval>);

const COLUMNS: [Column; 5] = [
    ("translation mm", 1, |s| s.translation_mm),
    ("rotation deg", 1, |s| s.rotation_deg),
    ("MPJPE mm", 1, |s| s.mpjpe_mm),
    ("AUC 3D", 3, |s| s.auc_3d),
    ("AUC 2D", 3, |s| s.auc_2d),
];

fn print_scores(all: &[ConditionEvaluation]) {
    let heading: String = COLUMNS.iter().map(|(name, ..)| format!("{name:>24}")).collect();
    say(format!("{:<12}{:<18}{heading}", "condition", "method"));
    for evaluation in all {
        for method in &evaluation.methods {
            let summary = method.evaluation.summary(&evaluation.config.evaluation.bootstrap);
            let cells: String = COLUMNS
                .iter()
                .map(|(_, digits, get)| {
                    let (value, interval) = cell(get(&summary), *digits);
                    format!("{:>24}", format!("{value} {interval}").trim_end())
                })
                .collect();
            say(format!("{:<12}{:<18}{cells}", evaluation.condition.name, method.name));
        }
    }
}

/// Prints rates of the slow-motion mode.
fn print_usage(all: &[ConditionEvaluation]) {
    let headings = ["events/s", "inputs/s", "repeated %", "fast %", "wait ms"];
    let heading: String = headings.iter().map(|name| format!("{name:>14}")).collect();
    say(format!("{:<12}{:<18}{heading}", "condition", "slow motion"));
    for ConditionEvaluation { condition, usage, .. } in all {
        let inputs = usage.inputs.max(1) as f64;
        let values = [
            usage.events as f64 / usage.seconds,
            usage.inputs as f64 / usage.seconds,
            100.0 * usage.repeated as f64 / inputs,
            100.0 * usage.fast as f64 / inputs,
            1e3 * usage.waited_s / inputs,
        ];
        let cells: String = values.iter().map(|value| format!("{value:>14.1}")).collect();
        say(format!("{:<12}{:<18}{cells}", condition.name, ""));
    }
}
