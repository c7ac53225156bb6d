//! One file per command.

pub(crate) mod ablate;
mod account;
pub(crate) mod bench_infer;
mod bench_io;
pub(crate) mod bench_live;
mod bench_repr;
mod bench_sensor;
mod bench_sim;
mod bench_train;
mod body;
pub(crate) mod calibrate;
pub(crate) mod check_labels;
mod checkpoint_info;
pub(crate) mod clean;
mod conditions;
mod config_source;
pub(crate) mod convert;
mod data_set;
mod demo;
mod eval;
mod events;
mod export;
pub(crate) mod gap;
mod hand_joints;
pub(crate) mod held_out;
mod infer;
mod info;
#[cfg(test)]
mod job_files;
mod latency;
pub(crate) mod live;
pub(crate) mod opening;
pub(crate) mod prepare;
mod quantize;
pub(crate) mod sensor;
mod simulate;
mod train;
pub(crate) mod view;

use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context, Result};
use evpose_core::atomic_write;
use serde::Serialize;

use crate::args::{Args, BenchCommand, Command, DeviceArgs};

/// Does what was typed.
pub(crate) fn run(args: Args) -> Result<ExitCode> {
    match args.command {
        Command::Gap(command) => return gap::run(&command),
        Command::CheckLabels(args) => return check_labels::run(&args),
        Command::Calibrate(command) => calibrate::run(&command),
        Command::Ablate(command) => ablate::run(&command),
        Command::Demo(args) => demo::run(&args),
        Command::Simulate(args) => simulate::run(&args),
        Command::Events(args) => events::run(&args),
        Command::Prepare(command) => prepare::run(&command),
        Command::Train(args) => train::run(&args),
        Command::Eval(args) => eval::run(&args),
        Command::Infer(args) => infer::run(&args),
        Command::Live(args) => live::run(&args),
        Command::Quantize(args) => quantize::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Bench(BenchCommand::Infer(args)) => bench_infer::run(&args),
        Command::Bench(BenchCommand::Train(args)) => bench_train::run(&args),
        Command::Sensor(command) => sensor::run(&command),
        Command::Bench(BenchCommand::Sensor(args)) => bench_sensor::run(&args),
        Command::Bench(BenchCommand::Io(args)) => bench_io::run(&args),
        Command::Bench(BenchCommand::Repr(args)) => bench_repr::run(&args),
        Command::Bench(BenchCommand::Sim(args)) => bench_sim::run(&args),
        Command::Bench(BenchCommand::Live(args)) => bench_live::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Convert(args) => convert::run(&args),
        Command::Clean(args) => clean::run(&args),
        Command::View(args) => view::run(&args),
    }
    .map(|()| ExitCode::SUCCESS)
}

/// Writes what a benchmark measured to `path`, if the user gave one.
fn as_json(path: Option<&Path>, report: &impl Serialize) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let text = serde_json::to_string_pretty(report)? + "\n";
    atomic_write(path, text.as_bytes()).with_context(|| format!("writing {}", path.display()))
}

/// Sets the number of CPU threads for everything that follows.
fn use_threads(threads: Option<usize>) -> Result<()> {
    if let Some(threads) = threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global()
            .context("setting the number of threads")?;
    }
    Ok(())
}

/// The device that was asked for, with its threads.
fn device(args: &DeviceArgs) -> Result<burn::tensor::Device> {
    use_threads(args.threads)?;
    Ok(args.device.resolve()?)
}
