//! Inter-event intervals of pixels.

use evpose_core::EventStream;

const PER_DECADE: f64 = 5.0;
/// Bins: one for equal time stamps, then from 1 us to 10 s.
const BINS: usize = 37;

/// Total variation distance of the histograms over the logarithm of the interval, at most one.
pub(crate) fn distance(a: &EventStream, b: &EventStream) -> f64 {
    let (a, b) = (histogram(a), histogram(b));
    0.5 * a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum::<f64>()
}

/// Fractions of all intervals; a recording without intervals has an extra bin.
fn histogram(events: &EventStream) -> [f64; BINS + 1] {
    let width = usize::from(events.sensor().width);
    let mut last = vec![None; events.sensor().pixels()];
    let mut shares = [0.0; BINS + 1];
    for event in events.iter() {
        let pixel = usize::from(event.y) * width + usize::from(event.x);
        if let Some(before) = last[pixel].replace(event.t.0) {
            let interval_us = event.t.0 - before;
            let bin = match interval_us {
                // Zero has no logarithm.
                0 => 0,
                us => 1 + ((us as f64).log10() * PER_DECADE) as usize,
            };
            shares[bin.min(BINS - 1)] += 1.0;
        }
    }
    let sum: f64 = shares.iter().sum();
    if sum > 0.0 {
        shares.iter_mut().for_each(|share| *share /= sum);
    } else {
        shares[BINS] = 1.0;
    }
    shares
}
