//! What a representation of a running stream is.

use std::fmt::Debug;

use evpose_core::{EventStream, Micros, SensorSize};

use crate::{ChannelOrder, ReprError};

/// Events in, dense planes out, incrementally. One instance is one stream.
///
/// The planes show the events of the last `length` of their [`StreamWindow`]: those with
/// `now - length < t <= now`, where `now` is the time of the latest event or the latest
/// [`advance`](Self::advance), whichever is later. How the events are cut into pushes does not
/// matter.
pub trait Representation: Debug + Send {
    /// Planes rendered.
    fn channels(&self) -> usize;

    /// Takes events. If they start before the last event pushed, time has jumped back (a recording
    /// looped, a camera restarted): everything before is forgotten.
    ///
    /// # Panics
    /// If they come from a sensor of another size.
    fn push(&mut self, events: &EventStream);

    /// Moves `now` on to `t`; an earlier `t` changes nothing.
    fn advance(&mut self, t: Micros);

    /// Writes the planes, `[channels][height][width]`.
    ///
    /// # Panics
    /// If `out` has another length.
    fn render(&self, out: &mut [f32]);

    /// Forgets every event and the time.
    fn reset(&mut self);
}

/// What the planes of a stream show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamWindow {
    pub(crate) sensor: SensorSize,
    /// At most [`Self::LONGEST`], so that it fits an `i32`.
    pub(crate) length_us: i32,
    pub(crate) order: ChannelOrder,
}

impl StreamWindow {
    /// The longest window, almost 18 minutes.
    pub const LONGEST: Micros = Micros(1 << 30);

    /// Planes of what `sensor` saw during the last `length`.
    ///
    /// # Errors
    /// If the window is empty or longer than [`Self::LONGEST`].
    pub fn new(sensor: SensorSize, length: Micros, order: ChannelOrder) -> Result<Self, ReprError> {
        let length_us = i32::try_from(length.0).ok().filter(|&us| us > 0);
        let length_us = length_us.filter(|&us| i64::from(us) <= Self::LONGEST.0);
        let length_us = length_us.ok_or(ReprError::WindowLength { length })?;
        Ok(Self { sensor, length_us, order })
    }

    pub(crate) fn check(&self, events: &EventStream) {
        assert_eq!(events.sensor(), self.sensor, "events from a sensor of another size");
    }

    /// Position of a pixel of one polarity in planes of two channels.
    pub(crate) fn index(&self, x: u16, y: u16, channel: usize) -> usize {
        let row = channel * usize::from(self.sensor.height) + usize::from(y);
        row * usize::from(self.sensor.width) + usize::from(x)
    }
}
