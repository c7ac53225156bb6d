//! Event counts by blocks of the image.

use evpose_core::EventStream;

use crate::relative_difference;

/// Side of a block, pixels.
const BLOCK: usize = 8;

pub(crate) fn distance(a: &EventStream, b: &EventStream) -> f64 {
    relative_difference(&blocks(a), &blocks(b))
}

fn blocks(events: &EventStream) -> Vec<f64> {
    let across = usize::from(events.sensor().width).div_ceil(BLOCK);
    let down = usize::from(events.sensor().height).div_ceil(BLOCK);
    let mut counts = vec![0.0; across * down];
    for event in events.iter() {
        counts[usize::from(event.y) / BLOCK * across + usize::from(event.x) / BLOCK] += 1.0;
    }
    counts
}
