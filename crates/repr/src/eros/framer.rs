//! The image that the online program sends to its network: an EROS in 8 bits, blurred, resized.
//!
//! # Model
//! 1. Values rounded to 8 bits, halves to even.
//! 2. Gaussian blur over 5x5 pixels, `[1, 4, 6, 4, 1]/16` along rows and columns, in exact integers,
//!    rounded once, halves up. Borders reflect without repeating the edge: `dcb|abcd|cba`.
//! 3. Bilinear resizing; pixel `i` of `m` lies at `(i + 1/2)·n/m - 1/2` of `n`. Weights have 11 bits and
//!    what is summed loses bits on the way, as in OpenCV; borders repeat the edge.
//!
//! Equal to OpenCV's `convertTo`, `GaussianBlur` and `resize` (linear), bit for bit.
//!
//! # Source
//! hpe-core, `eros-framer` and `movenet_online`; the arithmetic is that of OpenCV's `smooth` and
//! `resize` for 8-bit images.

use std::array::from_fn;

use evpose_core::{Plane, SensorSize};
use evpose_cpu::vectorize;

use crate::{BlurWork, Eros, GaussianKernel};

/// Makes the images of a running EROS; holds memory for one.
#[derive(Debug, Clone)]
pub struct ErosFramer {
    sensor: SensorSize,
    columns: Vec<Tap>,
    rows: Vec<Tap>,
    /// The values in 8 bits.
    grey: Plane<u8>,
    blurs: BlurWork,
    blurred: Plane<u8>,
    /// Two blurred rows, resized along themselves, in 1/2048.
    resized: [(Option<usize>, Vec<i32>); 2],
}

/// Bilinear interpolation coefficients of a resized row or column: source pixel and weights.
#[derive(Debug, Clone, Copy)]
struct Tap {
    first: usize,
    second: usize,
    weights: [i32; 2],
}

const WEIGHT_ONE: f32 = 2048.0;

impl ErosFramer {
    /// Images of `sensor`, resized to `width` times `height`.
    pub fn new(sensor: SensorSize, width: usize, height: usize) -> Self {
        let (from_width, from_height) = (usize::from(sensor.width), usize::from(sensor.height));
        Self {
            sensor,
            columns: taps(from_width, width),
            rows: taps(from_height, height),
            grey: Plane::for_sensor(sensor, 0),
            blurs: BlurWork::default(),
            blurred: Plane::for_sensor(sensor, 0),
            resized: from_fn(|_| (None, vec![0; width])),
        }
    }

    /// Writes the blurred EROS in the sensor's size.
    ///
    /// # Panics
    /// If the EROS or `out` has another size.
    pub fn blurred(&mut self, eros: &Eros, out: &mut [u8]) {
        assert_eq!(out.len(), self.sensor.pixels(), "an image of another size");
        self.blur(eros);
        out.copy_from_slice(self.blurred.data());
    }

    /// Writes the blurred EROS, resized.
    ///
    /// # Panics
    /// If the EROS or `out` has another size.
    pub fn resized(&mut self, eros: &Eros, out: &mut [u8]) {
        let (width, height) = (self.columns.len(), self.rows.len());
        assert_eq!(out.len(), width * height, "an image of another size");
        self.blur(eros);
        // Rows of the image before are of no use.
        for (y, _) in &mut self.resized {
            *y = None;
        }
        for (tap, out) in self.rows.iter().zip(out.chunks_exact_mut(width.max(1))) {
            // Each row that is looked at is resized once.
            if self.resized[0].0 != Some(tap.first) {
                self.resized.swap(0, 1);
            }
            for (y, slot) in [tap.first, tap.second].into_iter().zip(&mut self.resized) {
                if slot.0 != Some(y) {
                    resize_row(self.blurred.row(y), &self.columns, &mut slot.1);
                    slot.0 = Some(y);
                }
            }
            let [(_, first), (_, second)] = &self.resized;
            mix_rows(first, second, tap.weights, out);
        }
    }

    fn blur(&mut self, eros: &Eros) {
        let since = &eros.since;
        assert_eq!(since.sensor(), self.sensor, "an EROS of another size");
        let width = usize::from(self.sensor.width).max(1);
        for (out, since) in self.grey.data_mut().chunks_exact_mut(width).zip(since.rows()) {
            eros.row_u8(since, out);
        }
        GaussianKernel::Five.blur(&self.grey, &mut self.blurs, &mut self.blurred);
    }
}

/// Interpolation coefficients of a line of `from` pixels resized to `to`.
fn taps(from: usize, to: usize) -> Vec<Tap> {
    // By way of the inverse, as there: its rounding shows in the weights.
    let scale = 1.0 / (to as f64 / from as f64);
    let last = from.saturating_sub(1);
    let tap = |i: usize| {
        let at = ((i as f64 + 0.5) * scale - 0.5) as f32;
        let rest = at - at.floor();
        let before = at.floor() as isize;
        // The same pixel twice beyond the edge, truncated twice.
        let [first, second] = [before, before + 1].map(|k| k.clamp(0, last as isize) as usize);
        let weights = [1.0 - rest, rest].map(|w| (w * WEIGHT_ONE).round_ties_even() as i32);
        Tap { first, second, weights }
    };
    (0..to).map(tap).collect()
}

fn resize_row(row: &[u8], columns: &[Tap], out: &mut [i32]) {
    for (out, tap) in out.iter_mut().zip(columns) {
        let [first, second] = [row[tap.first], row[tap.second]].map(i32::from);
        *out = first * tap.weights[0] + second * tap.weights[1];
    }
}

/// The sum of two rows, weighted, with the truncations of OpenCV's fixed point.
fn mix_rows(first: &[i32], second: &[i32], weights: [i32; 2], out: &mut [u8]) {
    vectorize(
        #[inline(always)]
        move || {
            for ((out, &a), &b) in out.iter_mut().zip(first).zip(second) {
                // OpenCV's own fixed-point steps, whose roundings the published images have.
                let sum = ((weights[0] * (a >> 4)) >> 16) + ((weights[1] * (b >> 4)) >> 16);
                *out = ((sum + 2) >> 2) as u8;
            }
        },
    );
}
