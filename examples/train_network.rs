//! Trains a small hand network in less than a minute: simulates labelled sequences, trains on them,
//! and prints how the validation loss falls.
//!
//! ```console
//! $ cargo run --release --example train_network [STEPS]
//! ```
//!
//! `configs/hand/quick.toml` is the same experiment with enough data and steps to be of use.

#![allow(clippy::print_stdout, reason = "a program")]

use anyhow::{Context, Result};
use evpose_nn::DeviceKind;
use evpose_sim::{Simulation, record_all};
use evpose_task::hand::HandConfig;
use evpose_train::{TrainOptions, read_history, train_hand, validation_losses};

/// Optimiser steps between validations.
const STEPS_PER_VALIDATION: u64 = 15;

fn main() -> Result<()> {
    let steps: u64 = match std::env::args().nth(1) {
        Some(steps) => steps.parse().context("STEPS is a count of optimiser steps")?,
        None => 60,
    };
    let config = small(steps);
    let directory = tempfile::tempdir()?;
    let (data, run) = (directory.path().join("data"), directory.path().join("run"));

    let simulation = Simulation::new(&config.simulation, config.seed)?;
    let recorded = record_all(&simulation, &data, &|_| {})?;
    let events: u64 = recorded.sequences.iter().map(|sequence| sequence.events).sum();
    println!("simulated {} sequences, {events} events", recorded.sequences.len());

    let options = TrainOptions {
        device: DeviceKind::default(),
        resume: false,
        plain: true,
        progress: Some(evpose_train::ProgressCallback::new(|_| {})),
        pause_after: None,
    };
    let summary = train_hand(&config, &data, &run, &options)?;
    println!("trained on {} windows, {:.0} a second", summary.samples, summary.samples_per_second);
    let history = read_history(&run.join("metrics.jsonl"))?;
    for (interval, loss) in validation_losses(&history) {
        println!(
            "  validation loss after {:>3} steps: {loss:.3}",
            interval as u64 * STEPS_PER_VALIDATION
        );
    }
    println!(
        "checkpoint: {} parameters",
        evpose_nn::parameters::trained_count(&summary.best.network)
    );
    Ok(())
}

/// The published experiment at a sixth of its resolution and a sixteenth of its width.
fn small(steps: u64) -> HandConfig {
    let mut config = HandConfig::default();
    config.simulation.image_scale = 0.15;
    config.simulation.sequences = 4;
    config.simulation.seconds = 1.0;
    config.network.width = 0.0625;
    config.training.batch_size = 8;
    config.training.steps = steps;
    config.training.steps_per_validation = STEPS_PER_VALIDATION;
    config.training.validation_s = 0.3;
    config.training.validation_samples = 32;
    config
}
