//! Data and steps that fit into a given time on this machine.

use std::time::Instant;

use crate::recorded;
use anyhow::{Context, Result};
use evpose_nn::DeviceKind;
use evpose_task::hand::{HandConfig, NetworkPredictor, Predictor as _};
use evpose_train::{TrainOptions, train_hand, untrained};

/// Sequences of the measurement, one for each thread of a small machine, and their length.
const PROBE_SEQUENCES: usize = 2;
const PROBE_S: f64 = 1.0;
/// Optimiser steps of the measurement.
const PROBE_STEPS: u64 = 60;
/// Windows whose inference is timed.
const PROBE_WINDOWS: usize = 256;
/// Share of the time that is planned with: other programs, heat, the disk.
const PLANNED_SHARE: f64 = 0.88;
/// Setting up, reading, filters, drawing.
const FIXED_S: f64 = 20.0;
/// Networks that are evaluated: before and after training, and the one that is shipped.
const NETWORKS: f64 = 3.0;
/// The smallest data set and training.
const MIN_SEQUENCES: usize = 8;
const MIN_STEPS: u64 = 100;

/// Speeds of this machine at the work of a config.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Speeds {
    /// Simulated steps of 1 ms per second.
    pub(super) simulated_steps_hz: f64,
    pub(super) trained_samples_hz: f64,
    /// Evaluated poses of a network per second.
    pub(super) evaluated_poses_hz: f64,
}

impl Speeds {
    /// Measures them in some seconds.
    pub(super) fn measure(config: &HandConfig, device: DeviceKind) -> Result<Self> {
        let directory = tempfile::tempdir().context("a directory for the measurement")?;
        let mut probe = config.clone();
        probe.simulation.sequences = PROBE_SEQUENCES;
        probe.simulation.seconds = config.simulation.seconds.min(PROBE_S);
        let training = &mut probe.training;
        // Some of each sequence has to stay for the training.
        training.validation_s = training.validation_s.min(0.5 * probe.simulation.seconds);
        training.steps = training.steps.min(PROBE_STEPS);
        // One short validation at the end, since the training is what is timed.
        training.steps_per_validation = training.steps;
        training.validation_samples = training.batch_size as u64;
        training.estimate_filter = false;
        let (data, run) = (directory.path().join("data"), directory.path().join("run"));
        let simulated = recorded::record(&probe, &data, "measuring")?;
        let progress = Some(evpose_train::ProgressCallback::new(|_| {}));
        let options =
            TrainOptions { device, resume: false, plain: true, progress, pause_after: None };
        let trained = train_hand(&probe, &data, &run, &options)?;

        let device = device.resolve()?;
        let mut predictor = NetworkPredictor::new(&probe, untrained(&probe, &device)?, device)?;
        let size = probe.simulation.image_size();
        // Values do not change the time of an inference.
        let windows = vec![0.0; 2 * size.pixels() * PROBE_WINDOWS];
        let image_size = (usize::from(size.height), usize::from(size.width));
        // The first time, the network is compiled.
        predictor.predict(&windows, image_size)?;
        let started = Instant::now();
        predictor.predict(&windows, image_size)?;
        Ok(Self {
            simulated_steps_hz: simulated.steps_per_second(),
            trained_samples_hz: trained.samples_per_second,
            evaluated_poses_hz: PROBE_WINDOWS as f64 / started.elapsed().as_secs_f64(),
        })
    }

    /// Seconds for a config whose poses are evaluated every `stride_ms`: simulation of the training
    /// data, training, and all that does not depend on their amount.
    fn seconds(&self, config: &HandConfig, stride_ms: u32) -> [f64; 3] {
        let (simulation, evaluation) = (&config.simulation, &config.evaluation);
        let steps = 1e3 * simulation.seconds * simulation.sequences as f64;
        let samples = (config.training.steps * config.training.batch_size as u64) as f64;
        let held_out = 1e3 * evaluation.seconds * evaluation.sequences as f64;
        let poses = NETWORKS * held_out / f64::from(stride_ms.max(1));
        // Held-out sequences are simulated once more for the network that is shipped.
        let constant = 2.0 * held_out / self.simulated_steps_hz + poses / self.evaluated_poses_hz;
        [steps / self.simulated_steps_hz, samples / self.trained_samples_hz, constant + FIXED_S]
    }

    /// The config with as much of its data and steps as fit into `budget_s`, and the expected time
    /// of the whole in seconds.
    pub(super) fn plan(
        &self,
        config: &HandConfig,
        budget_s: f64,
        stride_ms: u32,
    ) -> (HandConfig, f64) {
        let [simulation_s, training_s, constant_s] = self.seconds(config, stride_ms);
        // Constant parts do not shrink with data and steps: the rest is shared in proportion.
        let available_s = PLANNED_SHARE * budget_s - constant_s;
        let share = (available_s / (simulation_s + training_s)).clamp(0.0, 1.0);
        let mut planned = config.clone();
        if share < 1.0 {
            let sequences = share * config.simulation.sequences as f64;
            // At least so many, even beyond the time: with fewer there is nothing to show.
            planned.simulation.sequences =
                (sequences as usize).max(MIN_SEQUENCES).min(config.simulation.sequences);
            let steps = (share * config.training.steps as f64) as u64;
            planned.training.steps = steps.max(MIN_STEPS).min(config.training.steps);
            let per_validation = &mut planned.training.steps_per_validation;
            *per_validation = (*per_validation).min(planned.training.steps);
        }
        let expected_s = self.seconds(&planned, stride_ms).iter().sum();
        (planned, expected_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn speeds(factor: f64) -> Speeds {
        Speeds {
            simulated_steps_hz: 10_000.0 * factor,
            trained_samples_hz: 3_000.0 * factor,
            evaluated_poses_hz: 4_000.0 * factor,
        }
    }

    fn config() -> HandConfig {
        let mut config = HandConfig::default();
        config.simulation.sequences = 480;
        config.simulation.seconds = 4.0;
        config.training.steps = 17_500;
        config.evaluation.sequences = 20;
        config.evaluation.seconds = 4.0;
        config
    }

    #[test]
    fn a_fast_machine_does_everything_and_a_slow_one_keeps_to_the_time() {
        let (planned, expected_s) = speeds(10.0).plan(&config(), 540.0, 5);
        assert_eq!(planned, config());
        assert!(expected_s < 540.0);
        let mut before = u64::MAX;
        for factor in [1.0, 0.5, 0.25] {
            let (planned, expected_s) = speeds(factor).plan(&config(), 540.0, 5);
            assert!(expected_s <= 540.0, "{factor}: {expected_s}");
            assert!(planned.training.steps < before);
            before = planned.training.steps;
        }
        // Data and steps shrink alike.
        let (planned, _) = speeds(0.5).plan(&config(), 540.0, 5);
        let shares =
            [planned.simulation.sequences as f64 / 480.0, planned.training.steps as f64 / 17_500.0];
        assert!((shares[0] - shares[1]).abs() < 0.01, "{shares:?}");
    }
}
