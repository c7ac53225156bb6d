//! Light behind the optics of models, kept for the models that differ in what comes behind them.
//!
//! A search simulates hundreds of models whose lens is the same: its light is computed once.

use std::sync::{Arc, Mutex, PoisonError};

use evpose_core::Plane;
use evpose_sensor::{LinearOptics, SensorConfig};

use crate::{GapError, LightSequence};

const KEPT: usize = 4;
/// Largest sequence that is kept, bytes: all together take a gigabyte at most.
const MAX_BYTES: usize = 256 << 20;

type SharedPlanes = Arc<Vec<Plane<f32>>>;

/// Light behind optics, the last used at the end: the effects of the optics as TOML, and the planes.
#[derive(Debug, Default)]
pub(crate) struct LightBehindOptics {
    entries: Mutex<Vec<(String, SharedPlanes)>>,
}

pub(crate) struct DividedModel {
    pub(crate) light: SharedPlanes,
    pub(crate) rest: SensorConfig,
}

impl LightSequence {
    /// The light of the scene behind the linear optics of a model, and the rest of the model; none
    /// where that is no faster, or takes too much memory.
    ///
    /// # Errors
    /// Optics that cannot be built.
    pub(crate) fn behind_optics(
        &self,
        config: &SensorConfig,
    ) -> Result<Option<DividedModel>, GapError> {
        let bytes = self.planes().len() * self.size().pixels() * size_of::<f32>();
        if bytes > MAX_BYTES {
            return Ok(None);
        }
        let Some((optics, rest)) = LinearOptics::divide(config)? else {
            return Ok(None);
        };
        let of_optics = SensorConfig {
            effects: config
                .effects
                .iter()
                .filter(|effect| rest.effect(&effect.name).is_none())
                .cloned()
                .collect(),
        };
        // Parts of a scene share the cache and differ in their number of planes.
        let key = format!("{} planes\n{}", self.planes().len(), of_optics.to_toml());
        let lock = || self.behind.entries.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut kept = lock();
            if let Some(at) = kept.iter().position(|(other, _)| *other == key) {
                let known = kept.remove(at);
                let light = Arc::clone(&known.1);
                kept.push(known);
                return Ok(Some(DividedModel { light, rest }));
            }
        }
        // Without the lock: another thread may compute the same, but none waits for optics it does
        // not need.
        let light = Arc::new(optics.images(self.planes()));
        let mut kept = lock();
        kept.retain(|(other, _)| *other != key);
        kept.push((key, Arc::clone(&light)));
        if kept.len() > KEPT {
            kept.remove(0);
        }
        Ok(Some(DividedModel { light, rest }))
    }
}

#[cfg(test)]
mod tests {
    use evpose_sensor::EffectConfig;

    use super::*;

    fn scene() -> LightSequence {
        let light = |k: usize, pixel: usize| 0.2 + 0.15 * ((pixel % 20 + k) as f32 * 0.7).sin();
        let plane = |k| (0..300).map(|pixel| light(k, pixel)).collect();
        let planes = (0..40).map(|k| Plane::from_vec(20, 15, plane(k)).unwrap());
        LightSequence::new(1_000.0, planes.collect()).unwrap()
    }

    fn with_blur(sigma_px: f64) -> SensorConfig {
        let mut config = SensorConfig::default();
        let blur = EffectConfig::new("psf_blur").with("sigma_px", sigma_px);
        config.insert(blur);
        config
    }

    #[test]
    fn light_behind_one_lens_is_computed_once_and_shared_with_parts_of_the_scene() {
        let scene = scene();
        let light = |scene: &LightSequence, sigma_px: f64| {
            scene.behind_optics(&with_blur(sigma_px)).unwrap().unwrap().light
        };
        let first = light(&scene, 1.0);
        assert_ne!(first[7].data(), scene.planes()[7].data());
        assert!(Arc::ptr_eq(&first, &light(&scene, 1.0)));
        let part = scene.first(scene.time(19));
        assert_eq!(light(&part, 1.0).as_slice(), &first[..20]);
        assert!(Arc::ptr_eq(&light(&part, 1.0), &light(&scene.first(scene.time(19)), 1.0)));
        // The lens that was used last but a few is forgotten.
        (2..=1 + KEPT).for_each(|sigma| drop(light(&scene, sigma as f64)));
        assert!(!Arc::ptr_eq(&first, &light(&scene, 1.0)));
    }

    #[test]
    fn a_model_without_optics_sees_the_scene_as_it_is() {
        assert!(scene().behind_optics(&SensorConfig::default()).unwrap().is_none());
    }
}
