//! Untrained networks in reduced precision.

use anyhow::Result;
use evpose_infer::{CalibrationRanges, Engine, EngineOptions, Precision};

use super::networks::Network;

/// Calibration images, distinct from the timed ones.
const IMAGES: u64 = 4;

/// Compiles an engine for a network; int8 is calibrated on random images.
///
/// # Errors
/// If a layer cannot be compiled.
pub(super) fn compiled(network: &Network, options: EngineOptions, seed: u64) -> Result<Engine> {
    let Network { graph, input, .. } = network;
    if options.precision != Precision::Int8 {
        return Ok(Engine::compile(graph, *input, options)?);
    }
    let whole = options.with_precision(Precision::F32);
    // Layers that are fused into a chain leave no values that could be observed.
    let mut engine = Engine::compile(graph, *input, whole.layer_by_layer())?;
    let mut ranges = CalibrationRanges::new(graph);
    for image in 1..=IMAGES {
        engine.observe(&network.image(seed.wrapping_add(image)), &mut ranges);
    }
    Ok(Engine::compile_with(graph, *input, options, Some(&ranges))?)
}

/// Maximum difference of outputs between runtimes, relative to the largest: more means another
/// network. The loss of accuracy of a trained network is measured by `evpose quantize`.
pub(super) fn tolerance(precision: Precision) -> f64 {
    match precision {
        Precision::F32 => 1e-3,
        Precision::Bf16 => 0.05,
        _ => 0.25,
    }
}
