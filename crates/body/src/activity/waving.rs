//! Waving with one arm or with both, the rest of the body still.

use std::f32::consts::TAU;

use evpose_core::CounterRng;

use super::rhythm::{part, pulse};
use super::{Activity, Arm, Figure, Motion};

pub(super) const ACTIVITY: Activity =
    Activity { name: "waving", about: "waves with one arm or both, legs and trunk still", draw };

fn draw(rng: &mut CounterRng) -> Motion {
    let both = rng.chance(0.25);
    let side = usize::from(rng.chance(0.5));
    let rate = TAU * rng.uniform(0.7, 1.9);
    let (period_s, begin) = (rng.uniform(4.0, 8.0), rng.unit());
    let from_shoulder = rng.chance(0.4);
    let up = Arm {
        flexion: rng.uniform(-0.1, 0.4),
        abduction: if from_shoulder { rng.uniform(2.1, 2.7) } else { rng.uniform(1.0, 2.0) },
        twist: rng.uniform(-1.7, -1.2),
        elbow: if from_shoulder { rng.uniform(0.1, 0.5) } else { rng.uniform(1.1, 1.7) },
        wrist: 0.0,
    };
    let swing = rng.uniform(0.25, 0.55);
    let rest = Arm {
        flexion: rng.uniform(-0.1, 0.15),
        abduction: rng.uniform(0.08, 0.3),
        elbow: rng.uniform(0.05, 0.5),
        ..Arm::default()
    };
    // The other hand hangs or rests on the hip.
    let idle = if rng.chance(0.3) {
        Arm { flexion: -0.5, abduction: 0.7, twist: 0.9, elbow: 1.7, wrist: 0.0 }
    } else {
        rest
    };
    let heading = rng.uniform(-0.8, 0.8);
    Box::new(move |t_s| {
        let raised = pulse(part(t_s, period_s, begin), [0.0, 0.14, 0.8, 0.95]);
        let wave = swing * (rate * t_s).sin();
        let mut waving = blend(&rest, &up, raised);
        // From the shoulder the whole arm waves, otherwise the forearm most.
        if from_shoulder {
            waving.abduction += raised * wave;
        } else {
            waving.elbow += raised * wave;
            waving.abduction += 0.3 * raised * wave;
        }
        waving.wrist = 0.5 * raised * wave;
        let mut arms = [idle; 2];
        arms[side] = waving;
        if both {
            arms[1 - side] = waving;
        }
        Figure { heading, arms, ..Figure::default() }
    })
}

/// Between two ways to hold an arm.
pub(super) fn blend(from: &Arm, to: &Arm, share: f32) -> Arm {
    let mix = |a: f32, b: f32| a + (b - a) * share;
    Arm {
        flexion: mix(from.flexion, to.flexion),
        abduction: mix(from.abduction, to.abduction),
        twist: mix(from.twist, to.twist),
        elbow: mix(from.elbow, to.elbow),
        wrist: mix(from.wrist, to.wrist),
    }
}
