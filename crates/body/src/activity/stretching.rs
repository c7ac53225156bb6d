//! Side bends with an arm over the head.

use std::f32::consts::TAU;

use evpose_core::CounterRng;

use super::{Activity, Arm, Figure, Leg, Motion};

pub(super) const ACTIVITY: Activity = Activity {
    name: "stretching",
    about: "bends from side to side with an arm over the head",
    draw,
};

fn draw(rng: &mut CounterRng) -> Motion {
    let rate = TAU * rng.uniform(0.2, 0.5);
    let phase = rng.uniform(0.0, TAU);
    let (bend, up) = (rng.uniform(0.25, 0.55), rng.uniform(2.0, 2.8));
    let heading = rng.uniform(-0.7, 0.7);
    let stand = Leg { abduction: rng.uniform(0.1, 0.3), knee: 0.03, turn: 0.15, ..Leg::default() };
    Box::new(move |t_s| {
        let lean = (rate * t_s + phase).sin();
        let arm = |raised: f32| {
            let raised = raised.max(0.0);
            let raised = raised * (2.0 - raised);
            Arm {
                abduction: 0.15 + up * raised,
                twist: -1.2 * raised,
                elbow: 0.15 + 0.7 * raised,
                ..Arm::default()
            }
        };
        Figure {
            heading,
            pelvis: [0.0, 0.15 * bend * lean],
            spine: [0.0, bend * lean, 0.0],
            head: [0.0, 0.3 * bend * lean, 0.0],
            arms: [arm(lean), arm(-lean)],
            legs: [stand; 2],
            ..Figure::default()
        }
    })
}
