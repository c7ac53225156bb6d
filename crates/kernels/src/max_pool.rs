//! Max-pooling over 3x3 pixels with stride 2 and one pixel of padding, as ResNets use it.

use rayon::prelude::*;

const KERNEL: usize = 3;
const STRIDE: usize = 2;
const PADDING: usize = 1;

/// Rows and columns of the output for an input of `height` x `width` pixels.
pub fn output([height, width]: [usize; 2]) -> [usize; 2] {
    [height.div_ceil(STRIDE), width.div_ceil(STRIDE)]
}

/// The largest value around every second pixel, and which of the nine it was: the first of
/// several. NaN counts as larger than any number.
///
/// # Shapes
/// - `input`: `[planes, height, width]` with `size = [height, width]`
/// - both outputs: `[planes, ceil(height / 2), ceil(width / 2)]`
pub fn forward(input: &[f32], size: [usize; 2]) -> (Vec<f32>, Vec<u8>) {
    let ([height, width], [rows, columns]) = (size, output(size));
    let (pixels_in, pixels_out) = ((height * width).max(1), (rows * columns).max(1));
    let planes = input.len() / pixels_in;
    let (mut values, mut taps) = (vec![0.0; planes * pixels_out], vec![0; planes * pixels_out]);
    values
        .par_chunks_mut(pixels_out)
        .zip(taps.par_chunks_mut(pixels_out))
        .zip(input.par_chunks_exact(pixels_in))
        .with_min_len(8)
        .for_each(|((values, taps), image)| {
            let lines = values.chunks_exact_mut(columns).zip(taps.chunks_exact_mut(columns));
            for (y, (values, taps)) in lines.enumerate() {
                for (x, (value, tap)) in values.iter_mut().zip(taps).enumerate() {
                    let mut best = (f32::NEG_INFINITY, None);
                    for_each_tap(size, [y, x], |index, at| {
                        let candidate = image[at];
                        if best.1.is_none() || candidate > best.0 || candidate.is_nan() {
                            best = (candidate, Some(index));
                        }
                    });
                    (*value, *tap) = (best.0, best.1.unwrap_or(0));
                }
            }
        });
    (values, taps)
}

/// The gradient by the input, from the gradient by the output and the second result of
/// [`forward`]. Shapes as there.
pub fn backward(gradient: &[f32], taps: &[u8], size: [usize; 2]) -> Vec<f32> {
    let ([height, width], [rows, columns]) = (size, output(size));
    let (pixels_in, pixels_out) = ((height * width).max(1), (rows * columns).max(1));
    let mut input = vec![0.0; gradient.len() / pixels_out * pixels_in];
    input
        .par_chunks_mut(pixels_in)
        .zip(gradient.par_chunks_exact(pixels_out))
        .zip(taps.par_chunks_exact(pixels_out))
        .with_min_len(8)
        .for_each(|((image, gradient), taps)| {
            for (at, (value, tap)) in gradient.iter().zip(taps).enumerate() {
                let tap = usize::from(*tap);
                let line = at / columns * STRIDE + tap / KERNEL - PADDING;
                image[line * width + at % columns * STRIDE + tap % KERNEL - PADDING] += value;
            }
        });
    input
}

/// Calls `tap(index, at)` for those of the nine pixels around output `(y, x)` that are inside.
#[inline(always)]
fn for_each_tap([height, width]: [usize; 2], [y, x]: [usize; 2], mut tap: impl FnMut(u8, usize)) {
    for ky in 0..KERNEL {
        let line = y * STRIDE + ky;
        if line < PADDING || line >= height + PADDING {
            continue;
        }
        for kx in 0..KERNEL {
            let column = x * STRIDE + kx;
            if column >= PADDING && column < width + PADDING {
                tap((ky * KERNEL + kx) as u8, (line - PADDING) * width + column - PADDING);
            }
        }
    }
}
