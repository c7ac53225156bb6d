//! Gaussian blur of 8-bit images with OpenCV's small fixed kernels, those it takes for a standard
//! deviation of zero.
//!
//! # Model
//! `[1 4 6 4 1] / 16` or `[2 7 14 18 14 7 2] / 64` along rows and along columns, exact in integers,
//! rounded half up once at the end. Outside, the image goes on as its mirror image about the
//! centre of the border pixel, which is not repeated (`BORDER_REFLECT_101`).

use evpose_core::Plane;
use evpose_cpu::vectorize;
use serde::{Deserialize, Serialize};

use super::ring::{Around, Ring};

/// A blur.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GaussianKernel {
    /// 5x5 pixels.
    #[default]
    Five,
    /// 7x7 pixels.
    Seven,
}

/// Memory of a blur, to be used again.
#[derive(Debug, Clone, Default)]
pub struct BlurWork {
    /// A row with its mirror images.
    padded: Vec<u16>,
    /// Rows blurred along themselves.
    blurred: Ring<u16>,
}

impl GaussianKernel {
    /// Blurs `image` into `out`, which takes its size.
    pub fn blur(self, image: &Plane<u8>, work: &mut BlurWork, out: &mut Plane<u8>) {
        match self {
            Self::Five => blur([6, 4, 1], image, work, out),
            Self::Seven => blur([18, 14, 7, 2], image, work, out),
        }
    }
}

/// With `weights` at distances 0, 1, …
fn blur<const HALF: usize>(
    weights: [u16; HALF],
    image: &Plane<u8>,
    work: &mut BlurWork,
    out: &mut Plane<u8>,
) {
    let (width, height) = (image.width(), image.height());
    fit(out, width, height);
    if width == 0 || height == 0 {
        return;
    }
    let reach = HALF - 1;
    // Whole vectors; what lies behind the last pixel is not read again.
    let whole = width.next_multiple_of(64);
    work.padded.resize(whole + 2 * reach, 0);
    // As many rows as the kernel reaches over: others are never read again.
    work.blurred.reset(2 * reach + 1, whole);
    let mut known = 0;
    for y in 0..height {
        while known < height.min(y + reach + 1) {
            let (padded, row) = (&mut work.padded, work.blurred.row_mut(known));
            vectorize(
                #[inline(always)]
                || {
                    mirror(image.row(known), reach, padded);
                    blur_along(weights, Around::along(padded), row);
                },
            );
            known += 1;
        }
        let across = Around::across(&work.blurred, y, |y| mirrored(y, height));
        let row = out.row_mut(y);
        vectorize(
            #[inline(always)]
            || blur_across(weights, across, row),
        );
    }
}

/// Gives `out` a size; what it held is lost unless it had that size.
pub(super) fn fit(out: &mut Plane<u8>, width: usize, height: usize) {
    if (out.width(), out.height()) != (width, height) {
        *out = Plane::filled(width, height, 0);
    }
}

/// The place of `n` where the mirror images of places outside are, however far.
fn mirrored(place: isize, n: usize) -> usize {
    let period = (2 * (n as isize - 1)).max(1);
    let folded = place.rem_euclid(period);
    folded.min(period - folded).min(n as isize - 1) as usize
}

#[inline(always)]
fn mirror(row: &[u8], reach: usize, padded: &mut [u16]) {
    let width = row.len();
    for (wide, value) in padded[reach..].iter_mut().zip(row) {
        *wide = u16::from(*value);
    }
    for k in 1..=reach {
        padded[reach - k] = u16::from(row[mirrored(-(k as isize), width)]);
        padded[reach + width - 1 + k] = u16::from(row[mirrored((width - 1 + k) as isize, width)]);
    }
}

/// Weights add up to at most 64, so sums fit 14 bits.
#[inline(always)]
fn blur_along<const HALF: usize>(
    weights: [u16; HALF],
    around: Around<'_, u16, HALF>,
    out: &mut [u16],
) {
    let around = around.cut(out.len());
    for (x, out) in out.iter_mut().enumerate() {
        let mut sum = weights[0] * around.behind[0][x];
        for (k, weight) in weights.iter().enumerate().skip(1) {
            sum += weight * (around.before[k][x] + around.behind[k][x]);
        }
        *out = sum;
    }
}

#[inline(always)]
fn blur_across<const HALF: usize>(
    weights: [u16; HALF],
    around: Around<'_, u16, HALF>,
    out: &mut [u8],
) {
    let around = around.cut(out.len());
    for (x, out) in out.iter_mut().enumerate() {
        *out = if HALF == 3 {
            // At most 255 · 256 + 128.
            let mut sum = 128 + weights[0] * around.behind[0][x];
            for (k, weight) in weights.iter().enumerate().skip(1) {
                sum += weight * (around.before[k][x] + around.behind[k][x]);
            }
            (sum >> 8) as u8
        } else {
            // Larger kernels need 32 bits.
            let mut sum = 2048 + u32::from(weights[0]) * u32::from(around.behind[0][x]);
            for (k, &weight) in weights.iter().enumerate().skip(1) {
                sum += u32::from(weight) * u32::from(around.before[k][x] + around.behind[k][x]);
            }
            (sum >> 12) as u8
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `weights` over all pixels around, in one sum.
    fn defined<const N: usize>(weights: [u32; N], image: &Plane<u8>) -> Plane<u8> {
        let (width, height) = (image.width(), image.height());
        let total: u32 = weights.iter().sum();
        let mut out = Plane::filled(width, height, 0);
        for y in 0..height {
            for x in 0..width {
                let mut sum = 0;
                for (dy, wy) in weights.iter().enumerate() {
                    for (dx, wx) in weights.iter().enumerate() {
                        let reach = N as isize / 2;
                        let at_y = bounced(y as isize + dy as isize - reach, height);
                        let at_x = bounced(x as isize + dx as isize - reach, width);
                        sum += wx * wy * u32::from(*image.at(at_x, at_y));
                    }
                }
                *out.at_mut(x, y) = ((sum + total * total / 2) / (total * total)) as u8;
            }
        }
        out
    }

    /// Back and forth until it is inside.
    fn bounced(mut place: isize, n: usize) -> usize {
        let last = n as isize - 1;
        while last > 0 && !(0..=last).contains(&place) {
            place = if place < 0 { -place } else { 2 * last - place };
        }
        if last == 0 { 0 } else { place as usize }
    }

    #[test]
    fn a_blur_is_the_weighted_sum_of_its_definition_at_every_size() {
        let mut rng = evpose_core::CounterRng::new(1, "blur", 0);
        for (width, height) in [(1, 1), (1, 6), (6, 1), (2, 2), (3, 2), (2, 9), (4, 4), (37, 21)] {
            let data = (0..width * height).map(|_| rng.below(256) as u8).collect();
            let image = Plane::from_vec(width, height, data).unwrap();
            let (mut work, mut out) = (BlurWork::default(), Plane::filled(0, 0, 0));
            GaussianKernel::Five.blur(&image, &mut work, &mut out);
            assert_eq!(out, defined([1, 4, 6, 4, 1], &image), "{width}x{height}");
            GaussianKernel::Seven.blur(&image, &mut work, &mut out);
            assert_eq!(out, defined([2, 7, 14, 18, 14, 7, 2], &image), "{width}x{height}");
        }
    }

    #[test]
    fn an_empty_image_stays_empty() {
        let mut out = Plane::filled(2, 2, 0);
        GaussianKernel::Five.blur(&Plane::filled(0, 3, 0), &mut BlurWork::default(), &mut out);
        assert_eq!((out.width(), out.height()), (0, 3));
    }
}
