//! A pixel's request for an event, before it has a timestamp.

use evpose_core::Polarity;

/// A pixel that has something to say. Becomes an event when the readout serves it and the clock
/// stamps it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// When, in seconds.
    pub t_s: f64,
    /// Which pixel, row by row from the top left.
    pub pixel: u32,
    /// Direction of the change.
    pub polarity: Polarity,
}

/// Puts requests in order of time and, at equal times, of pixels. Requests of one pixel at one
/// time keep their order.
pub(crate) fn sort(requests: &mut [Request]) {
    let order = |a: &Request, b: &Request| a.t_s.total_cmp(&b.t_s).then(a.pixel.cmp(&b.pixel));
    // Detectors that place all events at the exposure are in order already.
    if !requests.is_sorted_by(|a, b| order(a, b).is_le()) {
        requests.sort_by(order);
    }
}
