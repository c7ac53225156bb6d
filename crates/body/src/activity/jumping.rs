//! Jumping: straight up from a crouch, or jumping jacks.

use evpose_core::CounterRng;

use super::rhythm::{ease, part, pulse};
use super::{Activity, Arm, Figure, Leg, Motion};

pub(super) const ACTIVITY: Activity = Activity {
    name: "jumping",
    about: "crouches, jumps up with swinging arms, and lands",
    draw: jump,
};

pub(super) const JACKS: Activity = Activity {
    name: "jumping_jacks",
    about: "jumps with legs apart and arms up, and back",
    draw: jacks,
};

/// Gravity, in metres per second squared.
const G: f32 = 9.81;

fn jump(rng: &mut CounterRng) -> Motion {
    let height_m = rng.uniform(0.12, 0.4);
    // Up and down again: the height gives the time in the air.
    let flight_s = 2.0 * (2.0 * height_m / G).sqrt();
    let period_s = flight_s + rng.uniform(0.7, 1.3);
    let begin = rng.unit();
    let depth = rng.uniform(0.6, 1.1);
    let arms_up = rng.uniform(0.6, 2.6);
    let arms_back = rng.uniform(0.3, 0.9);
    let heading = rng.uniform(-0.9, 0.9);
    let spread = rng.uniform(0.02, 0.15);
    Box::new(move |t_s| {
        let ground_s = period_s - flight_s;
        // Flight first, then landing, standing, crouching, pushing off.
        let now_s = part(t_s, period_s, begin) * period_s;
        let on_ground = ((now_s - flight_s) / ground_s).clamp(0.0, 1.0);
        let rise_m = if now_s < flight_s { 0.5 * G * now_s * (flight_s - now_s) } else { 0.0 };
        // A crouch before the flight and a smaller one that ends it.
        let crouch = pulse(on_ground, [0.45, 0.82, 0.84, 1.0])
            + 0.6 * pulse(on_ground, [0.0, 0.16, 0.18, 0.42]);
        let flying = now_s < flight_s;
        let near_flight =
            |share: f32| ease((on_ground - 1.0 + share) / share) + 1.0 - ease(on_ground / share);
        let air = if flying { 1.0 } else { near_flight(0.12) };
        let push = if flying { 1.0 } else { near_flight(0.35) };
        let leg = Leg {
            flexion: depth * crouch,
            knee: 1.65 * depth * crouch + 0.05,
            ankle: 0.5 * air - 0.6 * depth * crouch,
            abduction: spread,
            turn: 0.1,
        };
        let arm = Arm {
            flexion: arms_up * push - arms_back * crouch * (1.0 - push),
            abduction: 0.2,
            elbow: 0.3 + 0.3 * crouch,
            ..Arm::default()
        };
        Figure {
            heading,
            rise_m,
            pelvis: [0.35 * depth * crouch, 0.0],
            spine: [0.3 * depth * crouch, 0.0, 0.0],
            legs: [leg; 2],
            arms: [arm; 2],
            ..Figure::default()
        }
    })
}

fn jacks(rng: &mut CounterRng) -> Motion {
    let (period_s, begin) = (rng.uniform(1.0, 1.6), rng.unit());
    let (legs, arms) = (rng.uniform(0.25, 0.5), rng.uniform(2.0, 2.8));
    let heading = rng.uniform(-0.7, 0.7);
    Box::new(move |t_s| {
        let now = part(t_s, period_s, begin);
        let open = pulse(now, [0.0, 0.38, 0.5, 0.88]);
        // Two hops a period.
        let hop = part(now, 0.5, 0.0);
        // In the air for three quarters of a hop.
        let rise_m = 0.28 * (hop * (0.75 - hop)).max(0.0);
        let bend = pulse(hop, [0.62, 0.8, 0.82, 1.0]);
        let leg = Leg {
            abduction: 0.03 + legs * open,
            flexion: 0.25 * bend,
            knee: 0.5 * bend + 0.05,
            ankle: 0.1,
            turn: 0.15,
        };
        let arm =
            Arm { abduction: 0.1 + arms * open, twist: -0.6 * open, elbow: 0.2, ..Arm::default() };
        Figure { heading, rise_m, legs: [leg; 2], arms: [arm; 2], ..Figure::default() }
    })
}
