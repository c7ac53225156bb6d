//! TOS, the threshold-ordinal surface: which pixels of a moving edge fired last.
//!
//! # Model
//! Times and polarities are ignored. An event takes 1 from every value in a square of `k` by `k`
//! pixels around it, and what was below `255 - k·l` becomes 0, where `l` is the thickness of the
//! lines that are to stay; then its own pixel becomes 255.
//!
//! # Borders
//! Squares reach over the border, where there is nothing to change.
//!
//! # Source
//! Glover et al., *luvHarris*, TPAMI 2021; event-driven and hpe-core, class `TOS`. At hpe-core's
//! head the square never moves from where the first event put it, in both languages; that is not
//! imitated.

use evpose_core::{EventStream, Micros, NumberKind, NumberSpec, Parameter, SensorSize};

use crate::neighbourhood::{Neighbourhood, kernel_parameter};
use crate::spec::{Memory, PolarityUse, RepresentationSpec};
use crate::{Grey, Representation};

pub(crate) static SPEC: RepresentationSpec = RepresentationSpec {
    name: "tos",
    summary: "which pixels of a moving edge fired last, 0 to 255",
    parameters: &[
        kernel_parameter(TosConfig::PUBLISHED.kernel_px, NumberKind::Odd),
        Parameter::Number(NumberSpec {
            name: "line",
            unit: "px",
            doc: "thickness of the lines that stay",
            kind: NumberKind::Whole,
            range: (1.0, 8.0),
            default: Some(TosConfig::PUBLISHED.line_px as f64),
            ..NumberSpec::LINEAR
        }),
    ],
    memory: Memory::Own,
    polarity: PolarityUse::Ignored,
    any_order_at_once: false,
    channels: |_| 1,
    start: |window, values| {
        let (kernel_px, line_px) = (values.whole("kernel"), values.whole("line"));
        Box::new(Tos::new(window.sensor, TosConfig { kernel_px, line_px }))
    },
    fill: None,
};

/// The shape of a TOS.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TosConfig {
    /// Width and height of the square that an event changes, in pixels; odd.
    pub kernel_px: u32,
    /// Thickness of lines, in pixels.
    pub line_px: u32,
}

impl TosConfig {
    /// The published classes.
    pub const PUBLISHED: Self = Self { kernel_px: 5, line_px: 2 };
}

impl Default for TosConfig {
    fn default() -> Self {
        Self::PUBLISHED
    }
}

/// The TOS of a stream. It has a memory of its own and no window.
#[derive(Debug, Clone)]
pub struct Tos {
    values: Neighbourhood,
    threshold: u16,
}

const PEAK: u16 = 255;

impl Tos {
    /// A TOS without events.
    ///
    /// # Panics
    /// If the kernel is even or above [`ErosConfig::MAX_KERNEL_PX`](crate::ErosConfig).
    pub fn new(sensor: SensorSize, config: TosConfig) -> Self {
        assert!(config.kernel_px % 2 == 1, "an even kernel is not centred");
        let lines = config.kernel_px.saturating_mul(config.line_px);
        // No value is above the peak, and a threshold of 1 lets every one of them live.
        let threshold = u32::from(PEAK).saturating_sub(lines).max(1) as u16;
        Self { values: Neighbourhood::new(sensor, config.kernel_px, 0), threshold }
    }
}

impl Representation for Tos {
    fn channels(&self) -> usize {
        1
    }

    fn push(&mut self, events: &EventStream) {
        let threshold = self.threshold;
        self.values.push(events, PEAK, move |v, _| if v < threshold { 0 } else { v - 1 });
    }

    fn advance(&mut self, _: Micros) {}

    fn render(&self, out: &mut [f32]) {
        self.values.render(out, f32::from);
    }

    fn grey(&self) -> Grey {
        Grey::White(PEAK.into())
    }

    fn render_u8(&self, out: &mut [u8]) {
        self.values.render(out, |value| value as u8);
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

    fn after(columns: &[u16], config: TosConfig) -> [f32; 4] {
        let mut events = EventStream::empty(SENSOR);
        for &x in columns {
            events.push(Event { t: Micros(0), x, y: 0, polarity: Polarity::On }).unwrap();
        }
        let mut tos = Tos::new(SENSOR, config);
        tos.push(&events);
        let mut out = [f32::NAN; 4];
        tos.render(&mut out);
        out
    }

    /// By hand: a square of 3, lines of 1: what is below 252 goes.
    #[test]
    fn an_event_ages_its_neighbours_and_the_oldest_are_dropped() {
        let config = TosConfig { kernel_px: 3, line_px: 1 };
        assert_eq!(after(&[0, 1, 2], config), [254.0, 254.0, 255.0, 0.0]);
        assert_eq!(after(&[0, 1, 1, 1, 1], config), [251.0, 255.0, 0.0, 0.0]);
        assert_eq!(after(&[0, 1, 1, 1, 1, 1], config), [0.0, 255.0, 0.0, 0.0]);
    }
}
