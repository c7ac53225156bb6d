//! Weights quantised to int8, symmetrically and per output channel.

use super::image::QuantizationParams;

/// Largest magnitude of a quantised weight: symmetric, so -128 is not used.
const MAX_INT8: f32 = 127.0;

/// Quantised weights, with the scale and bias that turn integer sums into values.
///
/// # Model
/// An input byte `q` means `(q - z) s`, a weight `w` of output channel `k` means `w s_k`. The sum
/// over the taps is `s s_k (Σ q w - z Σ w)`. The first sum is computed in integers; the second is
/// constant and goes into the bias.
///
/// # Source
/// Jacob et al.: *Quantization and Training of Neural Networks for Efficient
/// Integer-Arithmetic-Only Inference*, CVPR 2018, Sec. 2.
pub(super) struct QuantizedWeights {
    /// In the order of the weights.
    pub(super) weight: Vec<i8>,
    /// `s s_k` of every output channel.
    pub(super) scales: Vec<f32>,
    /// The bias of every output channel, less `s s_k z Σ w`.
    pub(super) bias: Vec<f32>,
}

impl QuantizedWeights {
    /// Quantises `weight`, `[outputs][taps]`, for inputs with parameters `input`.
    pub(super) fn new(weight: &[f32], bias: &[f32], input: QuantizationParams) -> Self {
        let mut quantized = Self { weight: Vec::new(), scales: Vec::new(), bias: Vec::new() };
        let taps = weight.len() / bias.len();
        for (weight, bias) in weight.chunks(taps).zip(bias) {
            let max_abs = weight.iter().fold(0.0_f32, |max, value| max.max(value.abs()));
            // Weights that are all 0 are exact at any scale.
            let weight_scale = if max_abs > 0.0 { max_abs / MAX_INT8 } else { 1.0 };
            let first = quantized.weight.len();
            quantized
                .weight
                .extend(weight.iter().map(|value| (value / weight_scale).round() as i8));
            let sum: i64 = quantized.weight[first..].iter().map(|byte| i64::from(*byte)).sum();
            let scale = f64::from(input.scale) * f64::from(weight_scale);
            quantized.scales.push(scale as f32);
            let shift = scale * f64::from(input.zero_point) * sum as f64;
            quantized.bias.push((f64::from(*bias) - shift) as f32);
        }
        quantized
    }
}
