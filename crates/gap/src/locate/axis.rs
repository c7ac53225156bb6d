//! Axes along which events are classified, and descriptions of ranges of them.

use crate::{EventFeatures, View};

/// Number of columns and rows of tiles.
pub(super) const TILES: (usize, usize) = (6, 4);
/// Number of parts of the window of time.
pub(super) const TIMES: usize = 10;
/// Edges of the interval since the pixel's last event, microseconds.
const INTERVALS_US: [i64; 4] = [1_000, 5_000, 20_000, 100_000];
/// Edges of the time since luminance last changed, milliseconds; see [`crate::Cell::age`].
const AGES_MS: [u32; 7] = [0, 5, 10, 20, 50, 100, 200];
/// Edges of the change of log luminance over an edge; see [`crate::Cell::contrast`].
const CONTRASTS: [&str; 3] = ["0.3", "0.8", "1.5"];
/// First level of [`Axis::Motion`] at which luminance is at rest.
const REST: usize = 3;

/// One property of an event, in levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Fifths of luminance, the darkest first.
    Brightness,
    /// Luminance that changes fast, at middle speed or slowly; then the time since it did.
    Motion,
    /// Change of log luminance over the current or last edge.
    Contrast,
    /// ON while or after luminance rises or falls, and OFF while or after it falls or rises.
    Sign,
    /// Sixths of the image from left to right.
    Column,
    /// Fourths of the image from top to bottom.
    Row,
    /// Tenths of the window.
    Time,
    /// Interval since the pixel's last event.
    Interval,
}

/// A subset of the levels of an axis, one bit each.
pub(super) type Levels = u64;

impl Axis {
    /// All axes.
    pub const ALL: [Self; 8] = [
        Self::Brightness,
        Self::Motion,
        Self::Contrast,
        Self::Sign,
        Self::Column,
        Self::Row,
        Self::Time,
        Self::Interval,
    ];

    pub(super) const fn count(self) -> usize {
        match self {
            Self::Brightness => 5,
            Self::Motion => 10,
            Self::Contrast | Self::Sign => 4,
            Self::Column => TILES.0,
            Self::Row => TILES.1,
            Self::Time => TIMES,
            Self::Interval => 6,
        }
    }

    /// First bit in a key of all axes.
    pub(super) const fn shift(self) -> u32 {
        let mut shift = 0;
        let mut i = 0;
        while i < self as usize {
            shift += Self::ALL[i].count() as u32;
            i += 1;
        }
        shift
    }

    /// Bits in a key of all axes.
    pub(super) const fn bits(self) -> u64 {
        ((1 << self.count()) - 1) << self.shift()
    }

    /// Level of a key that has one level of every axis.
    pub(super) fn level(self, key: u64) -> usize {
        ((key & self.bits()) >> self.shift()).trailing_zeros() as usize
    }

    /// Subsets of levels that have a description: intervals of levels; for signs, ON, OFF, with and
    /// against the light, rising, falling, and their unions.
    pub(super) fn ranges(self) -> Vec<Levels> {
        if self == Self::Sign {
            return vec![1, 2, 4, 8, 0b0011, 0b1100, 0b0110, 0b1001, 0b0101, 0b1010, 0b1111];
        }
        let count = self.count();
        let ranges = (0..count).flat_map(|from| (from + 1..=count).map(move |to| (from, to)));
        ranges.map(|(from, to)| (1 << to) - (1 << from)).collect()
    }

    pub(super) fn level_of(self, event: &EventFeatures, view: &View<'_>) -> usize {
        let size = view.size();
        let (width, height) = (usize::from(size.width), usize::from(size.height));
        let cell = event.cell;
        match self {
            Self::Brightness => cell.brightness(),
            // Fast first, then slower, then longer and longer at rest: neighbours on the axis are
            // alike.
            Self::Motion if cell.age() == 0 => REST - cell.speed().clamp(1, REST),
            Self::Motion => REST - 1 + cell.age(),
            Self::Contrast => cell.contrast(),
            Self::Sign => match (event.is_on, cell.rises()) {
                (true, true) => 0,
                (true, false) => 1,
                (false, false) => 2,
                (false, true) => 3,
            },
            Self::Column => event.pixel as usize % width * TILES.0 / width,
            Self::Row => event.pixel as usize / width * TILES.1 / height,
            Self::Time => {
                let since = view.since_start_us(event.t_us).max(0) as usize;
                (since * TIMES / (view.window.length().0.max(1) as usize)).min(TIMES - 1)
            }
            Self::Interval => event.before().map_or(INTERVALS_US.len() + 1, |(interval_us, _)| {
                INTERVALS_US.iter().filter(|edge| interval_us >= **edge).count()
            }),
        }
    }
}

/// First level of a range, and the level behind its last.
pub(super) fn ends(levels: Levels) -> (usize, usize) {
    (levels.trailing_zeros() as usize, 64 - levels.leading_zeros() as usize)
}

/// Polarity of events of some signs; empty for both.
pub(super) fn polarity(sign: Levels) -> &'static str {
    match (sign & 0b0011 != 0, sign & 0b1100 != 0) {
        (true, false) => "ON ",
        (false, true) => "OFF ",
        _ => "",
    }
}

/// Describes a range of [`Axis::Motion`], for events of some signs; empty for the whole range.
pub(super) fn motion(motion: Levels, sign: Levels) -> String {
    let (from, to) = ends(motion);
    let (does, did) = match sign {
        0b0001 | 0b1000 | 0b1001 => ("rises", "rose"),
        0b0010 | 0b0100 | 0b0110 => ("falls", "fell"),
        _ => ("changes", "changed"),
    };
    // Levels below `REST` are speeds, those from there on times since luminance last changed.
    let is_all_speeds = from == 0 && to >= REST;
    let speed = match (from, to.min(REST)) {
        (0, REST) => "",
        (0, 1) => " fast",
        (1, 2) => " at middle speed",
        (0, 2) => " at middle or high speed",
        (1, REST) => " slowly or at middle speed",
        _ => " slowly",
    };
    let moves = format!("while light {does}{speed}");
    let end_ms = AGES_MS.get(to.saturating_sub(REST)).filter(|_| to > REST);
    let words = match (from < REST, end_ms) {
        (true, _) if to <= REST => moves,
        (true, Some(end)) if is_all_speeds => {
            format!("while light {does} and up to {end} ms later")
        }
        (true, Some(end)) => format!("{moves} and up to {end} ms after it {did}"),
        (true, None) if is_all_speeds && does == "changes" => String::new(),
        (true, None) if is_all_speeds => format!("where light {does} or last {did}"),
        (true, None) => format!("{moves} or not at all"),
        (false, Some(end)) if from == REST => format!("within {end} ms after light {did}"),
        (false, Some(end)) => format!("{}-{end} ms after light {did}", AGES_MS[from - REST]),
        (false, None) if from == REST && does == "changes" => "where light is at rest".to_owned(),
        (false, None) if from == REST => format!("at rest after light {did}"),
        (false, None) => format!("more than {} ms after light last {did}", AGES_MS[from - REST]),
    };
    let against = match sign {
        0b0101 => "that go with the light",
        0b1010 => "that go against the light",
        _ => "",
    };
    [against, &words].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(", ")
}

/// Describes a range of [`Axis::Brightness`]; empty for the whole range.
pub(super) fn brightness(levels: Levels) -> String {
    const COUNTS: [&str; 5] = ["", "", "two ", "three ", "four "];
    let (from, to) = ends(levels);
    let fifths = |count: usize| if count == 1 { "fifth" } else { "fifths" };
    match (from, to) {
        (0, 5) => String::new(),
        (0, to) => format!("in the darkest {}{} of all pixels", COUNTS[to], fifths(to)),
        (from, 5) => {
            format!("in the brightest {}{} of all pixels", COUNTS[5 - from], fifths(5 - from))
        }
        _ => "in pixels of middle brightness".to_owned(),
    }
}

/// Describes a range of [`Axis::Contrast`]; empty for the whole range.
pub(super) fn contrast(levels: Levels) -> String {
    let of = "at edges of log contrast";
    match ends(levels) {
        (0, 4) => String::new(),
        (0, to) => format!("{of} below {}", CONTRASTS[to - 1]),
        (from, 4) => format!("{of} above {}", CONTRASTS[from - 1]),
        (from, to) => format!("{of} {}-{}", CONTRASTS[from - 1], CONTRASTS[to - 1]),
    }
}

/// Describes a range of [`Axis::Interval`]; empty for the whole range.
pub(super) fn interval(levels: Levels) -> String {
    let first = INTERVALS_US.len() + 1;
    let ms = |limit: usize| INTERVALS_US[limit - 1] / 1_000;
    let last = "the pixel's last event";
    match ends(levels) {
        (0, to) if to == first + 1 => String::new(),
        (from, to) if from == first && to == first + 1 => "the first events of pixels".to_owned(),
        (from, to) if to == first + 1 => {
            format!("first in their pixel or more than {} ms after its last event", ms(from))
        }
        (0, to) if to == first => "other than the first of a pixel".to_owned(),
        (from, to) if to == first => format!("more than {} ms after {last}", ms(from)),
        (0, to) => format!("less than {} ms after {last}", ms(to)),
        (from, to) => format!("{}-{} ms after {last}", ms(from), ms(to)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_levels_of_all_axes_fit_side_by_side_into_a_key() {
        let mut all = 0;
        for axis in Axis::ALL {
            assert_eq!(all & axis.bits(), 0);
            all |= axis.bits();
            assert_eq!(axis.level(1 << (axis.shift() + 2)), 2);
        }
        assert_eq!(all.count_ones() as usize, Axis::ALL.iter().map(|a| a.count()).sum::<usize>());
    }

    #[test]
    fn ranges_are_described_in_plain_words() {
        let range = |from: u32, to: u32| (1u64 << to) - (1 << from);
        assert_eq!(motion(range(5, 7), 0b1100), "10-50 ms after light changed");
        assert_eq!(motion(range(5, 7), 0b0100), "10-50 ms after light fell");
        assert_eq!(motion(range(3, 10), 0b1111), "where light is at rest");
        assert_eq!(motion(range(0, 10), 0b1111), "");
        assert_eq!(motion(range(0, 1), 0b0001), "while light rises fast");
        assert_eq!(motion(range(0, 6), 0b0011), "while light changes and up to 20 ms later");
        assert_eq!(motion(range(8, 10), 0b0011), "more than 100 ms after light last changed");
        assert_eq!(brightness(0b00011), "in the darkest two fifths of all pixels");
        assert_eq!(brightness(0b10000), "in the brightest fifth of all pixels");
        assert_eq!(contrast(0b0110), "at edges of log contrast 0.3-1.5");
        assert_eq!(interval(0b000001), "less than 1 ms after the pixel's last event");
        assert_eq!(interval(0b111111), "");
    }
}
