//! Boxing: a guard, straight punches from either side, a bounce.

use std::f32::consts::TAU;

use evpose_core::CounterRng;

use super::rhythm::{part, pulse};
use super::waving::blend;
use super::{Activity, Arm, Figure, Leg, Motion};

pub(super) const ACTIVITY: Activity =
    Activity { name: "boxing", about: "punches to the front from a guard, bouncing", draw };

fn draw(rng: &mut CounterRng) -> Motion {
    let guard = Arm {
        flexion: rng.uniform(0.3, 0.7),
        abduction: rng.uniform(0.15, 0.4),
        twist: rng.uniform(-0.5, 0.0),
        elbow: rng.uniform(2.0, 2.4),
        wrist: 0.0,
    };
    let punch = Arm {
        flexion: rng.uniform(1.25, 1.7),
        abduction: rng.uniform(-0.1, 0.25),
        twist: rng.uniform(-0.3, 0.2),
        elbow: rng.uniform(0.05, 0.3),
        wrist: 0.0,
    };
    let (period_s, begin) = (rng.uniform(0.9, 1.8), rng.unit());
    // Sides have offsets of their own: punches come in turn, or together.
    let order = [rng.unit(), rng.unit()];
    let quick = rng.uniform(0.12, 0.22);
    let heading = rng.uniform(-0.9, 0.9);
    let (bounce_hz, bounce) = (rng.uniform(1.2, 2.2), rng.uniform(0.02, 0.09));
    // One foot before the other.
    let stance = rng.uniform(0.1, 0.3) * if rng.chance(0.5) { 1.0 } else { -1.0 };
    Box::new(move |t_s| {
        let out = order.map(|offset| {
            pulse(
                part(t_s, period_s, begin + offset),
                [0.1, 0.1 + quick, 0.12 + quick, 0.14 + 2.2 * quick],
            )
        });
        let bounced = bounce * (TAU * bounce_hz * t_s).sin();
        let leg = |side: f32| Leg {
            flexion: 0.15 + side * stance + bounced,
            knee: 0.32 - 0.4 * side * stance + 2.0 * bounced,
            abduction: 0.14,
            turn: 0.15,
            ankle: -0.12 - bounced,
        };
        Figure {
            heading,
            arms: out.map(|out| blend(&guard, &punch, out)),
            legs: [leg(1.0), leg(-1.0)],
            pelvis: [0.08, 0.0],
            // The trunk turns with the arm that punches, the head against it.
            spine: [0.12, 0.0, 0.55 * (out[1] - out[0])],
            head: [0.0, 0.0, -0.5 * (out[1] - out[0])],
            ..Figure::default()
        }
    })
}
