//! Devices by name: the CPU always, others where a Cargo feature built them in.

use std::fmt;
use std::str::FromStr;

use burn::tensor::Device;
use serde::{Deserialize, Serialize};

use crate::NnError;

/// A kind of device that networks are computed on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DeviceKind {
    /// Burn's pure-Rust CPU device.
    #[default]
    Flex,
    /// Burn's older CPU device, several times slower, kept for comparison.
    Ndarray,
    /// Any GPU through WebGPU: Vulkan, Metal, DirectX 12.
    Wgpu,
    /// NVIDIA GPUs.
    Cuda,
}

impl DeviceKind {
    /// Every device, built in or not.
    pub const ALL: [Self; 4] = [Self::Flex, Self::Ndarray, Self::Wgpu, Self::Cuda];

    /// The name on the command line, which is also the Cargo feature's.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flex => "flex",
            Self::Ndarray => "ndarray",
            Self::Wgpu => "wgpu",
            Self::Cuda => "cuda",
        }
    }

    /// The device. Training needs its `.autodiff()`.
    ///
    /// # Errors
    /// [`NnError::DeviceNotBuilt`] where this build leaves the device out. Whether the machine
    /// has such a device shows only when it is first used.
    pub fn resolve(self) -> Result<Device, NnError> {
        match self {
            Self::Flex => Ok(Device::flex()),
            #[cfg(feature = "ndarray")]
            #[allow(deprecated, reason = "offered until Burn removes it")]
            Self::Ndarray => Ok(Device::ndarray()),
            #[cfg(feature = "wgpu")]
            Self::Wgpu => Ok(Device::wgpu(burn::tensor::DeviceKind::DefaultDevice)),
            #[cfg(feature = "cuda")]
            Self::Cuda => Ok(Device::cuda(0usize)),
            #[allow(unreachable_patterns, reason = "with every feature on, nothing is left")]
            absent => Err(NnError::DeviceNotBuilt { device: absent.name() }),
        }
    }

    /// The first `count` devices of this kind. The CPU can stand for any number, to try what
    /// several devices do.
    ///
    /// # Errors
    /// As [`resolve`](Self::resolve), and [`NnError::TooFewDevices`] where the machine has fewer.
    pub fn resolve_several(self, count: usize) -> Result<Vec<Device>, NnError> {
        let one = self.resolve()?;
        let mut devices: Vec<Device> = match self {
            Self::Flex | Self::Ndarray => vec![one; count],
            #[cfg(feature = "wgpu")]
            Self::Wgpu => Device::enumerate(burn::tensor::DeviceType::Wgpu).into_vec(),
            #[cfg(feature = "cuda")]
            Self::Cuda => Device::enumerate(burn::tensor::DeviceType::Cuda).into_vec(),
            #[allow(unreachable_patterns, reason = "with every feature on, nothing is left")]
            absent => return Err(NnError::DeviceNotBuilt { device: absent.name() }),
        };
        let available = devices.len();
        if available < count {
            return Err(NnError::TooFewDevices { device: self.name(), available, count });
        }
        devices.truncate(count);
        Ok(devices)
    }
}

impl fmt::Display for DeviceKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for DeviceKind {
    type Err = NnError;

    fn from_str(name: &str) -> Result<Self, NnError> {
        let kind = Self::ALL.into_iter().find(|kind| kind.name() == name);
        kind.ok_or_else(|| NnError::UnknownDevice { name: name.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn every_device_is_found_by_its_own_name() {
        for kind in DeviceKind::ALL {
            assert_eq!(kind.to_string().parse::<DeviceKind>().unwrap(), kind);
        }
    }

    #[test]
    fn flex_is_always_there() {
        assert!(DeviceKind::default().resolve().is_ok());
    }

    #[test]
    fn an_unknown_device_names_the_known_ones() {
        let error = "tpu".parse::<DeviceKind>().unwrap_err().to_string();
        assert_eq!(error, "no device is called `tpu`: choose one of flex, ndarray, wgpu, cuda");
    }

    #[cfg(not(feature = "wgpu"))]
    #[test]
    fn a_device_left_out_names_its_feature() {
        let error = DeviceKind::Wgpu.resolve().unwrap_err().to_string();
        assert_eq!(error, "this build has no wgpu device: rebuild with `--features wgpu`");
    }
}
