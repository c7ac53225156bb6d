//! The patches of an image as the columns of a matrix, and back.
//!
//! # Model
//! The image is first padded and split into `stride * stride` planes per channel: plane `(p, q)`
//! has the padded pixels `(stride i + p, stride j + q)`. In them, the pixels under one tap of the
//! kernel are whole rows without gaps or borders.

use std::ops::Range;

use crate::conv2d::Conv2d;

/// Buffers of one piece of work, kept for the next.
#[derive(Default)]
pub(crate) struct Scratch {
    /// Patches as columns.
    pub(crate) patches: Vec<f32>,
    /// Outputs of several images beside each other.
    pub(crate) pixels: Vec<f32>,
    /// A padded image, split.
    pub(crate) planes: Vec<f32>,
}

/// The first `length` elements of a buffer that is made longer where it is too short.
pub(crate) fn resized(buffer: &mut Vec<f32>, length: usize) -> &mut [f32] {
    if buffer.len() < length {
        buffer.resize(length, 0.0);
    }
    &mut buffer[..length]
}

/// The part of a column matrix that belongs to one image: rows are `(channel, ky, kx)`.
#[derive(Clone, Copy)]
pub(crate) struct Columns {
    /// Columns of the whole matrix.
    pub(crate) width: usize,
    /// First column of the image.
    pub(crate) start: usize,
}

/// Writes the patches of `image` `[channels_in, height, width]` into `matrix`.
pub(crate) fn im2col(
    conv: &Conv2d,
    image: &[f32],
    planes: &mut Vec<f32>,
    matrix: &mut [f32],
    columns: Columns,
) {
    let planes = resized(planes, conv.channels_in * conv.stride * conv.stride * area(conv));
    lines(conv, |line, source| {
        let line = &mut planes[line];
        let Some((first, inside)) = source else {
            line.fill(0.0);
            return;
        };
        line[..inside.start].fill(0.0);
        line[inside.end..].fill(0.0);
        let (line, pixels) = (&mut line[inside], &image[first..]);
        match conv.stride {
            1 => line.copy_from_slice(&pixels[..line.len()]),
            2 => every_second(line, pixels, |to, from| *to = *from),
            stride => {
                line.iter_mut().zip(pixels.iter().step_by(stride)).for_each(|(to, x)| *to = *x);
            }
        }
    });
    taps(conv, columns, |row, line| matrix[row].copy_from_slice(&planes[line]));
}

/// Writes the sums over the patches in `matrix` into `image` `[channels_in, height, width]`, which
/// is zero before.
pub(crate) fn col2im(
    conv: &Conv2d,
    matrix: &[f32],
    planes: &mut Vec<f32>,
    image: &mut [f32],
    columns: Columns,
) {
    let planes = resized(planes, conv.channels_in * conv.stride * conv.stride * area(conv));
    planes.fill(0.0);
    taps(conv, columns, |row, line| {
        planes[line].iter_mut().zip(&matrix[row]).for_each(|(to, from)| *to += *from);
    });
    lines(conv, |line, source| {
        let Some((first, inside)) = source else { return };
        let pixels = image[first..].iter_mut().step_by(conv.stride);
        pixels.zip(&planes[line][inside]).for_each(|(to, from)| *to = *from);
    });
}

/// Calls `copy(to, from)` for `line` and every second of `pixels`.
fn every_second(line: &mut [f32], pixels: &[f32], copy: impl Fn(&mut f32, &f32)) {
    let (pairs, rest) = pixels.as_chunks::<2>();
    let (paired, last) = line.split_at_mut(line.len().min(pairs.len()));
    paired.iter_mut().zip(pairs).for_each(|(to, pair)| copy(to, &pair[0]));
    last.iter_mut().zip(rest).for_each(|(to, from)| copy(to, from));
}

/// Rows and columns of a plane.
fn plane(conv: &Conv2d) -> [usize; 2] {
    let [rows, columns] = conv.output();
    [rows + (conv.kernel[0] - 1) / conv.stride, columns + (conv.kernel[1] - 1) / conv.stride]
}

fn area(conv: &Conv2d) -> usize {
    plane(conv).iter().product()
}

/// The pixels of a line of `length` that lie inside an axis of `size` pixels, where the first is
/// the padded pixel `offset`.
fn inside(length: usize, size: usize, conv: &Conv2d, offset: usize) -> Range<usize> {
    let first = conv.padding.saturating_sub(offset).div_ceil(conv.stride);
    let end = (size + conv.padding).saturating_sub(offset).div_ceil(conv.stride).min(length);
    first.min(end)..end
}

/// Calls `line(range, source)` for every line of the planes: the index of its first pixel inside
/// the image, and which of its pixels are inside; `None` where none is.
fn lines(conv: &Conv2d, mut line: impl FnMut(Range<usize>, Option<(usize, Range<usize>)>)) {
    let [height, width] = plane(conv);
    let mut start = 0;
    for channel in 0..conv.channels_in {
        for (p, q) in (0..conv.stride).flat_map(|p| (0..conv.stride).map(move |q| (p, q))) {
            let ys = inside(height, conv.height, conv, p);
            let xs = inside(width, conv.width, conv, q);
            for y in 0..height {
                let source = (ys.contains(&y) && !xs.is_empty()).then(|| {
                    let row = channel * conv.height + y * conv.stride + p - conv.padding;
                    (row * conv.width + xs.start * conv.stride + q - conv.padding, xs.clone())
                });
                line(start..start + width, source);
                start += width;
            }
        }
    }
}

/// Calls `tap(row, line)` for every row of outputs under every tap of the kernel: where it is in
/// the column matrix and where in the planes.
fn taps(conv: &Conv2d, columns: Columns, mut tap: impl FnMut(Range<usize>, Range<usize>)) {
    let [rows_out, columns_out] = conv.output();
    let [height, width] = plane(conv);
    let [kernel_y, kernel_x] = conv.kernel;
    let stride = conv.stride;
    let mut start = columns.start;
    for channel in 0..conv.channels_in {
        for (ky, kx) in (0..kernel_y).flat_map(|y| (0..kernel_x).map(move |x| (y, x))) {
            let plane = (channel * stride + ky % stride) * stride + kx % stride;
            let first = (plane * height + ky / stride) * width + kx / stride;
            for y in 0..rows_out {
                let (row, line) = (start + y * columns_out, first + y * width);
                tap(row..row + columns_out, line..line + columns_out);
            }
            start += columns.width;
        }
    }
}
