//! Event counts, in total and per pixel.

use evpose_core::EventStream;

use crate::relative_difference;

pub(crate) fn total(a: &EventStream, b: &EventStream, is_on: bool) -> f64 {
    let count = |events: &EventStream| {
        events.polarity().iter().filter(|polarity| polarity.is_on() == is_on).count() as f64
    };
    relative_difference(&[count(a)], &[count(b)])
}

/// Mean absolute difference of the counts of pixels, relative to the mean count.
pub(crate) fn per_pixel(a: &EventStream, b: &EventStream, is_on: bool) -> f64 {
    relative_difference(&counts(a, is_on), &counts(b, is_on))
}

fn counts(events: &EventStream, is_on: bool) -> Vec<f64> {
    let mut counts = vec![0.0; events.sensor().pixels()];
    for event in events.iter().filter(|event| event.polarity.is_on() == is_on) {
        counts[usize::from(event.y) * usize::from(events.sensor().width) + usize::from(event.x)] +=
            1.0;
    }
    counts
}
