//! How many events there are, and how many each pixel has.

use evpose_core::EventStream;

use crate::relative_difference;

/// Difference of the numbers of events of a polarity over their mean.
pub(crate) fn of_totals(a: &EventStream, b: &EventStream, is_on: bool) -> f64 {
    let total = |events: &EventStream| {
        events.polarity().iter().filter(|polarity| polarity.is_on() == is_on).count() as f64
    };
    relative_difference(&[total(a)], &[total(b)])
}

/// Mean absolute difference of the counts of a pixel over the mean count.
pub(crate) fn per_pixel(a: &EventStream, b: &EventStream, is_on: bool) -> f64 {
    relative_difference(&of_pixels(a, is_on), &of_pixels(b, is_on))
}

fn of_pixels(events: &EventStream, is_on: bool) -> Vec<f64> {
    let mut counts = vec![0.0; events.sensor().pixels()];
    for event in events.iter().filter(|event| event.polarity.is_on() == is_on) {
        counts[usize::from(event.y) * usize::from(events.sensor().width) + usize::from(event.x)] +=
            1.0;
    }
    counts
}
