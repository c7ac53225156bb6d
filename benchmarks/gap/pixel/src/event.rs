//! Events and recordings: what a measurement gives, and nothing else.

/// Pixels across.
pub const WIDTH: usize = 96;
/// Pixels down.
pub const HEIGHT: usize = 72;
/// Length of a recording in seconds.
pub const DURATION_S: f64 = 1.0;

/// One event as it leaves the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Event {
    /// Time stamp in microseconds since the start of the recording.
    pub t_us: u64,
    /// Row, from the top.
    pub y: u16,
    /// Column, from the left.
    pub x: u16,
    /// Brighter (ON) or darker (OFF).
    pub on: bool,
}

/// The events of one recording, ordered by time, row and column.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// The events.
    pub events: Vec<Event>,
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Length in seconds.
    pub duration_s: f64,
}

/// An event inside the camera, before the time-stamper: time still continuous.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spike {
    /// Time in seconds.
    pub t_s: f64,
    /// Number of the pixel, `y * WIDTH + x`.
    pub pixel: u32,
    /// Brighter (ON) or darker (OFF).
    pub on: bool,
}

impl Spike {
    /// Column of the pixel.
    pub fn column(&self) -> usize {
        self.pixel as usize % WIDTH
    }

    /// Row of the pixel.
    pub fn row(&self) -> usize {
        self.pixel as usize / WIDTH
    }
}

/// Orders spikes by time; those at one instant keep the order of pixels and of their making.
pub fn sort_spikes(spikes: &mut [Spike]) {
    spikes.sort_by(|a, b| a.t_s.total_cmp(&b.t_s).then(a.pixel.cmp(&b.pixel)));
}
