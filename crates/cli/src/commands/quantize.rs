//! `evpose quantize`: calibration of int8 inference, and the accuracy of reduced precision.

use std::path::PathBuf;

use crate::args::DeviceArgs;
use crate::json::write_json;
use crate::machine::Machine;
use crate::outputs::OutputFile;
use crate::progress::{bar, say};
use crate::provenance::Provenance;
use crate::ranges::{count, threads};
use crate::tasks::PrecisionScores;
use anyhow::{Result, anyhow};
use evpose_infer::Precision;
use evpose_nn::DeviceKind;
use evpose_task::{QuantizationRanges, TaskError};
use serde::Serialize;

/// Arguments of `evpose quantize`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose quantize --checkpoint runs/hand --data data/train \
    --evaluate data/test\n  evpose infer --checkpoint runs/hand --precision int8 --events hand.evc \
    --out poses.csv\n  \
    evpose quantize --checkpoint body --data data/walkers\n\n\
    Calibration observes the value range of every layer on the data, and writes the ranges to int8.json\n\
    beside the checkpoint.")]
pub struct QuantizeArgs {
    /// A run directory, a .bpk file, or the name of a shipped network: `hand`, `body`, …
    #[arg(long)]
    pub(crate) checkpoint: PathBuf,
    /// Data set for the calibration: the training data
    #[arg(long)]
    pub(crate) data: PathBuf,
    /// Inputs for the calibration, spread evenly over the data
    #[arg(long, default_value_t = 256, value_parser = count::<u64>())]
    pub(crate) windows: u64,
    /// Held-out data set to evaluate f32, bf16 and int8 on
    #[arg(long)]
    pub(crate) evaluate: Option<PathBuf>,
    /// Milliseconds between evaluated poses
    #[arg(long, default_value_t = 20, requires = "evaluate", value_parser = count::<u32>())]
    pub(crate) stride_ms: u32,
    /// Where to write the results as JSON
    #[arg(long, requires = "evaluate")]
    pub(crate) json: Option<OutputFile>,
    /// CPU threads; all cores by default
    #[arg(long, value_parser = threads())]
    pub(crate) threads: Option<usize>,
}

/// Runs `evpose quantize`.
pub fn run(args: &QuantizeArgs) -> Result<()> {
    let device = DeviceArgs { device: DeviceKind::Flex, threads: args.threads };
    let model = crate::tasks::open(&args.checkpoint, &device)?;
    let model = model.network()?;
    let inputs = model.calibration_inputs(&args.data, args.windows)?;
    let progress = bar("calibrating", inputs.len() as u64, "inputs");
    let observed = || progress.inc(1);
    let ranges = calibrate(&model.graph(), model.input_shape(), inputs, observed)?;
    progress.finish_and_clear();
    let path = QuantizationRanges::path(&crate::shipped::checkpoint_path(&args.checkpoint)?);
    // Ranges are of use without the evaluation, which may be interrupted.
    ranges.write(&path)?;
    say(format!("ranges of all layers: {}", path.display()));
    let Some(data) = &args.evaluate else { return Ok(()) };
    let provenance = Provenance::new(Machine::this());
    let scores = model.evaluate_precisions(data, ranges.ranges(), args.stride_ms)?;
    print(&scores);
    write_json(args.json.as_deref(), &Report::new(provenance, scores, args.stride_ms))
}

/// Calibrates on inputs; the first that cannot be read ends the calibration.
fn calibrate(
    graph: &evpose_nn::graph::Graph,
    shape: [usize; 3],
    inputs: impl Iterator<Item = Result<Vec<f32>>>,
    mut observed: impl FnMut(),
) -> Result<QuantizationRanges> {
    // An input that cannot be read ends the inputs; its error is returned below.
    let mut failure = None;
    let readable = inputs.map_while(|input| input.map_err(|error| failure = Some(error)).ok());
    let ranges =
        QuantizationRanges::calibrate::<TaskError>(graph, shape, readable.map(Ok), &mut observed);
    match failure {
        Some(error) => Err(error),
        None => ranges.map_err(|error| anyhow!(error)),
    }
}

/// Accuracy and latency in reduced precision.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    provenance: Provenance,
    threads: usize,
    stride_ms: u32,
    precisions: Vec<Row>,
}

/// Results in one precision.
#[derive(Debug, Serialize)]
struct Row {
    precision: Precision,
    /// Median time of an inference of one input.
    latency_ms: f64,
    held_out: serde_json::Value,
}

impl Report {
    fn new(provenance: Provenance, scores: Vec<PrecisionScores>, stride_ms: u32) -> Self {
        let row = |scores: PrecisionScores| Row {
            precision: scores.precision,
            latency_ms: scores.latency_ms,
            held_out: scores.held_out,
        };
        Self {
            provenance,
            threads: rayon::current_num_threads(),
            stride_ms,
            precisions: scores.into_iter().map(row).collect(),
        }
    }
}

fn print(scores: &[PrecisionScores]) {
    let Some(first) = scores.first() else { return };
    let mut heading = format!("{:<10}{:>12}", "precision", "ms/pose");
    for (index, (name, _)) in first.cells.iter().enumerate() {
        heading += &format!("{name:>width$}", width = width(index));
    }
    say(heading);
    for PrecisionScores { precision, latency_ms, cells, .. } in scores {
        let mut row = format!("{:<10}{latency_ms:>12.2}", precision.to_string());
        for (index, (_, cell)) in cells.iter().enumerate() {
            row += &format!("{cell:>width$}", width = width(index));
        }
        say(row);
    }
}

/// Width of a column of scores.
fn width(index: usize) -> usize {
    if index == 0 { 28 } else { 26 }
}
