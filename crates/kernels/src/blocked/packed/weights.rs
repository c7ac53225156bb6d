//! Weights of eight bits.

use super::image::Scale;

/// Weights in steps of their own for each output, and what whole sums become.
///
/// # Model
/// A byte `q` stands for `(q - z) s`, a weight `w` of output `k` for `w s_k`: the sum over the taps is
/// `s s_k (Σ q w - z Σ w)`. The first sum is made in whole numbers; the second is known beforehand and goes
/// into the offset.
pub(super) struct Bytes {
    /// As the weights were.
    pub(super) weight: Vec<i8>,
    /// `s s_k` of every output.
    pub(super) factors: Vec<f32>,
    /// The bias of every output, less `s s_k z Σ w`.
    pub(super) offsets: Vec<f32>,
}

impl Bytes {
    /// Of `[outputs][taps]`, for inputs of a scale.
    pub(super) fn new(weight: &[f32], bias: &[f32], Scale { step, zero }: Scale) -> Self {
        let mut bytes = Self { weight: Vec::new(), factors: Vec::new(), offsets: Vec::new() };
        let of_output = weight.len() / bias.len();
        for (weight, bias) in weight.chunks(of_output).zip(bias) {
            let largest = weight.iter().fold(0.0_f32, |most, value| most.max(value.abs()));
            // Any step will do for weights that are all 0.
            let of_weight = if largest > 0.0 { largest / 127.0 } else { 1.0 };
            let first = bytes.weight.len();
            bytes.weight.extend(weight.iter().map(|value| (value / of_weight).round() as i8));
            let sum: i64 = bytes.weight[first..].iter().map(|byte| i64::from(*byte)).sum();
            let factor = f64::from(step) * f64::from(of_weight);
            bytes.factors.push(factor as f32);
            let shift = factor * f64::from(zero) * sum as f64;
            bytes.offsets.push((f64::from(*bias) - shift) as f32);
        }
        bytes
    }
}
