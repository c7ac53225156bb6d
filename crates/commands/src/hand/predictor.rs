//! Predictors of hand poses in a precision.

use std::path::Path;

use anyhow::{Result, ensure};
use burn::tensor::Device;
use evpose_infer::Precision;
use evpose_nn::HandRegressor;
use evpose_task::QuantizationRanges;
use evpose_task::hand::NetworkPredictor;

/// Predictor of a checkpoint's network, at the given precision.
///
/// # Errors
/// If the precision is not f32 on a device other than flex, or int8 without ranges from `evpose
/// quantize`.
pub(super) fn predictor(
    checkpoint: &Path,
    network: HandRegressor,
    precision: Precision,
    device: Device,
) -> Result<NetworkPredictor> {
    if precision == Precision::F32 {
        return Ok(NetworkPredictor::new(network, device));
    }
    ensure!(
        device == Device::flex(),
        "--precision {precision} is for our engine, on the device flex"
    );
    let ranges = match precision {
        Precision::Int8 => {
            let quantized =
                QuantizationRanges::read(&QuantizationRanges::path(checkpoint), &network.graph())?;
            Some(quantized.ranges().clone())
        }
        _ => None,
    };
    Ok(NetworkPredictor::compiled(&network, precision, ranges))
}
