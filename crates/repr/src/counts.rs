//! How often each pixel fired within a window that slides.

use evpose_core::{EventStream, Micros};

use crate::clock::StreamClock;
use crate::sliding::{Sliding, first_shown};
use crate::{Counting, StreamWindow};

/// Events of a sliding window, counted per pixel and polarity.
#[derive(Debug, Clone)]
pub(crate) struct Counts {
    window: StreamWindow,
    counting: Counting,
    /// `[2][height][width]`.
    counts: Vec<u32>,
    /// The counted events, and where they count.
    counted: Sliding,
    /// Frame in which each pixel and polarity was last counted; empty where every event counts.
    last_frame: Vec<i64>,
    clock: StreamClock,
}

const NO_FRAME: i64 = i64::MIN;

impl Counts {
    pub(crate) fn new(window: StreamWindow, counting: Counting) -> Self {
        let values = 2 * window.sensor.pixels();
        let last_frame = match counting {
            Counting::EveryEvent => Vec::new(),
            Counting::OncePerFrame => vec![NO_FRAME; values],
        };
        let (counts, counted) = (vec![0; values], Sliding::default());
        Self { window, counting, counts, counted, last_frame, clock: StreamClock::default() }
    }

    pub(crate) fn push(&mut self, events: &EventStream) {
        self.window.check(events);
        let (Some(&first), Some(&last)) = (events.t().first(), events.t().last()) else { return };
        if self.clock.jumps_back(first) {
            self.reset();
        }
        let Self { window, counts, last_frame, .. } = self;
        match self.counting {
            Counting::EveryEvent => {
                // Events that are older than the window already would be counted and taken out at
                // once.
                let shown = first_shown(window, events);
                self.counted.extend(window.indices(events, shown).map(|(t, index)| {
                    counts[index as usize] += 1;
                    (t, index)
                }));
            }
            Counting::OncePerFrame => {
                // All events: even one that has left the window decides which is the first of its
                // frame.
                let indices = window.indices(events, 0).filter(|&(t, index)| {
                    let frame = t.0.div_euclid(Micros::MILLISECOND.0);
                    std::mem::replace(&mut last_frame[index as usize], frame) != frame
                });
                let indices = indices.inspect(|&(_, index)| counts[index as usize] += 1);
                self.counted.extend(indices);
            }
        }
        self.clock.observe(last);
        self.expire();
    }

    pub(crate) fn advance(&mut self, t: Micros) {
        self.clock.advance(t);
        self.expire();
    }

    fn expire(&mut self) {
        let Some(now) = self.clock.now else { return };
        let counts = &mut self.counts;
        self.counted.expire(&self.window, now, |index| counts[index as usize] -= 1);
    }

    pub(crate) fn counting(&self) -> Counting {
        self.counting
    }

    /// `[2][height][width]`.
    pub(crate) fn per_polarity(&self) -> &[u32] {
        &self.counts
    }

    /// Of both polarities, `[height][width]`.
    pub(crate) fn per_pixel(&self) -> impl Iterator<Item = u32> + '_ {
        let (first, second) = self.counts.split_at(self.counts.len() / 2);
        first.iter().zip(second).map(|(a, b)| a + b)
    }

    pub(crate) fn reset(&mut self) {
        self.counts.fill(0);
        self.counted.clear();
        self.last_frame.fill(NO_FRAME);
        self.clock = StreamClock::default();
    }
}
