//! The place of the latest events: an EROS keeps the trail of somebody who has walked away.

use evpose_core::{EventStream, Micros, SensorSize};
use glam::Vec2;

/// Counts are kept for one to two of these, a step of somebody who walks, or for longer, until enough events
/// have come: somebody far who rests stays where they are.
const GENERATION: Micros = Micros(150_000);
/// Share of the events that is beyond the extent, on each of its four sides.
const OUTSIDE: f32 = 0.03;
/// Fewer events have no extent, and end no generation.
const MIN_EVENTS: u32 = 100;

/// The latest events, counted by column and by row.
#[derive(Debug, Clone)]
pub(super) struct RecentEvents {
    /// Of the columns and of the rows: counts of this generation and of the one before.
    counts: [[Vec<u32>; 2]; 2],
    /// Events of this generation, and the time that it ends at.
    count: u32,
    end: Micros,
}

impl RecentEvents {
    pub(super) fn new(size: SensorSize) -> Self {
        let counts = [size.width, size.height]
            .map(|side| [vec![0; usize::from(side)], vec![0; usize::from(side)]]);
        Self { counts, count: 0, end: Micros(i64::MAX) }
    }

    pub(super) fn push(&mut self, events: &EventStream) {
        for ((t, x), y) in events.t().iter().zip(events.x()).zip(events.y()) {
            if self.count == 0 {
                // Recordings begin at any time, so that the first event starts the clock.
                self.end = *t + GENERATION;
            } else if *t >= self.end && self.count >= MIN_EVENTS {
                self.begin_generation(*t);
            }
            self.count += 1;
            self.counts[0][0][usize::from(*x)] += 1;
            self.counts[1][0][usize::from(*y)] += 1;
        }
    }

    fn begin_generation(&mut self, t: Micros) {
        // A generation that ended long ago says where somebody was, until the next one is as large.
        for [current, before] in &mut self.counts {
            std::mem::swap(current, before);
            current.fill(0);
        }
        (self.count, self.end) = (0, t + GENERATION);
    }

    /// The corners of the rectangle that holds most of them, relative to the image; none of few events.
    pub(super) fn extent(&self) -> Option<[Vec2; 2]> {
        let [x, y] = self.counts.each_ref().map(side_of);
        let ([left, right], [top, bottom]) = (x?, y?);
        Some([Vec2::new(left, top), Vec2::new(right, bottom)])
    }

    pub(super) fn reset(&mut self) {
        self.counts.iter_mut().flatten().for_each(|counts| counts.fill(0));
        self.count = 0;
    }
}

/// Beginning and end of most events along an axis, 0 to 1.
fn side_of([current, before]: &[Vec<u32>; 2]) -> Option<[f32; 2]> {
    let at = |k: usize| current[k] + before[k];
    let all: u32 = (0..current.len()).map(at).sum();
    if all < MIN_EVENTS {
        return None;
    }
    let outside = (OUTSIDE * all as f32) as u32;
    let mut passed = 0;
    let mut is_inside = |k: &usize| {
        passed += at(*k);
        passed > outside
    };
    let low = (0..current.len()).find(&mut is_inside)?;
    passed = 0;
    let high = (0..current.len()).rev().find(|k| {
        passed += at(*k);
        passed > outside
    })?;
    let side = current.len() as f32;
    // The rectangle includes its last pixel, whose far side is one further on.
    Some([low as f32 / side, (high + 1) as f32 / side])
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Polarity};

    use super::*;

    const SIZE: SensorSize = SensorSize { width: 40, height: 20 };

    /// One event in each pixel of a rectangle.
    fn rectangle(
        t_ms: i64,
        columns: std::ops::Range<u16>,
        rows: std::ops::Range<u16>,
    ) -> EventStream {
        let mut events = EventStream::empty(SIZE);
        for (x, y) in rows.flat_map(|y| columns.clone().map(move |x| (x, y))) {
            events.push(Event { t: Micros(1_000 * t_ms), x, y, polarity: Polarity::On }).unwrap();
        }
        events
    }

    #[test]
    fn the_extent_is_of_the_latest_events_and_stray_ones_are_outside() {
        let mut recent = RecentEvents::new(SIZE);
        assert_eq!(recent.extent(), None);
        recent.push(&rectangle(0, 0..40, 0..20));
        let all = [Vec2::new(1.0 / 40.0, 0.0), Vec2::new(39.0 / 40.0, 1.0)];
        assert_eq!(recent.extent().unwrap(), all);
        // In the next generation both count, in the one behind it the latter alone.
        recent.push(&rectangle(160, 10..30, 5..15));
        assert!(recent.extent().unwrap()[0].x < 0.1);
        recent.push(&rectangle(310, 10..30, 5..15));
        recent.push(&rectangle(320, 0..1, 0..3));
        let middle = [Vec2::splat(0.25), Vec2::splat(0.75)];
        assert_eq!(recent.extent().unwrap(), middle);
        // A few events are nobody: the place stands until there are enough of them.
        for t_s in 1..4 {
            recent.push(&rectangle(1_000 * t_s, 0..5, 0..5));
        }
        assert_eq!(recent.counts[0][1].iter().sum::<u32>(), 203);
        recent.push(&rectangle(5_000, 0..20, 0..10));
        recent.push(&rectangle(5_100, 0..20, 0..10));
        recent.push(&rectangle(6_000, 0..20, 0..10));
        assert_eq!(recent.extent().unwrap(), [Vec2::ZERO, Vec2::splat(0.5)]);
        recent.reset();
        assert_eq!(recent.extent(), None);
        recent.push(&rectangle(0, 10..30, 5..15));
        assert_eq!(recent.extent().unwrap(), middle);
    }
}
