//! USB and Ethernet cameras, without vendor software.
//!
//! This file is a thin layer over the driver; `bytes` decodes the transfers and is tested without a
//! device. **Untested on hardware.**

mod bytes;
mod models;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use evpose_core::SensorSize;
use evpose_io::Columns;
use neuromorphic_drivers::adapters::Adapter;
use neuromorphic_drivers::{
    Device, Error, Flag, Identifier, UsbEventLoop, UsbOverflow, flag_and_event_loop,
};

use super::Source;
use crate::LiveError;
use models::{MODELS, Model};

/// Interval at which a waiting reader checks for a stop request and for a disconnected device.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Hint for a camera that is connected but cannot be opened.
const ACCESS: &str = "on Linux, a rule of udev must let the user open it, see docs/guide/live.md";

/// A camera.
pub struct CameraSource {
    name: String,
    sensor: SensorSize,
    device: Device,
    adapter: Adapter,
    flag: Flag<Error, UsbOverflow>,
    /// Drives the transfers; dropped after the device.
    _transfers: Arc<UsbEventLoop>,
    is_stopped: Arc<AtomicBool>,
}

impl CameraSource {
    /// Opens the first camera found, of any type, or of the type or serial number `which`.
    ///
    /// # Errors
    /// If there is none, or it cannot be opened.
    pub fn open(which: Option<&str>) -> Result<Self, LiveError> {
        let failed = |reason: String| LiveError::Source { name: "camera".to_owned(), reason };
        // A name of a type comes before a serial number.
        let model = MODELS.iter().find(|model| Some(model.name) == which);
        let (identifier, models) = match (which, model) {
            (_, Some(model)) => (Identifier::None, std::slice::from_ref(model)),
            (Some(serial), None) => (Identifier::Serial(serial), MODELS),
            (None, None) => (Identifier::None, MODELS),
        };
        let (flag, transfers) = flag_and_event_loop().map_err(|e| failed(format!("USB: {e}")))?;
        for model in models {
            let Model { configuration, ring, .. } = model;
            let opened = neuromorphic_drivers::open(
                identifier,
                Some(configuration()),
                ring(),
                transfers.clone(),
                flag.clone(),
            );
            match opened {
                Ok(device) => return Ok(Self::new(device, model, flag, transfers)),
                // No camera of this model: another one may be connected.
                Err(error) if models::is_elsewhere(&error) => {}
                Err(error) => return Err(failed(format!("{}: {error}; {ACCESS}", model.name))),
            }
        }
        let names = MODELS.iter().map(|model| model.name).collect::<Vec<_>>().join(", ");
        Err(failed(match which {
            None => format!("none is connected of those that are known: {names}"),
            Some(which) => format!("no `{which}` is connected; types are {names}"),
        }))
    }

    fn new(
        device: Device,
        model: &Model,
        flag: Flag<Error, UsbOverflow>,
        transfers: Arc<UsbEventLoop>,
    ) -> Self {
        Self {
            name: format!("{} {}", device.name(), device.serial()),
            sensor: model.sensor,
            adapter: device.create_adapter(),
            device,
            flag,
            _transfers: transfers,
            is_stopped: Arc::default(),
        }
    }
}

impl Source for CameraSource {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn sensor(&self) -> SensorSize {
        self.sensor
    }

    fn next(&mut self, columns: &mut Columns) -> Result<Option<Instant>, LiveError> {
        let before = columns.len();
        while !self.is_stopped.load(Ordering::Relaxed) {
            self.flag.load_error().map_err(|error| LiveError::Source {
                name: self.name.clone(),
                reason: error.to_string(),
            })?;
            // The wait is short, so that a stop is noticed while the camera sends nothing.
            let Some(buffer) = self.device.next_with_timeout(&POLL_INTERVAL) else { continue };
            bytes::decode(&mut self.adapter, buffer.slice, columns);
            // Buffers without events, of motion sensors for example, are no packets.
            if columns.len() > before {
                return Ok(Some(buffer.instant));
            }
        }
        Ok(None)
    }

    fn lost(&self) -> u64 {
        self.device.dropped_packets()
    }

    fn waker(&self) -> Option<Box<dyn Fn() + Send + Sync>> {
        let is_stopped = self.is_stopped.clone();
        Some(Box::new(move || is_stopped.store(true, Ordering::Relaxed)))
    }
}

#[cfg(test)]
mod tests;
