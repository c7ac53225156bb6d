//! Bilinear upsampling on devices where Burn cannot differentiate it.

use burn::tensor::module::interpolate;
use burn::tensor::ops::{InterpolateMode, InterpolateOptions};
use burn::tensor::{Device, Tensor, TensorData};

/// Twice as many rows and columns by bilinear interpolation without aligned corners.
///
/// Burn 0.22.1 panics at its gradient on GPUs ("Bilinear interpolation backward is not supported by
/// JIT backend"), so training there takes two matrix products.
///
/// # Shapes
/// - input: `[batch, channels, height, width]`
/// - output: `[batch, channels, 2 height, 2 width]`
pub(crate) fn upsample(input: Tensor<4>) -> Tensor<4> {
    let device = input.device();
    if device.is_autodiff() && device != Device::flex() {
        return upsample_by_products(input);
    }
    let [_, _, height, width] = input.dims();
    let options = InterpolateOptions::new(InterpolateMode::Bilinear)
        .with_align_corners(false)
        .with_output_size([2 * height, 2 * width]);
    interpolate(input, options)
}

/// The same as products with the weights of rows and of columns.
fn upsample_by_products(input: Tensor<4>) -> Tensor<4> {
    let ([_, _, height, width], device) = (input.dims(), input.device());
    let format = input.dtype();
    let [rows, columns] = [height, width].map(|length| weights(length, &device).cast(format));
    rows.matmul(input).matmul(columns.swap_dims(2, 3))
}

/// Weights of `length` values in twice as many, `[1, 1, 2 length, length]`: three quarters of the
/// nearest value and a quarter of the next one on the other side, the outermost repeated.
fn weights(length: usize, device: &Device) -> Tensor<4> {
    let mut values = vec![0.0f32; 2 * length * length];
    for (out, row) in values.chunks_exact_mut(length).enumerate() {
        let nearest = out / 2;
        let next = if out % 2 == 0 { nearest.saturating_sub(1) } else { nearest + 1 };
        // Centres of output cells lie a quarter of an input cell off: weights 3/4 and 1/4.
        row[nearest] += 0.75;
        row[next.min(length - 1)] += 0.25;
    }
    Tensor::from_data(TensorData::new(values, [1, 1, 2 * length, length]), device)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_upsample_and_pass_gradients_as_burns_interpolation() {
        let device = Device::flex().autodiff();
        let count = 2 * 3 * 4 * 5;
        let values: Vec<f32> = (0..count).map(|i| (i * i % 23) as f32).collect();
        let both = [upsample, upsample_by_products].map(|upsample| {
            let data = TensorData::new(values.clone(), [2, 3, 4, 5]);
            let input = Tensor::<4>::from_data(data, &device).require_grad();
            let output = upsample(input.clone());
            // A plain sum would have the same gradient whatever the output is.
            let gradients = output.clone().square().sum().backward();
            let gradient = input.grad(&gradients).unwrap();
            [output.into_data(), gradient.into_data()]
                .map(|data| data.iter::<f32>().collect::<Vec<f32>>())
        });
        for (burns, ours) in both[0].iter().zip(&both[1]) {
            assert_eq!(burns.len(), ours.len());
            let is_near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-4 * a.abs().max(1.0);
            assert!(burns.iter().zip(ours).all(is_near), "{burns:?}, {ours:?}");
        }
    }
}
