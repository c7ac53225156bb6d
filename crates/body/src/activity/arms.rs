//! Arms that circle, the rest of the body still.

use std::f32::consts::TAU;

use evpose_core::CounterRng;

use super::rhythm::side;
use super::{Activity, Arm, Figure, Leg, Motion};

pub(super) const ACTIVITY: Activity = Activity {
    name: "arm_circles",
    about: "stretched arms circle at the sides, or swing before the body",
    draw,
};

fn draw(rng: &mut CounterRng) -> Motion {
    let (turn_hz, direction) = (rng.uniform(0.4, 1.1), side(rng));
    // Both arms in step, or half a turn apart.
    let lag = if rng.chance(0.5) { 0.0 } else { 0.5 };
    let (wide, middle) = (rng.uniform(0.3, 0.8), rng.uniform(0.9, 1.6));
    let elbow = rng.uniform(0.0, 0.3);
    let heading = rng.uniform(-0.9, 0.9);
    let stand =
        Leg { abduction: rng.uniform(0.03, 0.25), knee: 0.04, turn: 0.12, ..Leg::default() };
    Box::new(move |t_s| {
        let arm = |lag: f32| {
            let phase = TAU * (direction * turn_hz * t_s + lag);
            Arm {
                flexion: wide * phase.sin(),
                abduction: middle + wide * phase.cos(),
                elbow,
                ..Arm::default()
            }
        };
        Figure { heading, arms: [arm(0.0), arm(lag)], legs: [stand; 2], ..Figure::default() }
    })
}
