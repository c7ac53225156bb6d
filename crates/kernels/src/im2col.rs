//! The patches of an image as the columns of a matrix, and back.

use std::ops::Range;

use crate::conv2d::Conv2d;

/// The part of a column matrix that belongs to one image: rows are `(channel, ky, kx)`.
#[derive(Clone, Copy)]
pub(crate) struct Columns {
    /// Columns of the whole matrix.
    pub(crate) width: usize,
    /// First column of the image.
    pub(crate) start: usize,
}

/// The outputs whose tap `offset` lies inside an axis of `size` pixels.
fn inside(
    outputs: usize,
    size: usize,
    stride: usize,
    padding: usize,
    offset: usize,
) -> Range<usize> {
    let first = padding.saturating_sub(offset).div_ceil(stride);
    let end = (size + padding).saturating_sub(offset).div_ceil(stride);
    let end = end.min(outputs);
    first.min(end)..end
}

/// Calls `row(channel, first, at, xs, inside)` for every row of patches: `first` is the start of
/// the image row, `at` of the columns, `xs` the outputs inside the image; `None` where the whole
/// row is padding.
fn walk(
    conv: &Conv2d,
    columns: Columns,
    mut row: impl FnMut(usize, Option<(usize, Range<usize>)>),
) {
    let [rows_out, columns_out] = conv.output();
    let [kernel_y, kernel_x] = conv.kernel;
    for channel in 0..conv.channels_in {
        for ky in 0..kernel_y {
            let ys = inside(rows_out, conv.height, conv.stride, conv.padding, ky);
            for kx in 0..kernel_x {
                let xs = inside(columns_out, conv.width, conv.stride, conv.padding, kx);
                let k = (channel * kernel_y + ky) * kernel_x + kx;
                for y in 0..rows_out {
                    let at = k * columns.width + columns.start + y * columns_out;
                    let source = (ys.contains(&y) && !xs.is_empty()).then(|| {
                        let line = y * conv.stride + ky - conv.padding;
                        let x = xs.start * conv.stride + kx - conv.padding;
                        ((channel * conv.height + line) * conv.width + x, xs.clone())
                    });
                    row(at, source);
                }
            }
        }
    }
}

/// Writes the patches of `image` `[channels_in, height, width]` into `matrix`.
pub(crate) fn im2col(conv: &Conv2d, image: &[f32], matrix: &mut [f32], columns: Columns) {
    let [_, columns_out] = conv.output();
    walk(conv, columns, |at, source| {
        let row = &mut matrix[at..at + columns_out];
        let Some((first, xs)) = source else {
            row.fill(0.0);
            return;
        };
        row[..xs.start].fill(0.0);
        row[xs.end..].fill(0.0);
        let taps = &image[first..];
        if conv.stride == 1 {
            row[xs.clone()].copy_from_slice(&taps[..xs.len()]);
        } else {
            for (to, from) in row[xs].iter_mut().zip(taps.iter().step_by(conv.stride)) {
                *to = *from;
            }
        }
    });
}

/// Adds the patches in `matrix` to `image` `[channels_in, height, width]`.
pub(crate) fn col2im(conv: &Conv2d, matrix: &[f32], image: &mut [f32], columns: Columns) {
    let [_, columns_out] = conv.output();
    walk(conv, columns, |at, source| {
        let Some((first, xs)) = source else { return };
        let row = &matrix[at..at + columns_out][xs];
        let taps = &mut image[first..];
        if conv.stride == 1 {
            for (to, from) in taps.iter_mut().zip(row) {
                *to += *from;
            }
        } else {
            for (to, from) in taps.iter_mut().step_by(conv.stride).zip(row) {
                *to += *from;
            }
        }
    });
}
