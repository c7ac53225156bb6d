//! Devices by name: the CPU always, others where a Cargo feature built them in.
//!
//! * [`DeviceKind`]: a device as it is named, and the device of Burn.
//! * [`Availability`]: the adapters of a kind on this machine, or why there are none.

mod availability;
#[cfg(any(feature = "wgpu", feature = "cuda"))]
mod drivers;
#[cfg(feature = "wgpu")]
mod wgpu_adapters;

use std::fmt;
use std::str::FromStr;

use burn::tensor::Device;

use crate::NnError;

pub use availability::{Adapter, Availability};

/// A kind of device that networks are computed on, and for GPUs which of them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum DeviceKind {
    /// Burn's pure-Rust CPU device.
    #[default]
    Flex,
    /// Burn's older CPU device, several times slower, kept for comparison.
    Ndarray,
    /// Any GPU through WebGPU: Vulkan, Metal, DirectX 12.
    Wgpu {
        /// Index of the adapter among those of [`Availability`], from 0; if none, the one that wgpu
        /// prefers: the fastest GPU.
        adapter: Option<usize>,
    },
    /// NVIDIA GPUs.
    Cuda {
        /// Index of the GPU, from 0; the first if none.
        adapter: Option<usize>,
    },
}

impl DeviceKind {
    /// Every kind, built in or not, with the default adapter.
    pub const ALL: [Self; 4] =
        [Self::Flex, Self::Ndarray, Self::Wgpu { adapter: None }, Self::Cuda { adapter: None }];

    /// The name of the kind on the command line, which is also the Cargo feature's.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flex => "flex",
            Self::Ndarray => "ndarray",
            Self::Wgpu { .. } => "wgpu",
            Self::Cuda { .. } => "cuda",
        }
    }

    /// Index of the adapter, if one is chosen.
    pub fn adapter(self) -> Option<usize> {
        match self {
            Self::Flex | Self::Ndarray => None,
            Self::Wgpu { adapter } | Self::Cuda { adapter } => adapter,
        }
    }

    /// The device. Training needs its `.autodiff()`.
    ///
    /// # Errors
    /// [`NnError::DeviceNotBuilt`] where this build leaves the device out,
    /// [`NnError::DeviceMissing`] where the machine has none, and [`NnError::NoAdapter`] where it
    /// has fewer than the index asks for.
    pub fn resolve(self) -> Result<Device, NnError> {
        self.checked(1)?;
        match self {
            Self::Flex => Ok(Device::flex()),
            #[cfg(feature = "ndarray")]
            #[allow(deprecated, reason = "offered until Burn removes it")]
            Self::Ndarray => Ok(Device::ndarray()),
            #[cfg(feature = "wgpu")]
            Self::Wgpu { adapter: None } => {
                Ok(Device::wgpu(burn::tensor::DeviceKind::DefaultDevice))
            }
            #[cfg(feature = "cuda")]
            Self::Cuda { adapter: None } => Ok(Device::cuda(0usize)),
            // One of several.
            #[allow(unreachable_patterns, reason = "without devices of several adapters")]
            chosen => {
                let device = chosen.chosen_and_later().into_iter().next();
                device
                    .ok_or_else(|| NnError::NoAdapter { device: chosen.to_string(), available: 0 })
            }
        }
    }

    /// `count` devices of this kind, from the chosen adapter on. The CPU can stand for any number,
    /// to try what several devices do.
    ///
    /// # Errors
    /// As [`resolve`](Self::resolve), and [`NnError::TooFewDevices`] where the machine has fewer.
    pub fn resolve_several(self, count: usize) -> Result<Vec<Device>, NnError> {
        self.checked(count)?;
        match self {
            Self::Flex | Self::Ndarray => Ok(vec![self.resolve()?; count]),
            _ => Ok(self.chosen_and_later().into_iter().take(count).collect()),
        }
    }

    /// Checks that the machine has `count` devices from the chosen adapter on: Burn panics at the
    /// first operation on a device that is not there.
    fn checked(self, count: usize) -> Result<(), NnError> {
        let available = match Availability::of(self) {
            Availability::NotBuilt => {
                return Err(NnError::DeviceNotBuilt { device: self.name() });
            }
            Availability::Missing { reason } => {
                return Err(NnError::DeviceMissing { device: self.name(), reason });
            }
            Availability::Adapters(adapters) => adapters.len(),
        };
        let first = self.adapter().unwrap_or(0);
        if first >= available {
            return Err(NnError::NoAdapter { device: self.to_string(), available });
        }
        // The CPU is one device, however many are asked for: they share it.
        let has_several = !matches!(self, Self::Flex | Self::Ndarray);
        if has_several && available - first < count {
            let available = available - first;
            return Err(NnError::TooFewDevices { device: self.name(), available, count });
        }
        Ok(())
    }

    /// The devices of this kind from the chosen adapter on, in the order of [`Availability`].
    fn chosen_and_later(self) -> Vec<Device> {
        let devices: Vec<Device> = match self {
            #[cfg(feature = "wgpu")]
            Self::Wgpu { .. } => Device::enumerate(burn::tensor::DeviceType::Wgpu).into_vec(),
            #[cfg(feature = "cuda")]
            Self::Cuda { .. } => Device::enumerate(burn::tensor::DeviceType::Cuda).into_vec(),
            _ => Vec::new(),
        };
        devices.into_iter().skip(self.adapter().unwrap_or(0)).collect()
    }
}

/// The name of the hardware behind a GPU's device, which is opened for it; none on the CPU.
#[cfg(any(feature = "wgpu", feature = "cuda"))]
pub fn adapter_name(device: &Device) -> Option<String> {
    device.clone().without_autodiff().identity().map(|identity| identity.name)
}

/// The name of the hardware behind a GPU's device; none on the CPU, the only one of this build.
#[cfg(not(any(feature = "wgpu", feature = "cuda")))]
pub fn adapter_name(_: &Device) -> Option<String> {
    None
}

impl fmt::Display for DeviceKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())?;
        self.adapter().map_or(Ok(()), |index| write!(f, ":{index}"))
    }
}

impl FromStr for DeviceKind {
    type Err = NnError;

    /// A name, and for GPUs an adapter: `wgpu`, `wgpu:1`.
    fn from_str(text: &str) -> Result<Self, NnError> {
        let unknown = || NnError::UnknownDevice { name: text.to_owned() };
        let (name, index) = match text.split_once(':') {
            None => (text, None),
            Some((name, index)) => (name, Some(index.parse().map_err(|_| unknown())?)),
        };
        let kind = Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(unknown)?;
        match (kind, index) {
            (kind, None) => Ok(kind),
            (Self::Wgpu { .. }, adapter) => Ok(Self::Wgpu { adapter }),
            (Self::Cuda { .. }, adapter) => Ok(Self::Cuda { adapter }),
            // The CPU is one device: an index of it is a mistake that should not pass unnoticed.
            (Self::Flex | Self::Ndarray, Some(_)) => Err(unknown()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_device_is_found_by_its_own_name() {
        let chosen = [DeviceKind::Wgpu { adapter: Some(1) }, DeviceKind::Cuda { adapter: Some(0) }];
        for kind in DeviceKind::ALL.into_iter().chain(chosen) {
            assert_eq!(kind.to_string().parse::<DeviceKind>().unwrap(), kind);
        }
    }

    #[test]
    fn flex_is_always_there() {
        assert!(DeviceKind::default().resolve().is_ok());
        assert_eq!(DeviceKind::Flex.resolve_several(3).unwrap().len(), 3);
    }

    #[test]
    fn an_unknown_device_names_the_known_ones() {
        for name in ["tpu", "wgpu:x", "wgpu:-1", "flex:0"] {
            let error = name.parse::<DeviceKind>().unwrap_err().to_string();
            let known = "choose one of flex, ndarray, wgpu, cuda, or of several GPUs wgpu:1";
            assert!(
                error.starts_with(&format!("no device is called `{name}`: {known}")),
                "{error}"
            );
        }
    }

    #[cfg(not(feature = "wgpu"))]
    #[test]
    fn a_device_left_out_names_its_feature() {
        let error = DeviceKind::Wgpu { adapter: None }.resolve().unwrap_err().to_string();
        assert_eq!(error, "this build has no wgpu device: rebuild with `--features wgpu`");
    }

    #[cfg(feature = "wgpu")]
    #[test]
    fn an_adapter_that_is_not_there_is_an_error() {
        let error = DeviceKind::Wgpu { adapter: Some(99) }.resolve().unwrap_err().to_string();
        let is_said =
            ["no device wgpu:99", "no wgpu device"].iter().any(|what| error.contains(what));
        assert!(is_said, "{error}");
    }
}
