//! A part of a frame in the size of the event camera.
//!
//! # Model
//! A pixel is the mean of the light that falls on it: of all pixels of the part that it covers,
//! each weighted by how much of it is covered. Equal to OpenCV's `INTER_AREA` where the part is the
//! larger one.

use evpose_core::Plane;
use glam::IVec2;

use super::{Crop, SENSOR};

/// Resizes a part of frames of one size.
#[derive(Debug, Clone)]
pub(super) struct Resizer {
    columns: Vec<Share>,
    rows: Vec<Share>,
    /// A row of the result before it is complete.
    row: Vec<f32>,
}

/// Pixels of a line that a pixel covers, and the weight of each.
#[derive(Debug, Clone)]
struct Share {
    first: usize,
    weights: Vec<f32>,
}

impl Resizer {
    /// Of frames of `frame_px` columns and rows, in which `crop` must lie.
    pub(super) fn new(crop: &Crop, frame_px: IVec2) -> Self {
        assert!(crop.is_inside(frame_px));
        let size = crop.size(frame_px);
        // All frames of a clip have one crop: weights are computed once.
        Self {
            columns: shares(crop.left as usize, size.x as usize, SENSOR.width.into()),
            rows: shares(crop.top as usize, size.y as usize, SENSOR.height.into()),
            row: vec![0.0; SENSOR.width.into()],
        }
    }

    pub(super) fn resize(&mut self, frame: &Plane<f32>, out: &mut Plane<f32>) {
        for (y, share) in self.rows.iter().enumerate() {
            self.row.fill(0.0);
            for (row, weight) in share.weights.iter().enumerate() {
                let row = frame.row(share.first + row);
                for (sum, share) in self.row.iter_mut().zip(&self.columns) {
                    let pixels = row[share.first..].iter().zip(&share.weights);
                    *sum += weight * pixels.map(|(pixel, weight)| pixel * weight).sum::<f32>();
                }
            }
            out.row_mut(y).copy_from_slice(&self.row);
        }
    }
}

/// Weights that average `from` pixels, the first of them `begin`, to `to` pixels: one list for each of
/// these.
fn shares(begin: usize, from: usize, to: usize) -> Vec<Share> {
    let scale = from as f64 / to as f64;
    let share = |pixel: usize| {
        // Rounding may carry the last bound beyond the last pixel.
        let (low, high) = (pixel as f64 * scale, ((pixel + 1) as f64 * scale).min(from as f64));
        let (first, last) = (low.floor() as usize, (high.ceil() as usize).min(from));
        let covered = |k: usize| high.min((k + 1) as f64) - low.max(k as f64);
        let weights = (first..last).map(|k| (covered(k) / (high - low)) as f32).collect();
        Share { first: begin + first, weights }
    };
    (0..to).map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_a_line_are_where_it_is_covered() {
        let found = shares(10, 5, 2);
        assert_eq!((found[0].first, found[1].first), (10, 12));
        assert_eq!(found[0].weights, [0.4, 0.4, 0.2]);
        assert_eq!(found[1].weights, [0.2, 0.4, 0.4]);
        assert!(
            shares(3, 7, 7)
                .iter()
                .enumerate()
                .all(|(k, share)| { share.first == 3 + k && share.weights == [1.0] })
        );
    }

    #[test]
    fn each_pixel_of_the_part_counts_once_and_no_other_does() {
        let frame_px = IVec2::new(1000, 900);
        let crop = Crop { left: 100, right: 83, top: 7, bottom: 200 };
        let mut frame = Plane::filled(1000, 900, 0.0_f32);
        let size = crop.size(frame_px);
        for y in 7..700 {
            frame.row_mut(y)[100..917]
                .iter_mut()
                .enumerate()
                .for_each(|(x, v)| *v = (x % 7) as f32);
        }
        let mut out = Plane::for_sensor(SENSOR, 0.0);
        Resizer::new(&crop, frame_px).resize(&frame, &mut out);
        let mean = |plane: &Plane<f32>, count: f64| {
            plane.data().iter().map(|&v| f64::from(v)).sum::<f64>() / count
        };
        let part = f64::from(size.x * size.y);
        assert!((mean(&out, 307_200.0) - mean(&frame, part)).abs() < 1e-5);
        // Neighbours of the part, bright as they may be, are not seen.
        let before = out.clone();
        frame.row_mut(6).fill(1e6);
        frame.row_mut(700).fill(1e6);
        for y in 0..900 {
            frame.row_mut(y)[99] = 1e6;
            frame.row_mut(y)[917] = 1e6;
        }
        Resizer::new(&crop, frame_px).resize(&frame, &mut out);
        assert_eq!(out, before);
    }
}
