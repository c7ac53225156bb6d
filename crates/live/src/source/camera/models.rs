//! Supported cameras.

use evpose_core::SensorSize;
use neuromorphic_drivers::{
    Configuration, Error, GenericDevice, RingConfiguration, centuryarks_vga, inivation_davis346,
    inivation_dvxplorer, lucid_triton, prophesee_evk3_hd, prophesee_evk4,
};

/// A type of camera.
pub(super) struct Model {
    pub(super) name: &'static str,
    pub(super) sensor: SensorSize,
    /// Default biases and settings of the driver.
    pub(super) configuration: fn() -> Configuration,
    /// Ring buffer of transfers; the driver's default where none.
    pub(super) ring: fn() -> Option<RingConfiguration>,
}

macro_rules! model {
    ($name:literal, $driver:ident, $configuration:ident, $ring:expr) => {
        Model {
            name: $name,
            sensor: SensorSize {
                width: $driver::Device::PROPERTIES.width,
                height: $driver::Device::PROPERTIES.height,
            },
            configuration: || {
                Configuration::$configuration($driver::Device::PROPERTIES.default_configuration)
            },
            ring: $ring,
        }
    };
}

/// In the order in which [`super::CameraSource::open`] tries them.
pub(super) const MODELS: &[Model] = &[
    model!("davis346", inivation_davis346, InivationDavis346, ring),
    model!("dvxplorer", inivation_dvxplorer, InivationDvxplorer, ring),
    model!("evk3-hd", prophesee_evk3_hd, PropheseeEvk3Hd, ring),
    model!("evk4", prophesee_evk4, PropheseeEvk4, ring),
    model!("centuryarks-vga", centuryarks_vga, CenturyarksVga, ring),
    // Its packets are those of Ethernet: the ring is the driver's.
    model!("lucid-triton", lucid_triton, LucidTriton, || None),
];

/// 32 MiB of transfers of 128 KiB, 32 of them under way: the driver's own ring has half a gigabyte,
/// whose events would be seconds late.
fn ring() -> Option<RingConfiguration> {
    Some(RingConfiguration {
        buffer_length: 1 << 17,
        ring_length: 1 << 8,
        parallel_submissions: 1 << 5,
    })
}

/// Whether an error only means that no camera of this type is connected.
pub(super) fn is_elsewhere(error: &Error) -> bool {
    matches!(
        error,
        Error::Device(_) | Error::DeviceWithSerial { .. } | Error::Serial(_) | Error::NoDevice
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_has_a_configuration_of_its_own_and_a_ring_that_is_valid() {
        for model in MODELS {
            let kind = (model.configuration)().type_name();
            let same = MODELS.iter().filter(|other| (other.configuration)().type_name() == kind);
            assert_eq!(same.count(), 1, "{kind}");
            assert!((model.ring)().is_none_or(|ring| ring.validate().is_ok()), "{kind}");
            assert!(model.sensor.pixels() >= 346 * 260, "{kind}");
        }
    }
}
