//! `evpose demo`: the whole hand pipeline on the embedded default, in a given time.

mod plan;
mod shipped;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use burn::tensor::Device;
use evpose_task::hand::{HandCheckpoint, HandConfig};
use evpose_train::{HandDataset, TrainOptions, TrainSummary, read_history, train_hand};
use serde_json::{Map, Value, json};

use crate::args::DeviceArgs;
use crate::configs;
use crate::json::write_result;
use crate::machine::Machine;
use crate::pages::hand as report;
use crate::pages::held_out;
use crate::progress::say;
use crate::ranges::{count, within};
use crate::recorded::{self, SimulationSummary};
use crate::run_info;
use plan::Speeds;
use shipped::Shipped;

/// Arguments of `evpose demo`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    evpose demo --out runs/first\n  \
    evpose demo --minutes 1        # no training: the network that is shipped\n  \
    evpose demo --minutes 60 --config hand-wide")]
pub struct DemoArgs {
    /// Directory for data, checkpoints and report [default: a fresh one below runs/]
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
    /// Time for the whole on this machine, whose speed is measured first: data and training steps are
    /// reduced to what fits. Below 3, nothing is trained: the shipped network is evaluated
    #[arg(long, default_value_t = 9.0, value_parser = within(0.1..=1e4))]
    pub(crate) minutes: f64,
    /// A TOML file, or an embedded config
    #[arg(long, default_value = "quick")]
    pub(crate) config: String,
    /// Change one field, for example --set training.steps=500 (may be repeated)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) overrides: Vec<String>,
    /// Milliseconds between the poses that are evaluated
    #[arg(long, default_value_t = 5, value_parser = count::<u32>())]
    pub(crate) stride_ms: u32,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

const MIN_TRAINING_MINUTES: f64 = 3.0;
/// Sequences that the shipped network is shown on, at most.
const SHOWN_SEQUENCES: usize = 6;

/// Directory of demos without --out.
const RUNS: &str = "runs";

/// Runs `evpose demo`.
pub fn run(args: &DemoArgs) -> Result<()> {
    let started = Instant::now();
    let device = args.device.open()?;
    let config: HandConfig = configs::load(&args.config, &args.overrides)?;
    let shipped = Shipped::load(&device)?;
    let out = output_directory(args)?;
    let machine = Machine::this();
    say(format!("machine: {machine}"));
    say(format!("output:  {}", out.display()));
    if args.minutes < MIN_TRAINING_MINUTES {
        let shipped = shipped.context(
            "nothing can be trained in so short a time, and checkpoints/hand.bpk is not there: run \
             from the repository, or give --minutes 9",
        )?;
        return show_shipped(args, &config, &shipped, &device, &out);
    }
    let config = planned(&config, args, started)?;
    run_info::write(&out, config.seed, Some(&config))?;
    let sets = DataSets::simulate(&config, &out)?;

    say(format!(
        "2/4 training {} of width {} for {} steps of {}",
        config.network.backbone,
        config.network.width,
        config.training.steps,
        config.training.batch_size
    ));
    let run = out.join("train");
    // Plain lines: a dashboard would wait for a key at the end.
    let options = TrainOptions::new(args.device.device);
    let summary = train_hand(&config, &sets.train_dir, &run, &options)?;

    say("3/4 evaluating on held-out sequences");
    let data = HandDataset::open(&sets.held_out_dir, &config)?;
    let mean = summary.best.mean_pose.context("the training poses have no mean")?;
    let trained = summary.best.predictor(device.clone())?;
    let mut evaluation =
        held_out::evaluate_with_baselines(&config, &data, trained, mean, &device, args.stride_ms)?;
    evaluation.metrics.measured = measured(&sets, &summary);
    match &shipped {
        Some(shipped) => {
            shipped.introduce()?;
            let directory = out.join("data/held-out-shipped");
            let results = shipped.evaluate(&config, &directory, &device, args.stride_ms)?;
            evaluation.add(&config, results)?;
        }
        None => say("    no checkpoints/hand.bpk here: the shipped network is not shown"),
    }

    say("4/4 writing the report");
    let mut facts = vec![format!("machine: {machine}"), format!("commit: {}", run_info::COMMIT)];
    facts.extend(experiment_facts(&config, args, &sets, &summary));
    facts.push(format!("time until this report: {:.0} s", started.elapsed().as_secs_f64()));
    let history = read_history(&run.join("metrics.jsonl"))?;
    report::write(&out, &config, &data, &evaluation, (&history, &facts))?;
    // The report itself takes time, which counts as well.
    let total_s = started.elapsed().as_secs_f64();
    evaluation.metrics.measured.insert("demo_s".to_owned(), json!(total_s));
    write_result(&out.join("metrics.json"), &evaluation.metrics)?;

    say("");
    held_out::print(&config, &evaluation);
    say("");
    say(format!("done in {:.1} minutes; checkpoint: {}", total_s / 60.0, summary.path.display()));
    say_results(&out);
    say(format!(
        "next:    evpose infer --checkpoint {} --events YOUR_RECORDING --out poses.csv",
        run.display()
    ));
    Ok(())
}

/// The config with what fits into the time that is left.
fn planned(config: &HandConfig, args: &DemoArgs, started: Instant) -> Result<HandConfig> {
    let speeds = Speeds::measure(config, args.device.device)?;
    // Measuring took a part of the minutes, too.
    let budget_s = 60.0 * args.minutes - started.elapsed().as_secs_f64();
    let (planned, expected_s) = speeds.plan(config, budget_s, args.stride_ms);
    say(format!(
        "speed:   {:.0} simulated steps/s, {:.0} training samples/s, {:.0} poses/s",
        speeds.simulated_steps_hz, speeds.trained_samples_hz, speeds.evaluated_poses_hz
    ));
    let (now, whole) = (&planned.training, &config.training);
    let reduced = if now.steps < whole.steps { "; --minutes for more" } else { "" };
    say(format!(
        "plan:    {} of {} sequences, {} of {} steps, about {:.1} of {} minutes{reduced}",
        planned.simulation.sequences,
        config.simulation.sequences,
        now.steps,
        whole.steps,
        (started.elapsed().as_secs_f64() + expected_s) / 60.0,
        args.minutes
    ));
    Ok(planned)
}

/// Evaluates and draws the shipped network alone.
fn show_shipped(
    args: &DemoArgs,
    config: &HandConfig,
    shipped: &Shipped,
    device: &Device,
    out: &Path,
) -> Result<()> {
    let started = Instant::now();
    shipped.introduce()?;
    let mut scenes = shipped.scenes(config);
    // A glance at the network, not a measurement of it: few sequences keep the demo short.
    scenes.evaluation.sequences = scenes.evaluation.sequences.min(SHOWN_SEQUENCES);
    run_info::write(out, scenes.seed, Some(&scenes))?;
    let directory = out.join("data/held-out");
    let held_out = recorded::record(&scenes.held_out(), &directory, "held-out")?;
    say(format!("    held out: {held_out}"));
    let checkpoint = &shipped.checkpoint;
    let data = HandDataset::open(&directory, &checkpoint.config)?;
    let mean = checkpoint.mean_pose.context("the checkpoint has no mean pose")?;
    let trained = checkpoint.predictor(device.clone())?;
    // Its own config, not the demo's: the network knows only its own representation.
    let own = &checkpoint.config;
    let evaluation =
        held_out::evaluate_with_baselines(own, &data, trained, mean, device, args.stride_ms)?;
    let facts = [
        format!("machine: {}", Machine::this()),
        format!("commit: {}", run_info::COMMIT),
        format!("checkpoint: {}", shipped.path.display()),
        format!("held-out data: {held_out}"),
    ];
    report::write(out, own, &data, &evaluation, (&[], &facts))?;
    write_result(&out.join("metrics.json"), &evaluation.metrics)?;
    say("");
    held_out::print(own, &evaluation);
    say("");
    say(format!(
        "nothing was trained: the shipped network {} was evaluated on {} simulated sequences, in {:.1} minutes",
        shipped.path.display(),
        data.sequences().len(),
        started.elapsed().as_secs_f64() / 60.0
    ));
    say_results(out);
    say("next:    evpose demo --minutes 9    # trains a network of its own");
    Ok(())
}

fn say_results(out: &Path) {
    say(format!("metrics: {}", out.join("metrics.json").display()));
    say(format!("frames:  {}", out.join("frames.png").display()));
    say(format!("report:  {}", out.join("report.html").display()));
}

/// The directory of the demo: that of the arguments, which must be empty, or a fresh one.
fn output_directory(args: &DemoArgs) -> Result<PathBuf> {
    match &args.out {
        Some(out) if out.read_dir().is_ok_and(|mut entries| entries.next().is_some()) => {
            bail!("{} is not empty: choose another --out", out.display())
        }
        Some(out) => Ok(out.clone()),
        None => Ok(fresh(Path::new(RUNS))),
    }
}

/// Simulated training and held-out sequences.
struct DataSets {
    train_dir: PathBuf,
    held_out_dir: PathBuf,
    train: SimulationSummary,
    held_out: SimulationSummary,
}

impl DataSets {
    fn simulate(config: &HandConfig, out: &Path) -> Result<Self> {
        let (train_dir, held_out_dir) = (out.join("data/train"), out.join("data/held-out"));
        say("1/4 simulating training sequences");
        let train = recorded::record(config, &train_dir, "training")?;
        say(format!("    {train}"));
        let held_out = recorded::record(&config.held_out(), &held_out_dir, "held-out")?;
        say(format!("    held out: {held_out}"));
        Ok(Self { train_dir, held_out_dir, train, held_out })
    }
}

/// Speeds of the demo, for `metrics.json`.
fn measured(sets: &DataSets, summary: &TrainSummary<HandCheckpoint>) -> Map<String, Value> {
    let measured = json!({
        "simulated_steps_per_second": sets.train.steps_per_second(),
        "trained_samples": summary.samples,
        "trained_samples_per_second": summary.samples_per_second,
        "training_s": summary.elapsed.as_secs_f64(),
        "training_waited_for_data_share": summary.data_wait.share(),
    });
    measured.as_object().cloned().unwrap_or_default()
}

/// Lines of the report about the experiment.
fn experiment_facts(
    config: &HandConfig,
    args: &DemoArgs,
    sets: &DataSets,
    summary: &TrainSummary<HandCheckpoint>,
) -> [String; 5] {
    [
        format!("seed: {}", config.seed),
        format!("training data: {}", sets.train),
        format!("held-out data: {}", sets.held_out),
        format!(
            "training: {} samples in {:.0} s, {:.0} samples/s on {}, {}",
            summary.samples,
            summary.elapsed.as_secs_f64(),
            summary.samples_per_second,
            args.device.device.name(),
            summary.data_wait
        ),
        format!("evaluation: a pose every {} ms", args.stride_ms),
    ]
}

/// The first of `runs/demo`, `runs/demo-2`, … that does not exist.
fn fresh(runs: &Path) -> PathBuf {
    let first = runs.join("demo");
    if !first.exists() {
        return first;
    }
    (2..).map(|n| runs.join(format!("demo-{n}"))).find(|dir| !dir.exists()).unwrap_or(first)
}
