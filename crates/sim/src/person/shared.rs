//! State shared by all sequences of a run of people.

use evpose_body::mocap::MotionLibrary;
use evpose_body::{BodyModel, MakeHuman, ShapedBody};
use evpose_core::CounterRng;
use glam::Vec2;

use super::config::PeopleConfig;
use super::luminance_image::LuminancePool;
use crate::SimError;
use crate::randomisation::Randomisation;
use crate::raster::is_closed;
use crate::texture::metres_per_texture;

/// Shares of MakeHuman's people with long hair, and with a skirt.
const LONG_HAIR: f32 = 0.4;
const SKIRTS: f32 = 0.25;

/// Configuration, bodies and background images of a run.
#[derive(Debug)]
pub(super) struct Shared {
    pub(super) config: PeopleConfig,
    pub(super) seed: u64,
    /// The bodies to choose from, at least one.
    pub(super) bodies: Vec<DressedBody>,
    /// MakeHuman's body, for a share of the people.
    pub(super) makehuman: Option<DressedBody>,
    /// Captured motion, for a share of the people.
    pub(super) motions: Option<MotionLibrary>,
    pub(super) images: LuminancePool,
    pub(super) randomisation: Option<Randomisation>,
}

#[derive(Debug)]
pub(super) struct DressedBody {
    pub(super) model: BodyModel,
    /// Faces of each outfit; none where the model's are the only ones.
    outfits: Vec<Vec<[u32; 3]>>,
    /// Whether the faces of the first outfit bound a solid; those of others do not.
    is_closed: bool,
    pub(super) metres_per_texture: Vec2,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct BodyChoice {
    /// Place among the bodies; none for MakeHuman's.
    body: Option<usize>,
    outfit: usize,
}

impl DressedBody {
    pub(super) fn new(model: BodyModel) -> Self {
        let (points_m, uvs, faces) = (&model.template_m, &model.uvs, &model.faces);
        Self {
            metres_per_texture: metres_per_texture(points_m, uvs, faces),
            is_closed: is_closed(faces),
            outfits: Vec::new(),
            model,
        }
    }

    pub(super) fn of_makehuman(MakeHuman { model, outfits }: MakeHuman) -> Self {
        let is_closed = is_closed(&outfits[0]);
        Self { outfits: outfits.to_vec(), is_closed, ..Self::new(model) }
    }

    /// Faces in the outfit of `choice`.
    pub(super) fn faces(&self, choice: BodyChoice) -> &[[u32; 3]] {
        self.outfits.get(choice.outfit).unwrap_or(&self.model.faces)
    }

    /// Whether they bound a solid.
    pub(super) fn is_closed(&self, choice: BodyChoice) -> bool {
        choice.outfit == 0 && self.is_closed
    }
}

impl Shared {
    /// The configuration of sequence `index` of the streams of `seed`: that of the run, randomised
    /// if it says so.
    pub(super) fn config_of(&self, seed: u64, index: u64) -> Result<PeopleConfig, SimError> {
        let Some(ranges) = &self.randomisation else { return Ok(self.config.clone()) };
        let config = ranges.draw(&self.config, seed, index)?;
        config.validate()?;
        Ok(config)
    }

    /// Draws a body: MakeHuman's, where there is one, for `share` of the people.
    pub(super) fn draw_body(&self, share: f32, rng: &mut CounterRng) -> BodyChoice {
        let body = rng.below(self.bodies.len());
        if self.makehuman.is_none() || !rng.chance(share) {
            return BodyChoice { body: Some(body), outfit: 0 };
        }
        let (has_hair, has_skirt) = (rng.chance(LONG_HAIR), rng.chance(SKIRTS));
        BodyChoice { body: None, outfit: usize::from(has_hair) + 2 * usize::from(has_skirt) }
    }

    pub(super) fn body(&self, choice: BodyChoice) -> &DressedBody {
        let own = choice.body.map(|body| &self.bodies[body]).or(self.makehuman.as_ref());
        own.unwrap_or(&self.bodies[0])
    }

    /// Height of a shaped body in the T-pose, in metres.
    pub(super) fn height_m(&self, shaped: &ShapedBody) -> f32 {
        let heights = shaped.vertices_m.iter().map(|vertex_m| vertex_m.y);
        let (low, high) = heights.fold((f32::MAX, f32::MIN), |(l, h), y| (l.min(y), h.max(y)));
        high - low
    }
}
