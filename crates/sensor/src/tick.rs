//! The interval between two exposures.

/// Bit position of the part index in a tick's index: a run of one exposure per microsecond reaches
/// this bit after twelve days.
const PART_SHIFT: u32 = 40;

/// The interval between two exposures. Times in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tick {
    /// The time of the exposure before.
    pub start_s: f64,
    /// The time of this exposure.
    pub end_s: f64,
    /// Index of the exposure. The first, 0, has `start_s == end_s`.
    pub index: u64,
}

impl Tick {
    /// Length of the interval; zero at the first exposure.
    pub fn dt_s(&self) -> f64 {
        self.end_s - self.start_s
    }

    /// One of `parts` equal parts, with a number, hence noise, of its own.
    pub(crate) fn part(&self, part: u32, parts: u32) -> Self {
        if parts == 1 {
            return *self;
        }
        let at = |k: u32| self.start_s + self.dt_s() * (f64::from(k) / f64::from(parts));
        let end_s = if part + 1 == parts { self.end_s } else { at(part + 1) };
        Self { start_s: at(part), end_s, index: self.index + (u64::from(part) << PART_SHIFT) }
    }
}
