//! Sizes, outputs and arguments of launches.

use burn::backend::TensorMetadata as _;
use burn::backend::cubecl::dtype_to_storage_type;
use burn::tensor::Shape;
use burn_cubecl::ops::numeric::empty_device_contiguous_dtype;
use burn_cubecl::tensor::CubeTensor;
use cubecl::calculate_cube_count_elemwise;
use cubecl::client::Client;
use cubecl::prelude::{AddressType, CubeCount, CubeDim, SequenceArg};
use cubecl::std::FastDivmod;

use super::kernels;

/// Units in flight that fill a GPU.
const UNITS: usize = 1 << 17;
/// The fewest pixels that are worth a unit of their own.
const MIN_PIXELS: usize = 16;
/// The most pieces that one unit then adds up.
const MAX_PIECES: usize = 256;

/// Cubes for `count` units.
pub(super) fn cubes(client: &Client, count: usize) -> (CubeCount, CubeDim) {
    let cube = CubeDim::new(client, count);
    (calculate_cube_count_elemwise(client, count, cube), cube)
}

/// Integers that reach all elements of all of these.
pub(super) fn address(tensors: &[&CubeTensor]) -> AddressType {
    let types = tensors.iter().map(|tensor| tensor.required_address_type());
    types.max().unwrap_or_default()
}

/// A tensor without gaps, of unset values, where another one is.
pub(super) fn empty(like: &CubeTensor, shape: Shape) -> CubeTensor {
    empty_device_contiguous_dtype(like.client.clone(), like.device.clone(), shape, like.dtype)
}

/// Divisors by which a kernel takes positions apart.
pub(super) fn sizes(of: impl IntoIterator<Item = usize>) -> SequenceArg<FastDivmod<usize>> {
    of.into_iter().collect()
}

/// Sizes of four dimensions.
pub(super) fn sizes_of(tensor: &CubeTensor) -> SequenceArg<FastDivmod<usize>> {
    sizes(tensor.shape().dims::<4>())
}

/// Constants of a kernel.
pub(super) fn constants(of: impl IntoIterator<Item = usize>) -> SequenceArg<usize> {
    of.into_iter().collect()
}

/// Into how many pieces of how many pixels a sum over `pixels` is cut, of `width` sums beside each other.
pub(super) fn pieces(pixels: usize, width: usize) -> (usize, usize) {
    let wanted = (UNITS / width).clamp(1, MAX_PIECES).min(pixels.div_ceil(MIN_PIXELS));
    let per = pixels.div_ceil(wanted).max(1);
    (pixels.div_ceil(per), per)
}

/// The sum of `[pieces, …]` over the pieces.
pub(super) fn sum_pieces(partial: CubeTensor, shape: Shape) -> CubeTensor {
    let sums = empty(&partial, shape);
    let (client, address) = (sums.client.clone(), address(&[&partial, &sums]));
    let (cubes, cube) = cubes(&client, sums.meta.num_elements());
    let element = dtype_to_storage_type(sums.dtype);
    // SAFETY: the kernel checks its position; what it reads and writes lies within the shapes.
    #[allow(unsafe_code, reason = "kernels are launched without checks of every access")]
    unsafe {
        kernels::sum_pieces::launch_unchecked(
            &client,
            cubes,
            cube,
            address,
            partial.into_tensor_arg(),
            sums.clone().into_tensor_arg(),
            element,
        );
    }
    sums
}
