//! Reference events of a window, pixel by pixel.

use evpose_core::TimeWindow;

use crate::View;

#[derive(Debug, Clone, Copy)]
pub(super) struct List<'a> {
    /// Index of the pixel, row by row.
    pub(super) pixel: usize,
    pub(super) is_on: bool,
    /// Times in microseconds, in order.
    pub(super) t_us: &'a [i64],
}

/// Non-empty lists of the events inside a window.
pub(super) fn lists<'a>(view: &View<'a>, window: TimeWindow) -> impl Iterator<Item = List<'a>> {
    let expected = &view.reference_scene.expected;
    let (start_us, end_us) = (window.start.0, window.end.0);
    let all = (0..2 * view.size().pixels()).map(move |i| {
        let (pixel, is_on) = (i / 2, i % 2 == 1);
        let times = expected.times(pixel, is_on);
        List { pixel, is_on, t_us: inside(times, start_us, end_us) }
    });
    all.filter(|list| !list.t_us.is_empty())
}

fn inside(times: &[i64], start_us: i64, end_us: i64) -> &[i64] {
    let (Some(first), Some(last)) = (times.first(), times.last()) else { return times };
    if *first >= start_us && *last < end_us {
        // The common case: the window is the whole recording.
        return times;
    }
    let from = times.partition_point(|t| *t < start_us);
    let length = times[from..].partition_point(|t| *t < end_us);
    &times[from..from + length]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_a_half_open_window_remain() {
        let times = [1, 3, 3, 7];
        for (start, end, inner) in [
            (0, 8, &times[..]),
            (1, 7, &times[..3]),
            (3, 4, &times[1..3]),
            (4, 7, &[]),
            (9, 9, &[]),
        ] {
            assert_eq!(inside(&times, start, end), inner, "{start} {end}");
        }
        assert!(inside(&[], 0, 9).is_empty());
    }
}
