//! Photometric augmentation: contrast, brightness, noise and occlusion of grey values, 0 to 255.

use evpose_core::CounterRng;
use glam::Vec2;

const WHITE: f32 = 255.0;
/// Bits of noise for each pixel.
const LANE_BITS: u32 = 16;
/// Pixels for which one draw has bits.
const LANES: usize = (u64::BITS / LANE_BITS) as usize;

/// A square of one grey. Lengths are relative to the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Square {
    pub(super) middle: Vec2,
    pub(super) half_side: f32,
    pub(super) grey: u8,
}

/// Multiplies distances to the mean grey by `contrast`, then adds `brightness` times white.
pub(super) fn relight(image: &mut [f32], contrast: f32, brightness: f32) {
    let sum: f64 = image.iter().map(|&grey| f64::from(grey)).sum();
    let mean = (sum / image.len() as f64) as f32;
    for grey in image {
        let contrasted = ((*grey - mean) * contrast + mean).clamp(0.0, WHITE);
        *grey = (contrasted + brightness * WHITE).clamp(0.0, WHITE);
    }
}

/// Adds uniform noise between `-most` and `most` to each pixel.
pub(super) fn add_noise(image: &mut [f32], rng: &mut CounterRng, most: f32) {
    let half = (1u32 << (LANE_BITS - 1)) as f32;
    for pixels in image.chunks_mut(LANES) {
        let bits = rng.bits();
        for (lane, grey) in pixels.iter_mut().enumerate() {
            let lane = (bits >> (LANE_BITS * lane as u32)) as u16;
            // Between -1 and 1, symmetric.
            let unit = (f32::from(lane) + 0.5 - half) / half;
            *grey = (*grey + unit * most).clamp(0.0, WHITE);
        }
    }
}

/// Fills a square of an image of `side` columns. Half of its side is cut to whole
/// pixels, its corners are rounded.
pub(super) fn blank(image: &mut [f32], side: usize, square: &Square) {
    let half = (square.half_side * side as f32).floor();
    let [columns, rows] = square.middle.to_array().map(|middle| {
        let middle = middle * side as f32;
        // Casts saturate at zero.
        (middle - half).round() as usize..((middle + half).round() as usize).min(side)
    });
    for row in rows {
        if let Some(pixels) = image[row * side..][..side].get_mut(columns.clone()) {
            pixels.fill(f32::from(square.grey));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contrast_keeps_the_mean_and_brightness_moves_it() {
        let image = [100.0, 120.0, 140.0, 160.0];
        let relit = |contrast, brightness| {
            let mut image = image;
            relight(&mut image, contrast, brightness);
            image
        };
        assert_eq!(relit(0.5, 0.0), [115.0, 125.0, 135.0, 145.0]);
        assert_eq!(relit(1.0, 0.2), image.map(|grey| grey + 51.0));
        assert_eq!(relit(16.0, 0.0), [0.0, 0.0, 255.0, 255.0]);
        assert_eq!(relit(1.0, -1.0), [0.0; 4]);
        relight(&mut [], 1.0, 0.0);
    }

    #[test]
    fn noise_is_uniform_and_stays_within_grey() {
        let n = 40_001;
        let mut image = vec![100.0; n];
        add_noise(&mut image, &mut CounterRng::new(3, "noise", 0), 5.0);
        let moments = image.iter().fold([0.0; 2], |[a, b], &grey| {
            let change = f64::from(grey) - 100.0;
            assert!(change.abs() <= 5.0);
            [a + change / n as f64, b + change * change / n as f64]
        });
        // Four standard errors.
        assert!(moments[0].abs() < 4.0 * 5.0 / (3.0 * n as f64).sqrt(), "{moments:?}");
        assert!((moments[1] - 25.0 / 3.0).abs() < 0.2, "{moments:?}");
        let mut black = vec![0.0; 64];
        add_noise(&mut black, &mut CounterRng::new(3, "noise", 1), 5.0);
        assert!(black.iter().all(|&grey| (0.0..=5.0).contains(&grey)));
        assert!(black.contains(&0.0) && black.iter().any(|&grey| grey > 2.0));
    }

    #[test]
    fn a_square_hides_what_is_about_its_middle() {
        let filled = |x: f32, y: f32| -> Vec<usize> {
            let mut image = vec![0.0; 100];
            blank(&mut image, 10, &Square { middle: Vec2::new(x, y), half_side: 0.25, grey: 7 });
            (0..100).filter(|&i| image[i] == 7.0).collect()
        };
        assert_eq!(
            filled(0.3, 0.8),
            [61, 62, 63, 64, 71, 72, 73, 74, 81, 82, 83, 84, 91, 92, 93, 94]
        );
        assert_eq!(filled(0.0, 1.0), [80, 81, 90, 91]);
        assert_eq!(filled(-3.0, 0.5), [0usize; 0]);
        assert_eq!(filled(9.0, 9.0), [0usize; 0]);
    }
}
