//! `evpose bench train`: how long one training step takes, and how much memory.

mod usage;

use std::time::Instant;

use anyhow::{Context as _, Result};
use burn::module::Module as BurnModule;
use burn::optim::ModuleOptimizer;
use burn::tensor::{Device, Tensor, TensorData};
use evpose_nn::{
    Adam, DeviceKind, HandLoss, MOVE_ENET, Network, adapter_name, set_training_kernels,
};
use evpose_task::hand::HandConfig;
use evpose_task::schedule::TrainingPrecision;
use evpose_train::training::mixed;
use evpose_train::untrained;
use serde::Serialize;

use crate::all::{Figure, threads};
use evpose_cli::args::DeviceArgs;
use evpose_cli::configs;
use evpose_cli::json::write_json;
use evpose_cli::latency;
use evpose_cli::outputs::OutputFile;
use evpose_cli::progress::say;
use evpose_cli::provenance::Provenance;
use evpose_cli::ranges::{count, within};
use evpose_core::stats::interval::median_outer_count;
use evpose_core::stats::quantile::{nearest_rank, outlier_count};
use usage::{peak_resident_mib, processor_s};

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose bench train\n  \
    evpose bench train --threads 1 --burn\n  \
    evpose bench train --config quick --steps 50 --json train.json\n  \
    evpose bench train --device cuda --precision bf16\n\n\
    Windows and poses are random. A step is the forward pass with the loss, the backward pass and Adam.")]
pub struct BenchTrainArgs {
    /// A TOML file, or an embedded config: its network and image size are measured
    #[arg(long, default_value = "eventhands")]
    pub(crate) config: String,
    /// A network of the registry instead of the config's own, of the config's width
    #[arg(long, value_name = "NAME")]
    pub(crate) network: Option<String>,
    /// Measured steps, after two to warm up
    #[arg(long, default_value_t = 20, value_parser = count::<usize>())]
    pub(crate) steps: usize,
    /// Windows of a step
    #[arg(long, default_value_t = 16, value_parser = within(1..=65_536_usize))]
    pub(crate) batch: usize,
    /// Time Burn's arithmetic instead of our kernels
    #[arg(long)]
    pub(crate) burn: bool,
    /// Number format of convolutions: f32, bf16 or f16
    #[arg(long, default_value = "f32", value_parser = precision)]
    pub(crate) precision: TrainingPrecision,
    /// Where to write the results as JSON
    #[arg(long)]
    pub(crate) json: Option<OutputFile>,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

fn precision(text: &str) -> Result<TrainingPrecision, String> {
    match text {
        "f32" => Ok(TrainingPrecision::F32),
        "bf16" => Ok(TrainingPrecision::Bf16),
        "f16" => Ok(TrainingPrecision::F16),
        _ => Err("is f32, bf16 or f16".to_owned()),
    }
}

/// Steps before those that are measured: memory is asked for, the optimiser gets its moments.
const WARM_UP: usize = 2;

/// Content of the JSON file.
#[derive(Debug, Serialize)]
struct Report {
    network: String,
    width: f32,
    parameters: usize,
    input: [usize; 4],
    device: String,
    /// The hardware of the device, if it is a GPU.
    adapter: Option<String>,
    #[serde(flatten)]
    provenance: Provenance,
    /// Implementation: our kernels or Burn.
    by: &'static str,
    precision: TrainingPrecision,
    steps: usize,
    step: Times,
    forward: Times,
    backward: Times,
    update: Times,
    /// Processor time of all threads for a step; 0 where the system does not report it.
    processor_ms: f64,
    /// The most memory that the process held; 0 where the system does not report it.
    peak_resident_mib: f64,
    windows_per_second: f64,
    /// Modified z-scores above 3.5 (Iglewicz and Hoaglin 1993): signs of a busy machine.
    outliers: usize,
    /// The loss of the last step: equal for equal bits.
    loss: f32,
}

/// Times of a phase of a step, in milliseconds.
#[derive(Debug, Serialize)]
struct Times {
    median_ms: f64,
    /// An interval that holds the median of all steps with at least 95 % (order statistics), the
    /// smallest and the largest where there are fewer than six.
    interval_ms: [f64; 2],
    min_ms: f64,
}

impl Times {
    fn from_samples(mut times_ms: Vec<f64>) -> Self {
        times_ms.sort_by(f64::total_cmp);
        let n = times_ms.len();
        let outer = median_outer_count(n);
        Self {
            median_ms: nearest_rank(&times_ms, 0.5),
            interval_ms: [times_ms[outer], times_ms[n - 1 - outer]],
            min_ms: times_ms[0],
        }
    }
}

pub(crate) fn run(args: &BenchTrainArgs) -> Result<()> {
    write_json(args.json.as_deref(), &measure(args)?)
}

pub(crate) fn figure(args: &BenchTrainArgs) -> Result<Figure> {
    let report = measure(args)?;
    let [batch, ..] = report.input;
    let threads = threads(report.provenance.machine.threads);
    let work = format!("{}, a step of {batch}, {threads}", report.network);
    Ok(Figure::time("train", work, "ms", report.step.median_ms))
}

fn measure(args: &BenchTrainArgs) -> Result<Report> {
    let mut config: HandConfig = configs::load(&args.config, &[])?;
    let target = args.device.open()?.autodiff();
    mixed::check(args.precision, &target)?;
    set_training_kernels(!args.burn);
    if let Some(name) = &args.network {
        name.clone_into(&mut config.network.backbone);
    }
    let report = if config.network.backbone == MOVE_ENET {
        of_body(args, &config, &target)?
    } else {
        of_hand(args, &config, &target)?
    };
    let report = Report { adapter: adapter_name(&target), ..report };
    print(&report);
    Ok(report)
}

/// A step of a hand's network: its loss against random poses.
fn of_hand(args: &BenchTrainArgs, config: &HandConfig, device: &Device) -> Result<Report> {
    let sensor = config.network_size();
    let input = [args.batch, 2, usize::from(sensor.height), usize::from(sensor.width)];
    let windows = images(input, config.seed, 1.0, device);
    let outputs = config.network.rotation.outputs();
    // The seed differs from that of the windows, whose values poses must not repeat.
    let poses = latency::windows([args.batch, outputs, 1, 1], config.seed ^ 1);
    let poses = TensorData::new(poses, [args.batch, outputs]);
    let poses = Tensor::<2>::from_data(poses, device);
    let loss = HandLoss::new(config.loss);
    let network = untrained(config, device)?.into_regressor();
    let network = network.context("a step is measured of a regressor: network.head must be it")?;
    Ok(measured(args, config, input, network, |network| {
        let windows = mixed::rounded(args.precision, windows.clone());
        loss.forward(network.forward(windows), poses.clone()).objective
    }))
}

/// A step of a body's network: the mean squares of its maps, each from random numbers.
fn of_body(args: &BenchTrainArgs, config: &HandConfig, device: &Device) -> Result<Report> {
    let network = Network::untrained(MOVE_ENET, config.network.width, config.seed, device)?;
    let ([channels, height, width], brightest) = (network.input(), network.max_input());
    let Network::Body(network) = network else { unreachable!("of this name") };
    let input = [args.batch, channels, height, width];
    let windows = images(input, config.seed, brightest, device);
    let target = |map: Tensor<4>| images(map.dims(), config.seed ^ 1, 1.0, device);
    // Only a forward pass shows the sizes of the maps, which their targets share.
    let targets = network.forward(windows.clone()).into_array().map(target);
    Ok(measured(args, config, input, *network, |network| {
        let windows = mixed::rounded(args.precision, windows.clone());
        let maps = network.forward(windows).into_array().into_iter();
        let by_map = maps.zip(&targets).map(|(map, target)| (map - target.clone()).square().mean());
        by_map.reduce(|sum, map| sum + map).unwrap_or_else(|| unreachable!("four"))
    }))
}

fn images(size: [usize; 4], seed: u64, brightest: f32, device: &Device) -> Tensor<4> {
    Tensor::from_data(TensorData::new(latency::windows(size, seed), size), device) * brightest
}

/// Times of the steps that lower an objective.
fn measured<M: BurnModule>(
    args: &BenchTrainArgs,
    config: &HandConfig,
    input: [usize; 4],
    mut network: M,
    objective: impl Fn(&M) -> Tensor<1>,
) -> Report {
    let provenance = Provenance::this();
    let precision = args.precision;
    let mut stepper = Stepper { adam: Adam::new(0.0).into(), precision, loss_was: 0.0 };
    let parameters = network.num_params();
    let steps = args.steps.max(1);
    let mut phases: [Vec<f64>; 4] = Default::default();
    let mut before_s = processor_s();
    for step in 0..WARM_UP + steps {
        if step == WARM_UP {
            // Processor time of the warm-up is not counted either.
            before_s = processor_s();
        }
        let times;
        (network, times) = stepper.step(network, &objective, config.training.learning_rate);
        if step >= WARM_UP {
            phases.iter_mut().zip(times).for_each(|(all, time)| all.push(time));
        }
    }
    let processor_ms = 1e3 * (processor_s() - before_s) / steps as f64;
    let [step, forward, backward, update] = phases;
    let mut sorted = step.clone();
    sorted.sort_by(f64::total_cmp);
    // Our kernels are for the CPU alone.
    let ours =
        !args.burn && args.device.device == DeviceKind::Flex && precision == TrainingPrecision::F32;
    let [step, forward, backward, update] =
        [step, forward, backward, update].map(Times::from_samples);
    Report {
        network: config.network.backbone.clone(),
        width: config.network.width,
        parameters,
        input,
        device: args.device.device.to_string(),
        adapter: None,
        provenance,
        by: if ours { "our kernels" } else { "Burn" },
        precision,
        steps,
        // The median step: interruptions by the system do not count.
        windows_per_second: args.batch as f64 * 1e3 / step.median_ms,
        step,
        forward,
        backward,
        update,
        processor_ms,
        peak_resident_mib: peak_resident_mib(),
        outliers: outlier_count(&sorted),
        loss: stepper.loss_was,
    }
}

fn print(report: &Report) {
    say(format!("machine   {}", report.provenance.machine));
    if let Some(adapter) = &report.adapter {
        say(format!("device    {}: {adapter}", report.device));
    }
    say(format!(
        "network   {} of width {}, {} parameters, input {:?}, on {} by {}",
        report.network, report.width, report.parameters, report.input, report.device, report.by
    ));
    let Times { median_ms, interval_ms: [low, high], min_ms } = report.step;
    say(format!(
        "step      {median_ms:.0} ms [{low:.0}, {high:.0}], min {min_ms:.0}, processor {:.0} ms  ({} \
         steps, {:.1} windows/s)",
        report.processor_ms, report.steps, report.windows_per_second
    ));
    say(format!(
        "phases    forward and loss {:.0} ms, backward {:.0} ms, Adam {:.0} ms",
        report.forward.median_ms, report.backward.median_ms, report.update.median_ms
    ));
    say(format!("memory    {:.0} MiB at most", report.peak_resident_mib));
    say(format!("loss      {} after {} steps", report.loss, report.steps + WARM_UP));
    if report.outliers * 10 > report.steps {
        say(format!(
            "warning   {} of {} steps were outliers: the machine was busy, measure again",
            report.outliers, report.steps
        ));
    }
}

/// State of a training.
struct Stepper {
    adam: ModuleOptimizer,
    precision: TrainingPrecision,
    loss_was: f32,
}

impl Stepper {
    /// One step, with the milliseconds of all of it, its forward pass, its backward pass, its
    /// update.
    fn step<M: BurnModule>(
        &mut self,
        network: M,
        objective: &impl Fn(&M) -> Tensor<1>,
        learning_rate: f64,
    ) -> (M, [f64; 4]) {
        let started = Instant::now();
        let objective = objective(&network);
        // Reading a value makes a device that works in the background finish.
        self.loss_was = objective.clone().into_scalar::<f32>();
        let forward = started.elapsed();
        let gradients = mixed::gradients(self.precision, objective, &network);
        let backward = started.elapsed();
        let network = self.adam.step(learning_rate, network, gradients);
        let all = started.elapsed();
        let times = [all, forward, backward - forward, all - backward];
        (network, times.map(|time| time.as_secs_f64() * 1e3))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_of_medians_are_those_of_the_binomial_tables() {
        // Conover's table A3: ranks 2 and 9 of 10 values.
        let times = Times::from_samples((1..=10).rev().map(f64::from).collect());
        assert_eq!((times.median_ms, times.interval_ms, times.min_ms), (5.0, [2.0, 9.0], 1.0));
    }
}
