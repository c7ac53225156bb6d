//! The devices of this machine, by kind, or why there are none.

use super::DeviceKind;

/// A device of this machine that networks can be computed on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Adapter {
    /// Name that the driver states.
    pub name: String,
    /// Its type, the API that it is reached by and its driver.
    pub details: String,
}

/// The adapters of a kind of device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Availability {
    /// This build leaves the kind out.
    NotBuilt,
    /// This machine has none.
    Missing {
        /// The missing part, and the remedy.
        reason: String,
    },
    /// At least one, in the order of the indices of [`DeviceKind`].
    Adapters(Vec<Adapter>),
}

impl Availability {
    /// The adapters of a kind of device; drivers are asked, no device is opened.
    pub fn of(kind: DeviceKind) -> Self {
        match kind {
            DeviceKind::Flex => Self::cpu("our engine and kernels, and Burn's flex"),
            DeviceKind::Ndarray if cfg!(feature = "ndarray") => Self::cpu("Burn's ndarray"),
            #[cfg(feature = "wgpu")]
            DeviceKind::Wgpu { .. } => super::wgpu_adapters::availability(),
            #[cfg(feature = "cuda")]
            DeviceKind::Cuda { .. } => cuda(),
            #[allow(unreachable_patterns, reason = "with every feature on, nothing is left")]
            _ => Self::NotBuilt,
        }
    }

    fn cpu(details: &str) -> Self {
        let name = "this machine's CPU".to_owned();
        Self::Adapters(vec![Adapter { name, details: details.to_owned() }])
    }
}

/// NVIDIA's GPUs. Burn's enumeration loads the driver, and panics without it.
#[cfg(feature = "cuda")]
fn cuda() -> Availability {
    use burn::tensor::{Device, DeviceType};

    const DRIVER: &str = "libcuda.so.1";
    if cfg!(target_os = "linux") && !super::drivers::has_library(DRIVER) {
        let reason = format!("no {DRIVER}: install NVIDIA's driver");
        return Availability::Missing { reason };
    }
    // Safe only now that the driver is there.
    let count = Device::enumerate(DeviceType::Cuda).into_vec().len();
    if count == 0 {
        return Availability::Missing { reason: "NVIDIA's driver reports no GPU".to_owned() };
    }
    let adapter = |index| Adapter {
        name: format!("NVIDIA GPU {index}"),
        details: "CUDA; `nvidia-smi` describes it".to_owned(),
    };
    Availability::Adapters((0..count).map(adapter).collect())
}
