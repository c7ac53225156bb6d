//! Convolutions of each channel by itself on GPUs.

use burn::backend::TensorMetadata as _;
use burn::backend::cubecl::dtype_to_storage_type;
use burn::tensor::Shape;
use burn_cubecl::ops::{permute, permute_nchw_to_nhwc, permute_nhwc_to_nchw, reshape};
use burn_cubecl::tensor::CubeTensor;

use super::columns::Geometry;
use super::kernels::depthwise as kernels;
use super::launch::{address, constants, cubes, empty, pieces, sizes, sizes_of, sum_pieces};

/// `[rows, columns, channels]` of `[channels, 1, rows, columns]`, as a view.
fn taps(weight: CubeTensor) -> CubeTensor {
    let mut weight = permute(weight, &[1, 2, 3, 0]);
    weight.meta.remove(0);
    weight
}

/// `[batch, channels, height', width']` from `[batch, channels, height, width]`.
pub(super) fn forward(geometry: &Geometry, input: CubeTensor, weight: CubeTensor) -> CubeTensor {
    let (input, weight) = (permute_nchw_to_nhwc(input), taps(weight));
    let output = empty(&input, Shape::from(geometry.output_shape()));
    let (client, address) = (input.client.clone(), address(&[&input, &output]));
    let (cubes, cube) = cubes(&client, output.meta.num_elements());
    // SAFETY: the kernel checks its position; what it reads and writes lies within the shapes.
    #[allow(unsafe_code, reason = "kernels are launched without checks of every access")]
    unsafe {
        kernels::forward::launch_unchecked(
            &client,
            cubes,
            cube,
            address,
            input.into_tensor_arg(),
            weight.into_tensor_arg(),
            output.clone().into_tensor_arg(),
            sizes_of(&output),
            constants(geometry.steps()),
            dtype_to_storage_type(output.dtype),
        );
    }
    permute_nhwc_to_nchw(output)
}

/// The gradient by the input, from that by the output.
pub(super) fn by_input(
    geometry: &Geometry,
    gradient: CubeTensor,
    weight: CubeTensor,
) -> CubeTensor {
    let (gradient, weight) = (permute_nchw_to_nhwc(gradient), taps(weight));
    let images = empty(&gradient, Shape::from(geometry.input_shape()));
    let (client, address) = (gradient.client.clone(), address(&[&gradient, &images]));
    let (cubes, cube) = cubes(&client, images.meta.num_elements());
    // SAFETY: as in `forward`.
    #[allow(unsafe_code, reason = "kernels are launched without checks of every access")]
    unsafe {
        kernels::by_images::launch_unchecked(
            &client,
            cubes,
            cube,
            address,
            gradient.into_tensor_arg(),
            weight.into_tensor_arg(),
            images.clone().into_tensor_arg(),
            sizes_of(&images),
            constants(geometry.steps()),
            dtype_to_storage_type(images.dtype),
        );
    }
    permute_nhwc_to_nchw(images)
}

/// The gradient by the weight, from that by the output.
pub(super) fn by_weight(
    geometry: &Geometry,
    gradient: CubeTensor,
    input: CubeTensor,
) -> CubeTensor {
    let [input, gradient] = [input, gradient].map(permute_nchw_to_nhwc);
    let ([batch, height, width, channels], [rows, columns]) =
        (gradient.shape().dims(), geometry.kernel());
    let taps = rows * columns * channels;
    // The weights are too few to keep a GPU busy: pieces of the pixels are summed in parallel.
    let (count, per) = pieces(batch * height * width, taps);
    let sums = empty(&input, Shape::from([count, taps]));
    let (client, address) = (input.client.clone(), address(&[&input, &gradient, &sums]));
    let (cubes, cube) = cubes(&client, count * taps);
    let shape = sizes_of(&gradient);
    // SAFETY: as in `forward`.
    #[allow(unsafe_code, reason = "kernels are launched without checks of every access")]
    unsafe {
        kernels::weight_sums::launch_unchecked(
            &client,
            cubes,
            cube,
            address,
            input.into_tensor_arg(),
            gradient.into_tensor_arg(),
            sums.clone().into_tensor_arg(),
            shape,
            sizes([rows, columns, channels]),
            constants(geometry.steps()),
            constants([per]),
            dtype_to_storage_type(sums.dtype),
        );
    }
    let weight = sum_pieces(sums, Shape::from([taps]));
    permute(reshape(weight, Shape::from([1, rows, columns, channels])), &[3, 0, 1, 2])
}
