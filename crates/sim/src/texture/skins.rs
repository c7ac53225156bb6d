//! Source of the skin textures of a run.

use evpose_core::CounterRng;

use super::covering::paint_covering;
use super::skin::skin_albedo;
use super::{HtmlSkins, SkinCoefficients, Texture};
use crate::SimError;
use crate::config::{SkinConfig, SkinSource};

/// Skin textures of people: procedural, or drawn from the HTML model.
#[derive(Debug)]
pub struct Skins(Option<HtmlSkins>);

impl Skins {
    /// Opens the `source`.
    ///
    /// # Errors
    /// As [`HtmlSkins::open`].
    pub fn new(source: &SkinSource) -> Result<Self, SimError> {
        Ok(Self(match source {
            SkinSource::Procedural => None,
            SkinSource::Html(folder) => Some(HtmlSkins::open(folder)?),
        }))
    }

    /// Paints the skin of episode `index` of a sequence; a procedural one has the person's
    /// `coefficients`.
    ///
    /// # Errors
    /// If a file can no longer be read.
    pub fn paint(
        &self,
        config: &SkinConfig,
        coefficients: &SkinCoefficients,
        sequence_seed: u64,
        index: u64,
    ) -> Result<Texture, SimError> {
        if let Some(skins) = &self.0 {
            let mut rng = CounterRng::new(sequence_seed, "episode skin texture", index);
            return skins.draw(&mut rng, config.variation_sd);
        }
        // Marks and clothes have streams of their own: a change of one leaves the other.
        let mut marks = CounterRng::new(sequence_seed, "episode skin marks", index);
        let mut albedo = skin_albedo(config.texels, coefficients, &mut marks);
        let mut worn = CounterRng::new(sequence_seed, "episode covering", index);
        paint_covering(config, &mut albedo, &mut worn);
        Ok(Texture::from_plane(&albedo))
    }
}
