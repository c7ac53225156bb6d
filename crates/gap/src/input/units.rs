//! Stamps in another unit than microseconds, told by how long the recording then is.

use evpose_core::{Event, EventStream, Micros};

use super::recording::on;

/// Fewer events say nothing of the unit.
const LEAST_EVENTS: usize = 100;
/// How far the span of events may be from the expected one, once the unit is right.
const FITS: std::ops::Range<f64> = 0.5..1.1;
/// How many times too long or too short a recording is in one unit read as another.
const RATIOS: [f64; 4] = [1e-6, 1e-3, 1e3, 1e6];

/// By what factor a recording is too long if it has the wrong unit, where `expected_s` is the time
/// from its first event to its last.
pub fn too_long_by(events: &EventStream, expected_s: f64) -> Option<f64> {
    let span_s = span_s(events)?;
    if events.len() < LEAST_EVENTS || expected_s <= 0.0 {
        return None;
    }
    if span_s * 1e6 <= expected_s.ceil() {
        // Whole seconds: too coarse for the comparison below.
        return Some(RATIOS[0]);
    }
    RATIOS.into_iter().find(|ratio| FITS.contains(&(span_s / expected_s / ratio)))
}

/// From the first event to the last.
pub fn span_s(events: &EventStream) -> Option<f64> {
    let (first, last) = (events.t().first()?, events.t().last()?);
    // At least one count of the clock.
    Some((last.0 - first.0).max(1) as f64 * 1e-6)
}

/// What the stamps seem to be.
pub fn words(too_long_by: f64) -> &'static str {
    match too_long_by {
        r if r >= 1e6 => "microseconds read as seconds",
        r if r >= 1e3 => "nanoseconds read as microseconds, or milliseconds as seconds",
        r if r >= 1e-3 => "milliseconds read as microseconds",
        _ => "seconds read as microseconds, the rest of which is lost",
    }
}

/// The recording with all stamps divided by a factor.
pub fn divided(events: &EventStream, factor: f64) -> EventStream {
    let scaled = |event: Event| {
        let t = Micros((event.t.0 as f64 / factor).round() as i64);
        Event { t, ..event }
    };
    on(events.sensor(), events.iter().map(scaled))
}

/// The recording with all stamps later by `by`.
pub fn shifted(events: &EventStream, by: Micros) -> EventStream {
    on(events.sensor(), events.iter().map(|event| Event { t: event.t + by, ..event }))
}
