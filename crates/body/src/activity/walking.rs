//! Walking to and fro before the camera or on the spot, and running on the spot.

use std::f32::consts::TAU;

use evpose_core::CounterRng;
use glam::Vec2;

use super::{Activity, Anchor, Arm, Figure, Leg, Motion};

pub(super) const ACTIVITY: Activity = Activity {
    name: "walking",
    about: "walks to and fro before the camera, or on a treadmill",
    draw: walk,
};

pub(super) const RUNNING: Activity =
    Activity { name: "running", about: "runs on the spot, knees high", draw: run };

/// Steps of a path that is added up.
const PATH_HZ: f32 = 50.0;
/// After how long a path begins again, in seconds.
const PATH_S: f32 = 60.0;

/// One stride of both legs and what the arms do to it.
#[derive(Debug, Clone, Copy)]
struct Gait {
    stride_hz: f32,
    phase: f32,
    hip: f32,
    forward: f32,
    knee: f32,
    arm: f32,
    elbow: f32,
    lean: f32,
}

impl Gait {
    fn figure(&self, t_s: f32) -> Figure {
        let phase = TAU * (self.stride_hz * t_s + self.phase);
        let leg = |phase: f32| Leg {
            flexion: self.forward + self.hip * phase.sin(),
            // Bent while the leg swings forwards, a little while it bears.
            knee: 0.12 + self.knee * (0.5 + 0.5 * (phase - 0.35).cos()).powi(2) + self.forward,
            ankle: 0.25 * (phase + 2.6).cos().max(0.0) - 0.08,
            abduction: 0.03,
            turn: 0.08,
        };
        let arm = |phase: f32| Arm {
            flexion: self.arm * phase.sin(),
            abduction: 0.14,
            elbow: self.elbow + 0.3 * self.arm * phase.sin(),
            ..Arm::default()
        };
        // Arms swing against the legs of their side.
        let opposite = phase + 0.5 * TAU;
        Figure {
            anchor: Anchor::Pelvis,
            pelvis: [self.lean, 0.04 * phase.cos()],
            spine: [0.5 * self.lean, 0.0, 0.12 * phase.sin()],
            legs: [leg(phase), leg(opposite)],
            arms: [arm(opposite), arm(phase)],
            ..Figure::default()
        }
    }
}

fn walk(rng: &mut CounterRng) -> Motion {
    let gait = Gait {
        stride_hz: rng.uniform(0.65, 1.05),
        phase: rng.unit(),
        hip: rng.uniform(0.32, 0.52),
        forward: rng.uniform(0.02, 0.12),
        knee: rng.uniform(0.7, 1.0),
        arm: rng.uniform(0.2, 0.55),
        elbow: rng.uniform(0.1, 0.6),
        lean: rng.uniform(0.0, 0.09),
    };
    if rng.chance(0.4) {
        let heading = rng.uniform(-1.0, 1.0);
        return Box::new(move |t_s| Figure { heading, ..gait.figure(t_s) });
    }
    let speed_m_s = 2.6 * gait.hip * gait.stride_hz;
    let (turned, period_s) = (rng.uniform(0.9, 1.5), rng.uniform(3.0, 5.0));
    let begin = rng.unit();
    // To one side and back, with a turn through the camera's direction between.
    let heading = move |t_s: f32| {
        let wave = (TAU * (t_s / period_s + begin)).sin();
        // A steep wave: turns are quick, with straight ways between.
        turned * wave / (wave * wave + 0.06).sqrt()
    };
    let steps = (PATH_S * PATH_HZ) as usize;
    let mut places_m = Vec::with_capacity(steps + 1);
    let mut place_m = Vec2::ZERO;
    // Integrated in steps: heading has no closed integral.
    for step in 0..=steps {
        places_m.push(place_m);
        place_m += Vec2::from(heading(step as f32 / PATH_HZ).sin_cos()) * (speed_m_s / PATH_HZ);
    }
    let extent = |axis: fn(&Vec2) -> f32| {
        // One period shows the extent to the side, in which the path repeats.
        let period = &places_m[..(period_s * PATH_HZ) as usize];
        period.iter().map(axis).fold((f32::MAX, f32::MIN), |(l, h), x| (l.min(x), h.max(x)))
    };
    let (low, high) = extent(|place| place.x);
    let middle_m = Vec2::new(0.5 * (low + high), 0.0);
    // The way towards the camera is taken out: the floor moves.
    let drift_m = Vec2::new(0.0, places_m[steps].y / PATH_S);
    Box::new(move |t_s| {
        let at = t_s.rem_euclid(PATH_S) * PATH_HZ;
        let (step, rest) = ((at as usize).min(steps - 1), at.fract());
        let place_m = places_m[step].lerp(places_m[step + 1], rest);
        let place_m = place_m - middle_m - drift_m * t_s.rem_euclid(PATH_S);
        Figure { place_m, heading: heading(t_s), ..gait.figure(t_s) }
    })
}

fn run(rng: &mut CounterRng) -> Motion {
    let gait = Gait {
        stride_hz: rng.uniform(1.1, 1.6),
        phase: rng.unit(),
        hip: rng.uniform(0.35, 0.6),
        forward: rng.uniform(0.35, 0.6),
        knee: rng.uniform(0.6, 1.2),
        arm: rng.uniform(0.4, 0.8),
        elbow: rng.uniform(1.2, 1.8),
        lean: rng.uniform(0.0, 0.12),
    };
    let heading = rng.uniform(-1.0, 1.0);
    let bounce_m = rng.uniform(0.02, 0.08);
    Box::new(move |t_s| {
        // Two rises in a stride, one a step: the absolute value doubles the frequency of the cosine.
        let rise_m = bounce_m * (TAU * (gait.stride_hz * t_s + gait.phase)).cos().abs();
        Figure { heading, rise_m, ..gait.figure(t_s) }
    })
}
