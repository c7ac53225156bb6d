//! Training activities at once: the legs of one, the arms of others, the trunk of a further one.
//!
//! Each of the other activities is a small family of motions; people in the world combine them, bend
//! down with folded arms, and turn their backs to the camera.

use std::f32::consts::PI;

use evpose_core::CounterRng;

use super::rhythm::Sway;
use super::{Activity, Arm, Figure, Motion, TRAINING_ACTIVITIES};

pub(super) const ACTIVITY: Activity = Activity {
    name: "mixed",
    about: "legs, arms and trunk of different activities, in any direction",
    draw,
};

/// Probability that an arm is held in one posture.
const HELD: f32 = 0.3;
/// Probability that the trunk is bent.
const BENT: f32 = 0.35;

/// A posture before the trunk, at the hips or at the head, as folded arms and hands in pockets are.
fn still_arm(rng: &mut CounterRng) -> Arm {
    Arm {
        flexion: rng.uniform(-0.5, 1.3),
        abduction: rng.uniform(-0.1, 0.8),
        twist: rng.uniform(-1.5, 1.2),
        elbow: rng.uniform(0.2, 2.3),
        wrist: rng.uniform(-0.3, 0.3),
    }
}

/// The activities whose parts are combined: what is held out of training is held out here too.
pub(super) fn sources() -> Vec<&'static Activity> {
    TRAINING_ACTIVITIES.iter().filter(|source| source.name != ACTIVITY.name).collect()
}

/// The motion of one of the sources.
fn other(rng: &mut CounterRng) -> Motion {
    let sources = sources();
    (sources[rng.below(sources.len())].draw)(rng)
}

fn draw(rng: &mut CounterRng) -> Motion {
    let [legs, left, right, trunk] = [(); 4].map(|()| other(rng));
    let held = [(); 2].map(|()| rng.chance(HELD).then(|| still_arm(rng)));
    let tired = [(); 2].map(|()| Sway::draw(rng, 0.5));
    let heading = rng.uniform(-PI, PI);
    let bend = if rng.chance(BENT) { rng.uniform(0.3, 1.1) } else { 0.0 };
    let aside = rng.uniform(-0.25, 0.25);
    Box::new(move |t_s| {
        let mut figure: Figure = legs(t_s);
        let trunk = trunk(t_s);
        figure.heading += heading;
        figure.spine = trunk.spine;
        figure.spine[0] += bend * (0.8 + 0.2 * tired[0].at(0.6 * t_s));
        figure.spine[1] += aside;
        figure.head = trunk.head;
        let arms = [left(t_s).arms[0], right(t_s).arms[1]];
        for side in 0..2 {
            let sway = 0.12 * tired[side].at(t_s);
            figure.arms[side] = match held[side] {
                Some(arm) => Arm { flexion: arm.flexion + sway, elbow: arm.elbow + sway, ..arm },
                None => arms[side],
            };
        }
        figure
    })
}
