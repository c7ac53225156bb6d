//! EROS, the exponentially reduced ordinal surface: how many events fell near a pixel since its
//! own.
//!
//! # Model
//! Times and polarities are ignored. An event at `(x, y)` multiplies every value in a square of `k`
//! by `k` pixels around it by `d = decay^(1/k)`, then the pixel's own becomes 255.
//!
//! A value is thus 255 times a power of `d`: what is kept per pixel is the exponent, the number of
//! events near it since its own, and the values are looked up when they are asked for. That is
//! exact, whatever arithmetic the values have, and an event costs additions of 16 bits. After
//! 65,535 events nearby a pixel reads 0, as one that never fired.
//!
//! # Variants
//! | | square | values |
//! |---|---|---|
//! | [`Eros::new`] | centred, odd | `255·decay^(n/k)`, f32 |
//! | [`Eros::python`] | even, one pixel more to the left and above | u8: the fraction is dropped at each event |
//! | [`Eros::hpe_core`] | centred, odd | f64, rounded at each event |
//!
//! # Borders
//! Squares reach over the border, where there is nothing to change: padded as in the published C++
//! and clipped as in the published Python are the same.
//!
//! # Source
//! Goyal et al., *MoveEnet*, CVPRW 2023, Sec. 3.1; hpe-core, class `EROS` in Python (all its data
//! sets) and in C++ (its online programs).

use evpose_core::{EventStream, Micros, NumberKind, NumberSpec, Parameter, SensorSize, Settings};

use crate::neighbourhood::{MAX_KERNEL, Neighbourhood, kernel_parameter};
use crate::spec::{Memory, PolarityUse, RepresentationSpec};
use crate::{Grey, Representation};

pub(crate) static SPEC: RepresentationSpec = RepresentationSpec {
    name: "eros",
    summary: "how many events fell near a pixel since its own, 0 to 255, exponentially",
    parameters: &[kernel_parameter(ErosConfig::ONLINE.kernel_px, NumberKind::Odd), DECAY],
    memory: Memory::Own,
    polarity: PolarityUse::Ignored,
    any_order_at_once: false,
    channels: |_| 1,
    start: |window, values| Box::new(Eros::new(window.sensor, config(values))),
    fill: None,
};

pub(crate) static PYTHON: RepresentationSpec = RepresentationSpec {
    name: "eros-python",
    summary: "eros as the published data sets have it: off-centre, fractions dropped",
    parameters: &[kernel_parameter(ErosConfig::DATA_SETS.kernel_px, NumberKind::Even), DECAY],
    memory: Memory::Own,
    polarity: PolarityUse::Ignored,
    any_order_at_once: false,
    channels: |_| 1,
    start: |window, values| Box::new(Eros::python(window.sensor, config(values))),
    fill: None,
};

pub(crate) static HPE_CORE: RepresentationSpec = RepresentationSpec {
    name: "eros-hpe-core",
    summary: "eros as the published online program has it: rounded in f64 at each event",
    parameters: &[kernel_parameter(ErosConfig::ONLINE.kernel_px, NumberKind::Odd), DECAY],
    memory: Memory::Own,
    polarity: PolarityUse::Ignored,
    any_order_at_once: false,
    channels: |_| 1,
    start: |window, values| Box::new(Eros::hpe_core(window.sensor, config(values))),
    fill: None,
};

const DECAY: Parameter = Parameter::Number(NumberSpec {
    name: "decay",
    doc: "factor on a value after kernel events nearby",
    range: (0.0, 1.0),
    default: Some(ErosConfig::ONLINE.decay),
    ..NumberSpec::LINEAR
});

fn config(values: &Settings) -> ErosConfig {
    ErosConfig { kernel_px: values.whole("kernel"), decay: values.number("decay") }
}

mod framer;
pub use framer::ErosFramer;

/// The shape of an EROS.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErosConfig {
    /// Width and height of the square that an event changes, in pixels.
    pub kernel_px: u32,
    /// Factor on a value after `kernel_px` events nearby.
    pub decay: f64,
}

impl ErosConfig {
    /// The published online program.
    pub const ONLINE: Self = Self { kernel_px: 7, decay: 0.3 };
    /// The published data sets, made in Python.
    pub const DATA_SETS: Self = Self { kernel_px: 8, decay: 0.3 };
    /// The largest kernel.
    pub const MAX_KERNEL_PX: u32 = MAX_KERNEL;
}

impl Default for ErosConfig {
    fn default() -> Self {
        Self::ONLINE
    }
}

/// The EROS of a stream. It has a memory of its own and no window.
#[derive(Debug, Clone)]
pub struct Eros {
    /// Events near each pixel since its own; [`NEVER`] where there was none.
    since: Neighbourhood,
    /// Decayed value by number of events, with the precision of the variant; the last one is kept.
    values: Vec<f64>,
    /// The same for every number of events, up to where only zeros follow.
    values_f32: Vec<f32>,
    values_u8: Vec<u8>,
}

/// Saturated count, and count of a pixel without events.
const NEVER: u16 = u16::MAX;
const PEAK: f64 = 255.0;

impl Eros {
    /// An EROS by its definition.
    ///
    /// # Panics
    /// If the kernel is even or above [`ErosConfig::MAX_KERNEL_PX`], or the decay not within 0
    /// to 1.
    pub fn new(sensor: SensorSize, config: ErosConfig) -> Self {
        assert!(config.kernel_px % 2 == 1, "an even kernel is not centred");
        let ErosConfig { kernel_px, decay } = config;
        let value = |n: u16| PEAK * decay.powf(f64::from(n) / f64::from(kernel_px));
        // What is too small for an `f32` is nothing.
        let shown = |n| Some(value(n)).filter(|&value| value >= f32::MIN_POSITIVE.into());
        Self::with_values(sensor, config, until_steady(|n, _| shown(n).unwrap_or(0.0)))
    }

    /// An EROS as the published Python computes it.
    ///
    /// # Panics
    /// If the kernel is odd or above [`ErosConfig::MAX_KERNEL_PX`], or the decay not within 0 to
    /// 1.
    pub fn python(sensor: SensorSize, config: ErosConfig) -> Self {
        assert!(config.kernel_px.is_multiple_of(2), "the published program makes kernels even");
        let base = config.base();
        Self::with_values(sensor, config, until_steady(|_, value| (value * base).trunc()))
    }

    /// An EROS as the published C++ computes it.
    ///
    /// # Panics
    /// If the kernel is even or above [`ErosConfig::MAX_KERNEL_PX`], or the decay not within 0
    /// to 1.
    pub fn hpe_core(sensor: SensorSize, config: ErosConfig) -> Self {
        assert!(config.kernel_px % 2 == 1, "the published program makes kernels odd");
        let base = config.base();
        Self::with_values(sensor, config, until_steady(|_, value| value * base))
    }

    fn with_values(sensor: SensorSize, config: ErosConfig, values: Vec<f64>) -> Self {
        assert!((0.0..=1.0).contains(&config.decay), "a decay of {}", config.decay);
        Self {
            since: Neighbourhood::new(sensor, config.kernel_px, NEVER),
            values_f32: lookup(&values, |value| value as f32),
            // Rounded as OpenCV converts to 8 bits.
            values_u8: lookup(&values, |value| value.round_ties_even() as u8),
            values,
        }
    }

    /// Writes the values with all the digits of the variant.
    ///
    /// # Panics
    /// If `out` has another length.
    pub fn render_f64(&self, out: &mut [f64]) {
        let last = self.values.len() - 1;
        self.since.render(out, |n| match n {
            NEVER => 0.0,
            n => self.values[usize::from(n).min(last)],
        });
    }

    /// A row of grey values, for filters that need them one by one.
    fn row_u8(&self, since: &[u16], out: &mut [u8]) {
        const TOGETHER: usize = 32;
        let values = self.values_u8.as_slice();
        // At most 65,535: there is a value for every number of events, and no more.
        let last = (values.len() - 1) as u16;
        let (out, out_rest) = out.as_chunks_mut::<TOGETHER>();
        let (since, since_rest) = since.as_chunks::<TOGETHER>();
        for (out, since) in out.iter_mut().zip(since) {
            // Most pixels of a scene have not fired for long.
            if since.iter().fold(0, |any, &n| any | last.saturating_sub(n)) == 0 {
                *out = [values[usize::from(last)]; TOGETHER];
            } else {
                for (out, &n) in out.iter_mut().zip(since) {
                    *out = values[usize::from(n.min(last))];
                }
            }
        }
        for (out, &n) in out_rest.iter_mut().zip(since_rest) {
            *out = values[usize::from(n.min(last))];
        }
    }
}

impl ErosConfig {
    /// Factor on a value after one event nearby.
    fn base(&self) -> f64 {
        self.decay.powf(1.0 / f64::from(self.kernel_px))
    }
}

/// Values after 0, 1, … events nearby, `next` of their number and the one before, until they stay.
fn until_steady(next: impl Fn(u16, f64) -> f64) -> Vec<f64> {
    let mut values = vec![PEAK];
    let mut last = PEAK;
    for n in 1..NEVER {
        let value = next(n, last);
        // Nothing, the smallest number that there is, or 255 where nothing decays.
        if value == last {
            break;
        }
        values.push(value);
        last = value;
    }
    values
}

/// Value of every count, without all but one of the trailing zeros.
fn lookup<T: Copy + Default + PartialEq>(values: &[f64], shown: impl Fn(f64) -> T) -> Vec<T> {
    let mut out: Vec<T> = values.iter().map(|&value| shown(value)).collect();
    let last = out[out.len() - 1];
    out.resize(NEVER.into(), last);
    out.push(T::default());
    let zeros = out.iter().rev().take_while(|&&value| value == T::default()).count();
    out.truncate(out.len() + 1 - zeros);
    out
}

impl Representation for Eros {
    fn channels(&self) -> usize {
        1
    }

    fn push(&mut self, events: &EventStream) {
        // Nothing changes a pixel that never fired, nor one that fired too long ago.
        self.since.push(events, 0, |n, _| n.saturating_add(1));
    }

    fn advance(&mut self, _: Micros) {}

    fn render(&self, out: &mut [f32]) {
        let last = self.values_f32.len() - 1;
        self.since.render(out, |n| self.values_f32[usize::from(n).min(last)]);
    }

    fn grey(&self) -> Grey {
        Grey::White(PEAK as f32)
    }

    fn render_u8(&self, out: &mut [u8]) {
        let sensor = self.since.sensor();
        assert_eq!(out.len(), sensor.pixels(), "planes of another size");
        let width = usize::from(sensor.width).max(1);
        for (out, since) in out.chunks_exact_mut(width).zip(self.since.rows()) {
            self.row_u8(since, out);
        }
    }

    fn reset(&mut self) {
        self.since.reset();
    }
}

#[cfg(test)]
mod tests;
