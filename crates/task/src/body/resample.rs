//! One sampling of an image along an affine map.

use std::f64::consts::{FRAC_PI_4, PI};

use evpose_core::Plane;
use glam::{DAffine2, DVec2};
use serde::{Deserialize, Serialize};

const WHITE: f32 = 255.0;
/// The slope of the cubic, as in OpenCV.
const CUBIC: f64 = -0.75;

/// How the grey between pixels is made. A pixel is a square; its grey is that of its middle.
///
/// All but `Area` look at as many pixels of the image no matter how many fall into one of the
/// result: of images that become much smaller they see some edges and miss others, as the programs
/// do that run published networks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// The pixel that is there: OpenCV's `INTER_NEAREST_EXACT`.
    Nearest,
    /// Between two pixels along either side.
    Linear,
    /// The mean over what falls into a pixel of the result. Of rotated images, over an upright
    /// rectangle of that size.
    Area,
    /// A cubic through four pixels along either side, of slope -3/4.
    Cubic,
    /// Eight pixels along either side, weighted by Lanczos' kernel.
    Lanczos4,
}

impl Interpolation {
    /// All of them: those among which the published training draws.
    pub const ALL: [Self; 5] =
        [Self::Nearest, Self::Linear, Self::Area, Self::Cubic, Self::Lanczos4];

    /// Writes the weights of consecutive pixels of a line of `n`, the first of which is returned.
    /// `at` and `width` are where a pixel of the result lies and how wide it is there, in pixels
    /// from the line's start. Beyond its ends, the line goes on as it ends as long as `at` is on
    /// it, otherwise there is nothing.
    fn weights(self, at: f64, width: f64, n: usize, weights: &mut Vec<f32>) -> usize {
        weights.clear();
        let before = (at - 0.5).floor();
        let rest = at - 0.5 - before;
        let before = before as isize;
        match self {
            // From beyond the line's ends an area may reach into it; the others ask for its middle alone.
            Self::Area => area(at - 0.5 * width, at + 0.5 * width, n, weights),
            _ if !(0.0..=n as f64).contains(&at) => 0,
            Self::Nearest => {
                weights.push(1.0);
                (at as usize).min(n - 1)
            }
            Self::Linear => clamped(before, [1.0 - rest, rest], n, weights),
            Self::Cubic => clamped(before - 1, cubic(rest), n, weights),
            Self::Lanczos4 => clamped(before - 3, lanczos4(rest), n, weights),
        }
    }
}

/// An image in another size.
///
/// # Panics
/// If `out` is not of `width` times `height`.
pub fn resize_grey(
    image: &Plane<u8>,
    interpolation: Interpolation,
    [width, height]: [usize; 2],
    out: &mut [f32],
) {
    sample(image, DAffine2::IDENTITY, interpolation, [width, height], out);
}

/// Writes `height` rows of `width` greys, 0 to 255, black where the map leads out of the image. It
/// leads from the result to the image, both from 0 to 1 along either side.
///
/// # Panics
/// If `out` is of another size.
pub fn sample(
    image: &Plane<u8>,
    image_from_out: DAffine2,
    interpolation: Interpolation,
    [width, height]: [usize; 2],
    out: &mut [f32],
) {
    assert_eq!(out.len(), width * height, "an image of another size");
    if out.is_empty() || image.data().is_empty() {
        out.fill(0.0);
        return;
    }
    let pixels = DVec2::new(image.width() as f64, image.height() as f64);
    let cells = DVec2::new(width as f64, height as f64);
    // From pixels of the result to pixels of the image.
    let map = DAffine2::from_scale_angle_translation(pixels, 0.0, DVec2::ZERO)
        * image_from_out
        * DAffine2::from_scale_angle_translation(1.0 / cells, 0.0, DVec2::ZERO);
    if map.matrix2.x_axis.y == 0.0 && map.matrix2.y_axis.x == 0.0 {
        sample_upright(image, map, interpolation, width, out);
    } else {
        sample_turned(image, map, interpolation, width, out);
    }
    // Cubics and Lanczos' kernel overshoot beyond black and white.
    for grey in out {
        *grey = grey.clamp(0.0, WHITE);
    }
}

/// Weights of pixels of a line, for all pixels of a resampled one: of as many pixels for each.
struct Line {
    taps: usize,
    firsts: Vec<usize>,
    weights: Vec<f32>,
}

impl Line {
    fn new(interpolation: Interpolation, [scale, start]: [f64; 2], from: usize, to: usize) -> Self {
        let mut weights = Vec::new();
        let write = |i: usize, weights: &mut Vec<f32>| {
            let at = start + scale * (i as f64 + 0.5);
            interpolation.weights(at, scale.abs(), from, weights)
        };
        let mut taps = 1;
        // All pixels get as many taps as the widest one, so that weights need no lengths.
        for i in 0..to {
            write(i, &mut weights);
            taps = taps.max(weights.len());
        }
        let mut line = Self { taps, firsts: Vec::with_capacity(to), weights: vec![0.0; taps * to] };
        for (i, padded) in line.weights.chunks_exact_mut(taps).enumerate() {
            let first = write(i, &mut weights);
            // Weights that are not there are zeros, behind the others or, at the line's end, before
            // them.
            let shifted = first.min(from - taps);
            padded[first - shifted..][..weights.len()].copy_from_slice(&weights);
            line.firsts.push(shifted);
        }
        line
    }

    /// For each pixel of the result, the first pixel and the weights from there on.
    fn taps(&self) -> impl Iterator<Item = (usize, &[f32])> {
        self.firsts.iter().copied().zip(self.weights.chunks_exact(self.taps))
    }

    fn resample(&self, row: &[u8], out: &mut [f32]) {
        // These are the taps of the fixed kernels; a known count lets the compiler unroll.
        match self.taps {
            1 => self.resample_by::<1>(row, out),
            2 => self.resample_by::<2>(row, out),
            4 => self.resample_by::<4>(row, out),
            8 => self.resample_by::<8>(row, out),
            _ => {
                for ((first, weights), out) in self.taps().zip(out) {
                    *out = dot(weights, &row[first..]);
                }
            }
        }
    }

    /// The same with a number of taps that the compiler knows.
    fn resample_by<const TAPS: usize>(&self, row: &[u8], out: &mut [f32]) {
        let (weights, _) = self.weights.as_chunks::<TAPS>();
        for ((first, weights), out) in self.firsts.iter().zip(weights).zip(out) {
            *out = dot(weights, &row[*first..][..TAPS]);
        }
    }
}

/// Along rows, then along columns.
fn sample_upright(
    image: &Plane<u8>,
    map: DAffine2,
    interpolation: Interpolation,
    width: usize,
    out: &mut [f32],
) {
    let [x, y] = [0, 1].map(|axis| [map.matrix2.col(axis)[axis], map.translation[axis]]);
    let columns = Line::new(interpolation, x, image.width(), width);
    let rows = Line::new(interpolation, y, image.height(), out.len() / width);
    // Rows of the image, resampled when they are first looked at.
    let mut resampled = vec![0.0; width * image.height()];
    let mut is_resampled = vec![false; image.height()];
    for ((first, weights), out) in rows.taps().zip(out.chunks_exact_mut(width)) {
        out.fill(0.0);
        for (y, &weight) in (first..).zip(weights) {
            let row = &mut resampled[y * width..][..width];
            if !std::mem::replace(&mut is_resampled[y], true) {
                columns.resample(image.row(y), row);
            }
            for (out, value) in out.iter_mut().zip(row) {
                *out += weight * *value;
            }
        }
    }
}

/// Pixel by pixel.
fn sample_turned(
    image: &Plane<u8>,
    map: DAffine2,
    interpolation: Interpolation,
    width: usize,
    out: &mut [f32],
) {
    // How far one pixel of the result reaches along columns and rows of the image.
    let rows = map.matrix2.transpose();
    let reach = DVec2::new(rows.x_axis.length(), rows.y_axis.length());
    let (mut columns, mut lines) = (Vec::new(), Vec::new());
    for (y, out) in out.chunks_exact_mut(width).enumerate() {
        let start = map.transform_point2(DVec2::new(0.5, y as f64 + 0.5));
        for (x, out) in out.iter_mut().enumerate() {
            let at = start + map.matrix2.x_axis * x as f64;
            *out = if interpolation == Interpolation::Linear {
                linear(image, at)
            } else {
                let left = interpolation.weights(at.x, reach.x, image.width(), &mut columns);
                let top = interpolation.weights(at.y, reach.y, image.height(), &mut lines);
                let row = |y: usize| dot(&columns, &image.row(y)[left..]);
                (top..).zip(&lines).map(|(y, weight)| weight * row(y)).sum()
            };
        }
    }
}

/// [`Interpolation::Linear`] at one place, in pixels from the image's corner: the usual case,
/// without lists of weights.
fn linear(image: &Plane<u8>, at: DVec2) -> f32 {
    let last = [image.width() - 1, image.height() - 1];
    let size = DVec2::new(image.width() as f64, image.height() as f64);
    if !(at.cmpge(DVec2::ZERO).all() && at.cmple(size).all()) {
        return 0.0;
    }
    // Not below zero: casts cut there as the line's end does.
    let from = (at - 0.5).max(DVec2::ZERO);
    let [x, y] = [from.x as usize, from.y as usize];
    let [rest_x, rest_y] = [(from.x - x as f64) as f32, (from.y - y as f64) as f32];
    let right = (x + 1).min(last[0]);
    let along = |y: usize| {
        let row = image.row(y);
        let [a, b] = [row[x], row[right]].map(f32::from);
        a + (b - a) * rest_x
    };
    let (above, below) = (along(y), along((y + 1).min(last[1])));
    above + (below - above) * rest_y
}

fn dot(weights: &[f32], pixels: &[u8]) -> f32 {
    weights.iter().zip(pixels).map(|(weight, &pixel)| weight * f32::from(pixel)).sum()
}

/// Weights from pixel `first` on, those beyond the line's ends given to the last ones there.
fn clamped<const N: usize>(first: isize, all: [f64; N], n: usize, weights: &mut Vec<f32>) -> usize {
    let inside = |i: usize| (first + i as isize).clamp(0, n as isize - 1) as usize;
    weights.resize(inside(N - 1) - inside(0) + 1, 0.0);
    for (i, weight) in all.into_iter().enumerate() {
        weights[inside(i) - inside(0)] += weight as f32;
    }
    inside(0)
}

/// The share of each pixel in what lies between two places.
fn area(from: f64, to: f64, n: usize, weights: &mut Vec<f32>) -> usize {
    let [first, end] = [from.max(0.0).floor(), to.min(n as f64).ceil()];
    if first >= end {
        return 0;
    }
    // The divisor is the whole width, so that what lies beyond the line counts as black.
    let share = |i: usize| (to.min(i as f64 + 1.0) - from.max(i as f64)) / (to - from);
    weights.extend((first as usize..end as usize).map(|i| share(i) as f32));
    first as usize
}

/// Weights of four pixels at `rest` behind the second.
fn cubic(rest: f64) -> [f64; 4] {
    let near = |d: f64| ((CUBIC + 2.0) * d - (CUBIC + 3.0)) * d * d + 1.0;
    let far = |d: f64| ((d - 5.0) * d + 8.0) * d * CUBIC - 4.0 * CUBIC;
    [far(1.0 + rest), near(rest), near(1.0 - rest), far(2.0 - rest)]
}

/// Weights of eight pixels at `rest` behind the fourth.
fn lanczos4(rest: f64) -> [f64; 8] {
    let kernel = |d: f64| (PI * d).sin() * (FRAC_PI_4 * d).sin() / (d * d);
    // On a pixel, that alone counts; the formula is 0 by 0 there.
    if rest == 0.0 {
        return std::array::from_fn(|i| if i == 3 { 1.0 } else { 0.0 });
    }
    let weights: [f64; 8] = std::array::from_fn(|i| kernel(rest + 3.0 - i as f64));
    let sum: f64 = weights.iter().sum();
    // Weights of Lanczos do not add up to one, and a plain grey would get a pattern.
    weights.map(|weight| weight / sum)
}

#[cfg(test)]
mod tests;
