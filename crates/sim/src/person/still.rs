//! Photographs of people, to begin a training with.

use evpose_core::{CounterRng, Micros, Plane, seed_for};
use evpose_pose::body::BodyPoints;

use super::joints::joints_px;
use super::people::Shared;
use super::simulator::SEQUENCES;
use super::take::Take;
use super::wall::encoded;

/// Before this, nobody is photographed, in seconds; and not later than this.
const TIMES_S: [f32; 2] = [0.0, 30.0];

/// A photograph and who is on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Still {
    /// Grey values as a photograph encodes them.
    pub grey: Plane<u8>,
    /// Joints on the image; none outside of it.
    pub joints_px: BodyPoints,
}

/// Photograph number `index`.
pub(super) fn still(shared: &Shared, index: u64) -> Still {
    let seed = seed_for(shared.seed, "people stills", 0);
    let mut take = Take::draw(shared, seed, index, TIMES_S[1]);
    let t_s = CounterRng::new(seed, "still time", index).uniform(TIMES_S[0], TIMES_S[1]);
    let grey = photograph(shared, &mut take, t_s);
    Still { grey, joints_px: joints_px(&take.joints_m(), take.camera()) }
}

/// Photographs of sequence number `sequence`.
pub(super) fn photographs(shared: &Shared, sequence: u64, times: &[Micros]) -> Vec<Plane<u8>> {
    let seed = seed_for(shared.seed, SEQUENCES, 0);
    let mut take = Take::draw(shared, seed, sequence, shared.config.seconds as f32);
    times.iter().map(|t| photograph(shared, &mut take, t.as_seconds() as f32)).collect()
}

fn photograph(shared: &Shared, take: &mut Take, t_s: f32) -> Plane<u8> {
    let gamma = shared.config.surroundings.gamma;
    let light = take.light(shared, t_s);
    let mut grey = Plane::filled(light.width(), light.height(), 0);
    for (code, value) in grey.data_mut().iter_mut().zip(light.data()) {
        *code = encoded(*value, gamma);
    }
    grey
}
