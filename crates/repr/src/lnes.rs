//! LNES: how recent the last event of each pixel and polarity is.
//!
//! # Model
//! `LNES(x, y, p) = (t − t_start) / (t_end − t_start)` of the last event at `(x, y)` with polarity
//! `p`, 0 where there was none.
//!
//! # Source
//! Rudnev et al., *EventHands*, ICCV 2021, Sec. 4.

use crate::frame::{FrameSurface, Write};

/// Locally normalised event surface.
#[derive(Debug)]
pub(crate) struct Lnes;

impl FrameSurface for Lnes {
    fn write(&self, planes: &mut [f32], event: Write) {
        planes[event.pixel] = event.age;
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Polarity;

    use crate::frame::tests::{event, planes};

    #[test]
    fn the_last_event_wins_and_ages_are_shares_of_the_window() {
        let planes = planes(
            "lnes",
            &[
                event(1, 0, 0, Polarity::On),
                event(3, 0, 0, Polarity::On),
                event(2, 1, 0, Polarity::On),
            ],
        );
        assert_eq!(planes[6..], [0.75, 0.5, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(planes[..6], [0.0; 6]);
    }

    #[test]
    fn the_oldest_frame_is_invisible_as_published() {
        assert_eq!(planes("lnes", &[event(0, 0, 0, Polarity::On)]), [0.0; 12]);
    }
}
