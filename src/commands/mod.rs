//! The registry of commands.

mod completions;
mod gap;
#[cfg(test)]
mod guides;
#[cfg(test)]
mod job_files;
mod man;

use std::process::{ExitCode, Termination};

use anyhow::Result;
use clap::Subcommand;
use evpose_cli::commands::{
    average, calibrate, check, check_labels, clean, convert, demo, eval, events, export, infer,
    info, live, prepare, quantize, represent, sensor, simulate, train, view,
};
use evpose_cli::tasks::args as tasks;
use evpose_studies::{ablate, compare, tune};

/// Declares the subcommands: help text, name, arguments and the function that runs them.
macro_rules! commands {
    ($($(#[$meta:meta])* $name:ident($args:ty) => $run:path,)*) => {
        /// The subcommands.
        #[derive(Debug, Subcommand)]
        pub(crate) enum Command {
            $($(#[$meta])* $name($args),)*
        }

        /// Runs a subcommand.
        pub(crate) fn run(command: &Command) -> Result<ExitCode> {
            match command {
                // Some commands end with codes of their own, such as `gap` and `check-labels`.
                $(Command::$name(args) => $run(args).map(Termination::report),)*
            }
        }
    };
}

commands! {
    /// Simulate, train, evaluate and write a report with the default config, in minutes
    Demo(demo::DemoArgs) => demo::run,
    /// Simulate labelled event recordings of hands or people
    Simulate(tasks::SimulateArgs) => simulate::run,
    /// Simulate events from image sequences
    Events(events::EventsArgs) => events::run,
    /// Convert public data sets, or recordings and labels of your own, to training data
    #[command(subcommand)]
    Prepare(prepare::PrepareCommand) => prepare::run,
    /// Check whether a recording can be used as it is: order, clock, unit, axes, noise, flicker
    Check(check::CheckArgs) => check::run,
    /// Check body labels for errors
    CheckLabels(check_labels::CheckLabelsArgs) => check_labels::run,
    /// Train a network of hands or bodies
    Train(tasks::TrainArgs) => train::run,
    /// Search for hyper-parameters: random or successive halving
    Tune(tune::TuneArgs) => tune::run,
    /// Evaluate a checkpoint on sequences with known poses
    Eval(tasks::EvalArgs) => eval::run,
    /// Predict the poses of a recording
    Infer(tasks::InferArgs) => infer::run,
    /// Predict poses online from a camera, a stream or a recording
    Live(live::LiveArgs) => live::run,
    /// Calibrate int8 quantisation, and measure the loss of accuracy
    Quantize(quantize::QuantizeArgs) => quantize::run,
    /// Average two networks, for example a shipped one and one trained further from it
    Average(average::AverageArgs) => average::run,
    /// Export a network as an ONNX file
    Export(export::ExportArgs) => export::run,
    /// Benchmarks: speed and memory of inference, training, simulation, files
    #[command(subcommand)]
    Bench(evpose_bench::BenchCommand) => evpose_bench::run,
    /// List, show and plot sensor models and their effects
    #[command(subcommand)]
    Sensor(sensor::SensorCommand) => sensor::run,
    /// Compare a sensor model with a recording, and identify missing effects
    #[command(subcommand)]
    Gap(gap::GapCommand) => gap::run,
    /// Estimate contrast thresholds, noise rates and hot pixels of a camera
    #[command(subcommand)]
    Calibrate(calibrate::CalibrateCommand) => calibrate::run,
    /// Ablation studies: retrain with one change at a time
    #[command(subcommand)]
    Ablate(ablate::AblateCommand) => ablate::run,
    /// Compare systems of others with MoveEnet, under one protocol
    #[command(subcommand)]
    Compare(compare::CompareCommand) => compare::run,
    /// Describe recordings, checkpoints, body models, data sets and devices
    Info(info::InfoArgs) => info::run,
    /// Convert a recording to another format
    Convert(convert::ConvertArgs) => convert::run,
    /// Check a recording; undistort it, remove noise and flicker
    Clean(clean::CleanArgs) => clean::run,
    /// Write windows of a recording as arrays or images, in any representation
    Represent(represent::RepresentArgs) => represent::run,
    /// Render a recording as a web page, a contact sheet or an animation
    View(view::ViewArgs) => view::run,
    /// Print completions of the command line for a shell
    Completions(completions::CompletionsArgs) => completions::run,
    /// Write manual pages
    Man(man::ManArgs) => man::run,
}
