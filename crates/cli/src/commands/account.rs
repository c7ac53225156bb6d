//! Warnings about a recording that was read.

use evpose_core::{Rejected, SensorSize};
use evpose_io::{Recording, SensorOrigin, Windows};

use crate::progress::say;

/// Anomalies of a recording: an inferred sensor size, rejected and reordered events, remarks.
pub(super) struct Account {
    pub(super) sensor: SensorSize,
    origin: SensorOrigin,
    rejected: Rejected,
    sorted: usize,
    remarks: Vec<String>,
}

impl Account {
    /// Anomalies of a recording that was read to the end in windows.
    pub(super) fn from_windows(windows: &Windows) -> Self {
        Self {
            sensor: windows.sensor(),
            origin: windows.sensor_origin(),
            rejected: windows.rejected(),
            sorted: 0,
            remarks: windows.remarks(),
        }
    }

    /// Anomalies of a recording that was read at once.
    pub(super) fn from_recording(recording: &Recording) -> Self {
        Self {
            sensor: recording.stream.sensor(),
            origin: recording.sensor_origin,
            rejected: recording.rejected,
            sorted: recording.sorted,
            remarks: recording.remarks.clone(),
        }
    }

    /// Prints the warnings.
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
        let Rejected { outside_sensor, out_of_order } = self.rejected;
        for (count, anomaly) in [
            (outside_sensor, "outside the sensor: skipped"),
            (out_of_order, "out of order: skipped"),
            (self.sorted, "out of order: sorted"),
        ] {
            if count > 0 {
                say(format!("warning   {count} events {anomaly}"));
            }
        }
    }
}
