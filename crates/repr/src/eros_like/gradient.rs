//! Gradients of 8-bit images with Sobel's operators.
//!
//! # Model
//! Along one axis the derivative `[-1 0 1]`, `[-1 -2 0 2 1]` or `[-1 -4 -5 0 5 4 1]`, along the
//! other the binomial smoothing of the same length. Seven taps are divided by 16, rounded half to
//! even, so that they fit 16 bits. Outside, the border pixel goes on.
//!
//! # Source
//! OpenCV's `Sobel` as its `Canny` calls it.

use evpose_core::Plane;
use evpose_cpu::vectorize;
use serde::{Deserialize, Serialize};

use super::ring::{Around, Ring};

/// FilterTaps of the derivative along each axis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Aperture {
    /// 3x3 pixels.
    Three,
    /// 5x5 pixels.
    #[default]
    Five,
    /// 7x7 pixels, a sixteenth of their sum.
    Seven,
}

/// Norm of a gradient.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GradientNorm {
    /// `|gx| + |gy|`.
    #[default]
    L1,
    /// `√(gx² + gy²)`.
    L2,
}

/// Weights at distances 0, 1, …
#[derive(Debug, Clone, Copy)]
pub(super) struct FilterTaps<const HALF: usize> {
    smooth: [i16; HALF],
    derive: [i16; HALF],
}

pub(super) const THREE: FilterTaps<2> = FilterTaps { smooth: [2, 1], derive: [0, 1] };
pub(super) const FIVE: FilterTaps<3> = FilterTaps { smooth: [6, 4, 1], derive: [0, 2, 1] };
pub(super) const SEVEN: FilterTaps<4> = FilterTaps { smooth: [20, 15, 6, 1], derive: [0, 5, 4, 1] };

/// Strength of gradients: `i16` for the sum of magnitudes, `i32` for the sum of squares.
pub(super) trait Strength: Copy + Default + Ord {
    /// Of a gradient with components of up to 12240.
    fn from_gradient(gx: i16, gy: i16) -> Self;
    /// The next larger one.
    fn next(self) -> Self;
    /// The strength up to which gradients are below `threshold`, which counts `scale` times theirs.
    fn threshold(threshold: u16, scale: u16) -> Self;
}

impl Strength for i16 {
    #[inline(always)]
    fn from_gradient(gx: i16, gy: i16) -> Self {
        gx.abs() + gy.abs()
    }

    #[inline(always)]
    fn next(self) -> Self {
        self + 1
    }

    fn threshold(threshold: u16, scale: u16) -> Self {
        // All gradients are below 2¹⁵.
        (threshold / scale).min(Self::MAX as u16) as Self
    }
}

impl Strength for i32 {
    #[inline(always)]
    fn from_gradient(gx: i16, gy: i16) -> Self {
        Self::from(gx) * Self::from(gx) + Self::from(gy) * Self::from(gy)
    }

    #[inline(always)]
    fn next(self) -> Self {
        self + 1
    }

    fn threshold(threshold: u16, scale: u16) -> Self {
        let (threshold, scale) = (u32::from(threshold), u32::from(scale));
        // OpenCV limits it to 32767 before squaring.
        let limited = threshold.min(scale * i16::MAX as u32);
        (limited * limited / (scale * scale)) as Self
    }
}

/// Along which of its neighbours a gradient points, in sectors of 45 degrees.
pub(super) mod sector {
    /// Left and right.
    pub(in super::super) const LEVEL: u8 = 0;
    /// Up and down.
    pub(in super::super) const UPRIGHT: u8 = 1;
    /// To the upper left and the lower right.
    pub(in super::super) const FALLING: u8 = 2;
    /// To the upper right and the lower left.
    pub(in super::super) const RISING: u8 = 3;
}

/// tan 22.5° · 2¹⁵ as OpenCV rounds it.
const TAN_22_5: u32 = 13573;

/// OpenCV compares `|gy| · 2¹⁵` with `|gx| · 13573` and with `|gx| · (13573 + 2¹⁶)`. As 13573 is
/// odd and `|gx|` below 2¹⁵, neither product is a multiple of 2¹⁵ unless `|gx|` is 0, so
/// comparisons with what is left of them after the division are the same, in 16 bits.
#[inline(always)]
fn sector_of(gx: i16, gy: i16) -> u8 {
    let (x, y) = (gx.unsigned_abs(), gy.unsigned_abs());
    let level = ((u32::from(2 * x) * TAN_22_5) >> 16) as u16;
    let slanted = if (gx ^ gy) < 0 { sector::RISING } else { sector::FALLING };
    let steep = if y > level + 2 * x { sector::UPRIGHT } else { slanted };
    if y <= level { sector::LEVEL } else { steep }
}

/// Memory of a gradient, to be used again.
#[derive(Debug, Clone, Default)]
pub(super) struct GradientWork {
    /// A row and the border pixels that go on.
    padded: Vec<i16>,
    /// Rows smoothed along themselves.
    smooth: Ring<i16>,
    /// Rows differentiated along themselves.
    derived: Ring<i16>,
    /// Rows of the image that have been read.
    known: usize,
}

impl GradientWork {
    /// Prepares for an image of at most this width: whole vectors leave loops no end of their own.
    pub(super) fn start<const HALF: usize>(&mut self, width: usize) {
        let reach = HALF - 1;
        self.padded.resize(width + 2 * reach, 0);
        self.smooth.reset(2 * reach + 1, width);
        self.derived.reset(2 * reach + 1, width);
        self.known = 0;
    }

    /// Strength and sector of the gradients of row `y`; rows are asked for from the top. Behind the
    /// last pixel, they mean nothing.
    pub(super) fn row<S: Strength, const HALF: usize>(
        &mut self,
        taps: FilterTaps<HALF>,
        image: &Plane<u8>,
        y: usize,
        strength: &mut [S],
        sectors: &mut [u8],
    ) {
        let reach = HALF - 1;
        let height = image.height();
        // Each row is filtered along once and used by all rows that it is near to.
        while self.known < height.min(y + reach + 1) {
            let (row, padded) = (image.row(self.known), &mut self.padded);
            let smooth = self.smooth.row_mut(self.known);
            let derived = self.derived.row_mut(self.known);
            vectorize(
                #[inline(always)]
                || {
                    extend(row, reach, padded);
                    split(taps, Around::along(padded), smooth, derived);
                },
            );
            self.known += 1;
        }
        let inside = |y: isize| y.clamp(0, height as isize - 1) as usize;
        let smooth = Around::across(&self.smooth, y, inside);
        let derived = Around::across(&self.derived, y, inside);
        vectorize(
            #[inline(always)]
            || join(taps, smooth, derived, strength, sectors),
        );
    }
}

#[inline(always)]
fn extend(row: &[u8], reach: usize, padded: &mut [i16]) {
    let (first, last) = (i16::from(row[0]), i16::from(row[row.len() - 1]));
    padded[..reach].fill(first);
    for (wide, value) in padded[reach..].iter_mut().zip(row) {
        *wide = i16::from(*value);
    }
    padded[reach + row.len()..].fill(last);
}

/// At most 64 · 255: a row fits 16 bits for any taps.
#[inline(always)]
fn split<const HALF: usize>(
    taps: FilterTaps<HALF>,
    around: Around<'_, i16, HALF>,
    smooth: &mut [i16],
    derived: &mut [i16],
) {
    let around = around.cut(smooth.len());
    let derived = &mut derived[..smooth.len()];
    for x in 0..smooth.len() {
        let mut sum = taps.smooth[0] * around.behind[0][x];
        let mut difference = 0;
        for k in 1..HALF {
            let (before, behind) = (around.before[k][x], around.behind[k][x]);
            sum += taps.smooth[k] * (before + behind);
            difference += taps.derive[k] * (behind - before);
        }
        smooth[x] = sum;
        derived[x] = difference;
    }
}

#[inline(always)]
fn join<S: Strength, const HALF: usize>(
    taps: FilterTaps<HALF>,
    smooth: Around<'_, i16, HALF>,
    derived: Around<'_, i16, HALF>,
    strength: &mut [S],
    sectors: &mut [u8],
) {
    let width = strength.len();
    let (smooth, derived) = (smooth.cut(width), derived.cut(width));
    let sectors = &mut sectors[..width];
    for x in 0..width {
        // Gradients of seven taps exceed 16 bits; wider lanes hold half as many values, which the
        // others.
        let (gx, gy) = if HALF < 4 {
            let (mut gx, mut gy) = (taps.smooth[0] * derived.behind[0][x], 0);
            for k in 1..HALF {
                gx += taps.smooth[k] * (derived.before[k][x] + derived.behind[k][x]);
                gy += taps.derive[k] * (smooth.behind[k][x] - smooth.before[k][x]);
            }
            (gx, gy)
        } else {
            let wide = i32::from;
            let (mut gx, mut gy) = (wide(taps.smooth[0]) * wide(derived.behind[0][x]), 0);
            for k in 1..HALF {
                let sum = derived.before[k][x] + derived.behind[k][x];
                gx += wide(taps.smooth[k]) * wide(sum);
                gy += wide(taps.derive[k]) * wide(smooth.behind[k][x] - smooth.before[k][x]);
            }
            (sixteenth(gx), sixteenth(gy))
        };
        strength[x] = S::from_gradient(gx, gy);
        sectors[x] = sector_of(gx, gy);
    }
}

/// Rounded half to even; sums of seven taps are below 2¹⁸.
#[inline(always)]
fn sixteenth(sum: i32) -> i16 {
    ((sum + 7 + ((sum >> 4) & 1)) >> 4) as i16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sectors_are_those_of_products_of_32_bits() {
        // Every magnitude along x, and along y all around both limits.
        for x in 0..=12240i32 {
            let limits = [(x * 13573) >> 15, (x * (13573 + 65536)) >> 15, 0, 6000];
            for y in limits.into_iter().flat_map(|limit| limit - 2..=limit + 2) {
                if !(0..=12240).contains(&y) || (x, y) == (0, 0) {
                    continue;
                }
                let expected = if (y << 15) < x * 13573 {
                    sector::LEVEL
                } else if i64::from(y) << 15 > i64::from(x) * (13573 + 65536) {
                    sector::UPRIGHT
                } else {
                    sector::FALLING
                };
                assert_eq!(sector_of(x as i16, y as i16), expected, "{x} {y}");
                let mirrored = if expected == sector::FALLING { sector::RISING } else { expected };
                assert_eq!(
                    sector_of(-x as i16, y as i16),
                    if x == 0 { expected } else { mirrored }
                );
            }
        }
    }

    #[test]
    fn a_sixteenth_is_rounded_half_to_even() {
        for sum in -200_000..200_000 {
            let rounded = (f64::from(sum) / 16.0).round_ties_even();
            assert_eq!(f64::from(sixteenth(sum)), rounded, "{sum}");
        }
    }
}
