//! Analytic scenes: linear luminance at any point and instant, 1 = white.
//!
//! A scene is made again from its kind and seed and never stored. Everything is drawn in the
//! logarithm of light between .02 and 1 (.017 under a passing shade). Every edge is at least
//! 1.5 px wide and takes at least 10 ms to pass, so that frames at 1 kHz, interpolated linearly,
//! follow the scene to .035 in `ln I` everywhere and to .0007 r.m.s. (both are tests). Each scene
//! has a strip of eight still brightness levels, and more ground on which only the shade moves, too
//! weak to fire the ideal pixel.

mod bars;
mod blobs;
mod cloud;
mod disc;
mod discs;
mod pan;
mod rest;
mod shape;
mod steps;
mod waves;

use serde::Serialize;

use crate::draw::{Purpose, Sequence};
use crate::event::{HEIGHT, WIDTH};
use cloud::Cloud;
use steps::Strip;

/// Darkest level of any scene, natural logarithm.
pub(crate) const DARKEST_LN: f64 = -3.912_023_005;

/// The kinds of scenes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SceneKind {
    /// Textured discs that cross a shaded ground.
    Discs,
    /// Gratings of several periods and speeds between still patches.
    Bars,
    /// Polygons behind a shaking camera, with a still frame.
    Pan,
    /// Travelling waves inside still ground.
    Waves,
    /// Soft bright and dark blobs on their orbits.
    Blobs,
    /// Mostly still patches, a few slow discs and a fast one.
    Rest,
}

/// All kinds, in the order the plan goes through them.
pub const SCENE_KINDS: [SceneKind; 6] = [
    SceneKind::Discs,
    SceneKind::Bars,
    SceneKind::Pan,
    SceneKind::Waves,
    SceneKind::Blobs,
    SceneKind::Rest,
];

impl SceneKind {
    /// The name of the kind.
    pub fn name(self) -> &'static str {
        match self {
            Self::Discs => "discs",
            Self::Bars => "bars",
            Self::Pan => "pan",
            Self::Waves => "waves",
            Self::Blobs => "blobs",
            Self::Rest => "rest",
        }
    }
}

#[derive(Debug, Clone)]
enum World {
    Discs(discs::Discs),
    Bars(bars::Bars),
    Pan(pan::Pan),
    Waves(waves::Waves),
    Blobs(blobs::Blobs),
    Rest(rest::Rest),
}

/// One scene.
#[derive(Debug, Clone)]
pub struct Scene {
    strip: Strip,
    cloud: Cloud,
    world: World,
}

impl Scene {
    /// The scene of this kind and seed.
    pub fn new(kind: SceneKind, seed: u64) -> Self {
        let mut draws = Sequence::new(seed, Purpose::Scene, kind as u64);
        let strip = Strip::new(&mut draws);
        let cloud = Cloud::new(&mut draws);
        let world = match kind {
            SceneKind::Discs => World::Discs(discs::Discs::new(&mut draws)),
            SceneKind::Bars => World::Bars(bars::Bars::new(&mut draws)),
            SceneKind::Pan => World::Pan(pan::Pan::new(&mut draws)),
            SceneKind::Waves => World::Waves(waves::Waves::new(&mut draws)),
            SceneKind::Blobs => World::Blobs(blobs::Blobs::new(&mut draws)),
            SceneKind::Rest => World::Rest(rest::Rest::new(&mut draws)),
        };
        Self { strip, cloud, world }
    }

    /// Natural logarithm of the luminance at `(x, y)` in pixels (centres are integers) at `t_s`.
    pub fn log_luminance(&self, x_px: f64, y_px: f64, t_s: f64) -> f64 {
        // The strip lies before the world, and no shade falls on it: its levels are known exactly.
        let (cover, level) = self.strip.at(x_px, y_px);
        if cover >= 1.0 {
            return level;
        }
        let world = match &self.world {
            World::Discs(world) => world.at(x_px, y_px, t_s),
            World::Bars(world) => world.at(x_px, y_px, t_s),
            World::Pan(world) => world.at(x_px, y_px, t_s),
            World::Waves(world) => world.at(x_px, y_px, t_s),
            World::Blobs(world) => world.at(x_px, y_px, t_s),
            World::Rest(world) => world.at(x_px, y_px, t_s),
        };
        shape::blend(world + self.cloud.at(x_px, y_px, t_s), level, cover)
    }

    /// Linear luminance, 1 = white.
    pub fn luminance(&self, x_px: f64, y_px: f64, t_s: f64) -> f64 {
        self.log_luminance(x_px, y_px, t_s).exp()
    }

    /// Frame `k` of a camera with `fps` frames per second: the luminance at the pixel centres at
    /// `k / fps`, row by row.
    pub fn frame(&self, k: usize, fps: f64) -> Vec<f32> {
        let t_s = k as f64 / fps;
        let pixel = |i: usize| self.luminance((i % WIDTH) as f64, (i / WIDTH) as f64, t_s) as f32;
        (0..WIDTH * HEIGHT).map(pixel).collect()
    }
}
