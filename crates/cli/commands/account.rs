//! Warnings about a recording that was read.

use evpose_core::{Rejected, SensorSize};
use evpose_io::{Recording, SensorOrigin, Windows};

use evpose_app::progress::say;

/// Anomalies of a recording: an inferred sensor size, rejected and reordered events, remarks.
pub(super) struct Account {
    pub(super) sensor: SensorSize,
    origin: SensorOrigin,
    rejected: Rejected,
    sorted: usize,
    remarks: Vec<String>,
}

impl Account {
    /// Of a recording that was read to the end.
    pub(super) fn of_windows(windows: &Windows) -> Self {
        Self {
            sensor: windows.sensor(),
            origin: windows.sensor_origin(),
            rejected: windows.rejected(),
            sorted: 0,
            remarks: windows.remarks(),
        }
    }

    /// Of a recording that was read whole.
    pub(super) fn of_whole(recording: &Recording) -> Self {
        Self {
            sensor: recording.stream.sensor(),
            origin: recording.sensor_origin,
            rejected: recording.rejected,
            sorted: recording.sorted,
            remarks: recording.remarks.clone(),
        }
    }

    /// Says it, if there is anything.
    pub(super) fn say(&self) {
        for remark in &self.remarks {
            say(format!("warning   {remark}"));
        }
        if self.origin == SensorOrigin::Inferred {
            say(format!(
                "warning   the file does not state its sensor: {} holds every event; --sensor says \
                 what it was",
                self.sensor
            ));
        }
        let Rejected { outside_sensor, out_of_order } = self.rejected;
        for (count, what) in [
            (outside_sensor, "lie outside the sensor: left out"),
            (out_of_order, "stand behind later ones: left out"),
            (self.sorted, "stood behind later ones: put where they belong"),
        ] {
            if count > 0 {
                say(format!("warning   {count} events {what}"));
            }
        }
    }
}
