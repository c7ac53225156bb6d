//! Turning on the spot from one side to the other, in small steps.
//!
//! Nobody turns their back to the camera: backs and fronts look alike in events, and so do left and
//! right then (Goyal et al. 2023, 4.1.2, take front cameras only for this reason).

use std::f32::consts::TAU;

use evpose_core::CounterRng;

use super::rhythm::{ease, part};
use super::{Activity, Arm, Figure, Leg, Motion};

pub(super) const ACTIVITY: Activity = Activity {
    name: "turning",
    about: "turns on the spot from side to side, looking ahead of the turn",
    draw,
};

fn draw(rng: &mut CounterRng) -> Motion {
    let reach = [rng.uniform(0.5, 1.4), rng.uniform(-1.4, -0.5)];
    let (period_s, begin) = (rng.uniform(2.4, 5.0), rng.unit());
    let step_hz = rng.uniform(1.2, 2.0);
    let (lift, swing) = (rng.uniform(0.15, 0.4), rng.uniform(0.05, 0.3));
    let held = rng.uniform(0.1, 0.5);
    Box::new(move |t_s| {
        let now = part(t_s, period_s, begin);
        let there = ease((now - 0.02) / 0.4) - ease((now - 0.52) / 0.4);
        // Head and spine turn before the feet do.
        let ahead = ease(now / 0.36) - ease((now - 0.5) / 0.36);
        let heading = |share: f32| reach[1] + (reach[0] - reach[1]) * share;
        // Steps are made only while the heading changes.
        let moving = (12.0 * there * (1.0 - there)).min(1.0);
        let phase = TAU * step_hz * t_s;
        let leg = |phase: f32| {
            let up = moving * phase.sin().max(0.0);
            Leg {
                flexion: lift * up,
                knee: 2.0 * lift * up + 0.05,
                abduction: 0.07,
                turn: 0.1,
                ankle: 0.0,
            }
        };
        let arm = |phase: f32| Arm {
            flexion: swing * moving * phase.sin(),
            abduction: 0.12 + 0.2 * moving * swing,
            elbow: held,
            ..Arm::default()
        };
        // The spine and the head share the turn: each adds half.
        let twist = 0.5 * (heading(ahead) - heading(there));
        Figure {
            heading: heading(there),
            spine: [0.03, 0.0, twist],
            head: [0.0, 0.0, twist],
            legs: [leg(phase), leg(phase + 0.5 * TAU)],
            arms: [arm(phase + 0.5 * TAU), arm(phase)],
            ..Figure::default()
        }
    })
}
