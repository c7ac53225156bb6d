//! Events that nothing near them supports: the noise of pixels by themselves.
//!
//! # Model
//! An event is kept if another one happened at one of the eight pixels around it, at most 70 ms
//! before. Events that are taken out support others nevertheless.
//!
//! # Variants
//! The published program looks at the four images side by side, as one of 1384x260 pixels. So
//! events at the edge of one camera support those at the edge of the next, those at the outermost
//! border support none, and at the beginning of the clock everything is supported, since all pixels
//! are taken to have had an event at time 0.
//!
//! # Source
//! The published `BackgroundFilter.m`.

use evpose_core::EventStream;

use super::{CAMERAS, SENSOR};

/// Keeps events with neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BackgroundFilter {
    /// How long an event supports those around it, in microseconds.
    pub support_us: i64,
    /// Rule by which events support their neighbours.
    pub rule: NeighbourRule,
}

impl Default for BackgroundFilter {
    fn default() -> Self {
        Self { support_us: 70_000, rule: NeighbourRule::default() }
    }
}

/// Rule by which events support their neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NeighbourRule {
    /// Each pixel around an event on the same camera.
    #[default]
    PerCamera,
    /// As in the published program. Events of different cameras at the same microsecond are taken
    /// in the order of the cameras, there in that of the file: it matters at edges that touch only.
    Published,
}

/// Takes out of each camera what has no support.
pub(super) fn keep_supported(cameras: &mut [EventStream; CAMERAS], filter: &BackgroundFilter) {
    let (width, height) = (usize::from(SENSOR.width), usize::from(SENSOR.height));
    match filter.rule {
        NeighbourRule::PerCamera => {
            for camera in cameras {
                let mut support = Support::new(width, height, filter);
                camera.retain(|e| support.take(e.t.0, e.x.into(), e.y.into()));
            }
        }
        NeighbourRule::Published => {
            // As published: cameras lie side by side, and borders support events of the next.
            let mut support = Support::new(CAMERAS * width, height, filter);
            let mut next = [0; CAMERAS];
            let mut are_kept = cameras.each_ref().map(|camera| Vec::with_capacity(camera.len()));
            loop {
                // In the order of time over all cameras, as they were in one stream.
                let waiting = (0..CAMERAS).filter(|&k| next[k] < cameras[k].len());
                let Some(k) = waiting.min_by_key(|&k| cameras[k].t()[next[k]]) else { break };
                let (camera, i) = (&cameras[k], next[k]);
                let x = usize::from(camera.x()[i]) + k * width;
                are_kept[k].push(support.take(camera.t()[i].0, x, camera.y()[i].into()));
                next[k] += 1;
            }
            for (camera, are_kept) in cameras.iter_mut().zip(are_kept) {
                let mut are_kept = are_kept.into_iter();
                camera.retain(|_| are_kept.next().unwrap_or(true));
            }
        }
    }
}

/// When each pixel was last supported.
struct Support {
    width: usize,
    height: usize,
    /// Row by row.
    last_us: Vec<i64>,
    support_us: i64,
    rule: NeighbourRule,
}

impl Support {
    fn new(width: usize, height: usize, filter: &BackgroundFilter) -> Self {
        let begin_us = match filter.rule {
            NeighbourRule::PerCamera => i64::MIN,
            NeighbourRule::Published => 0,
        };
        let BackgroundFilter { support_us, rule } = *filter;
        Self { width, height, last_us: vec![begin_us; width * height], support_us, rule }
    }

    /// Whether an event is supported. It supports what is around it from then on.
    fn take(&mut self, t_us: i64, x: usize, y: usize) -> bool {
        let last_us = self.last_us[y * self.width + x];
        let is_supported = t_us.saturating_sub(last_us) <= self.support_us;
        let is_at_border = x == 0 || x + 1 == self.width || y == 0 || y + 1 == self.height;
        if is_at_border && self.rule == NeighbourRule::Published {
            return is_supported;
        }
        for row in y.saturating_sub(1)..(y + 2).min(self.height) {
            let columns = x.saturating_sub(1)..(x + 2).min(self.width);
            let begin = row * self.width;
            self.last_us[begin + columns.start..begin + columns.end].fill(t_us);
        }
        // Not by itself.
        self.last_us[y * self.width + x] = last_us;
        is_supported
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Micros, Polarity};

    use super::*;

    fn filtered(events: &[(usize, i64, u16, u16)], rule: NeighbourRule) -> [Vec<i64>; CAMERAS] {
        let mut cameras: [EventStream; CAMERAS] =
            std::array::from_fn(|k| {
                let events = events
                    .iter()
                    .filter(|event| event.0 == k)
                    .map(|&(_, t, x, y)| Event { t: Micros(t), x, y, polarity: Polarity::Off });
                EventStream::from_events(SENSOR, events).unwrap()
            });
        keep_supported(&mut cameras, &BackgroundFilter { rule, ..BackgroundFilter::default() });
        cameras.map(|camera| camera.t().iter().map(|t| t.0).collect())
    }

    const LATE: i64 = 1_000_000;

    #[test]
    fn neighbours_support_each_other_for_70_ms_and_no_pixel_supports_itself() {
        let events = [
            (0, LATE, 10, 10),
            (0, LATE + 1, 10, 10),
            (0, LATE + 70_000, 11, 9),
            (0, LATE + 70_002, 9, 11),
            (0, LATE + 70_003, 12, 10),
        ];
        for rule in [NeighbourRule::PerCamera, NeighbourRule::Published] {
            // The last two are next to what was taken out, and next to what was kept.
            assert_eq!(filtered(&events, rule)[0], [LATE + 70_000, LATE + 70_003]);
        }
    }

    #[test]
    fn cameras_touch_only_in_the_published_program() {
        let events = [(0, LATE, 345, 5), (1, LATE + 1, 0, 6), (3, LATE, 345, 5), (3, LATE, 345, 6)];
        let [_, second, _, last] = filtered(&events, NeighbourRule::PerCamera);
        assert_eq!((second, last), (vec![], vec![LATE]));
        let [_, second, _, last] = filtered(&events, NeighbourRule::Published);
        assert_eq!((second, last), (vec![LATE + 1], vec![]));
        assert_eq!(filtered(&[(0, 70_000, 3, 3)], NeighbourRule::Published)[0], [70_000]);
        assert!(filtered(&[(0, 70_000, 3, 3)], NeighbourRule::PerCamera)[0].is_empty());
    }
}
