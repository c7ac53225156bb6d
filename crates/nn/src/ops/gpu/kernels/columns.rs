//! Kernels that lay images out as the columns of a matrix product, and back.
//!
//! A row of the matrix is an output pixel; its columns are the pixels under the kernel, row by row,
//! each with all of its channels.

use cubecl::prelude::*;
use cubecl::std::FastDivmod;

/// `columns[(n, i, j), (k, l, c)] = images[n, i * s - p + k * d, j * s - p + l * d, c]`, zero outside.
///
/// `shape` holds the sizes of n, i, j, k, l and c; `geometry` strides, paddings and dilations, each
/// vertical and horizontal.
#[cube(launch_unchecked, address_type = "dynamic")]
pub(crate) fn gather<E: Numeric>(
    images: &Tensor<E>,
    columns: &mut Tensor<E>,
    shape: Sequence<FastDivmod<usize>>,
    geometry: Sequence<usize>,
    #[define(E)] _element: ElemType,
) {
    // Threads come in whole cubes: the last ones have no element.
    if ABSOLUTE_POS >= columns.len() {
        terminate!();
    }
    let (rest, channel) = shape.index(5).div_mod(ABSOLUTE_POS);
    let (rest, column) = shape.index(4).div_mod(rest);
    let (rest, row) = shape.index(3).div_mod(rest);
    let (rest, x) = shape.index(2).div_mod(rest);
    let (image, y) = shape.index(1).div_mod(rest);
    // Unsigned: the padding is subtracted only where that leaves a pixel.
    let y = y * *geometry.index(0) + row * *geometry.index(4);
    let x = x * *geometry.index(1) + column * *geometry.index(5);
    let (top, left) = (*geometry.index(2), *geometry.index(3));
    let mut value = E::from_int(0);
    if y >= top && x >= left && y < images.shape(1) + top && x < images.shape(2) + left {
        value = images[image * images.stride(0)
            + (y - top) * images.stride(1)
            + (x - left) * images.stride(2)
            + channel * images.stride(3)];
    }
    columns[ABSOLUTE_POS] = value;
}

/// The transpose of [`gather`]: every pixel is the sum of the columns that it was copied to.
///
/// `shape` holds the sizes of the images; `geometry` is that of [`gather`], followed by rows and
/// columns of the output and of the kernel.
#[cube(launch_unchecked, address_type = "dynamic")]
pub(crate) fn scatter<E: Numeric>(
    columns: &Tensor<E>,
    images: &mut Tensor<E>,
    shape: Sequence<FastDivmod<usize>>,
    geometry: Sequence<usize>,
    #[define(E)] _element: ElemType,
) {
    if ABSOLUTE_POS >= images.len() {
        terminate!();
    }
    let (rest, channel) = shape.index(3).div_mod(ABSOLUTE_POS);
    let (rest, x) = shape.index(2).div_mod(rest);
    let (image, y) = shape.index(1).div_mod(rest);
    // In padded coordinates, in which strides and dilations count from 0.
    let y = y + *geometry.index(2);
    let x = x + *geometry.index(3);
    let (height, width) = (*geometry.index(6), *geometry.index(7));
    let (rows, taps) = (*geometry.index(8), *geometry.index(9));
    let channels = images.shape(3);
    let mut sum = E::from_int(0);
    for row in 0..rows {
        let down = row * *geometry.index(4);
        let i = (y - down) / *geometry.index(0);
        // An unsigned difference may wrap: it is checked below, before it is used.
        // Only a whole number of strides leads from a pixel of the output to this one.
        if y >= down && i * *geometry.index(0) + down == y && i < height {
            for column in 0..taps {
                let right = column * *geometry.index(5);
                let j = (x - right) / *geometry.index(1);
                if x >= right && j * *geometry.index(1) + right == x && j < width {
                    let pixel = (image * height + i) * width + j;
                    let tap = (row * taps + column) * channels + channel;
                    sum += columns[pixel * columns.stride(0) + tap * columns.stride(1)];
                }
            }
        }
    }
    images[ABSOLUTE_POS] = sum;
}
