//! Predictors of hand poses in a precision.

use std::path::Path;

use anyhow::Result;
use burn::tensor::Device;
use evpose_infer::Precision;
use evpose_task::hand::{HandCheckpoint, NetworkPredictor};
use evpose_task::{QuantizationRanges, TaskError};

/// Predictor of a checkpoint's network, at the given precision.
///
/// # Errors
/// If the precision is not f32 on a device other than flex, or int8 without ranges from `evpose
/// quantize`.
pub(super) fn predictor(
    path: &Path,
    checkpoint: &HandCheckpoint,
    precision: Precision,
    device: Device,
) -> Result<NetworkPredictor> {
    if precision == Precision::F32 {
        return Ok(checkpoint.predictor(device)?);
    }
    if device != Device::flex() {
        return Err(TaskError::Precision { precision }.into());
    }
    let HandCheckpoint { config, network, .. } = checkpoint;
    let ranges = match precision {
        Precision::Int8 => {
            let quantized =
                QuantizationRanges::read(&QuantizationRanges::path(path), &network.graph())?;
            Some(quantized.ranges().clone())
        }
        _ => None,
    };
    Ok(NetworkPredictor::compiled(config, network, precision, ranges)?)
}
