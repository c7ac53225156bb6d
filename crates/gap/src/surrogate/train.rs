//! Event train (a marked point process) of all pixels, and its surrogates.

use evpose_core::{
    CounterRng, Event, EventStream, EventStreamBuilder, Micros, Polarity, SensorSize,
};

/// Side of the blocks within which surrogates displace events, pixels.
const BLOCK: usize = 4;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Mark {
    pub(super) t_us: i64,
    /// Index of the pixel, row by row.
    pub(super) pixel: u32,
    pub(super) is_on: bool,
}

/// Events sorted by time and, at equal times, by pixel.
#[derive(Debug, Clone)]
pub(super) struct Train {
    pub(super) size: SensorSize,
    pub(super) marks: Vec<Mark>,
}

impl Train {
    pub(super) fn from_events(events: &EventStream) -> Self {
        let width = u32::from(events.sensor().width);
        let mark = |event: Event| Mark {
            t_us: event.t.0,
            pixel: u32::from(event.y) * width + u32::from(event.x),
            is_on: event.polarity.is_on(),
        };
        Self::sorted(events.sensor(), events.iter().map(mark).collect())
    }

    fn sorted(size: SensorSize, mut marks: Vec<Mark>) -> Self {
        // Stable: events of one pixel at one time keep their order.
        marks.sort_by_key(|mark| (mark.t_us, mark.pixel));
        Self { size, marks }
    }

    pub(super) fn into_stream(self) -> EventStream {
        let width = u32::from(self.size.width);
        let mut builder = EventStreamBuilder::new(self.size);
        for mark in self.marks {
            builder.push(Event {
                t: Micros(mark.t_us),
                x: (mark.pixel % width) as u16,
                y: (mark.pixel / width) as u16,
                polarity: Polarity::from_on(mark.is_on),
            });
        }
        builder.finish().0
    }

    /// Half-open interval from the first to behind the last event, microseconds.
    pub(super) fn span_us(&self) -> (i64, i64) {
        match (self.marks.first(), self.marks.last()) {
            (Some(first), Some(last)) => (first.t_us, last.t_us + 1),
            _ => (0, 1),
        }
    }

    pub(super) fn seconds(&self) -> f64 {
        let (start, end) = self.span_us();
        1e-6 * (end - start) as f64
    }

    pub(super) fn width(&self) -> usize {
        usize::from(self.size.width)
    }

    /// First and second half of the time.
    pub(super) fn halves(&self) -> [Self; 2] {
        let (start, end) = self.span_us();
        let middle = self.marks.partition_point(|mark| mark.t_us < start + (end - start) / 2);
        let (early, late) = self.marks.split_at(middle);
        [early, late].map(|marks| Self { size: self.size, marks: marks.to_vec() })
    }

    /// Removes the events of some pixels, which are sorted.
    pub(super) fn without(&self, pixels: &[u32]) -> Self {
        let stays = |mark: &&Mark| pixels.binary_search(&mark.pixel).is_err();
        Self { size: self.size, marks: self.marks.iter().filter(stays).copied().collect() }
    }

    /// At most `max_events` events from the middle of the recording.
    pub(super) fn middle(mut self, max_events: usize) -> Self {
        if self.marks.len() > max_events {
            let skipped = (self.marks.len() - max_events) / 2;
            self.marks = self.marks[skipped..skipped + max_events].to_vec();
        }
        self
    }

    /// Surrogate with every event at a random time within its window.
    pub(super) fn jittered(&self, window_us: i64, rng: &mut CounterRng) -> Self {
        let (start, end) = self.span_us();
        let moved = |mark: &Mark| {
            let begin = mark.t_us.div_euclid(window_us) * window_us;
            let (from, to) = (begin.max(start), (begin + window_us).min(end));
            Mark { t_us: from + rng.below((to - from) as usize) as i64, ..*mark }
        };
        Self::sorted(self.size, self.marks.iter().map(moved).collect())
    }

    /// Surrogate with every event at a random pixel within its block.
    pub(super) fn displaced(&self, rng: &mut CounterRng) -> Self {
        let (width, height) = (self.width(), usize::from(self.size.height));
        let mut pick = |at: usize, length: usize| {
            let begin = at / BLOCK * BLOCK;
            // Blocks at the right and lower border are smaller.
            begin + rng.below(BLOCK.min(length - begin))
        };
        let moved = |mark: &Mark| {
            let pixel = mark.pixel as usize;
            let (x, y) = (pick(pixel % width, width), pick(pixel / width, height));
            Mark { pixel: (y * width + x) as u32, ..*mark }
        };
        Self::sorted(self.size, self.marks.iter().map(moved).collect())
    }
}
