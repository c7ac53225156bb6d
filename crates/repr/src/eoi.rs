//! EOI: whether a pixel had an event of each polarity.
//!
//! # Model
//! `EOI(x, y, p) = 1` where there was an event, else 0.
//!
//! # Source
//! EventHands, supplement, Eq. 1.

use crate::frame::{FrameSurface, Write};

/// Event occurrence image.
#[derive(Debug)]
pub(crate) struct Eoi;

impl FrameSurface for Eoi {
    fn write(&self, planes: &mut [f32], event: Write) {
        planes[event.pixel] = 1.0;
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Polarity;

    use crate::frame::tests::{event, planes};

    #[test]
    fn time_and_number_do_not_matter() {
        let once = planes("eoi", &[event(0, 1, 1, Polarity::Off)]);
        let often = planes("eoi", &[event(0, 1, 1, Polarity::Off), event(3, 1, 1, Polarity::Off)]);
        assert_eq!(once, often);
        assert_eq!(once[4], 1.0);
    }
}
