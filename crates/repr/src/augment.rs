//! Augmentation of training samples: the length of the window and the channel of each polarity.
//!
//! # Model
//! 1. The window has `round(exp(U(ln 30, ln 300)))` frames, log-uniform: a fast hand seen for a
//!    short time looks like a slow one seen for long.
//! 2. With probability 1/2 the two channels are swapped.
//! 3. With probability 1/2, for each pixel by itself, its two channels are swapped: what a pixel
//!    fires depends on which of hand and background is brighter, so the network must not lean
//!    on it.
//!
//! # Source
//! The published program of Rudnev et al., *EventHands*, ICCV 2021, which applies it to training
//! and validation samples alike.

use evpose_core::{CounterRng, StageNoise};
use serde::{Deserialize, Serialize};

/// How training windows vary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WindowAugmentation {
    /// The shortest window.
    pub shortest_frames: u32,
    /// The longest window.
    pub longest_frames: u32,
    /// Swap the channels of half of the samples.
    pub swap_image: bool,
    /// Swap the channels of half of the pixels.
    pub swap_pixels: bool,
}

impl Default for WindowAugmentation {
    /// The published augmentation.
    fn default() -> Self {
        Self { shortest_frames: 30, longest_frames: 300, swap_image: true, swap_pixels: true }
    }
}

impl WindowAugmentation {
    /// Windows of one length, nothing swapped.
    pub fn none(frames: u32) -> Self {
        Self {
            shortest_frames: frames,
            longest_frames: frames,
            swap_image: false,
            swap_pixels: false,
        }
    }

    /// Draws the variation of sample number `sample`, which depends on it and on `seed` only.
    pub fn draw(&self, seed: u64, sample: u64) -> WindowDraw {
        let mut rng = CounterRng::new(seed, "window augmentation", sample);
        let shortest = self.shortest_frames.max(1);
        let longest = self.longest_frames.max(shortest);
        // Even in the logarithm: half and double length are equally likely.
        let log_frames = rng.uniform((shortest as f32).ln(), (longest as f32).ln());
        let frames = (log_frames.exp().round() as u32).clamp(shortest, longest);
        // Drawn in any case: switching one augmentation off must not change the others.
        let swap_image = rng.chance(0.5) && self.swap_image;
        let pixels =
            self.swap_pixels.then(|| StageNoise::new(seed, "window augmentation pixels", sample));
        WindowDraw { frames, swap_image, pixels }
    }
}

/// The variation of one sample.
#[derive(Debug, Clone, Copy)]
pub struct WindowDraw {
    /// Length of its window.
    pub frames: u32,
    /// Whether its channels are swapped as a whole.
    pub swap_image: bool,
    /// Noise that selects the swapped pixels, if any.
    pixels: Option<StageNoise>,
}

impl WindowDraw {
    /// Swaps channels in planes `[2][height][width]`; planes of another number of channels have
    /// nothing to swap.
    pub fn swap_channels(&self, planes: &mut [f32], channels: usize) {
        if channels != 2 || (self.pixels.is_none() && !self.swap_image) {
            return;
        }
        let (first, second) = planes.split_at_mut(planes.len() / 2);
        for (word, (first, second)) in first.chunks_mut(64).zip(second.chunks_mut(64)).enumerate() {
            // One bit a pixel.
            let swapped = self.pixels.map_or(0, |noise| noise.bits(word, 0));
            let swapped = if self.swap_image { !swapped } else { swapped };
            let bytes = swapped.to_le_bytes();
            let (first, first_rest) = first.as_chunks_mut::<8>();
            let (second, second_rest) = second.as_chunks_mut::<8>();
            let rest_byte = bytes.get(first.len()).copied().unwrap_or(0);
            for (byte, (first, second)) in bytes.into_iter().zip(first.iter_mut().zip(second)) {
                swap_where(byte, first, second);
            }
            swap_where(rest_byte, first_rest, second_rest);
        }
    }
}

/// Swaps up to eight pairs, those whose bit is set, without a branch that would be taken at random.
#[inline]
fn swap_where(bits: u8, first: &mut [f32], second: &mut [f32]) {
    const BIT: [u8; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
    for ((a, b), bit) in first.iter_mut().zip(second).zip(BIT) {
        let mask = if bits & bit == 0 { 0 } else { u32::MAX };
        let difference = (a.to_bits() ^ b.to_bits()) & mask;
        *a = f32::from_bits(a.to_bits() ^ difference);
        *b = f32::from_bits(b.to_bits() ^ difference);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planes() -> Vec<f32> {
        (0..2 * 500).map(|i| i as f32).collect()
    }

    #[test]
    fn a_draw_depends_on_seed_and_sample_only() {
        let augmentation = WindowAugmentation::default();
        let all = |seed| -> Vec<_> {
            (0..50)
                .map(|sample| {
                    let draw = augmentation.draw(seed, sample);
                    let mut swapped = planes();
                    draw.swap_channels(&mut swapped, 2);
                    (draw.frames, draw.swap_image, swapped)
                })
                .collect()
        };
        assert_eq!(all(1), all(1));
        assert_ne!(all(1), all(2));
    }

    #[test]
    fn windows_are_log_uniform_between_the_shortest_and_the_longest() {
        let augmentation = WindowAugmentation::default();
        let n = 30_000;
        let mut logs: Vec<f64> =
            (0..n).map(|i| f64::from(augmentation.draw(5, i).frames).ln()).collect();
        logs.sort_by(f64::total_cmp);
        let (low, high) = (30f64.ln(), 300f64.ln());
        // Kolmogorov's distance at 1 in 10^6, and half of the widest rounding step.
        let bound = 2.7 / (n as f64).sqrt() + 0.5 / 30.0 / (high - low);
        for (i, log) in logs.iter().enumerate() {
            let uniform = (log - low) / (high - low);
            assert!((uniform - (i as f64 + 0.5) / n as f64).abs() < bound, "{i}: {log}");
        }
        assert!(logs[0] >= low && logs[logs.len() - 1] <= high);
    }

    #[test]
    fn swapping_moves_values_between_the_channels_of_a_pixel_only() {
        let draw = WindowAugmentation::default().draw(3, 9);
        let mut swapped = planes();
        draw.swap_channels(&mut swapped, 2);
        let mut moved = 0;
        for pixel in 0..500 {
            let pair = (swapped[pixel], swapped[500 + pixel]);
            let kept = (pixel as f32, (500 + pixel) as f32);
            assert!(pair == kept || pair == (kept.1, kept.0));
            moved += usize::from(pair != kept);
        }
        // Four standard deviations of a fair coin.
        assert!(moved.abs_diff(250) < 45, "{moved}");
        draw.swap_channels(&mut swapped, 2);
        assert_eq!(swapped, planes());
    }

    #[test]
    fn half_of_the_images_are_swapped_as_a_whole() {
        let augmentation = WindowAugmentation { swap_pixels: false, ..Default::default() };
        let mut count = 0;
        for sample in 0..1000 {
            let draw = augmentation.draw(8, sample);
            let mut swapped = planes();
            draw.swap_channels(&mut swapped, 2);
            let whole = [&planes()[500..], &planes()[..500]].concat();
            assert_eq!(swapped, if draw.swap_image { whole } else { planes() });
            count += usize::from(draw.swap_image);
        }
        assert!(count.abs_diff(500) < 64, "{count}");
    }

    #[test]
    fn without_augmentation_nothing_varies() {
        for sample in 0..100 {
            let draw = WindowAugmentation::none(100).draw(1, sample);
            let mut kept = planes();
            draw.swap_channels(&mut kept, 2);
            assert_eq!((draw.frames, kept), (100, planes()));
        }
    }

    #[test]
    fn planes_of_one_channel_have_nothing_to_swap() {
        let draw = WindowAugmentation::default().draw(3, 9);
        let mut kept = planes();
        draw.swap_channels(&mut kept, 1);
        assert_eq!(kept, planes());
    }
}
