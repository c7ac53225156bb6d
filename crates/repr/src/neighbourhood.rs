//! Representations in which an event changes the square around it.
//!
//! # Borders
//! The plane is wider and higher than the sensor by the square's size less one, so no square is
//! clipped. What is written outside the sensor is never read: each cell depends on its own events
//! and on the cell of the event, and events lie on the sensor. Padding, as the published C++ has
//! it, and clipping, as the published Python has it, therefore give the same.

use std::array::from_fn;
use std::hint::black_box;
use std::ops::Range;

use evpose_core::{EventStream, NumberKind, NumberSpec, Parameter, SensorSize};
use evpose_cpu::vectorize;

use crate::clock::StreamClock;

/// The largest square.
pub(crate) const MAX_KERNEL: u32 = 31;

/// The parameter `kernel` of a representation.
pub(crate) const fn kernel_parameter(default_px: u32, kind: NumberKind) -> Parameter {
    Parameter::Number(NumberSpec {
        name: "kernel",
        unit: "px",
        doc: "width and height of the square that an event changes",
        kind,
        range: (1.0, MAX_KERNEL as f64),
        default: Some(default_px as f64),
        ..NumberSpec::LINEAR
    })
}

/// A plane of small integers and the square that an event changes.
#[derive(Debug, Clone)]
pub(crate) struct Neighbourhood {
    sensor: SensorSize,
    square: Square,
    /// Value of a cell before any event.
    initial: u16,
    cells: Vec<u16>,
    clock: StreamClock,
}

#[derive(Debug, Clone, Copy)]
struct Square {
    /// Its width and height.
    kernel: usize,
    /// From a row of cells to the next.
    stride: usize,
}

/// A kernel that is known at run time only.
const ANY: usize = 0;
/// Cells worked on at once: a row of the square, padded.
const NARROW: usize = 8;
const BROAD: usize = MAX_KERNEL.next_power_of_two() as usize;

impl Neighbourhood {
    /// A plane of `initial` for squares of `kernel` cells, `kernel / 2` of them before the event:
    /// an odd one is centred.
    ///
    /// # Panics
    /// If `kernel` is 0 or larger than [`MAX_KERNEL`].
    pub(crate) fn new(sensor: SensorSize, kernel: u32, initial: u16) -> Self {
        assert!((1..=MAX_KERNEL).contains(&kernel), "a kernel of {kernel} px");
        let kernel = kernel as usize;
        // Rows begin where cache lines do.
        let stride = (usize::from(sensor.width) + kernel - 1).next_multiple_of(32);
        let rows = usize::from(sensor.height) + kernel - 1;
        let square = Square { kernel, stride };
        let cells = vec![initial; rows * stride + BROAD];
        Self { sensor, square, initial, cells, clock: StreamClock::default() }
    }

    /// Takes events: every cell of a square becomes `rule(cell, cell of the event)`, then the cell
    /// of the event `fired`.
    pub(crate) fn push(
        &mut self,
        events: &EventStream,
        fired: u16,
        rule: impl Fn(u16, u16) -> u16 + Copy,
    ) {
        assert_eq!(events.sensor(), self.sensor, "events from a sensor of another size");
        let (Some(&first), Some(&last)) = (events.t().first(), events.t().last()) else { return };
        if self.clock.jumps_back(first) {
            self.reset();
        }
        self.clock.observe(last);
        let Self { square, cells, .. } = self;
        let (x, y) = (events.x(), events.y());
        match square.kernel {
            // Sizes in use are compiled for themselves: a loop of known length unrolls.
            5 => square.apply::<5, NARROW>(cells, x, y, fired, rule),
            7 => square.apply::<7, NARROW>(cells, x, y, fired, rule),
            8 => square.apply::<8, NARROW>(cells, x, y, fired, rule),
            // Other narrow sizes share a loop whose length is known only at run time.
            ..NARROW => square.apply::<ANY, NARROW>(cells, x, y, fired, rule),
            _ => square.apply::<ANY, BROAD>(cells, x, y, fired, rule),
        }
    }

    /// The cells of the sensor, row by row.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &[u16]> {
        let Square { kernel, stride } = self.square;
        let before = kernel / 2;
        let (width, height) = (usize::from(self.sensor.width), usize::from(self.sensor.height));
        let rows = self.cells.chunks_exact(stride).skip(before).take(height);
        rows.map(move |row| &row[before..before + width])
    }

    /// Writes `value` of every cell of the sensor.
    #[inline(always)]
    pub(crate) fn render<T>(&self, out: &mut [T], value: impl Fn(u16) -> T) {
        assert_eq!(out.len(), self.sensor.pixels(), "planes of another size");
        let width = usize::from(self.sensor.width).max(1);
        for (out, row) in out.chunks_exact_mut(width).zip(self.rows()) {
            for (out, &cell) in out.iter_mut().zip(row) {
                *out = value(cell);
            }
        }
    }

    pub(crate) fn sensor(&self) -> SensorSize {
        self.sensor
    }

    pub(crate) fn reset(&mut self) {
        self.cells.fill(self.initial);
        self.clock = StreamClock::default();
    }
}

impl Square {
    /// `KERNEL` is the square's where it is a usual one: code that knows it is twice as fast.
    #[inline(always)]
    fn apply<const KERNEL: usize, const LANES: usize>(
        self,
        cells: &mut [u16],
        x: &[u16],
        y: &[u16],
        fired: u16,
        rule: impl Fn(u16, u16) -> u16 + Copy,
    ) {
        vectorize(
            // What is captured by reference might be among the cells: it would be read again and
            // again.
            #[inline(always)]
            move || {
                let kernel = if KERNEL == ANY { self.kernel } else { KERNEL };
                // Columns left of an event, and rows above, that belong to its square.
                let before = kernel / 2;
                // Seven cells would be worked on as four, two and one: masks that the compiler does
                // not know leave vectors whole.
                let inside: [u16; LANES] = black_box(from_fn(|lane| mask(lane < kernel)));
                let middle: [u16; LANES] = black_box(from_fn(|lane| mask(lane == before)));
                let nowhere = [0; LANES];
                for (&x, &y) in x.iter().zip(y) {
                    // The plane is shifted by what lies before an event: the square begins here.
                    let start = usize::from(y) * self.stride + usize::from(x);
                    let centre = cells[start + before * (self.stride + 1)];
                    let rule = move |cell| rule(cell, centre);
                    let cells = &mut cells[start..];
                    self.change(0..before, cells, &inside, rule, &nowhere, fired);
                    // With its row: a cell that is written by itself keeps the next event waiting.
                    self.change(before..before + 1, cells, &inside, rule, &middle, fired);
                    self.change(before + 1..kernel, cells, &inside, rule, &nowhere, fired);
                }
            },
        );
    }

    /// Applies `rule` to rows of the square that begins with `cells`, where `inside` is set, and
    /// writes `fired` where `events` is.
    #[inline(always)]
    fn change<const LANES: usize>(
        self,
        rows: Range<usize>,
        cells: &mut [u16],
        inside: &[u16; LANES],
        rule: impl Fn(u16) -> u16,
        events: &[u16; LANES],
        fired: u16,
    ) {
        for row in rows {
            let Some(row) = cells[row * self.stride..].first_chunk_mut::<LANES>() else { return };
            let before = *row;
            *row = from_fn(
                #[inline(always)]
                |lane| {
                    let cell = before[lane];
                    // Masks instead of branches: all lanes do the same, and become vector
                    // instructions.
                    let changed = cell ^ ((rule(cell) ^ cell) & inside[lane]);
                    (changed & !events[lane]) | (fired & events[lane])
                },
            );
        }
    }
}

/// All bits or none.
fn mask(is_set: bool) -> u16 {
    if is_set { u16::MAX } else { 0 }
}

#[cfg(test)]
mod tests;
