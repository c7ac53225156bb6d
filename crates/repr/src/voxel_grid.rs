//! The voxel grid: polarities of a window, spread over bins of time.
//!
//! # Model
//! With `t_1` and `t_N` the times of the first and last event of the window and `B` bins, an event
//! lies at `t* = (B - 1)·(t - t_1)/(t_N - t_1)` and adds its polarity, +1 or -1, to the bins on
//! either side, `1 - |b - t*|` of it to bin `b`. Where all events happen at once they are in the
//! first bin.
//!
//! A window of fewer events than an image has values is summed event by event, in `f32`; one of
//! more by sums that are kept from push to push and are exact. The two differ by rounding.
//!
//! # Borders
//! None: an event changes its own pixel only. Along time, the first event is in the first bin as a
//! whole, the last in the last.
//!
//! # Source
//! Zhu et al., *Unsupervised Event-based Learning of Optical Flow, Depth, and Egomotion*, CVPR
//! 2019, Eq. 1 to 3. (Tonic multiplies by `B` instead and drops what falls into bin `B`.)

use evpose_core::{EventStream, Micros, NumberKind, NumberSpec, Parameter};

use crate::clock::StreamClock;
use crate::sliding::{Placed, Sliding, first_shown};
use crate::spec::{Memory, PolarityUse, RepresentationSpec};
use crate::{Grey, Representation, StreamWindow};

mod prefix_sums;
use prefix_sums::PrefixSums;

pub(crate) static SPEC: RepresentationSpec = RepresentationSpec {
    name: "voxel-grid",
    summary: "ON minus OFF events, spread over bins of time",
    parameters: &[Parameter::Number(NumberSpec {
        name: "bins",
        doc: "bins of time, each a channel",
        kind: NumberKind::Whole,
        range: (1.0, 1024.0),
        default: Some(VoxelGridConfig::DEFAULT.bins as f64),
        ..NumberSpec::LINEAR
    })],
    memory: Memory::Window,
    polarity: PolarityUse::Sign,
    // Sums are rounded.
    any_order_at_once: false,
    channels: |values| values.whole("bins") as usize,
    start: |window, values| {
        Box::new(VoxelGrid::new(window, VoxelGridConfig { bins: values.whole("bins") }))
    },
    fill: None,
};

/// The shape of a voxel grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VoxelGridConfig {
    /// Bins of time, each a channel.
    pub bins: u32,
}

impl VoxelGridConfig {
    /// Five, as most networks that take voxel grids; Zhu et al. have nine.
    pub const DEFAULT: Self = Self { bins: 5 };
}

impl Default for VoxelGridConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The voxel grid of a stream.
#[derive(Debug, Clone)]
pub struct VoxelGrid {
    window: StreamWindow,
    bins: usize,
    /// Positions in planes of two channels, OFF first.
    events: Sliding,
    /// Sums, once there were many events.
    sums: Option<PrefixSums>,
    clock: StreamClock,
}

impl VoxelGrid {
    /// A grid without events. Polarities are signs: the channel order of `window` is ignored.
    ///
    /// # Panics
    /// If there are no bins.
    pub fn new(window: StreamWindow, config: VoxelGridConfig) -> Self {
        assert!(config.bins > 0, "a grid without bins");
        let window = window.off_first();
        let (bins, events) = (config.bins as usize, Sliding::default());
        Self { window, bins, events, sums: None, clock: StreamClock::default() }
    }
}

impl Representation for VoxelGrid {
    fn channels(&self) -> usize {
        self.bins
    }

    fn push(&mut self, events: &EventStream) {
        self.window.check(events);
        let (Some(&first), Some(&last)) = (events.t().first(), events.t().last()) else { return };
        if self.clock.jumps_back(first) {
            self.reset();
        }
        self.events.extend(self.window.indices(events, first_shown(&self.window, events)));
        self.clock.observe(last);
        self.expire();
    }

    fn advance(&mut self, t: Micros) {
        self.clock.advance(t);
        self.expire();
    }

    fn render(&self, out: &mut [f32]) {
        let pixels = self.window.sensor.pixels();
        assert_eq!(out.len(), self.bins * pixels, "planes of another size");
        let summed = self.sums.as_ref().filter(|_| self.has_many());
        if !summed.is_some_and(|sums| sums.render(&self.events, self.bins, out)) {
            self.add_events(out);
        }
    }

    fn grey(&self) -> Grey {
        Grey::Signed
    }

    fn reset(&mut self) {
        self.events.clear();
        if let Some(sums) = &mut self.sums {
            sums.reset();
        }
        self.clock = StreamClock::default();
    }
}

impl VoxelGrid {
    fn expire(&mut self) {
        let Some(now) = self.clock.now else { return };
        let before = self.events.len();
        self.events.expire(&self.window, now, |_| ());
        if let Some(sums) = &mut self.sums {
            sums.remove_first(before - self.events.len());
        }
        if self.has_many() {
            let pixels = self.window.sensor.pixels();
            self.sums.get_or_insert_with(|| PrefixSums::new(pixels)).follow(&self.events);
        }
    }

    /// Whether events cost more than the pixels of as many sums as there are bins.
    fn has_many(&self) -> bool {
        self.bins > 1 && self.events.len() > self.bins * self.window.sensor.pixels()
    }

    /// Writes the planes, event by event.
    fn add_events(&self, out: &mut [f32]) {
        out.fill(0.0);
        let Some(((first, _), (last, _))) = self.events.get(0).zip(self.events.last()) else {
            return;
        };
        let (pixels, span_us) = (self.window.sensor.pixels(), (last.0 - first.0).max(1));
        // The window is a ring: its events lie in two pieces.
        let (older, newer) = self.events.as_slices();
        for part in [older, newer] {
            spread(part, first, span_us, pixels, self.bins, out);
        }
    }
}

/// Adds events to their bins. Between two bins, events are in order: planes change rarely.
fn spread(
    events: &[Placed],
    first: Micros,
    span_us: i64,
    pixels: usize,
    bins: usize,
    out: &mut [f32],
) {
    // The first event lies on the first bin, the last on the last.
    let per_us = (bins - 1) as f64 / span_us as f64;
    let place = |t: Micros| (t.0 - first.0) as f64 * per_us;
    let mut rest = events;
    while let Some(&(t, _)) = rest.first() {
        let bin = (place(t) as usize).min(bins - 1);
        let upto = rest.partition_point(|&(t, _)| place(t) < (bin + 1) as f64);
        // The last event lies on the last bin; its neighbour there is none.
        let (these, later) = rest.split_at(if bin + 1 < bins { upto } else { rest.len() });
        rest = later;
        let mut planes = out[bin * pixels..].chunks_exact_mut(pixels);
        let (Some(near), next) = (planes.next(), planes.next()) else { return };
        let part = |t: Micros, index: u32| {
            let index = index as usize;
            let (at, sign) = if index < pixels { (index, -1.0) } else { (index - pixels, 1.0) };
            (at, sign, (place(t) - bin as f64) as f32)
        };
        match next {
            Some(next) => {
                for &(t, index) in these {
                    let (at, sign, share) = part(t, index);
                    near[at] += sign * (1.0 - share);
                    next[at] += sign * share;
                }
            }
            None => {
                for &(t, index) in these {
                    let (at, sign, _) = part(t, index);
                    near[at] += sign;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
