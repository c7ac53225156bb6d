//! Latencies of a network, run by run.

use std::time::Instant;

use anyhow::Result;
use burn::tensor::{Device, Tensor, TensorData};
use evpose_core::CounterRng;
use evpose_infer::{Engine, EngineOptions};
use evpose_nn::HandNetwork;

/// Runtime of a network.
pub enum Runner<'a> {
    /// Our engine, at batch size 1.
    Engine(Box<Engine>),
    /// Burn, on a device.
    Burn(Box<dyn Fn(Tensor<4>) + 'a>, &'a Device),
}

impl<'a> Runner<'a> {
    /// The engine on the CPU, Burn on other devices. `input` is `[batch, channels, height, width]`.
    pub fn usual(
        network: &'a HandNetwork,
        [_, channels, height, width]: [usize; 4],
        device: &'a Device,
    ) -> Result<Self> {
        if *device != Device::flex() {
            // Reading the result back waits for asynchronous devices.
            let forward = |images| drop(std::hint::black_box(network.forward(images).into_data()));
            return Ok(Self::Burn(Box::new(forward), device));
        }
        let options = EngineOptions::default().with_threads(rayon::current_num_threads());
        let engine = Engine::compile(&network.graph(), [channels, height, width], options)?;
        Ok(Self::Engine(Box::new(engine)))
    }

    /// Runs one inference and returns its time in milliseconds, without that of preparing the
    /// input.
    fn once(&mut self, values: &[f32], input: [usize; 4]) -> f64 {
        match self {
            Self::Engine(engine) => {
                let started = Instant::now();
                for window in values.chunks(input[1..].iter().product()) {
                    // Without it, the compiler may drop a computation whose result nobody reads.
                    std::hint::black_box(engine.run(window));
                }
                started.elapsed().as_secs_f64() * 1e3
            }
            Self::Burn(forward, device) => {
                let data = TensorData::new(values.to_vec(), input);
                let windows = Tensor::<4>::from_data(data, *device);
                // The input is on the device by now, as that of the engine is in memory.
                let started = Instant::now();
                forward(windows);
                started.elapsed().as_secs_f64() * 1e3
            }
        }
    }
}

/// Random windows of shape `input`.
pub fn windows(input: [usize; 4], seed: u64) -> Vec<f32> {
    let mut rng = CounterRng::new(seed, "bench", 0);
    (0..input.iter().product()).map(|_| rng.unit()).collect()
}

/// Times of `runs` predictions on random windows of shape `input` in milliseconds, in their order,
/// after a tenth as many to warm up.
pub fn times_ms(runner: &mut Runner<'_>, input: [usize; 4], runs: usize, seed: u64) -> Vec<f64> {
    let values = windows(input, seed);
    for _ in 0..runs.div_ceil(10) {
        runner.once(&values, input);
    }
    (0..runs).map(|_| runner.once(&values, input)).collect()
}

/// Times of [`times_ms`], sorted.
pub fn sorted_ms(runner: &mut Runner<'_>, input: [usize; 4], runs: usize, seed: u64) -> Vec<f64> {
    let mut times_ms = times_ms(runner, input, runs, seed);
    times_ms.sort_by(f64::total_cmp);
    times_ms
}
