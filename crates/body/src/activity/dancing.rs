//! Dancing: the whole body goes from one drawn posture to the next.

use evpose_core::CounterRng;

use super::rhythm::{ease, side};
use super::waving::blend;
use super::{Activity, Anchor, Arm, Figure, Leg, Motion};

pub(super) const ACTIVITY: Activity = Activity {
    name: "dancing",
    about: "arms, legs and trunk go from one posture to another, as in dancing or exercises",
    draw,
};

/// Postures before they begin again.
const POSTURES: usize = 16;

/// The whole of one moment.
#[derive(Debug, Clone, Copy)]
struct Posture {
    heading: f32,
    arms: [Arm; 2],
    legs: [Leg; 2],
    spine: [f32; 3],
    head: f32,
}

fn arm(rng: &mut CounterRng) -> Arm {
    // Half of them to the side, half to the front: both at once is behind the head.
    let (flexion, abduction) = if rng.chance(0.5) {
        (rng.uniform(-0.4, 0.5), rng.uniform(0.2, 2.8))
    } else {
        (rng.uniform(-0.6, 2.9), rng.uniform(0.0, 0.5))
    };
    let elbow = if rng.chance(0.4) { rng.uniform(0.0, 0.3) } else { rng.uniform(0.3, 2.2) };
    Arm { flexion, abduction, twist: rng.uniform(-1.5, 0.6), elbow, wrist: rng.uniform(-0.3, 0.3) }
}

fn legs(rng: &mut CounterRng) -> [Leg; 2] {
    let bent = rng.uniform(0.0, 0.35);
    // Hip and ankle share the bend of the knee, so that soles stay level.
    let stand = Leg {
        flexion: bent,
        knee: 2.0 * bent,
        ankle: -bent,
        abduction: rng.uniform(0.0, 0.3),
        turn: rng.uniform(0.0, 0.4),
    };
    let mut legs = [stand; 2];
    // One leg at most leaves the floor.
    if rng.chance(0.6) {
        legs[usize::from(rng.chance(0.5))] = Leg {
            flexion: rng.uniform(-0.6, 1.5),
            knee: rng.uniform(0.0, 1.6),
            abduction: rng.uniform(0.0, 0.8),
            turn: rng.uniform(-0.1, 0.5),
            ankle: rng.uniform(-0.1, 0.5),
        };
    }
    legs
}

fn between_legs(from: &Leg, to: &Leg, x: f32) -> Leg {
    let mix = |a: f32, b: f32| a + x * (b - a);
    Leg {
        flexion: mix(from.flexion, to.flexion),
        abduction: mix(from.abduction, to.abduction),
        turn: mix(from.turn, to.turn),
        knee: mix(from.knee, to.knee),
        ankle: mix(from.ankle, to.ankle),
    }
}

fn draw(rng: &mut CounterRng) -> Motion {
    let period_s = rng.uniform(0.45, 1.2);
    // Most face the camera, more or less; some turn about as they dance.
    let (mut heading, turning) = (rng.uniform(-1.0, 1.0), if rng.chance(0.4) { 0.8 } else { 0.15 });
    let postures: Vec<Posture> = (0..POSTURES)
        .map(|_| {
            // Headings add up: people who dance do not turn back each time.
            heading += turning * rng.uniform(0.0, 1.0) * side(rng);
            Posture {
                heading,
                arms: [(); 2].map(|()| arm(rng)),
                legs: legs(rng),
                spine: [rng.uniform(-0.1, 0.5), rng.uniform(-0.3, 0.3), rng.uniform(-0.5, 0.5)],
                head: rng.uniform(-0.5, 0.5),
            }
        })
        .collect();
    Box::new(move |t_s| {
        let at = (t_s / period_s).max(0.0);
        let step = at as usize;
        let [from, to] = [step, step + 1].map(|k| &postures[k % POSTURES]);
        // The posture is reached before the period ends, and held for the rest.
        let x = ease(1.3 * at.fract());
        let mix = |a: f32, b: f32| a + x * (b - a);
        Figure {
            anchor: Anchor::Pelvis,
            heading: mix(from.heading, to.heading),
            arms: std::array::from_fn(|side| blend(&from.arms[side], &to.arms[side], x)),
            legs: std::array::from_fn(|side| between_legs(&from.legs[side], &to.legs[side], x)),
            spine: std::array::from_fn(|k| mix(from.spine[k], to.spine[k])),
            head: [0.1, 0.0, mix(from.head, to.head)],
            ..Figure::default()
        }
    })
}
