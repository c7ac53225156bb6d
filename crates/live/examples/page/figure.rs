//! A person who jumps and waves.

use std::f32::consts::TAU;

use evpose_core::Micros;
use evpose_live::page::Skeleton;
use evpose_pose::PoseEstimate;
use evpose_pose::body::{BODY_JOINTS, LIMBS, number};
use glam::Vec2;

use crate::actor::{Actor, Outline};

/// One round of the motion, in seconds.
const ROUND_S: f32 = 1.6;

pub(crate) struct Figure;

impl Figure {
    fn joints(t: Micros) -> [Vec2; BODY_JOINTS] {
        let phase = TAU * t.as_seconds() as f32 / ROUND_S;
        let sway = (0.31 * phase).sin();
        let up = 0.5 - 0.5 * phase.cos();
        let middle = Vec2::new(320.0 + 70.0 * sway, 250.0 - 26.0 * (phase.sin().max(0.0)));
        // Angles from straight down, to the side where the arm or leg is.
        let limb = |from: Vec2, side: f32, angle: f32, length: f32| {
            from + length * Vec2::new(side * angle.sin(), angle.cos())
        };
        let mut joints = [middle; BODY_JOINTS];
        joints[number::HEAD] = middle + Vec2::new(8.0 * sway, -160.0);
        // Left is the person's: they face the camera.
        for (side, [shoulder, elbow, wrist, hip, knee, ankle]) in
            [(1.0, [1, 3, 5, 7, 9, 11]), (-1.0, [2, 4, 6, 8, 10, 12])]
        {
            let late = 0.35 * side;
            let wave = 0.5 - 0.5 * (phase - late).cos();
            joints[shoulder] = middle + Vec2::new(side * 48.0, -104.0);
            joints[hip] = middle + Vec2::new(side * 30.0, 20.0);
            joints[elbow] = limb(joints[shoulder], side, 0.25 + 2.0 * wave, 66.0);
            joints[wrist] = limb(joints[elbow], side, 0.35 + 2.5 * wave, 62.0);
            joints[knee] = limb(joints[hip], side, 0.06 + 0.42 * up, 78.0);
            joints[ankle] = limb(joints[knee], side, 0.02 + 0.3 * up, 76.0);
        }
        joints
    }
}

impl Actor for Figure {
    fn skeleton(&self) -> Skeleton {
        Skeleton::Body
    }

    fn pose(&self, t: Micros) -> PoseEstimate {
        let joints_px = Self::joints(t).map(Some);
        PoseEstimate::Body { joints_px, scores: [0.9; BODY_JOINTS], score: 0.9 }
    }

    fn outline(&self, t: Micros, later: Micros) -> Outline {
        let (before, now) = (Self::joints(t), Self::joints(later));
        let limb = |[a, b]: [usize; 2]| [[before[a], before[b]], [now[a], now[b]]];
        let mut strokes: Vec<_> = LIMBS.map(limb).into();
        // A head of sixteen short strokes.
        let corner = |head: Vec2, k: i32| head + 22.0 * Vec2::from_angle(k as f32 * TAU / 16.0);
        strokes.extend(
            (0..16).map(|k| {
                [before, now].map(|joints| [corner(joints[0], k), corner(joints[0], k + 1)])
            }),
        );
        Outline { strokes, radius_px: 11.0 }
    }
}
