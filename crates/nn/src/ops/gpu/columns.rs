//! Convolutions on GPUs as one matrix product each, of columns that hold what lies under the kernel.
//!
//! # Source
//! Chellapilla, Puri and Simard, "High performance convolutional neural networks for document
//! processing", 2006.

use burn::backend::cubecl::dtype_to_storage_type;
use burn::backend::ops::ConvOptions;
use burn::tensor::{DType, Shape};
use burn_cubecl::CubeDevice;
use burn_cubecl::kernel::matmul::{MatmulStrategy, init_matmul_output, matmul};
use burn_cubecl::kernel::reduce::reduce_dim;
use burn_cubecl::ops::{permute, permute_nchw_to_nhwc, permute_nhwc_to_nchw, reshape};
use burn_cubecl::tensor::CubeTensor;
use cubek::matmul::definition::{MatmulElems, MatmulGlobalElems};
use cubek::matmul::launch::launch_ref;
use cubek::matmul::multi_level::Strategy as MultiLevel;
use cubek::matmul::strategy::Strategy;
use cubek::reduce::components::instructions::ReduceOperationConfig;
use cubek::std::InputBinding;

use super::kernels::columns as kernels;
use super::launch::{address, constants, cubes, empty, sizes};

/// Rows of a product below which a sum over them is not cut into several.
const MIN_ROWS: usize = 2048;
/// The most pieces that such a sum is cut into.
const MAX_PIECES: usize = 64;

/// How products are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Product {
    /// By Burn's choice: on matrix units in a shorter format (TF32) where the GPU has them for f32.
    Burns,
    /// In f32 throughout, of inputs in f32.
    F32,
}

/// Shape of a convolution of all channels, or of each by itself.
#[derive(Debug, Clone)]
pub(super) struct Geometry {
    /// Images, rows, columns and channels of the input.
    input: [usize; 4],
    /// Rows and columns of the output.
    output: [usize; 2],
    /// Rows and columns of the kernel.
    kernel: [usize; 2],
    channels_out: usize,
    options: ConvOptions<2>,
}

impl Geometry {
    /// `input` is `[batch, channels, height, width]`, `weight` `[channels_out, channels, rows, columns]`.
    pub(super) fn new(input: &Shape, weight: &Shape, options: ConvOptions<2>) -> Self {
        let [batch, channels, height, width] = input.dims();
        let [channels_out, _, rows, columns] = weight.dims();
        let size = |side: usize, kernel: usize, axis: usize| {
            let (begin, end) = options.padding[axis];
            // The usual formula: positions at which the dilated kernel fits into the padded side.
            let extent = options.dilation[axis] * (kernel - 1) + 1;
            (side + begin + end - extent) / options.stride[axis] + 1
        };
        Self {
            input: [batch, height, width, channels],
            output: [size(height, rows, 0), size(width, columns, 1)],
            kernel: [rows, columns],
            channels_out,
            options,
        }
    }

    /// Images, rows, columns and channels of the input.
    pub(super) fn input_shape(&self) -> [usize; 4] {
        self.input
    }

    /// Images, rows, columns and channels of the output.
    pub(super) fn output_shape(&self) -> [usize; 4] {
        let ([batch, ..], [rows, columns]) = (self.input, self.output);
        [batch, rows, columns, self.channels_out]
    }

    /// Strides, paddings and dilations.
    pub(super) fn options(&self) -> ConvOptions<2> {
        self.options.clone()
    }

    /// Rows and columns of the kernel.
    pub(super) fn kernel(&self) -> [usize; 2] {
        self.kernel
    }

    /// Rows of the matrix of columns: output pixels of all images.
    fn pixels(&self) -> usize {
        self.input[0] * self.output[0] * self.output[1]
    }

    /// Columns of the matrix of columns: values under the kernel.
    fn taps(&self) -> usize {
        self.kernel[0] * self.kernel[1] * self.input[3]
    }

    /// Whether the pixels are the columns, so that none need be copied.
    fn is_product_of_pixels(&self) -> bool {
        self.kernel == [1, 1] && self.output == self.input[1..3] && self.steps()[..2] == [1, 1]
    }

    /// Strides, paddings and dilations, each vertical and horizontal.
    pub(super) fn steps(&self) -> [usize; 6] {
        let ConvOptions { stride, padding, dilation, .. } = &self.options;
        [stride[0], stride[1], padding[0].0, padding[1].0, dilation[0], dilation[1]]
    }

    /// `[batch, channels_out, height', width']` from `[pixels, channels_out]`, as a view.
    fn planes(&self, mut pixels: CubeTensor) -> CubeTensor {
        let [rows, columns] = self.output;
        // A product may pad its rows: their pitch, not the channels, is the step between pixels.
        let pitch = pixels.meta.strides()[0];
        pixels.meta.remove(0);
        for (size, stride) in
            [(columns, pitch), (rows, columns * pitch), (self.input[0], rows * columns * pitch)]
        {
            pixels.meta.insert(0, size, stride);
        }
        permute_nhwc_to_nchw(pixels)
    }

    /// `[pixels, channels_out]` from `[batch, channels_out, height', width']`.
    fn pixel_rows(&self, planes: CubeTensor) -> CubeTensor {
        let shape = Shape::from([self.pixels(), self.channels_out]);
        reshape(permute_nchw_to_nhwc(planes), shape)
    }

    /// `[channels_out, taps]` from `[channels_out, channels, rows, columns]`.
    fn weight_rows(&self, weight: CubeTensor) -> CubeTensor {
        let shape = Shape::from([self.channels_out, self.taps()]);
        reshape(permute_nchw_to_nhwc(weight), shape)
    }

    /// `[pixels, taps]`.
    fn columns(&self, input: CubeTensor) -> CubeTensor {
        // Channels last, as `planes` leaves them in memory: neighbouring threads read neighbours.
        let input = permute_nchw_to_nhwc(input);
        let shape = Shape::from([self.pixels(), self.taps()]);
        if self.is_product_of_pixels() {
            return reshape(input, shape);
        }
        let columns = empty(&input, shape);
        let [rows, width] = self.output;
        let parts = [self.input[0], rows, width, self.kernel[0], self.kernel[1], self.input[3]];
        let (client, count) = (input.client.clone(), self.pixels() * self.taps());
        let address = address(&[&input, &columns]);
        let (cubes, cube) = cubes(&client, count);
        // SAFETY: the kernel checks its position; what it reads and writes lies within the shapes.
        #[allow(unsafe_code, reason = "kernels are launched without checks of every access")]
        unsafe {
            kernels::gather::launch_unchecked(
                &client,
                cubes,
                cube,
                address,
                input.into_tensor_arg(),
                columns.clone().into_tensor_arg(),
                sizes(parts),
                constants(self.steps()),
                dtype_to_storage_type(columns.dtype),
            );
        }
        columns
    }

    pub(super) fn forward(
        &self,
        input: CubeTensor,
        weight: CubeTensor,
        product: Product,
    ) -> CubeTensor {
        let weight = permute(self.weight_rows(weight), &[1, 0]);
        self.planes(product.of(self.columns(input), weight))
    }

    /// The gradient by the input, from that by the output.
    pub(super) fn by_input(
        &self,
        gradient: CubeTensor,
        weight: CubeTensor,
        product: Product,
    ) -> CubeTensor {
        let columns = product.of(self.pixel_rows(gradient), self.weight_rows(weight));
        if self.is_product_of_pixels() {
            return permute_nhwc_to_nchw(reshape(columns, Shape::from(self.input)));
        }
        let images = empty(&columns, Shape::from(self.input));
        // A thread for each pixel sums what falls on it: no atomics, and always the same order.
        let (client, count) = (columns.client.clone(), self.input.iter().product());
        let address = address(&[&images, &columns]);
        let (cubes, cube) = cubes(&client, count);
        let ends = [self.output, self.kernel].concat();
        // SAFETY: as in `columns`.
        #[allow(unsafe_code, reason = "kernels are launched without checks of every access")]
        unsafe {
            kernels::scatter::launch_unchecked(
                &client,
                cubes,
                cube,
                address,
                columns.into_tensor_arg(),
                images.clone().into_tensor_arg(),
                sizes(self.input),
                constants(self.steps().into_iter().chain(ends)),
                dtype_to_storage_type(images.dtype),
            );
        }
        permute_nhwc_to_nchw(images)
    }

    /// The gradient by the weight, from that by the output.
    pub(super) fn by_weight(
        &self,
        gradient: CubeTensor,
        input: CubeTensor,
        product: Product,
    ) -> CubeTensor {
        let (columns, gradient) = (self.columns(input), self.pixel_rows(gradient));
        // A sum over all pixels for each of a few weights keeps few of a GPU's units busy.
        let pieces = self.pieces();
        // Pieces divide the pixels without a rest.
        let per = self.pixels() / pieces;
        let cut =
            |tensor: CubeTensor, width: usize| reshape(tensor, Shape::from([pieces, per, width]));
        let gradient = permute(cut(gradient, self.channels_out), &[0, 2, 1]);
        let sums = product.of(gradient, cut(columns, self.taps()));
        let sum = if pieces == 1 {
            sums
        } else {
            reduce_dim(sums, None, 0, Default::default(), ReduceOperationConfig::Sum)
                .unwrap_or_else(|error| unreachable!("the axis is there: {error:?}"))
        };
        // Here the weight has its channels last; the network has them before rows and columns.
        let [rows, columns] = self.kernel;
        let shape = [self.channels_out, rows, columns, self.input[3]];
        permute_nhwc_to_nchw(reshape(sum, Shape::from(shape)))
    }

    /// Into how many equal parts the pixels are cut.
    fn pieces(&self) -> usize {
        let most = (self.pixels() / MIN_ROWS).clamp(1, MAX_PIECES);
        (0..=most.ilog2())
            .rev()
            .map(|log| 1 << log)
            .find(|n| self.pixels().is_multiple_of(*n))
            .unwrap_or(1)
    }
}

impl Product {
    /// The matrix product.
    fn of(self, a: CubeTensor, b: CubeTensor) -> CubeTensor {
        let dtype = a.dtype;
        // Burn chooses plain f32 where there are no matrix units for it, as on wgpu, and is the faster there
        // (`benches/machines/xeon-2-vulkan.json`). In 16 bits matrix units are what is wanted.
        let rounds = matches!(a.device, CubeDevice::Cuda(_)) && dtype == DType::F32;
        if self == Self::Burns || !rounds {
            return matmul(a, b, None, MatmulStrategy::default(), dtype)
                .unwrap_or_else(|error| panic!("a matrix product: {error:?}"));
        }
        let out = init_matmul_output(&a, &b, dtype);
        let element = dtype_to_storage_type(dtype);
        let mut elements = MatmulElems::from_globals(&MatmulGlobalElems {
            lhs: element,
            rhs: element,
            out: element,
        });
        let client = out.client.clone();
        launch_ref(
            // Plain units, not matrix units, which would round f32 to TF32.
            &Strategy::MultiLevel(MultiLevel::DoubleUnit(Default::default())),
            &client,
            InputBinding::new(a.binding(), element),
            InputBinding::new(b.binding(), element),
            out.clone().binding(),
            &mut elements,
        )
        .unwrap_or_else(|error| panic!("a matrix product: {error:?}"));
        out
    }
}
