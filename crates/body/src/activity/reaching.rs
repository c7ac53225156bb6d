//! Reaching and gesturing: arms go from one drawn posture to the next.

use evpose_core::CounterRng;

use super::rhythm::{Sway, ease};
use super::waving::blend;
use super::{Activity, Arm, Figure, Leg, Motion};

pub(super) const ACTIVITY: Activity = Activity {
    name: "reaching",
    about: "moves its arms from one place to another, as in talking or taking things",
    draw,
};

/// Postures before they begin again.
const POSTURES: usize = 24;

fn posture(rng: &mut CounterRng) -> Arm {
    Arm {
        flexion: rng.uniform(-0.4, 2.6),
        abduction: rng.uniform(0.0, 1.5),
        twist: rng.uniform(-1.3, 0.5),
        elbow: rng.uniform(0.0, 1.9),
        wrist: rng.uniform(-0.3, 0.3),
    }
}

fn draw(rng: &mut CounterRng) -> Motion {
    let hanging = Arm { abduction: 0.15, elbow: rng.uniform(0.1, 0.4), ..Arm::default() };
    let arms = [(); 2].map(|()| {
        // Some arms hang for most of the time.
        let lazy = if rng.chance(0.3) { 0.9 } else { 0.25 };
        let postures: Vec<Arm> =
            (0..POSTURES).map(|_| if rng.chance(lazy) { hanging } else { posture(rng) }).collect();
        (postures, rng.uniform(0.7, 1.5), rng.unit())
    });
    let heading = rng.uniform(-1.0, 1.0);
    let sways = [(); 4].map(|()| Sway::draw(rng, 0.35));
    let stand = Leg { abduction: rng.uniform(0.02, 0.2), knee: 0.05, turn: 0.12, ..Leg::default() };
    let bow = rng.uniform(0.0, 0.25);
    Box::new(move |t_s| {
        let arms = std::array::from_fn(|side| {
            let (postures, period_s, begin) = &arms[side];
            let at = (t_s / period_s + begin).max(0.0);
            let (step, rest) = (at as usize, at.fract());
            let [from, to] = [step, step + 1].map(|k| &postures[k % POSTURES]);
            // Two thirds of a period are motion, the rest is a hold.
            blend(from, to, ease(1.5 * rest))
        });
        Figure {
            heading,
            arms,
            legs: [stand; 2],
            spine: [bow + 0.1 * sways[0].at(t_s), 0.08 * sways[1].at(t_s), 0.25 * sways[2].at(t_s)],
            head: [0.1, 0.0, 0.25 * sways[3].at(t_s)],
            ..Figure::default()
        }
    })
}
