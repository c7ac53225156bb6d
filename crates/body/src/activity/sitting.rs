//! Sitting down on a stool and standing up again; squatting down to the floor.

use evpose_core::CounterRng;

use super::rhythm::{ease, part};
use super::waving::blend;
use super::{Activity, Arm, Figure, Leg, Motion};

pub(super) const ACTIVITY: Activity =
    Activity { name: "sitting", about: "sits down as on a stool, stays, and stands up", draw: sit };

pub(super) const SQUATTING: Activity = Activity {
    name: "squatting",
    about: "bends down to the floor as to pick something up",
    draw: squat,
};

/// How low somebody is, 0 to 1, and how far the way down or up is, largest half-way.
fn course(t_s: f32, [down_s, low_s, up_s, high_s]: [f32; 4], begin: f32) -> (f32, f32) {
    let whole_s = down_s + low_s + up_s + high_s;
    let now_s = part(t_s, whole_s, begin) * whole_s;
    let down = ease(now_s / down_s);
    let up = ease((now_s - down_s - low_s) / up_s);
    let low = if now_s < down_s + low_s { down } else { 1.0 - up };
    (low, 4.0 * low * (1.0 - low))
}

fn sit(rng: &mut CounterRng) -> Motion {
    let ranges_s = [(0.7, 1.3), (0.5, 1.8), (0.7, 1.3), (0.3, 1.2)];
    let times_s = ranges_s.map(|(low, high)| rng.uniform(low, high));
    let begin = rng.unit();
    let deep = rng.uniform(1.25, 1.6);
    let apart = rng.uniform(0.05, 0.3);
    let bend = rng.uniform(0.4, 0.8);
    let heading = rng.uniform(-1.0, 1.0);
    let standing = Arm {
        abduction: rng.uniform(0.1, 0.25),
        flexion: rng.uniform(0.0, 0.2),
        elbow: rng.uniform(0.1, 0.4),
        ..Arm::default()
    };
    // Hands on the thighs, or hanging beside them.
    let seated = if rng.chance(0.7) {
        Arm { flexion: 0.45, abduction: 0.1, twist: 0.2, elbow: 0.8, wrist: 0.0 }
    } else {
        Arm { flexion: 0.1, abduction: 0.3, twist: 0.0, elbow: 0.2, wrist: 0.0 }
    };
    Box::new(move |t_s| {
        let (low, between) = course(t_s, times_s, begin);
        let leg = Leg {
            flexion: deep * low + 0.25 * bend * between,
            knee: (deep + 0.05) * low + 0.15 * between + 0.04,
            ankle: -0.1 * low - 0.15 * between,
            abduction: 0.05 + apart * low,
            turn: 0.1,
        };
        Figure {
            heading,
            pelvis: [0.5 * bend * between, 0.0],
            spine: [0.35 * bend * between + 0.08 * low, 0.0, 0.0],
            head: [-0.3 * bend * between, 0.0, 0.0],
            legs: [leg; 2],
            arms: [blend(&standing, &seated, low); 2],
            ..Figure::default()
        }
    })
}

fn squat(rng: &mut CounterRng) -> Motion {
    let ranges_s = [(0.6, 1.2), (0.1, 0.6), (0.6, 1.2), (0.3, 1.0)];
    let times_s = ranges_s.map(|(low, high)| rng.uniform(low, high));
    let begin = rng.unit();
    let depth = rng.uniform(0.6, 1.0);
    let stoop = rng.uniform(0.2, 0.6);
    let heading = rng.uniform(-1.0, 1.0);
    let reach = [rng.uniform(0.4, 1.2), rng.uniform(0.4, 1.2)];
    Box::new(move |t_s| {
        let (low, _) = course(t_s, times_s, begin);
        let leg = Leg {
            flexion: 1.75 * depth * low + 0.02,
            knee: 2.0 * depth * low + 0.05,
            ankle: -0.55 * depth * low,
            abduction: 0.08 + 0.2 * low,
            turn: 0.15,
        };
        let arm = |reach: f32| Arm {
            flexion: reach * low,
            abduction: 0.15,
            elbow: 0.2 + 0.2 * low,
            ..Arm::default()
        };
        Figure {
            heading,
            pelvis: [0.45 * low + 0.4 * stoop * low, 0.0],
            spine: [stoop * low, 0.0, 0.0],
            legs: [leg; 2],
            arms: reach.map(arm),
            ..Figure::default()
        }
    })
}
