//! Batch normalisation on GPUs, with the activation behind it.

use burn::backend::TensorMetadata as _;
use burn::backend::cubecl::dtype_to_storage_type;
use burn::tensor::Shape;
use burn_cubecl::ops::{permute_nchw_to_nhwc, permute_nhwc_to_nchw};
use burn_cubecl::tensor::CubeTensor;

use super::Activation;
use super::kernels::norm as kernels;
use super::launch::{address, constants, cubes, empty, pieces, sizes_of, sum_pieces};

/// Parameters and statistics of a normalisation, each `[channels]`.
#[derive(Debug, Clone)]
pub(super) struct Norm {
    pub(super) gamma: CubeTensor,
    pub(super) beta: CubeTensor,
    pub(super) mean: CubeTensor,
    pub(super) variance: CubeTensor,
    pub(super) epsilon: f32,
    pub(super) activation: Activation,
}

/// Gradients of a normalisation by the statistics of its batch.
#[derive(Debug)]
pub(super) struct NormGradients {
    pub(super) input: CubeTensor,
    pub(super) gamma: CubeTensor,
    pub(super) beta: CubeTensor,
}

/// Mean and variance of each channel of `[batch, channels, height, width]`, then the running ones moved towards
/// them.
pub(super) fn statistics(
    input: CubeTensor,
    [running_mean, running_variance]: [CubeTensor; 2],
    momentum: f32,
) -> [CubeTensor; 4] {
    let input = permute_nchw_to_nhwc(input);
    let [batch, height, width, channels] = input.shape().dims();
    // Channels are too few to keep a GPU busy: pieces of the pixels are summed in parallel.
    let (count, per) = pieces(batch * height * width, channels);
    let [sums, squares] = [(); 2].map(|()| empty(&input, Shape::from([count, channels])));
    let outputs = [(); 4].map(|()| empty(&input, Shape::from([channels])));
    let (client, address) = (input.client.clone(), address(&[&input, &sums]));
    let element = dtype_to_storage_type(input.dtype);
    let (piece_cubes, piece_cube) = cubes(&client, count * channels);
    let (cubes, cube) = cubes(&client, channels);
    let [mean, variance, next_mean, next_variance] =
        outputs.clone().map(CubeTensor::into_tensor_arg);
    // SAFETY: kernels check their positions; what they read and write lies within the shapes.
    #[allow(unsafe_code, reason = "kernels are launched without checks of every access")]
    unsafe {
        kernels::shifted_sums::launch_unchecked(
            &client,
            piece_cubes,
            piece_cube,
            address,
            input.clone().into_tensor_arg(),
            sums.clone().into_tensor_arg(),
            squares.clone().into_tensor_arg(),
            sizes_of(&input),
            constants([per]),
            element,
        );
        kernels::moments::launch_unchecked(
            &client,
            cubes,
            cube,
            address,
            input.into_tensor_arg(),
            sums.into_tensor_arg(),
            squares.into_tensor_arg(),
            running_mean.into_tensor_arg(),
            running_variance.into_tensor_arg(),
            mean,
            variance,
            next_mean,
            next_variance,
            momentum,
            element,
        );
    }
    outputs
}

impl Norm {
    /// Normalises `[batch, channels, height, width]`, then applies the activation.
    pub(super) fn forward(self, input: CubeTensor) -> CubeTensor {
        let input = permute_nchw_to_nhwc(input);
        let output = empty(&input, input.shape());
        let (client, address) = (input.client.clone(), address(&[&input, &output]));
        let (cubes, cube) = cubes(&client, input.meta.num_elements());
        let (shape, activation) = (sizes_of(&input), self.activation());
        // SAFETY: as in `statistics`.
        #[allow(unsafe_code, reason = "kernels are launched without checks of every access")]
        unsafe {
            kernels::normalize::launch_unchecked(
                &client,
                cubes,
                cube,
                address,
                input.into_tensor_arg(),
                output.clone().into_tensor_arg(),
                self.gamma.into_tensor_arg(),
                self.beta.into_tensor_arg(),
                self.mean.into_tensor_arg(),
                self.variance.into_tensor_arg(),
                shape,
                self.epsilon,
                activation,
                dtype_to_storage_type(output.dtype),
            );
        }
        permute_nhwc_to_nchw(output)
    }

    /// The gradients by an input whose statistics these are, gamma and beta, from that by the output.
    ///
    /// # Source
    /// Ioffe and Szegedy, "Batch normalization", 2015, section 3.
    pub(super) fn backward(self, input: CubeTensor, gradient: CubeTensor) -> NormGradients {
        let [input, gradient] = [input, gradient].map(permute_nchw_to_nhwc);
        let [batch, height, width, channels] = input.shape().dims();
        let (count, per) = pieces(batch * height * width, channels);
        let partial = [(); 2].map(|()| empty(&input, Shape::from([count, channels])));
        let output = empty(&input, input.shape());
        let (client, address) = (input.client.clone(), address(&[&input, &gradient, &output]));
        let (element, activation) = (dtype_to_storage_type(input.dtype), self.activation());
        let (piece_cubes, piece_cube) = cubes(&client, count * channels);
        let (cubes, cube) = cubes(&client, input.meta.num_elements());
        let [by_beta, by_gamma] = partial.clone().map(CubeTensor::into_tensor_arg);
        let Self { gamma, beta, mean, variance, epsilon, .. } = self;
        let norm = [gamma, beta, mean, variance];
        let [gamma, beta, mean, variance] = norm.clone().map(CubeTensor::into_tensor_arg);
        // SAFETY: as in `statistics`.
        #[allow(unsafe_code, reason = "kernels are launched without checks of every access")]
        unsafe {
            kernels::parameter_sums::launch_unchecked(
                &client,
                piece_cubes,
                piece_cube,
                address,
                input.clone().into_tensor_arg(),
                gradient.clone().into_tensor_arg(),
                gamma,
                beta,
                mean,
                variance,
                by_beta,
                by_gamma,
                sizes_of(&input),
                constants([per]),
                epsilon,
                activation,
                element,
            );
        }
        // The gradient by a value needs the sums over the whole batch, so it has a launch of its
        // own.
        let sums = partial.map(|partial| sum_pieces(partial, Shape::from([channels])));
        let [by_beta, by_gamma] = sums.clone().map(CubeTensor::into_tensor_arg);
        let [gamma, beta, mean, variance] = norm.map(CubeTensor::into_tensor_arg);
        let shape = sizes_of(&input);
        // SAFETY: as in `statistics`.
        #[allow(unsafe_code, reason = "kernels are launched without checks of every access")]
        unsafe {
            kernels::value_gradient::launch_unchecked(
                &client,
                cubes,
                cube,
                address,
                input.into_tensor_arg(),
                gradient.into_tensor_arg(),
                gamma,
                beta,
                mean,
                variance,
                by_beta,
                by_gamma,
                output.clone().into_tensor_arg(),
                shape,
                epsilon,
                activation,
                element,
            );
        }
        let [beta, gamma] = sums;
        NormGradients { input: permute_nhwc_to_nchw(output), gamma, beta }
    }

    fn activation(&self) -> u32 {
        match self.activation {
            Activation::Identity => 0,
            Activation::Relu => 1,
            Activation::Relu6 => 2,
        }
    }
}
