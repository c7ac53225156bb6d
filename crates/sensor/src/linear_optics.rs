//! Optics through which light can be sent once for many runs.
//!
//! Stages of the optics that are linear in light, and have no memory, noise or time, turn one
//! luminance plane into another. Who shows one scene to many models need not repeat that where the
//! optics stay the same.

use evpose_core::{Plane, SensorSize, StageNoise};

use crate::stage::{Block, State};
use crate::tick::Tick;
use crate::{Domain, PlaneStage, STAGES, SensorConfig, SensorError, Stage};

/// The linear optics in front of everything else that acts on light.
#[derive(Debug)]
pub struct LinearOptics {
    stages: Vec<Box<dyn PlaneStage>>,
}

impl LinearOptics {
    /// Divides a configuration into its linear optics and a configuration of the rest; none if it
    /// has no such optics, or a stage in front of them.
    ///
    /// # Errors
    /// As [`crate::SensorModel::from_config`] for effects of the optics.
    pub fn divide(config: &SensorConfig) -> Result<Option<(Self, SensorConfig)>, SensorError> {
        let mut stages = Vec::new();
        let mut rest = config.clone();
        let mut is_linear = true;
        for effect in &config.effects {
            let Some(spec) = STAGES.find(&effect.name) else { continue };
            // Effects may come in any order: those that are not of the optics stay in the rest.
            if spec.domain != Domain::Optics {
                continue;
            }
            match (spec.build)(&spec.settings(effect)?)? {
                Stage::Plane(stage) if is_linear && stage.traits().is_linear => {
                    rest.effects.retain(|other| other.name != effect.name);
                    stages.push(stage);
                }
                // Light within a divided step is not linear in that at its ends, wherever it is divided.
                Stage::Steps(_) => return Ok(None),
                // What comes behind a stage that is not linear cannot be taken out either.
                _ => is_linear = false,
            }
        }
        Ok((!stages.is_empty()).then_some((Self { stages }, rest)))
    }

    /// Light behind the optics, of planes of one size. What cannot be light is darkness.
    pub fn images(&self, luminance: &[Plane<f32>]) -> Vec<Plane<f32>> {
        let mut images = luminance.to_vec();
        let Some(first) = images.first() else { return images };
        let size = SensorSize { width: first.width() as u16, height: first.height() as u16 };
        // One infinity or NaN would spread over the whole image: a veil is a mean of all pixels.
        for image in &mut images {
            image.data_mut().iter_mut().for_each(|light| *light = light.clamp(0.0, f32::MAX));
            for light in image.data_mut().iter_mut().filter(|light| light.is_nan()) {
                *light = 0.0;
            }
        }
        // Linear optics draw nothing: no seed has an effect.
        let noise = StageNoise::new(0, "", 0);
        let tick = Tick { start_s: 0.0, end_s: 0.0, index: 0 };
        for stage in &self.stages {
            let mut planes = vec![vec![0.0; size.pixels()]; stage.state_planes()];
            let mut planes: Vec<&mut [f32]> = planes.iter_mut().map(Vec::as_mut_slice).collect();
            for (k, image) in images.iter_mut().enumerate() {
                let pixels = 0..size.pixels();
                let mut block = Block {
                    pixels: pixels.clone(),
                    photocurrent: &[],
                    signal: image.data_mut(),
                    state: State::new(&mut planes, pixels),
                };
                // Patterns of the optics are the same for all images.
                if k == 0 {
                    stage.init(size, &mut block, noise);
                }
                stage.step(&tick, size, &mut block, noise);
            }
        }
        images
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EffectConfig, SensorModel};
    use evpose_core::Micros;

    const SIZE: SensorSize = SensorSize { width: 24, height: 20 };

    fn scene() -> Vec<Plane<f32>> {
        let light = |k: usize, pixel: usize| {
            let (x, y) = (pixel % 24, pixel / 24);
            0.3 + 0.2 * (0.8 * x as f32 + 0.3 * y as f32 - 0.2 * k as f32).sin()
        };
        let plane = |k| (0..SIZE.pixels()).map(|pixel| light(k, pixel)).collect();
        (0..60).map(|k| Plane::from_vec(24, 20, plane(k)).unwrap()).collect()
    }

    #[test]
    fn light_that_has_passed_the_optics_makes_the_events_of_the_whole_sensor() {
        for name in ["lens_distortion", "psf_blur", "veiling_glare", "vignetting"] {
            let mut config = SensorConfig::preset("v2e-noisy").unwrap();
            config.insert(STAGES.find(name).unwrap().typical());
            let (optics, rest) = LinearOptics::divide(&config).unwrap().unwrap();
            assert!(rest.effect(name).is_none() && rest.effects.len() + 1 == config.effects.len());
            let events = |config: &SensorConfig, scene: &[Plane<f32>]| {
                let mut run = SensorModel::from_config(config).unwrap().start(SIZE, 5);
                let mut all = Vec::new();
                for (k, plane) in scene.iter().enumerate() {
                    all.extend(run.expose(plane, Micros(1_000 * k as i64)).unwrap().iter());
                }
                all
            };
            let whole = events(&config, &scene());
            assert!(whole.len() > 500, "{name}: {} events", whole.len());
            assert_eq!(whole, events(&rest, &optics.images(&scene())), "{name}");
        }
    }

    #[test]
    fn optics_behind_a_lamp_are_left_where_they_are() {
        let mut config = SensorConfig::default();
        assert!(LinearOptics::divide(&config).unwrap().is_none());
        config.insert(EffectConfig::new("psf_blur").with("sigma_px", 0.8));
        assert!(LinearOptics::divide(&config).unwrap().is_some());
        config.insert(STAGES.find("lamp_flicker").unwrap().typical());
        assert!(LinearOptics::divide(&config).unwrap().is_none());
    }
}
