//! A pixel's request for an event, before it has a timestamp.

use evpose_core::Polarity;

/// Origin of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Origin {
    /// A change of light, or of what the circuit takes for one.
    Signal,
    /// Charge that leaked off the memory.
    Leak,
    /// Shot noise, or noise without a cause.
    Shot,
    /// A hot pixel.
    Hot,
}

/// A request of a pixel for an event. It becomes an event when the readout serves it and the clock
/// stamps it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Time of the event, in seconds.
    pub t_s: f64,
    /// Pixel index, row by row from the top left.
    pub pixel: u32,
    /// Direction of the change.
    pub polarity: Polarity,
    /// Cause of the event.
    pub origin: Origin,
}

impl Request {
    /// Time and pixel in one number, which compares without a branch.
    pub(crate) fn order(&self) -> u128 {
        (u128::from(time_order(self.t_s)) << 32) | u128::from(self.pixel)
    }
}

/// Maps IEEE 754 floats to integers of the same order: the sign is flipped, and behind a set one
/// all other bits as well.
pub(crate) fn time_order(t_s: f64) -> u64 {
    let bits = t_s.to_bits();
    bits ^ (((bits as i64 >> 63) as u64) | (1 << 63))
}

/// Puts requests in order of time and, at equal times, of pixels. Requests of one pixel at one
/// time keep their order.
pub(crate) fn sort(requests: &mut [Request]) {
    // Detectors that place all events at the exposure are in order already.
    if !requests.is_sorted_by_key(Request::order) {
        requests.sort_by_key(Request::order);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_sorted_by_time_and_then_by_pixel() {
        let request =
            |t_s, pixel| Request { t_s, pixel, polarity: Polarity::On, origin: Origin::Signal };
        let sorted = [
            request(-2.0, 3),
            request(-1.0, 9),
            request(0.0, 1),
            request(1e-6, 0),
            request(1e-6, 70_000),
            request(3.0, 2),
        ];
        let mut shuffled = [3, 0, 5, 2, 4, 1].map(|i| sorted[i]);
        sort(&mut shuffled);
        assert_eq!(shuffled, sorted);
    }
}
