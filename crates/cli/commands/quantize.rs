//! `evpose quantize`, and predictions in fewer bits.

use std::time::Instant;

use anyhow::Result;
use burn::tensor::Device;
use evpose_infer::Precision;
use evpose_nn::HandRegressor;
use evpose_pose::metric::HandSummary;
use evpose_task::QuantizationRanges;
use evpose_task::hand::{HandCheckpoint, HandConfig, NetworkPredictor};
use evpose_train::{HandDataset, Method, evaluate, poses_to_judge};
use serde::Serialize;

use evpose_app::args::parse_threads;
use evpose_app::json::write_json;
use evpose_app::machine::Machine;
use evpose_app::progress::{bar, say};
use evpose_app::run_info::COMMIT;
use evpose_app::threads::use_threads;
use evpose_app::timing::quantile;
use evpose_report::held_out::cell;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose quantize --checkpoint runs/hand --data data/train \
    --judge data/test\n  evpose infer --checkpoint runs/hand --precision int8 --events hand.evc \
    --out poses.csv\n\nA byte stands for a step between the least and the largest value that a layer \
    was seen to make.\nThese are measured on the data and kept in int8.json beside the checkpoint.")]
pub(crate) struct QuantizeArgs {
    /// A run directory, or a .bpk file with its .toml beside it
    #[arg(long)]
    pub(crate) checkpoint: PathBuf,
    /// Directory of sequences to measure values on: those of the training
    #[arg(long)]
    pub(crate) data: PathBuf,
    /// Windows to measure values on, spread evenly
    #[arg(long, default_value_t = 256, value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) windows: u64,
    /// Directory of sequences the network has not seen, to judge f32, bf16 and int8 on
    #[arg(long)]
    pub(crate) judge: Option<PathBuf>,
    /// Milliseconds between the poses that are judged
    #[arg(long, default_value_t = 20, requires = "judge")]
    pub(crate) stride_ms: u32,
    /// Where to write the numbers
    #[arg(long, requires = "judge")]
    pub(crate) json: Option<PathBuf>,
    /// CPU threads; all cores by default
    #[arg(long, value_parser = parse_threads)]
    pub(crate) threads: Option<usize>,
}

/// Predictions of one window each that are timed.
const TIMED: usize = 50;

pub(crate) fn run(args: &QuantizeArgs) -> Result<()> {
    use_threads(args.threads)?;
    let device = Device::flex();
    let HandCheckpoint { config, network, .. } = HandCheckpoint::load(&args.checkpoint, &device)?;
    let data = HandDataset::open(&args.data, &config)?;
    let progress = bar("measuring", args.windows.min(data.len()), "windows");
    let quantized = QuantizationRanges::measure(&network, &data, args.windows, &mut || progress.inc(1))?;
    progress.finish_and_clear();
    let path = QuantizationRanges::path(&args.checkpoint);
    quantized.write(&path)?;
    say(format!("values of all layers: {}", path.display()));
    let Some(judge) = &args.judge else { return Ok(()) };
    let data = HandDataset::open(judge, &config)?;
    let report = Report::of(&config, &network, &quantized, &data, args.stride_ms)?;
    report.print();
    write_json(args.json.as_deref(), &report)
}

/// What fewer bits cost.
#[derive(Debug, Serialize)]
struct Report {
    machine: Machine,
    commit: &'static str,
    threads: usize,
    stride_ms: u32,
    precisions: Vec<Line>,
}

/// Numbers of one precision.
#[derive(Debug, Serialize)]
struct Line {
    precision: Precision,
    /// Median time of a prediction of one window.
    latency_ms: f64,
    held_out: HandSummary,
}

impl Report {
    fn of(
        config: &HandConfig,
        network: &HandRegressor,
        quantized: &QuantizationRanges,
        data: &HandDataset,
        stride_ms: u32,
    ) -> Result<Self> {
        let predictor = |precision| {
            NetworkPredictor::compiled(network, precision, Some(quantized.ranges().clone()))
        };
        let mut predictors = Precision::ALL.map(predictor);
        let mut methods = Vec::new();
        for (name, predictor) in ["f32", "bf16", "int8"].into_iter().zip(&mut predictors) {
            methods.push(Method { name, predictor, filtered: None });
        }
        let progress = bar("evaluating", poses_to_judge(config, data, stride_ms), "poses");
        let judged =
            evaluate(config, data, &mut methods, stride_ms, &mut |done| progress.inc(done))?;
        progress.finish_and_clear();
        let sequence = &data.sequences()[0];
        let window = data.surface(sequence, sequence.frames() - 1)?;
        let mut precisions = Vec::new();
        for (precision, (method, judged)) in
            Precision::ALL.into_iter().zip(methods.into_iter().zip(&judged))
        {
            let mut times_ms = Vec::with_capacity(TIMED);
            for _ in 0..TIMED {
                let begin = Instant::now();
                method.predictor.predict(&window, data.image_size())?;
                times_ms.push(begin.elapsed().as_secs_f64() * 1e3);
            }
            times_ms.sort_by(f64::total_cmp);
            precisions.push(Line {
                precision,
                latency_ms: quantile(&times_ms, 0.5),
                held_out: judged.evaluation.summary(&config.evaluation.bootstrap),
            });
        }
        Ok(Self {
            machine: Machine::this(),
            commit: COMMIT,
            threads: rayon::current_num_threads(),
            stride_ms,
            precisions,
        })
    }

    fn print(&self) {
        say(format!(
            "{:<10}{:>12}{:>28}{:>26}{:>26}",
            "precision", "ms a pose", "translation mm", "rotation deg", "articulation"
        ));
        for Line { precision, latency_ms, held_out } in &self.precisions {
            let error = |interval, digits| {
                let (number, interval) = cell(interval, digits);
                format!("{number} {interval}")
            };
            say(format!(
                "{:<10}{latency_ms:>12.2}{:>28}{:>26}{:>26}",
                precision.to_string(),
                error(held_out.translation_mm, 2),
                error(held_out.rotation_deg, 2),
                error(held_out.articulation, 3)
            ));
        }
    }
}
