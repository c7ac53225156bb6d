//! Time stamps in another unit than microseconds, detected by the length of the recording.

use evpose_core::{Event, EventStream, Micros};

use super::recording::on;

const MIN_EVENTS: usize = 100;
/// Range of the ratio of the span of events to the expected one, in the right unit.
const FITS: std::ops::Range<f64> = 0.5..1.1;
const RATIOS: [f64; 4] = [1e-6, 1e-3, 1e3, 1e6];

/// Factor by which a recording is too long in a wrong unit, if it is; `expected_s` is the expected
/// time from the first event to the last.
pub fn too_long_by(events: &EventStream, expected_s: f64) -> Option<f64> {
    let span_s = span_s(events)?;
    if events.len() < MIN_EVENTS || expected_s <= 0.0 {
        return None;
    }
    if span_s * 1e6 <= expected_s.ceil() {
        // Whole seconds: too coarse for the comparison below.
        return Some(RATIOS[0]);
    }
    RATIOS.into_iter().find(|ratio| FITS.contains(&(span_s / expected_s / ratio)))
}

/// Time from the first event to the last, seconds.
pub fn span_s(events: &EventStream) -> Option<f64> {
    let (first, last) = (events.t().first()?, events.t().last()?);
    // At least one count of the clock.
    Some((last.0 - first.0).max(1) as f64 * 1e-6)
}

/// Describes the unit that the time stamps seem to have.
pub fn words(too_long_by: f64) -> &'static str {
    match too_long_by {
        r if r >= 1e6 => "microseconds read as seconds",
        r if r >= 1e3 => "nanoseconds read as microseconds, or milliseconds as seconds",
        r if r >= 1e-3 => "milliseconds read as microseconds",
        _ => "seconds read as microseconds, the rest of which is lost",
    }
}

/// Divides all time stamps by a factor.
pub fn divided(events: &EventStream, factor: f64) -> EventStream {
    let scaled = |event: Event| {
        let t = Micros((event.t.0 as f64 / factor).round() as i64);
        Event { t, ..event }
    };
    on(events.sensor(), events.iter().map(scaled))
}

/// Shifts all time stamps by `by`.
pub fn shifted(events: &EventStream, by: Micros) -> EventStream {
    on(events.sensor(), events.iter().map(|event| Event { t: event.t + by, ..event }))
}
