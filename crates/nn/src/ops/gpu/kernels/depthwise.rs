//! Kernels of convolutions of each channel by itself.
//!
//! `geometry` holds strides, paddings and dilations, each vertical and horizontal.

use cubecl::prelude::*;
use cubecl::std::FastDivmod;

/// `output[n, i, j, c]` is the sum over `k` and `l` of `images[n, i s + k d - p, j s + l d - p, c] *
/// weight[k, l, c]`, zero outside.
#[cube(launch_unchecked, address_type = "dynamic")]
pub(crate) fn forward<E: Float>(
    images: &Tensor<E>,
    weight: &Tensor<E>,
    output: &mut Tensor<E>,
    shape: Sequence<FastDivmod<usize>>,
    geometry: Sequence<usize>,
    #[define(E)] _element: ElemType,
) {
    if ABSOLUTE_POS >= output.len() {
        terminate!();
    }
    // Channels are last, so that neighbouring threads read neighbours.
    let (rest, channel) = shape.index(3).div_mod(ABSOLUTE_POS);
    let (rest, j) = shape.index(2).div_mod(rest);
    let (image, i) = shape.index(1).div_mod(rest);
    // Indices are unsigned: in padded coordinates no difference is negative.
    let (top, left) = (*geometry.index(2), *geometry.index(3));
    let (bottom, right) = (images.shape(1) + top, images.shape(2) + left);
    let mut sum = E::from_int(0);
    for row in 0..weight.shape(0) {
        let y = i * *geometry.index(0) + row * *geometry.index(4);
        if y >= top && y < bottom {
            for column in 0..weight.shape(1) {
                let x = j * *geometry.index(1) + column * *geometry.index(5);
                if x >= left && x < right {
                    sum += images[image * images.stride(0)
                        + (y - top) * images.stride(1)
                        + (x - left) * images.stride(2)
                        + channel * images.stride(3)]
                        * weight[row * weight.stride(0)
                            + column * weight.stride(1)
                            + channel * weight.stride(2)];
                }
            }
        }
    }
    output[ABSOLUTE_POS] = sum;
}

/// The gradient by the images from that by the output.
#[cube(launch_unchecked, address_type = "dynamic")]
pub(crate) fn by_images<E: Float>(
    gradient: &Tensor<E>,
    weight: &Tensor<E>,
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
    let (height, width) = (gradient.shape(1), gradient.shape(2));
    let mut sum = E::from_int(0);
    for row in 0..weight.shape(0) {
        let down = row * *geometry.index(4);
        let i = (y - down) / *geometry.index(0);
        // An unsigned difference may wrap: it is checked before it is used.
        if y >= down && i * *geometry.index(0) + down == y && i < height {
            for column in 0..weight.shape(1) {
                let right = column * *geometry.index(5);
                let j = (x - right) / *geometry.index(1);
                if x >= right && j * *geometry.index(1) + right == x && j < width {
                    sum += gradient[image * gradient.stride(0)
                        + i * gradient.stride(1)
                        + j * gradient.stride(2)
                        + channel * gradient.stride(3)]
                        * weight[row * weight.stride(0)
                            + column * weight.stride(1)
                            + channel * weight.stride(2)];
                }
            }
        }
    }
    images[ABSOLUTE_POS] = sum;
}

/// Sums of the gradient by the weight over the output pixels of a piece, `[pieces, rows, columns, channels]`.
///
/// `taps` holds the sizes of the last three, `shape` those of the output, and `per[0]` the pixels of a piece, of
/// which the last one has fewer.
#[cube(launch_unchecked, address_type = "dynamic")]
pub(crate) fn weight_sums<E: Float>(
    images: &Tensor<E>,
    gradient: &Tensor<E>,
    sums: &mut Tensor<E>,
    shape: Sequence<FastDivmod<usize>>,
    taps: Sequence<FastDivmod<usize>>,
    geometry: Sequence<usize>,
    per: Sequence<usize>,
    #[define(E)] _element: ElemType,
) {
    if ABSOLUTE_POS >= sums.len() {
        terminate!();
    }
    let (rest, channel) = taps.index(2).div_mod(ABSOLUTE_POS);
    let (rest, column) = taps.index(1).div_mod(rest);
    let (piece, row) = taps.index(0).div_mod(rest);
    let begin = piece * *per.index(0);
    let mut end = begin + *per.index(0);
    let pixels = gradient.shape(0) * gradient.shape(1) * gradient.shape(2);
    if end > pixels {
        end = pixels;
    }
    let (top, left) = (*geometry.index(2), *geometry.index(3));
    let (bottom, right) = (images.shape(1) + top, images.shape(2) + left);
    let (down, across) = (row * *geometry.index(4), column * *geometry.index(5));
    let mut sum = E::from_int(0);
    // One thread sums a piece in order: without atomics every run has the same bits.
    for pixel in begin..end {
        let (rest, j) = shape.index(2).div_mod(pixel);
        let (image, i) = shape.index(1).div_mod(rest);
        let y = i * *geometry.index(0) + down;
        let x = j * *geometry.index(1) + across;
        if y >= top && y < bottom && x >= left && x < right {
            sum += images[image * images.stride(0)
                + (y - top) * images.stride(1)
                + (x - left) * images.stride(2)
                + channel * images.stride(3)]
                * gradient[image * gradient.stride(0)
                    + i * gradient.stride(1)
                    + j * gradient.stride(2)
                    + channel * gradient.stride(3)];
        }
    }
    sums[ABSOLUTE_POS] = sum;
}
