//! Kicks to the front, on one leg.

use evpose_core::CounterRng;

use super::rhythm::{part, pulse};
use super::{Activity, Anchor, Arm, Figure, Leg, Motion};

pub(super) const ACTIVITY: Activity = Activity {
    name: "kicking",
    about: "kicks to the front with one leg, arms out for balance",
    draw,
};

fn draw(rng: &mut CounterRng) -> Motion {
    let (period_s, begin) = (rng.uniform(1.6, 2.6), rng.unit());
    let kicking = usize::from(rng.chance(0.5));
    let height = rng.uniform(0.7, 1.5);
    let back = rng.uniform(0.2, 0.6);
    let balance = rng.uniform(0.3, 1.0);
    let heading = rng.uniform(-1.0, 1.0);
    Box::new(move |t_s| {
        let now = part(t_s, period_s, begin);
        // The leg swings back before it kicks.
        let (swung, kicked) =
            (pulse(now, [0.05, 0.25, 0.27, 0.42]), pulse(now, [0.27, 0.45, 0.48, 0.85]));
        let stand = Leg { flexion: 0.08, knee: 0.15, turn: 0.1, abduction: 0.02, ankle: -0.05 };
        let leg = Leg {
            flexion: height * kicked - back * swung + 0.05,
            knee: 1.1 * swung + 0.15,
            abduction: 0.04,
            turn: 0.1,
            ankle: 0.4 * kicked,
        };
        let mut legs = [stand; 2];
        legs[kicking] = leg;
        let mut arms = [Arm { abduction: 0.2 + balance * kicked, elbow: 0.5, ..Arm::default() }; 2];
        // The arm of the other side balances.
        arms[1 - kicking].flexion = 0.7 * kicked - 0.3 * swung;
        Figure {
            heading,
            // The foot that stands is the one that must not slip.
            anchor: Anchor::Foot(1 - kicking),
            pelvis: [-0.15 * kicked + 0.15 * swung, 0.0],
            spine: [0.1 * kicked, 0.0, 0.0],
            legs,
            arms,
            ..Figure::default()
        }
    })
}
