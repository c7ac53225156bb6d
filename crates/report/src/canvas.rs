//! Images with hands or bodies drawn over them.

use evpose_core::Plane;
use evpose_pose::HAND_BONES;
use evpose_pose::body::{BODY_JOINTS, BodyPoints, LIMBS};
use glam::Vec2;
use image::{Rgb, RgbImage};

use crate::dot_letters;

/// Colour of what is true.
pub const TRUTH: Rgb<u8> = Rgb([0x1a, 0x9e, 0x5c]);
/// Colour of what was predicted.
pub const PREDICTION: Rgb<u8> = Rgb([0xe8, 0x6a, 0x17]);

/// Colour of the hand predicted in the slow-motion mode.
pub const SLOW_MOTION: Rgb<u8> = Rgb([0x8b, 0x3f, 0xc6]);

/// Head and shoulders in the order of networks, between which the neck is drawn.
const HEAD: usize = 0;
const SHOULDERS: [usize; 2] = [1, 2];

const PAPER: [f32; 3] = [252.0, 252.0, 253.0];
const ON_INK: [f32; 3] = [30.0, 100.0, 200.0];
const OFF_INK: [f32; 3] = [200.0, 50.0, 60.0];

/// An event image, enlarged, on which skeletons can be drawn.
pub struct Canvas {
    image: RgbImage,
    scale: u32,
}

impl Canvas {
    /// Draws the two polarity planes of a representation with values in 0 to 1: ON blue, OFF red,
    /// newer events darker. Each pixel becomes `scale` by `scale`.
    pub fn events(on: &Plane<f32>, off: &Plane<f32>, scale: u32) -> Self {
        let (width, height) = (on.width() as u32 * scale, on.height() as u32 * scale);
        let image = RgbImage::from_fn(width, height, |x, y| {
            let at = ((x / scale) as usize, (y / scale) as usize);
            let (on, off) = (*on.at(at.0, at.1), *off.at(at.0, at.1));
            // The newer polarity is on top, as a person would see it.
            let (ink, strength) = if on >= off { (ON_INK, on) } else { (OFF_INK, off) };
            let strength = strength.clamp(0.0, 1.0).powf(1.5);
            Rgb(std::array::from_fn(|c| (PAPER[c] + (ink[c] - PAPER[c]) * strength) as u8))
        });
        Self { image, scale }
    }

    /// A grey image, each pixel `scale` by `scale`.
    pub fn grey(grey: &Plane<u8>, scale: u32) -> Self {
        let (width, height) = (grey.width() as u32 * scale, grey.height() as u32 * scale);
        let image = RgbImage::from_fn(width, height, |x, y| {
            Rgb([*grey.at((x / scale) as usize, (y / scale) as usize); 3])
        });
        Self { image, scale }
    }

    /// An image whose sensor's pixels are `scale` by `scale`.
    pub fn over(image: RgbImage, scale: u32) -> Self {
        Self { image, scale }
    }

    /// Draws joints, the limbs between them, and a neck from the head to the middle of the shoulders; what
    /// is not known is left out.
    pub fn body(&mut self, joints_px: &BodyPoints, colour: Rgb<u8>) {
        let radius = 0.55 * self.scale as f32;
        for [a, b] in LIMBS {
            if let (Some(a), Some(b)) = (joints_px[a], joints_px[b]) {
                self.line(a, b, radius, colour);
            }
        }
        if let [Some(head), Some(a), Some(b)] =
            [HEAD, SHOULDERS[0], SHOULDERS[1]].map(|k| joints_px[k])
        {
            self.line(head, 0.5 * (a + b), radius, colour);
        }
        // Last, since limbs would hide them.
        for joint in joints_px.iter().flatten() {
            self.line(*joint, *joint, 2.2 * radius, colour);
        }
    }

    /// Writes scores of joints beside them, with two decimals; none where the score or the joint is not
    /// known.
    pub fn scores(
        &mut self,
        joints_px: &BodyPoints,
        scores: &[Option<f32>; BODY_JOINTS],
        colour: Rgb<u8>,
    ) {
        for (joint_px, score) in joints_px.iter().zip(scores) {
            let (Some(joint_px), Some(score)) = (joint_px, score) else { continue };
            let at = *joint_px * self.scale as f32 + Vec2::new(4.0, -9.0);
            let at_px = (at.x.round() as i64, at.y.round() as i64);
            let text = format!("{score:.2}");
            // Paper around the letters, so that they can be read on events and limbs.
            let paper = Rgb(PAPER.map(|value| value as u8));
            for (x, y) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
                dot_letters::write(&mut self.image, &text, (at_px.0 + x, at_px.1 + y), 1, paper);
            }
            dot_letters::write(&mut self.image, &text, at_px, 1, colour);
        }
    }

    /// Draws the 21 evaluated points (pixels of the sensor, 0 at its top-left corner) as a hand.
    pub fn hand(&mut self, points_px: &[Vec2; 21], colour: Rgb<u8>) {
        self.hand_in_view(&points_px.map(Some), colour);
    }

    /// The same where not all points are in view.
    pub fn hand_in_view(&mut self, points_px: &[Option<Vec2>; 21], colour: Rgb<u8>) {
        let radius = 0.35 * self.scale as f32;
        for [a, b] in HAND_BONES {
            if let (Some(a), Some(b)) = (points_px[a], points_px[b]) {
                self.line(a, b, radius, colour);
            }
        }
        for &point in points_px.iter().flatten() {
            self.line(point, point, 1.6 * radius, colour);
        }
    }

    /// A stroke of round ends: every pixel is covered by as much as lies within `radius` of it.
    fn line(&mut self, from_px: Vec2, to_px: Vec2, radius: f32, colour: Rgb<u8>) {
        let (a, b) = (from_px * self.scale as f32, to_px * self.scale as f32);
        // A projection may be infinite.
        if !(a.is_finite() && b.is_finite()) {
            return;
        }
        let size = Vec2::new(self.image.width() as f32, self.image.height() as f32);
        // Only pixels that the stroke can reach.
        let low = (a.min(b) - radius - 1.0).clamp(Vec2::ZERO, size);
        let high = (a.max(b) + radius + 1.0).clamp(Vec2::ZERO, size);
        let along = b - a;
        for y in low.y as u32..high.y as u32 {
            for x in low.x as u32..high.x as u32 {
                let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - a;
                // Nearest place on the segment, which has no length if it is a dot.
                let s = (p.dot(along) / along.length_squared().max(1e-6)).clamp(0.0, 1.0);
                // Coverage falls from 1 to 0 over one pixel, so that edges are smooth.
                let cover = (radius + 0.5 - (p - along * s).length()).clamp(0.0, 1.0);
                let pixel = self.image.get_pixel_mut(x, y);
                for c in 0..3 {
                    let (old, new) = (f32::from(pixel[c]), f32::from(colour[c]));
                    pixel[c] = (old + (new - old) * cover) as u8;
                }
            }
        }
    }

    /// The finished image.
    pub fn into_image(self) -> RgbImage {
        self.image
    }
}

/// Images in rows of `columns`, with a thin gap, each in a cell as large as the largest.
pub fn contact_sheet(images: &[RgbImage], columns: usize) -> RgbImage {
    const GAP: u32 = 6;
    let largest = |side: fn(&RgbImage) -> u32| images.iter().map(side).max();
    let Some((width, height)) = largest(RgbImage::width).zip(largest(RgbImage::height)) else {
        // An image without pixels could not be written as PNG.
        return RgbImage::new(1, 1);
    };
    let rows = images.len().div_ceil(columns) as u32;
    let mut sheet = RgbImage::from_pixel(
        columns as u32 * (width + GAP) + GAP,
        rows * (height + GAP) + GAP,
        Rgb([228, 230, 235]),
    );
    for (i, image) in images.iter().enumerate() {
        let x = GAP + (i % columns) as u32 * (width + GAP);
        let y = GAP + (i / columns) as u32 * (height + GAP);
        image::imageops::replace(&mut sheet, image, i64::from(x), i64::from(y));
    }
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_has_a_neck_and_scores_where_both_are_known() {
        let mut joints_px = BodyPoints::default();
        joints_px[HEAD] = Some(Vec2::new(20.5, 5.5));
        joints_px[1] = Some(Vec2::new(30.5, 25.5));
        joints_px[2] = Some(Vec2::new(10.5, 25.5));
        let blank = || Canvas::over(RgbImage::from_pixel(80, 40, Rgb([255; 3])), 1);
        let mut canvas = blank();
        canvas.body(&joints_px, TRUTH);
        let image = canvas.into_image();
        assert_ne!(*image.get_pixel(20, 15), Rgb([255; 3]), "no neck");
        assert_eq!(*image.get_pixel(50, 15), Rgb([255; 3]));
        let mut scores = [None; BODY_JOINTS];
        scores[1] = Some(0.82);
        // Of a joint that is not known.
        scores[5] = Some(0.3);
        let mut canvas = blank();
        canvas.scores(&joints_px, &scores, PREDICTION);
        let image = canvas.into_image();
        let drawn: Vec<u32> =
            image.enumerate_pixels().filter(|(.., p)| **p == PREDICTION).map(|(x, ..)| x).collect();
        assert!(drawn.len() > 20 && drawn.iter().all(|x| (34..58).contains(x)), "{drawn:?}");
    }
}
