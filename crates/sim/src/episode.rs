//! Parameters that are constant over an episode and redrawn for the next.

use evpose_core::CounterRng;
use glam::Vec2;

use crate::config::SimulationConfig;
use crate::scene::{BackdropPlacement, Lighting};
use crate::texture::SkinCoefficients;

/// Person, surroundings and threshold of one episode.
#[derive(Debug, Clone, PartialEq)]
pub struct Episode {
    /// Index of the episode in its sequence, from 0.
    pub index: u64,
    /// Shape coefficients of the body.
    pub betas: Vec<f32>,
    /// Skin coefficients of the person.
    pub skin: SkinCoefficients,
    /// Lights on the hand.
    pub lighting: Lighting,
    /// Index of the background image in the pool.
    pub background: usize,
    /// Placement of the background image.
    pub placement: BackdropPlacement,
    /// Offset of the sensor's contrast thresholds, in natural-log intensity.
    pub threshold_offset: f64,
}

impl Episode {
    /// Draws episode `index` of a sequence. Each part has a random stream of its own: switching one
    /// off does not change the others.
    ///
    /// # Panics
    /// If the pool of `images` background images is empty.
    ///
    /// # Source
    /// EventHands simulator: shape U(-2, 2), texture N(0, 2²), light directions uniform on the
    /// sphere, colours · U(0.9, 1.1), background uniform, offset U(-0.1, 0.1)², threshold
    /// N(0.5, 0.02²).
    pub fn draw(
        config: &SimulationConfig,
        betas: usize,
        images: usize,
        sequence_seed: u64,
        index: u64,
    ) -> Self {
        // A generator each: a change to what one part draws leaves the others as they were.
        let part = |name| CounterRng::new(sequence_seed, name, index);
        let mut shape = part("episode shape");
        let mut background = part("episode background");
        let reach = config.backgrounds.offset;
        Self {
            index,
            betas: (0..betas)
                .map(|_| shape.uniform(-config.shape_range, config.shape_range))
                .collect(),
            skin: SkinCoefficients::draw(&mut part("episode skin"), config.skin.variation_sd),
            lighting: config.lights.draw(&mut part("episode lights")),
            background: background.below(images),
            placement: BackdropPlacement {
                scale: config.backgrounds.scale,
                offset: Vec2::new(
                    background.uniform(-reach, reach),
                    background.uniform(-reach, reach),
                ),
                gamma: config.backgrounds.gamma,
            },
            threshold_offset: config.threshold_sd * f64::from(part("episode threshold").normal()),
        }
    }
}

/// Whether `frame` is the first of an episode; see `ParityConfig::lagging_episode_clock`.
pub(crate) fn starts_episode(frame: u64, episode_frames: u64, lagging_clock: bool) -> bool {
    if lagging_clock {
        frame == 0 || (frame - 1).is_multiple_of(episode_frames)
    } else {
        frame.is_multiple_of(episode_frames)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn episodes_begin_at_the_published_frames() {
        let begins = |lagging| -> Vec<u64> {
            (0..150_000).filter(|&frame| starts_episode(frame, 50_000, lagging)).collect()
        };
        assert_eq!(begins(false), [0, 50_000, 100_000]);
        assert_eq!(begins(true), [0, 1, 50_001, 100_001]);
    }

    #[test]
    fn draws_have_the_published_distributions() {
        let config = SimulationConfig::default();
        let episodes: Vec<_> = (0..4_000).map(|i| Episode::draw(&config, 10, 9, 3, i)).collect();
        let n = episodes.len() as f64;
        let betas = episodes.iter().flat_map(|e| &e.betas);
        assert!(betas.clone().all(|b| (-2.0..=2.0).contains(b)));
        let variance = betas.map(|&b| f64::from(b * b)).sum::<f64>() / (10.0 * n);
        assert!((variance - 4.0 / 3.0).abs() < 0.03, "{variance}");
        let sd = (episodes.iter().map(|e| e.threshold_offset.powi(2)).sum::<f64>() / n).sqrt();
        assert!((sd - 0.02).abs() < 0.001, "{sd}");
        let mean: glam::Vec3A =
            episodes.iter().map(|e| e.lighting.lights[0].direction).sum::<glam::Vec3A>() / n as f32;
        assert!(mean.length() < 0.04, "{mean}");
        let mut images = [0; 9];
        for episode in &episodes {
            images[episode.background] += 1;
            assert!(episode.placement.offset.abs().max_element() <= 0.1);
        }
        assert!(images.iter().all(|&count| (360..530).contains(&count)), "{images:?}");
    }

    #[test]
    fn switching_one_draw_off_leaves_the_others() {
        let config = SimulationConfig::default();
        let mut plain = config.clone();
        plain.shape_range = 0.0;
        plain.lights.random = false;
        let (varied, plain) =
            (Episode::draw(&config, 10, 9, 1, 2), Episode::draw(&plain, 10, 9, 1, 2));
        assert!(plain.betas.iter().all(|&b| b == 0.0));
        assert_eq!((varied.skin, varied.background), (plain.skin, plain.background));
        assert_eq!(varied.threshold_offset, plain.threshold_offset);
    }
}
