//! Layers of networks on GPUs, with their gradients, and steps of Adam.
//!
//! * [`convolution`]: convolutions, by the way that is set; [`columns`]: as matrix products, [`depthwise`]: of
//!   each channel by itself.
//! * [`normalization`]: normalisations with their activation; [`norm`]: what they launch.
//! * [`adam`]: steps of the optimiser.
//! * [`kernels`]: what computes them, [`launch`]: what all are launched with.

pub(crate) mod adam;
mod columns;
mod convolution;
mod depthwise;
mod kernels;
mod launch;
mod norm;
mod normalization;

use std::sync::OnceLock;

use burn::tensor::Device;

use super::Activation;
use columns::Product;

pub(super) use convolution::{forward, suits};
pub(super) use normalization::{normalized, normalizes};

/// How convolutions are computed on GPUs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// As Burn does by default.
    Burn,
    /// Burn's implicit product on matrix units.
    Implicit,
    /// Our columns, and a product.
    Columns(Product),
}

impl Way {
    /// The way that `EVPOSE_GPU_CONVOLUTION` sets, for measurements: `burn`, `implicit` or `columns`;
    /// else our columns in f32.
    fn chosen() -> Self {
        // Every convolution asks, and the environment must not change the way within a run.
        static CHOSEN: OnceLock<Way> = OnceLock::new();
        *CHOSEN.get_or_init(|| {
            let name = std::env::var("EVPOSE_GPU_CONVOLUTION").unwrap_or_default();
            match name.as_str() {
                "implicit" => Self::Implicit,
                "columns" => Self::Columns(Product::Burns),
                "burn" => Self::Burn,
                _ => Self::Columns(Product::F32),
            }
        })
    }
}

fn is_gpu(device: &Device) -> bool {
    let device = device.clone().without_autodiff();
    #[cfg(feature = "ndarray")]
    #[allow(deprecated, reason = "offered until Burn removes it")]
    if device == Device::ndarray() {
        return false;
    }
    device != Device::flex()
}
