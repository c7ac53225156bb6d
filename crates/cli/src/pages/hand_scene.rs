//! The simulated hand as a scene for sensors.

use anyhow::{Context, Result};
use evpose_core::{Micros, Plane, SensorSize};
use evpose_sim::{SimulationConfig, Simulator};

/// The published simulation, in linear light without a sensor of its own.
fn config(scale: f32) -> SimulationConfig {
    SimulationConfig {
        image_scale: scale,
        // Quantised light would show up as an effect.
        frame: evpose_sim::scene::FrameResponse::Linear,
        sensor: evpose_sim::config::SensorChoice::Preset("ideal".to_owned()),
        ..SimulationConfig::default()
    }
}

/// Size of the images of the hand at a scale.
pub fn size(scale: f32) -> SensorSize {
    config(scale).image_size()
}

/// Renders `planes` images of luminance of the hand, 1 ms apart from time zero, and passes each to
/// `observe`.
///
/// # Errors
/// If the hand cannot be simulated, or `observe` fails.
pub fn for_each_plane(
    scale: f32,
    seed: u64,
    planes: usize,
    mut observe: impl FnMut(&Plane<f32>, Micros) -> Result<()>,
) -> Result<()> {
    let mut simulator = Simulator::new(&config(scale), seed)?;
    for _ in 0..planes {
        let step = simulator.advance().context("moving the hand")?;
        observe(step.luminance, step.t)?;
    }
    Ok(())
}
