//! SITS, the speed-invariant time surface: in which order the pixels around an edge fired.
//!
//! # Model
//! Times and polarities are ignored. With `c` the value of its pixel, an event takes 1 from every
//! value in a square of `k` by `k` pixels around it that is at least `c`, then its own pixel
//! becomes `k²`. A 0 stays 0: nothing is older than never. [`Ageing`] holds the published program's
//! departure.
//!
//! # Borders
//! Squares reach over the border, where there is nothing to change.
//!
//! # Source
//! Manderscheid et al., *Speed Invariant Time Surface for Learning to Detect Corner Points with
//! Event-Based Cameras*, CVPR 2019, Algorithm 1 (which keeps the polarities apart); hpe-core, class
//! `SITS`, whose square never moves from where the first event put it: that is not imitated.

use evpose_core::{EventStream, Micros, NumberKind, SensorSize, Settings};

use crate::neighbourhood::{Neighbourhood, kernel_parameter};
use crate::spec::{Memory, PolarityUse, RepresentationSpec};
use crate::{Grey, Representation};

pub(crate) static SPEC: RepresentationSpec = RepresentationSpec {
    name: "sits",
    summary: "in which order the pixels around an edge fired, 0 to kernel²",
    parameters: &[kernel_parameter(SitsConfig::PUBLISHED.kernel_px, NumberKind::Odd)],
    memory: Memory::Own,
    polarity: PolarityUse::Ignored,
    any_order_at_once: false,
    channels: |_| 1,
    start: |window, values| Box::new(Sits::new(window.sensor, config(values, Ageing::AtLeast))),
    fill: None,
};

pub(crate) static HPE_CORE: RepresentationSpec = RepresentationSpec {
    name: "sits-hpe-core",
    summary: "sits as hpe-core means it: pixels of the same age do not age each other",
    parameters: &[kernel_parameter(SitsConfig::PUBLISHED.kernel_px, NumberKind::Odd)],
    memory: Memory::Own,
    polarity: PolarityUse::Ignored,
    any_order_at_once: false,
    channels: |_| 1,
    start: |window, values| Box::new(Sits::new(window.sensor, config(values, Ageing::Above))),
    fill: None,
};

fn config(values: &Settings, ageing: Ageing) -> SitsConfig {
    SitsConfig { kernel_px: values.whole("kernel"), ageing }
}

/// The shape of a SITS.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SitsConfig {
    /// Width and height of the square that an event changes, in pixels; odd.
    pub kernel_px: u32,
    /// Values that an event decrements.
    pub ageing: Ageing,
}

/// Values that an event decrements.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Ageing {
    /// Those that are at least that of its pixel: the definition.
    #[default]
    AtLeast,
    /// Those above that of its pixel, as hpe-core.
    Above,
}

impl SitsConfig {
    /// The published class.
    pub const PUBLISHED: Self = Self { kernel_px: 5, ageing: Ageing::AtLeast };
}

impl Default for SitsConfig {
    fn default() -> Self {
        Self::PUBLISHED
    }
}

/// The SITS of a stream. It has a memory of its own and no window.
#[derive(Debug, Clone)]
pub struct Sits {
    values: Neighbourhood,
    ageing: Ageing,
    peak: u16,
}

impl Sits {
    /// A SITS without events.
    ///
    /// # Panics
    /// If the kernel is even or above [`ErosConfig::MAX_KERNEL_PX`](crate::ErosConfig).
    pub fn new(sensor: SensorSize, config: SitsConfig) -> Self {
        assert!(config.kernel_px % 2 == 1, "an even kernel is not centred");
        let values = Neighbourhood::new(sensor, config.kernel_px, 0);
        // At most 31².
        let peak = (config.kernel_px * config.kernel_px) as u16;
        Self { values, ageing: config.ageing, peak }
    }
}

impl Representation for Sits {
    fn channels(&self) -> usize {
        1
    }

    fn push(&mut self, events: &EventStream) {
        match self.ageing {
            Ageing::AtLeast => self.values.push(events, self.peak, |value, centre| {
                value.saturating_sub(u16::from(value >= centre))
            }),
            Ageing::Above => {
                self.values.push(events, self.peak, |v, centre| v - u16::from(v > centre));
            }
        }
    }

    fn advance(&mut self, _: Micros) {}

    fn render(&self, out: &mut [f32]) {
        self.values.render(out, f32::from);
    }

    fn grey(&self) -> Grey {
        Grey::White(self.peak.into())
    }

    fn reset(&mut self) {
        self.values.reset();
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Polarity};

    use super::*;

    const SENSOR: SensorSize = SensorSize { width: 4, height: 1 };

    fn after(columns: &[u16], ageing: Ageing) -> [f32; 4] {
        let mut events = EventStream::empty(SENSOR);
        for &x in columns {
            events.push(Event { t: Micros(0), x, y: 0, polarity: Polarity::On }).unwrap();
        }
        let mut sits = Sits::new(SENSOR, SitsConfig { kernel_px: 3, ageing });
        sits.push(&events);
        let mut out = [f32::NAN; 4];
        sits.render(&mut out);
        out
    }

    /// By hand, with a square of 3.
    #[test]
    fn an_event_ages_what_is_younger_than_its_own_pixel() {
        for ageing in [Ageing::AtLeast, Ageing::Above] {
            assert_eq!(after(&[0, 1, 2], ageing), [8.0, 8.0, 9.0, 0.0]);
            // The pixel on the left is older than the event's own.
            assert_eq!(after(&[0, 1, 1], ageing)[0], 8.0);
        }
        // Two of the same age: 8 and 8 beside an event on one of them.
        assert_eq!(after(&[0, 2, 1, 2], Ageing::AtLeast), [8.0, 8.0, 9.0, 0.0]);
        assert_eq!(after(&[1, 0, 1], Ageing::AtLeast), [8.0, 9.0, 0.0, 0.0]);
        assert_eq!(after(&[0, 0, 3, 1, 0], Ageing::AtLeast), [9.0, 8.0, 0.0, 9.0]);
        assert_eq!(after(&[1, 0, 3, 2, 3], Ageing::Above), [9.0, 7.0, 8.0, 9.0]);
    }
}
