//! Configuration of lights, backgrounds and skin.

use std::path::PathBuf;

use evpose_core::CounterRng;
use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::scene::{DirectionalLight, Lighting};

/// Two lights whose directions are drawn anew every episode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LightConfig {
    /// Linear RGB of the first light.
    pub first: Vec3,
    /// Linear RGB of the second light.
    pub second: Vec3,
    /// Each channel of each light is multiplied by a factor drawn from this range.
    pub jitter: [f32; 2],
    /// Linear RGB of the ambient light.
    pub ambient: Vec3,
    /// Factor on all light.
    pub gain: f32,
    /// Whether directions and jitter are drawn; otherwise the lights are the published resting
    /// ones.
    pub random: bool,
}

impl Default for LightConfig {
    fn default() -> Self {
        Self {
            first: Vec3::new(1.0, 0.7, 0.5),
            second: Vec3::new(0.15, 0.21, 0.3),
            jitter: [0.9, 1.1],
            ambient: Vec3::new(0.05, 0.05, 0.1),
            gain: 1.4,
            random: true,
        }
    }
}

impl LightConfig {
    /// Draws the lights of one episode.
    pub fn draw(&self, rng: &mut CounterRng) -> Lighting {
        let resting = [Vec3::new(-1.0, 1.0, 1.0), Vec3::new(1.0, 1.0, -1.0)];
        let [first, second] =
            [(self.first, resting[0]), (self.second, resting[1])].map(|(colour, resting)| {
                let (direction, factor) = if self.random {
                    // Each channel has a factor of its own, so that colours vary as well as
                    // brightness.
                    let [low, high] = self.jitter;
                    let mut factor = || rng.uniform(low, high);
                    let factor = Vec3::new(factor(), factor(), factor());
                    (unit_sphere(rng), factor)
                } else {
                    (resting, Vec3::ONE)
                };
                DirectionalLight {
                    direction: direction.normalize_or(Vec3::Y).into(),
                    colour: (colour * factor).into(),
                }
            });
        Lighting { lights: [first, second], ambient: self.ambient.into(), gain: self.gain }
    }
}

/// A vector whose direction is uniform on the sphere: the normal distribution is isotropic.
fn unit_sphere(rng: &mut CounterRng) -> Vec3 {
    Vec3::new(rng.normal(), rng.normal(), rng.normal())
}

/// Background images behind the hand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BackgroundConfig {
    /// Source of the images.
    pub source: BackgroundSource,
    /// Size of a background image relative to the frame.
    pub scale: f32,
    /// Largest shift of a background image, as a share of its width and height.
    pub offset: f32,
    /// Exponent of the images' gamma encoding.
    pub gamma: f32,
}

impl Default for BackgroundConfig {
    fn default() -> Self {
        Self { source: BackgroundSource::Procedural(9), scale: 1.3, offset: 0.1, gamma: 2.2 }
    }
}

/// Source of the pool from which each episode draws a background image.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BackgroundSource {
    /// `{ procedural = 9 }`: number of generated images; they depend on the seed.
    Procedural(usize),
    /// `{ folder = "…" }`: the `.png` and `.jpg` files of a folder, in order of name.
    Folder(PathBuf),
}

/// Skin of the hand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SkinConfig {
    /// Source of the skin textures.
    pub source: SkinSource,
    /// Texels along each side of a procedural skin.
    pub texels: usize,
    /// Standard deviation of the texture coefficients over people.
    pub variation_sd: f32,
    /// Share of the episodes with a sleeve down to about the wrist.
    pub sleeves: f32,
    /// Share of the episodes with a glove.
    pub gloves: f32,
    /// Share of the episodes with rings, and of those with a watch where there is no sleeve.
    pub rings: f32,
}

impl Default for SkinConfig {
    fn default() -> Self {
        Self {
            source: SkinSource::default(),
            texels: 512,
            variation_sd: 2.0,
            sleeves: 0.0,
            gloves: 0.0,
            rings: 0.0,
        }
    }
}

/// Source of skin textures.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SkinSource {
    /// `source = "procedural"`.
    #[default]
    Procedural,
    /// `source = { html = "…" }`: the folder of the HTML texture model, for a body with its texture
    /// coordinates.
    Html(PathBuf),
}
