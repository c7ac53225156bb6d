//! A step of Adam on GPUs, in one pass.

use burn::backend::cubecl::dtype_to_storage_type;
use burn::backend::tensor::FloatTensor;
use burn::backend::{Backend, Cube, Dispatch, TensorMetadata as _, backend_extension};
use burn::tensor::{DType, Tensor};
use burn_cubecl::kernel::into_contiguous;
use burn_cubecl::tensor::CubeTensor;

use super::kernels::adam as kernels;
use super::launch::{address, cubes, empty};
use super::{Way, is_gpu};

/// Settings of a step, named as in the publication.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AdamStep {
    pub(crate) learning_rate: f32,
    pub(crate) weight_decay: f32,
    pub(crate) beta_1: f32,
    pub(crate) beta_2: f32,
    pub(crate) epsilon: f32,
    /// Count of steps with this one.
    pub(crate) time: i32,
}

/// Whether steps of a parameter are computed here.
pub(crate) fn suits<const D: usize>(parameter: &Tensor<D>) -> bool {
    parameter.dtype() == DType::F32 && Way::chosen() != Way::Burn && is_gpu(&parameter.device())
}

/// The parameter and its two moments after a step.
pub(crate) fn step<const D: usize>(
    parameter: Tensor<D>,
    gradient: Tensor<D>,
    moments: [Tensor<D>; 2],
    step: AdamStep,
) -> (Tensor<D>, [Tensor<D>; 2]) {
    let [first, second] = moments.map(Tensor::into_dispatch);
    let (parameter, gradient) = (parameter.into_dispatch(), gradient.into_dispatch());
    let (parameter, first, second) = Dispatch::gpu_adam(parameter, gradient, first, second, step);
    (Tensor::from_dispatch(parameter), [first, second].map(Tensor::from_dispatch))
}

#[backend_extension(Cube)]
trait GpuAdam: Backend {
    fn gpu_adam(
        parameter: FloatTensor<Self>,
        gradient: FloatTensor<Self>,
        first: FloatTensor<Self>,
        second: FloatTensor<Self>,
        step: AdamStep,
    ) -> (FloatTensor<Self>, FloatTensor<Self>, FloatTensor<Self>);
}

impl GpuAdam for Cube {
    fn gpu_adam(
        parameter: FloatTensor<Self>,
        gradient: FloatTensor<Self>,
        first: FloatTensor<Self>,
        second: FloatTensor<Self>,
        step: AdamStep,
    ) -> (FloatTensor<Self>, FloatTensor<Self>, FloatTensor<Self>) {
        // Gradients of weights come with exchanged axes.
        let inputs = [parameter, gradient, first, second].map(into_contiguous);
        let [parameter, ..] = &inputs;
        let [next, first, second] = [(); 3].map(|()| empty(parameter, parameter.shape()));
        let (client, address) = (parameter.client.clone(), address(&[parameter]));
        let (cubes, cube) = cubes(&client, parameter.meta.num_elements());
        let element = dtype_to_storage_type(parameter.dtype);
        let [value, gradient, old_first, old_second] = inputs.map(CubeTensor::into_tensor_arg);
        // SAFETY: the kernel checks its position; all tensors are of one shape.
        #[allow(unsafe_code, reason = "kernels are launched without checks of every access")]
        unsafe {
            kernels::adam::launch_unchecked(
                &client,
                cubes,
                cube,
                address,
                value,
                gradient,
                old_first,
                old_second,
                next.clone().into_tensor_arg(),
                first.clone().into_tensor_arg(),
                second.clone().into_tensor_arg(),
                step.learning_rate,
                step.weight_decay,
                step.beta_1,
                step.beta_2,
                // Powers are computed once here, not by every thread.
                1.0 - step.beta_1.powi(step.time),
                (1.0 - step.beta_2.powi(step.time)).sqrt(),
                step.epsilon,
                element,
            );
        }
        (next, first, second)
    }
}
