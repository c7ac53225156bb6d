//! Moving subjects of the example.

use evpose_core::{CounterRng, Micros, SensorSize};
use evpose_live::page::{HandMesh, Skeleton};
use evpose_pose::PoseEstimate;
use glam::Vec2;

/// The simulated sensor.
pub(crate) const SENSOR: SensorSize = SensorSize { width: 640, height: 480 };

/// A moving subject.
pub(crate) trait Actor: Send + Sync {
    /// Skeleton of its poses.
    fn skeleton(&self) -> Skeleton;

    /// Its mesh, if it has one.
    fn mesh(&self) -> Option<HandMesh> {
        None
    }

    /// Its pose.
    fn pose(&self, t: Micros) -> PoseEstimate;

    /// Its outline at `t` and at `later`.
    fn outline(&self, t: Micros, later: Micros) -> Outline;
}

/// An outline at two times.
pub(crate) struct Outline {
    /// Strokes, each with its end points: before and now.
    pub(crate) strokes: Vec<[[Vec2; 2]; 2]>,
    /// Half the thickness of a stroke, in pixels.
    pub(crate) radius_px: f32,
}

impl Outline {
    /// A random point of a stroke: its position before and now, and the outward normal.
    pub(crate) fn draw(&self, rng: &mut CounterRng) -> [Vec2; 3] {
        let index = (rng.unit() * self.strokes.len() as f32) as usize;
        let [before, now] = self.strokes[index.min(self.strokes.len() - 1)];
        let along = rng.unit();
        let side = if rng.unit() < 0.5 { -1.0 } else { 1.0 };
        let out = side * (now[1] - now[0]).perp().try_normalize().unwrap_or(Vec2::X);
        let at = |[from, to]: [Vec2; 2]| from.lerp(to, along) + out * self.radius_px;
        [at(before), at(now), out]
    }
}
