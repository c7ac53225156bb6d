//! Colour images to grey ones.
//!
//! # Model
//! `(9798 R + 19235 G + 3735 B + 2¹⁴) / 2¹⁵`, rounded down: ITU-R BT.601's 0.299, 0.587 and 0.114
//! in 15 bits, as OpenCV has them since version 4 for images of 8 bits.

use evpose_cpu::vectorize;

const RED: u32 = 9798;
const GREEN: u32 = 19235;
const BLUE: u32 = 3735;
const SHIFT: u32 = 15;

/// Order of three interleaved channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColourOrder {
    /// Red, green, blue: most image files and libraries.
    Rgb,
    /// Blue, green, red: OpenCV.
    Bgr,
}

/// Grey of 8-bit pixels of three interleaved channels.
///
/// # Panics
/// If `pixels` is not three times as long as `grey`.
pub fn grey_from_colour(pixels: &[u8], order: ColourOrder, grey: &mut [u8]) {
    let (pixels, rest) = pixels.as_chunks::<3>();
    assert!(rest.is_empty() && pixels.len() == grey.len(), "three channels for each grey pixel");
    let weights = match order {
        ColourOrder::Rgb => [RED, GREEN, BLUE],
        ColourOrder::Bgr => [BLUE, GREEN, RED],
    };
    vectorize(
        #[inline(always)]
        || weigh(pixels, weights, grey),
    );
}

#[inline(always)]
fn weigh(pixels: &[[u8; 3]], weights: [u32; 3], grey: &mut [u8]) {
    for (grey, pixel) in grey.iter_mut().zip(pixels) {
        let sum: u32 = (0..3).map(|c| u32::from(pixel[c]) * weights[c]).sum();
        // The weights add up to 2¹⁵, so this is at most 255.
        *grey = ((sum + (1 << (SHIFT - 1))) >> SHIFT) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_channels_are_their_own_grey() {
        for value in 0..=255 {
            let mut grey = [0];
            grey_from_colour(&[value; 3], ColourOrder::Rgb, &mut grey);
            assert_eq!(grey, [value]);
        }
    }

    #[test]
    fn the_order_says_where_red_is() {
        let (mut rgb, mut bgr) = ([0; 2], [0; 2]);
        grey_from_colour(&[255, 0, 0, 0, 0, 255], ColourOrder::Rgb, &mut rgb);
        grey_from_colour(&[255, 0, 0, 0, 0, 255], ColourOrder::Bgr, &mut bgr);
        // 0.299 · 255 and 0.114 · 255.
        assert_eq!((rgb, bgr), ([76, 29], [29, 76]));
    }
}
