//! The image of a recording as the network's input.

use evpose_core::Plane;
use glam::{DAffine2, DVec2, Vec2};

use super::config::BaselineImageConfig;
use crate::body::{Interpolation, sample};

/// An image that is larger than the input by this many pixels is cropped, not scaled: DHP19's
/// network of 344 columns leaves out the last 2 of its cameras' 346.
const CUT_PX: usize = 4;

/// From images of a recording to the network's input.
///
/// # Model
/// An image that is at most 4 columns and rows larger than the input is cut at the right and at the
/// bottom, as published; any other is scaled to the input, each side by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaselineInput {
    size_px: [usize; 2],
    interpolation: Interpolation,
}

impl BaselineInput {
    /// The input of a config.
    pub fn new(image: &BaselineImageConfig) -> Self {
        Self { size_px: [image.width_px, image.height_px], interpolation: image.interpolation }
    }

    /// Columns and rows.
    pub fn size_px(&self) -> [usize; 2] {
        self.size_px
    }

    /// Values of an input: columns times rows.
    pub fn pixels(&self) -> usize {
        self.size_px[0] * self.size_px[1]
    }

    /// The part of an image that is in the input, relative to the image.
    pub fn shown(&self, image_px: [usize; 2]) -> Vec2 {
        let [width, height] = self.size_px;
        // Both sides must fit, for to cut one and to scale the other would change proportions.
        let beyond = |image: usize, input: usize| image.checked_sub(input).filter(|b| *b <= CUT_PX);
        match (beyond(image_px[0], width), beyond(image_px[1], height)) {
            (Some(_), Some(_)) => {
                Vec2::new(width as f32 / image_px[0] as f32, height as f32 / image_px[1] as f32)
            }
            _ => Vec2::ONE,
        }
    }

    /// Writes the input of an image, row by row, 0 to 255.
    ///
    /// # Panics
    /// If `out` is not of [`Self::pixels`].
    pub fn fill(&self, image: &Plane<u8>, out: &mut [f32]) {
        let shown = self.shown([image.width(), image.height()]);
        let scale = DVec2::new(f64::from(shown.x), f64::from(shown.y));
        let map = DAffine2::from_scale_angle_translation(scale, 0.0, DVec2::ZERO);
        sample(image, map, self.interpolation, self.size_px, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(width_px: usize, height_px: usize) -> BaselineInput {
        BaselineInput::new(&BaselineImageConfig {
            width_px,
            height_px,
            ..BaselineImageConfig::default()
        })
    }

    fn image(width: usize, height: usize) -> Plane<u8> {
        let mut image = Plane::filled(width, height, 0);
        image.data_mut().iter_mut().enumerate().for_each(|(k, grey)| *grey = (k % 251) as u8);
        image
    }

    #[test]
    fn the_last_columns_of_a_camera_of_dhp19_are_cut_off() {
        let (image, input) = (image(346, 260), input(344, 260));
        let mut out = vec![0.0; input.pixels()];
        input.fill(&image, &mut out);
        for (out, row) in out.chunks(344).zip(image.data().chunks(346)) {
            assert!(out.iter().zip(row).all(|(a, &b)| (a - f32::from(b)).abs() < 1e-3));
        }
    }

    #[test]
    fn other_images_are_scaled() {
        let input = input(160, 120);
        assert_eq!(input.shown([320, 240]), Vec2::ONE);
        let mut out = vec![0.0; input.pixels()];
        input.fill(&Plane::filled(320, 240, 9), &mut out);
        assert!(out.iter().all(|grey| (grey - 9.0).abs() < 1e-3));
    }
}
