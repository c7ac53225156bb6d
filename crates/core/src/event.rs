//! One event, its polarity, and the size of the sensor it came from.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::Micros;

/// Direction of the brightness change. The only definition of polarity in the project: file
/// formats and representations convert to and from it explicitly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[repr(u8)]
pub enum Polarity {
    /// Brightness went down.
    Off = 0,
    /// Brightness went up.
    On = 1,
}

impl Polarity {
    /// `true` is ON, the convention of every vendor format.
    pub fn from_on(on: bool) -> Self {
        if on { Self::On } else { Self::Off }
    }

    /// Whether brightness went up.
    pub fn is_on(self) -> bool {
        self == Self::On
    }

    /// The other polarity.
    pub fn flipped(self) -> Self {
        Self::from_on(!self.is_on())
    }
}

/// One brightness change at one pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Event {
    /// Time stamp in microseconds since the start of the recording.
    pub t: Micros,
    /// Column, 0 at the left.
    pub x: u16,
    /// Row, 0 at the top.
    pub y: u16,
    /// Direction of the change.
    pub polarity: Polarity,
}

/// Width and height of a sensor in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorSize {
    /// Number of columns.
    pub width: u16,
    /// Number of rows.
    pub height: u16,
}

impl SensorSize {
    /// The DAVIS240C of EventHands.
    pub const DAVIS240C: Self = Self { width: 240, height: 180 };

    /// Number of pixels.
    pub fn pixels(self) -> usize {
        usize::from(self.width) * usize::from(self.height)
    }

    /// Whether a pixel lies on the sensor.
    pub fn contains(self, x: u16, y: u16) -> bool {
        x < self.width && y < self.height
    }
}

impl fmt::Display for SensorSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}
