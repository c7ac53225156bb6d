//! Networks of untrained weights in fewer bits.

use anyhow::Result;
use evpose_infer::{Engine, EngineOptions, Precision, Ranges};

use super::networks::Network;

/// Images that ranges are measured on, without those that are timed.
const IMAGES: u64 = 4;

/// An engine for a network; for 8 bits of ranges that random images give.
///
/// # Errors
/// If a layer cannot be compiled.
pub(super) fn compiled(network: &Network, options: EngineOptions, seed: u64) -> Result<Engine> {
    let Network { graph, input, .. } = network;
    if options.precision != Precision::Int8 {
        return Ok(Engine::compile(graph, *input, options)?);
    }
    let whole = options.with_precision(Precision::F32);
    let mut engine = Engine::compile(graph, *input, whole.with_every_layer())?;
    let mut ranges = Ranges::of(graph);
    for image in 1..=IMAGES {
        engine.see(&network.image(seed.wrapping_add(image)), &mut ranges);
    }
    Ok(Engine::compile_with(graph, *input, options, Some(&ranges))?)
}

/// By how much outputs may differ from those of others, relative to the largest: more is another network.
/// How much fewer bits cost a trained one, `evpose quantize` measures.
pub(super) fn tolerance(precision: Precision) -> f64 {
    match precision {
        Precision::F32 => 1e-3,
        Precision::Bf16 => 0.05,
        _ => 0.25,
    }
}
