//! A run of people: the state shared by all its sequences.

use std::sync::Arc;

use evpose_body::files::ModelFile;
use evpose_body::mocap::MotionLibrary;
use evpose_body::{BodyModel, Garments, MakeHuman};
use evpose_core::{CounterRng, Micros, Plane, seed_for};
use rayon::prelude::*;

use super::config::PeopleConfig;
use super::luminance_image::LuminancePool;
use super::shared::{DressedBody, Shared};
use super::still::{Still, photographs, still};
use super::{PersonSimulator, PersonStep};
use crate::SimError;
use crate::config::{BodySource, MotionSource};
use crate::randomisation::Randomisation;
use crate::texture::ImagePool;

/// A validated configuration with body, background images and sensor loaded. Cheap to clone.
#[derive(Debug, Clone)]
pub struct People {
    pub(super) shared: Arc<Shared>,
}

impl People {
    /// Prepares a run. People, activities, surroundings and noise are functions of `seed`.
    ///
    /// # Errors
    /// As [`PeopleConfig::validate`]; unreadable models, motions and background images. Folders that
    /// are not there are no error: [`PeopleConfig::missing_folders`].
    pub fn new(config: &PeopleConfig, seed: u64) -> Result<Self, SimError> {
        config.validate()?;
        let bodies = match &config.body {
            BodySource::Procedural | BodySource::MakeHuman(_) => match config.outfits {
                0 => vec![BodyModel::procedural_human()],
                outfits => dressed(outfits, seed_for(seed, "people outfits", 0)),
            },
            BodySource::File(path) => {
                let model = ModelFile::read(path)?.model;
                // Labels are joints by number: those of another skeleton would be wrong.
                if model.parents.len() != evpose_body::skeleton::JOINTS {
                    return Err(SimError::NotABody { path: path.clone() });
                }
                vec![model]
            }
        };
        let makehuman = match &config.body {
            // A folder that is missing is no error: data sets are optional.
            BodySource::MakeHuman(folder) if folder.is_dir() => {
                Some(DressedBody::of_makehuman(MakeHuman::read(folder)?))
            }
            _ => None,
        };
        let motions = match &config.motion {
            MotionSource::Cmu(folder) if folder.is_dir() => Some(MotionLibrary::read(folder)?),
            _ => None,
        };
        let randomisation =
            config.randomisation.as_deref().map(Randomisation::named).transpose()?;
        // A seed of its own: images stay the same when another part of a run draws more.
        let pool = seed_for(seed, "people background pool", 0);
        let shared = Shared {
            seed,
            images: LuminancePool::new(
                ImagePool::new(&config.surroundings.source, pool)?,
                config.surroundings.gamma,
            ),
            bodies: bodies.into_iter().map(DressedBody::new).collect(),
            makehuman,
            motions,
            randomisation,
            config: config.clone(),
        };
        Ok(Self { shared: Arc::new(shared) })
    }

    /// Starts sequence `index`, before its first step.
    ///
    /// # Errors
    /// If the sensor's thresholds, varied, are out of their range.
    pub fn sequence(&self, index: u64) -> Result<PersonSimulator, SimError> {
        PersonSimulator::new(Arc::clone(&self.shared), index)
    }

    /// Renders photograph `index`: a drawn person at a drawn time of an activity.
    ///
    /// # Errors
    /// If a randomised field is out of its range.
    pub fn still(&self, index: u64) -> Result<Still, SimError> {
        still(&self.shared, index)
    }

    /// Renders grey frames of a sequence at `times`, in their order.
    ///
    /// # Errors
    /// If a randomised field is out of its range.
    pub fn photographs(&self, sequence: u64, times: &[Micros]) -> Result<Vec<Plane<u8>>, SimError> {
        photographs(&self.shared, sequence, times)
    }

    /// Configuration of the simulation.
    pub fn config(&self) -> &PeopleConfig {
        &self.shared.config
    }

    /// Passes the steps of a sequence to `visit`, one after another, until it fails.
    ///
    /// # Errors
    /// As [`PersonSimulator::advance`], and those of `visit`.
    pub fn play<E: From<SimError>>(
        &self,
        index: u64,
        mut visit: impl FnMut(&PersonStep<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut simulator = self.sequence(index)?;
        for _ in 0..self.shared.config.steps() {
            visit(&simulator.advance()?)?;
        }
        Ok(())
    }
}

/// Bodies in drawn outfits, made in parallel.
fn dressed(count: usize, seed: u64) -> Vec<BodyModel> {
    let outfit = |index| {
        let garments = Garments::draw(&mut CounterRng::new(seed, "outfit", index));
        BodyModel::dressed_human(&garments)
    };
    (0..count as u64).into_par_iter().map(outfit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::BackgroundSource;
    use crate::person::SurroundingsConfig;

    #[test]
    fn runs_of_two_seeds_share_no_outfit_and_no_background() {
        let config = PeopleConfig {
            outfits: 5,
            surroundings: SurroundingsConfig {
                source: BackgroundSource::Procedural(14),
                ..SurroundingsConfig::default()
            },
            ..PeopleConfig::default()
        };
        let [first, second] = [3, 4].map(|seed| People::new(&config, seed).expect("valid").shared);
        for a in &first.bodies {
            for b in &second.bodies {
                assert_ne!(a.model.template_m, b.model.template_m);
            }
        }
        for a in 0..14 {
            for b in 0..14 {
                assert_ne!(first.images.image(a), second.images.image(b), "{a} and {b}");
            }
        }
    }
}
