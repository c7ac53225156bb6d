//! Photographs of people, for pre-training.

use evpose_core::{CounterRng, Micros, Plane, seed_for};
use evpose_pose::body::BodyPoints;

use super::luminance_image::encoded;
use super::scene_instance::SceneInstance;
use super::shared::Shared;
use super::simulator::SEQUENCE_STREAM;
use crate::SimError;

/// First and last time of a photograph in an activity, in seconds.
const TIMES_S: [f32; 2] = [0.0, 30.0];

/// A photograph of a person with its label.
#[derive(Debug, Clone, PartialEq)]
pub struct Still {
    /// Gamma-encoded grey values.
    pub grey: Plane<u8>,
    /// Joints on the image in pixels; none outside of it.
    pub joints_px: BodyPoints,
}

/// Renders photograph `index`.
pub(super) fn still(shared: &Shared, index: u64) -> Result<Still, SimError> {
    let seed = seed_for(shared.seed, "people stills", 0);
    let config = shared.config_of(seed, index)?;
    let mut scene = SceneInstance::draw(shared, &config, seed, (index, 0), TIMES_S[1])?;
    let t_s = CounterRng::new(seed, "still time", index).uniform(TIMES_S[0], TIMES_S[1]);
    let grey = photograph(shared, &mut scene, t_s);
    Ok(Still { grey, joints_px: scene.joints_px().unwrap_or_default() })
}

/// Renders photographs of a sequence at `times`.
pub(super) fn photographs(
    shared: &Shared,
    sequence: u64,
    times: &[Micros],
) -> Result<Vec<Plane<u8>>, SimError> {
    let seed = seed_for(shared.seed, SEQUENCE_STREAM, 0);
    let scene_and_camera = shared.config.scene_of(sequence);
    let config = shared.config_of(seed, scene_and_camera.0)?;
    let seconds = config.seconds as f32;
    let mut scene = SceneInstance::draw(shared, &config, seed, scene_and_camera, seconds)?;
    Ok(times.iter().map(|t| photograph(shared, &mut scene, t.as_seconds() as f32)).collect())
}

/// Renders the scene at `t_s` seconds as gamma-encoded grey values.
fn photograph(shared: &Shared, scene: &mut SceneInstance, t_s: f32) -> Plane<u8> {
    let gamma = shared.config.surroundings.gamma;
    let light = scene.light(shared, t_s);
    let mut grey = Plane::filled(light.width(), light.height(), 0);
    for (code, value) in grey.data_mut().iter_mut().zip(light.data()) {
        *code = encoded(*value, gamma);
    }
    grey
}
