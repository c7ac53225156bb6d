//! Warnings about a recording that was read.

use evpose_core::SensorSize;
use evpose_io::{Recording, SensorOrigin, Windows};

use crate::progress::say;

/// Anomalies of a recording: an inferred sensor size, events outside it, remarks.
pub(super) struct Account {
    pub(super) sensor: SensorSize,
    origin: SensorOrigin,
    outside: usize,
    remarks: Vec<String>,
}

impl Account {
    /// Anomalies of a recording that was read to the end in windows.
    pub(super) fn from_windows(windows: &Windows) -> Self {
        Self {
            sensor: windows.sensor(),
            origin: windows.sensor_origin(),
            outside: windows.outside(),
            remarks: windows.remarks(),
        }
    }

    /// Anomalies of a recording that was read at once.
    pub(super) fn from_recording(recording: &Recording) -> Self {
        Self {
            sensor: recording.stream.sensor(),
            origin: recording.sensor_origin,
            outside: recording.outside,
            remarks: recording.remarks.clone(),
        }
    }

    pub(super) fn print(&self) {
        for remark in &self.remarks {
            say(format!("warning   {remark}"));
        }
        if self.origin == SensorOrigin::Inferred {
            say(format!(
                "warning   the file does not state its sensor: {} contains every event; set it with \
                 --sensor",
                self.sensor
            ));
        }
        if self.outside > 0 {
            say(format!("warning   {} events outside the sensor: skipped", self.outside));
        }
    }
}
