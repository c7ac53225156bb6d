//! How long a network takes for a batch, run by run.

use std::time::Instant;

use burn::tensor::{Device, Tensor, TensorData};
use evpose_core::CounterRng;
use evpose_nn::HandRegressor;

/// Times of `runs` predictions on random windows of shape `input` in milliseconds, sorted, after a
/// tenth as many to warm up.
pub(super) fn sorted_ms(
    network: &HandRegressor,
    input: [usize; 4],
    runs: usize,
    seed: u64,
    device: &Device,
) -> Vec<f64> {
    let mut rng = CounterRng::new(seed, "bench", 0);
    let values: Vec<f32> = (0..input.iter().product()).map(|_| rng.unit()).collect();
    let once = || {
        let surfaces = Tensor::<4>::from_data(TensorData::new(values.clone(), input), device);
        let started = Instant::now();
        // Reading the result back makes a device that works in the background finish.
        let poses = network.forward(surfaces).into_data();
        std::hint::black_box(poses);
        started.elapsed().as_secs_f64() * 1e3
    };
    for _ in 0..runs.div_ceil(10) {
        once();
    }
    let mut times_ms: Vec<f64> = (0..runs).map(|_| once()).collect();
    times_ms.sort_by(f64::total_cmp);
    times_ms
}
