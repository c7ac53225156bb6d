//! The trait of a representation of a running stream.

use std::fmt::Debug;

use evpose_core::{EventStream, Micros, Polarity, SensorSize};

use crate::{ChannelOrder, FrameWindow, Grey, ReprError};

/// Events in, dense planes out, incrementally. One instance is one stream.
///
/// The planes show the events of the last `length` of their [`StreamWindow`]: those with
/// `now - length < t <= now`, where `now` is the time of the latest event or the latest
/// [`advance`](Self::advance), whichever is later. Representations with a memory of their own
/// ([`Memory`](crate::Memory)) take no notice of `length`. How the events are cut into pushes does
/// not matter.
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

    /// Writes the planes, `[channels][height][width]`. Planes in a vector of their own become a
    /// tensor without a copy: Burn's `TensorData::new` takes its memory over.
    ///
    /// # Panics
    /// If `out` has another length.
    fn render(&self, out: &mut [f32]);

    /// Mapping of its values to 8 bits.
    fn grey(&self) -> Grey;

    /// Writes the planes as [`grey`](Self::grey) values, for the eye and for filters of 8 bits.
    ///
    /// # Panics
    /// If `out` has another length.
    fn render_u8(&self, out: &mut [u8]) {
        let mut planes = vec![0.0; out.len()];
        self.render(&mut planes);
        self.grey().write(&planes, out);
    }

    /// Forgets every event and the time.
    fn reset(&mut self);
}

/// Sensor, length and channel order of the planes of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamWindow {
    pub(crate) sensor: SensorSize,
    /// At most [`Self::MAX_LENGTH`], so that it fits an `i32`.
    pub(crate) length_us: i32,
    pub(crate) order: ChannelOrder,
}

impl StreamWindow {
    /// The longest window, almost 18 minutes.
    pub const MAX_LENGTH: Micros = Micros(1 << 30);

    /// Planes of what `sensor` saw during the last `length`.
    ///
    /// # Errors
    /// If the window is empty or longer than [`Self::MAX_LENGTH`].
    ///
    /// # Panics
    /// If the sensor has 2³¹ pixels or more.
    pub fn new(sensor: SensorSize, length: Micros, order: ChannelOrder) -> Result<Self, ReprError> {
        assert!(sensor.pixels() < 1 << 31, "a sensor of {sensor}");
        let length_us = i32::try_from(length.0).ok().filter(|&us| us > 0);
        let length_us = length_us.filter(|&us| i64::from(us) <= Self::MAX_LENGTH.0);
        let length_us = length_us.ok_or(ReprError::WindowLength { length })?;
        Ok(Self { sensor, length_us, order })
    }

    /// Size of the sensor.
    pub fn sensor(&self) -> SensorSize {
        self.sensor
    }

    /// Length of the window.
    pub fn length(&self) -> Micros {
        Micros(self.length_us.into())
    }

    /// Order of the polarity channels.
    pub fn order(&self) -> ChannelOrder {
        self.order
    }

    /// The window of a stream that shows the same as a window of frames of 1 ms.
    pub(crate) fn of_frames(window: &FrameWindow) -> Self {
        let length_us = i64::from(window.frames) * Micros::MILLISECOND.0;
        // A window without frames shows nothing, whatever its length.
        let length_us = length_us.clamp(1, Self::MAX_LENGTH.0) as i32;
        Self { sensor: window.sensor, length_us, order: window.order }
    }

    pub(crate) fn check(&self, events: &EventStream) {
        assert_eq!(events.sensor(), self.sensor, "events from a sensor of another size");
    }

    /// The same planes of the longest window that there is.
    pub(crate) fn longest(self) -> Self {
        Self { length_us: Self::MAX_LENGTH.0 as i32, ..self }
    }

    /// The same planes with OFF first.
    pub(crate) fn off_first(self) -> Self {
        Self { order: ChannelOrder::OffFirst, ..self }
    }

    /// Times and positions in planes of two channels of the events from number `first` on.
    #[inline(always)]
    pub(crate) fn indices(
        self,
        events: &EventStream,
        first: usize,
    ) -> impl ExactSizeIterator<Item = (Micros, u32)> + '_ {
        let width = u32::from(self.sensor.width);
        let plane = self.sensor.pixels() as u32;
        let planes = [Polarity::Off, Polarity::On].map(|p| self.order.channel(p) as u32 * plane);
        let (t, x, y) = (&events.t()[first..], &events.x()[first..], &events.y()[first..]);
        let columns = t.iter().zip(x).zip(y).zip(&events.polarity()[first..]);
        columns.map(move |(((&t, &x), &y), &polarity)| {
            (t, planes[polarity as usize] + u32::from(y) * width + u32::from(x))
        })
    }
}
