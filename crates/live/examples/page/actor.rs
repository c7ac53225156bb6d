//! Who is seen.

use evpose_core::{CounterRng, Micros, SensorSize};
use evpose_live::page::{HandMesh, Subject};
use evpose_pose::PoseEstimate;
use glam::Vec2;

/// Who sees it.
pub(crate) const SENSOR: SensorSize = SensorSize { width: 640, height: 480 };

/// Somebody who moves.
pub(crate) trait Actor: Send + Sync {
    /// What it is.
    fn subject(&self) -> Subject;

    /// Its surface, if it has one.
    fn mesh(&self) -> Option<HandMesh> {
        None
    }

    /// Its pose.
    fn pose(&self, t: Micros) -> PoseEstimate;

    /// Its outline, at a time and a little later.
    fn outline(&self, t: Micros, later: Micros) -> Outline;
}

/// Where an outline was, where it is.
pub(crate) struct Outline {
    /// Strokes, each from one point to another: before and now.
    pub(crate) strokes: Vec<[[Vec2; 2]; 2]>,
    /// Half the thickness of a stroke, in pixels.
    pub(crate) radius_px: f32,
}

impl Outline {
    /// A place on a side of a stroke drawn by chance: where it was, where it is, and the way outwards.
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
