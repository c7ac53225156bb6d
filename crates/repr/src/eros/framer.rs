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

use evpose_core::SensorSize;
use evpose_cpu::vectorize;

use crate::Eros;

/// Makes the images of a running EROS; holds memory for one.
#[derive(Debug, Clone)]
pub struct ErosFramer {
    sensor: SensorSize,
    columns: Vec<Tap>,
    rows: Vec<Tap>,
    /// The values in 8 bits, two columns wider at each side.
    grey: Vec<u8>,
    /// Blurred along columns, in sixteenths, two columns wider at each side.
    upright: Vec<u16>,
    /// Two blurred rows, resized along themselves, in 1/2048.
    resized: [(Option<usize>, Vec<i32>); 2],
    blurred: Vec<u8>,
}

/// Bilinear interpolation coefficients of a resized row or column: source pixel and weights.
#[derive(Debug, Clone, Copy)]
struct Tap {
    first: usize,
    second: usize,
    weights: [i32; 2],
}

/// Pixels that the blur reaches beyond its own.
const REACH: usize = 2;
const WEIGHT_ONE: f32 = 2048.0;

impl ErosFramer {
    /// Images of `sensor`, resized to `width` times `height`.
    pub fn new(sensor: SensorSize, width: usize, height: usize) -> Self {
        let (from_width, from_height) = (usize::from(sensor.width), usize::from(sensor.height));
        Self {
            sensor,
            columns: taps(from_width, width),
            rows: taps(from_height, height),
            grey: vec![0; from_height * from_width],
            upright: vec![0; from_width + 2 * REACH],
            resized: from_fn(|_| (None, vec![0; width])),
            blurred: vec![0; from_width],
        }
    }

    /// Writes the blurred EROS in the sensor's size.
    ///
    /// # Panics
    /// If the EROS or `out` has another size.
    pub fn blurred(&mut self, eros: &Eros, out: &mut [u8]) {
        assert_eq!(out.len(), self.sensor.pixels(), "an image of another size");
        self.convert(eros);
        for (y, out) in out.chunks_exact_mut(usize::from(self.sensor.width).max(1)).enumerate() {
            blur_row(&self.grey, y, &mut self.upright, out);
        }
    }

    /// Writes the blurred EROS, resized.
    ///
    /// # Panics
    /// If the EROS or `out` has another size.
    pub fn resized(&mut self, eros: &Eros, out: &mut [u8]) {
        let (width, height) = (self.columns.len(), self.rows.len());
        assert_eq!(out.len(), width * height, "an image of another size");
        self.convert(eros);
        // Rows of the image before are of no use.
        for (y, _) in &mut self.resized {
            *y = None;
        }
        for (tap, out) in self.rows.iter().zip(out.chunks_exact_mut(width.max(1))) {
            // Only rows that are looked at are blurred, and each of them once.
            if self.resized[0].0 != Some(tap.first) {
                self.resized.swap(0, 1);
            }
            for (y, slot) in [tap.first, tap.second].into_iter().zip(&mut self.resized) {
                if slot.0 != Some(y) {
                    blur_row(&self.grey, y, &mut self.upright, &mut self.blurred);
                    resize_row(&self.blurred, &self.columns, &mut slot.1);
                    slot.0 = Some(y);
                }
            }
            let [(_, first), (_, second)] = &self.resized;
            mix_rows(first, second, tap.weights, out);
        }
    }

    fn convert(&mut self, eros: &Eros) {
        let since = &eros.since;
        assert_eq!(since.sensor(), self.sensor, "an EROS of another size");
        let width = usize::from(self.sensor.width).max(1);
        for (out, since) in self.grey.chunks_exact_mut(width).zip(since.rows()) {
            eros.row_u8(since, out);
        }
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

/// The place of `i` on a line of `n` that is reflected at its ends.
fn reflected(i: isize, n: usize) -> usize {
    let (last, period) = (n as isize - 1, 2 * (n as isize - 1));
    if period == 0 {
        return 0;
    }
    let i = i.rem_euclid(period);
    (if i > last { period - i } else { i }) as usize
}

/// Row `y` of the blurred image.
fn blur_row(grey: &[u8], y: usize, upright: &mut [u16], out: &mut [u8]) {
    let width = out.len();
    let height = grey.len() / width;
    let [a, b, c, d, e] = from_fn(|k| {
        let y = reflected(y as isize + k as isize - REACH as isize, height);
        &grey[y * width..][..width]
    });
    let sums = &mut upright[REACH..][..width];
    vectorize(
        #[inline(always)]
        move || {
            for (i, sum) in sums.iter_mut().enumerate() {
                let [a, b, c, d, e] = [a[i], b[i], c[i], d[i], e[i]].map(u16::from);
                *sum = a + e + 4 * (b + d) + 6 * c;
            }
        },
    );
    // Edges are reflected, the last pixel not repeated, as OpenCV does.
    for k in 1..=REACH as isize {
        let (left, right) = (reflected(-k, width), reflected(width as isize - 1 + k, width));
        upright[REACH - k as usize] = upright[REACH + left];
        upright[REACH + width - 1 + k as usize] = upright[REACH + right];
    }
    let [a, b, c, d, e] = from_fn(|k| &upright[k..][..width]);
    vectorize(
        #[inline(always)]
        move || {
            for (i, out) in out.iter_mut().enumerate() {
                // At most 256 times 255 and a half: 16 bits hold it.
                let sum = a[i] + e[i] + 4 * (b[i] + d[i]) + 6 * c[i];
                // Half is added before the shift: rounded to the nearest.
                *out = ((sum + 128) >> 8) as u8;
            }
        },
    );
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
