//! A window of frames of 1 ms, and the planes it is drawn into.

use evpose_core::{Polarity, SensorSize};

use crate::ChannelOrder;

/// An event of a window of frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameEvent {
    /// Frame, counted from the first of the window.
    pub frame: u32,
    /// Column, 0 at the left.
    pub x: u16,
    /// Row, 0 at the top.
    pub y: u16,
    /// Direction of the change.
    pub polarity: Polarity,
}

/// Consecutive frames that are drawn into one set of planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameWindow {
    /// The sensor the events come from.
    pub sensor: SensorSize,
    /// Number of frames.
    pub frames: u32,
    /// Events of earlier frames are not drawn: the scene or the sensor changed before this one.
    pub visible_from: u32,
    /// Order of the polarity channels.
    pub order: ChannelOrder,
}

impl FrameWindow {
    /// A window all of whose frames are drawn.
    pub fn new(sensor: SensorSize, frames: u32, order: ChannelOrder) -> Self {
        Self { sensor, frames, visible_from: 0, order }
    }

    /// Whether the events of a frame are drawn.
    pub(crate) fn shows(&self, frame: u32) -> bool {
        // One comparison: frames before the first visible one wrap to large numbers.
        frame.wrapping_sub(self.visible_from) < self.frames.saturating_sub(self.visible_from)
    }

    /// Takes `out` as cleared planes.
    pub(crate) fn planes<'a, const CHANNELS: usize>(
        &self,
        out: &'a mut [f32],
    ) -> Planes<'a, CHANNELS> {
        assert_eq!(out.len(), CHANNELS * self.sensor.pixels(), "planes of another size");
        out.fill(0.0);
        Planes {
            values: out,
            width: self.sensor.width,
            height: self.sensor.height,
            off_channel: self.order.channel(Polarity::Off),
        }
    }
}

/// Planes that are being drawn into.
pub(crate) struct Planes<'a, const CHANNELS: usize> {
    pub(crate) values: &'a mut [f32],
    width: u16,
    height: u16,
    off_channel: usize,
}

impl<const CHANNELS: usize> Planes<'_, CHANNELS> {
    /// Position of an event's pixel. Takes the event by value: the loops over events are several
    /// times slower when it has an address.
    pub(crate) fn index(&self, event: FrameEvent) -> usize {
        let FrameEvent { x, y, polarity, .. } = event;
        if x >= self.width || y >= self.height {
            outside(x, y);
        }
        // Without a second channel both polarities share the first.
        let channel = (polarity as usize ^ self.off_channel) % CHANNELS;
        let row = channel * usize::from(self.height) + usize::from(y);
        row * usize::from(self.width) + usize::from(x)
    }
}

#[cold]
fn outside(x: u16, y: u16) -> ! {
    panic!("an event at ({x}, {y}) lies outside the sensor of its window")
}
