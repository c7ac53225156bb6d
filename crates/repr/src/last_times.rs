//! When each pixel last fired, per polarity.

use evpose_core::{EventStream, Micros};
use evpose_cpu::vectorize;

use crate::StreamWindow;
use crate::clock::StreamClock;

/// The state of every representation that depends on the latest event of a pixel only.
///
/// Times are kept in 32 bits after an origin that moves on every 18 minutes: planes of 64-bit times
/// take several times as long to render.
#[derive(Debug, Clone)]
pub(crate) struct LastTimes {
    window: StreamWindow,
    /// `[2][height][width]`, microseconds after the origin; [`NEVER`] where there was no event, or
    /// none that any window still shows.
    last_us: Vec<i32>,
    origin: Option<Micros>,
    clock: StreamClock,
}

/// Further back from the origin than the longest window.
const NEVER: i32 = -(1 << 30);
/// The origin moves when times get further from it, so that a difference from [`NEVER`] fits.
const FURTHEST_US: i64 = (1 << 30) - 1;

impl LastTimes {
    pub(crate) fn new(window: StreamWindow) -> Self {
        let last_us = vec![NEVER; 2 * window.sensor.pixels()];
        Self { window, last_us, origin: None, clock: StreamClock::default() }
    }

    pub(crate) fn push(&mut self, events: &EventStream) {
        self.window.check(events);
        let (Some(&first), Some(&last)) = (events.t().first(), events.t().last()) else { return };
        if self.clock.jumps_back(first) {
            self.reset();
        }
        let start = *self.origin.get_or_insert(first);
        let is_near = first.0 >= start.0 && last.0.saturating_sub(start.0) <= FURTHEST_US;
        let indices = self.window.indices(events, 0);
        // Near the origin 32 bits hold all differences, so that none is checked.
        if is_near {
            // In order, so that all others are as near.
            let last_us = self.last_us.as_mut_slice();
            for (t, index) in indices {
                last_us[index as usize] = (t.0 - start.0) as i32;
            }
        } else {
            for (t, index) in indices {
                let t_us = self.since_origin(t);
                self.last_us[index as usize] = t_us;
            }
        }
        self.clock.observe(last);
    }

    pub(crate) fn advance(&mut self, t: Micros) {
        self.since_origin(t);
        self.clock.advance(t);
    }

    pub(crate) fn reset(&mut self) {
        self.last_us.fill(NEVER);
        self.origin = None;
        self.clock = StreamClock::default();
    }

    /// The length of the window, in microseconds.
    pub(crate) fn length_us(&self) -> i32 {
        self.window.length_us
    }

    /// Writes `value(left)` for every pixel and polarity, where `left` is the time in microseconds
    /// until its latest event leaves the window: its length for an event that happens now, 0 where
    /// it shows none.
    #[inline(always)]
    pub(crate) fn render(&self, out: &mut [f32], value: impl Fn(i32) -> f32 + Copy) {
        assert_eq!(out.len(), self.last_us.len(), "planes of another size");
        let (offset_us, last_us) = (self.offset_us(), self.last_us.as_slice());
        vectorize(
            // What is captured by reference might be among the values: it would be read again and
            // again.
            #[inline(always)]
            move || {
                for (out, &last_us) in out.iter_mut().zip(last_us) {
                    *out = value((last_us + offset_us).max(0));
                }
            },
        );
    }

    /// As [`Self::render`], of the latest event of either polarity, `[height][width]`.
    #[inline(always)]
    pub(crate) fn render_joined(&self, out: &mut [f32], value: impl Fn(i32) -> f32 + Copy) {
        assert_eq!(2 * out.len(), self.last_us.len(), "planes of another size");
        let (offset_us, (first, second)) = (self.offset_us(), self.last_us.split_at(out.len()));
        vectorize(
            #[inline(always)]
            move || {
                for (out, (&first, &second)) in out.iter_mut().zip(first.iter().zip(second)) {
                    *out = value((first.max(second) + offset_us).max(0));
                }
            },
        );
    }

    /// Times left are times of events plus this: what was so long ago is below zero by then.
    fn offset_us(&self) -> i32 {
        let now_us = match (self.clock.now, self.origin) {
            // At most `FURTHEST_US`: the origin has been moved.
            (Some(now), Some(origin)) => now.0.saturating_sub(origin.0) as i32,
            _ => 0,
        };
        self.window.length_us - now_us
    }

    /// A time after the origin, which moves there if the time is too far from it.
    fn since_origin(&mut self, t: Micros) -> i32 {
        let origin = *self.origin.get_or_insert(t);
        let after_us = t.0.saturating_sub(origin.0);
        if after_us > FURTHEST_US {
            self.move_origin(t, after_us);
            return 0;
        }
        after_us.max(NEVER.into()) as i32
    }

    #[cold]
    fn move_origin(&mut self, to: Micros, by_us: i64) {
        for last_us in &mut self.last_us {
            // What falls behind `NEVER` is in no window.
            *last_us = i64::from(*last_us).saturating_sub(by_us).max(NEVER.into()) as i32;
        }
        self.origin = Some(to);
    }
}
