//! ECI and ECI-S: how many events a pixel had, by polarity or in all.
//!
//! # Model
//! `ECI(x, y, p) = 0.01 · |{events at (x, y) with polarity p}|`; ECI-S counts both polarities and
//! holds the sum in both channels, so that networks keep their input. The factor is EventHands'.
//!
//! # Source
//! EventHands, supplement, Eq. 2 and 3. Its code counts a pixel and polarity at most once a
//! millisecond: `once_per_frame`.

use crate::frame::{FrameSurface, Write};

/// What one event adds.
const STEP: f32 = 0.01;

/// Event count image.
#[derive(Debug)]
pub(crate) struct Eci {
    /// Whether an event counts in both channels (ECI-S).
    pub(crate) both: bool,
    /// Whether several events of a pixel and polarity in one frame count as one.
    pub(crate) once_per_frame: bool,
}

impl FrameSurface for Eci {
    fn write(&self, planes: &mut [f32], event: Write) {
        if self.once_per_frame && event.repeated {
            return;
        }
        planes[event.pixel] += STEP;
        if self.both {
            planes[event.other] += STEP;
        }
    }

    fn needs_repeats(&self) -> bool {
        self.once_per_frame
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Polarity;

    use crate::frame::FrameEvent;
    use crate::frame::tests::{event, planes};

    const EVENTS: [FrameEvent; 4] = [
        FrameEvent { frame: 1, x: 1, y: 0, polarity: Polarity::On },
        FrameEvent { frame: 1, x: 1, y: 0, polarity: Polarity::On },
        FrameEvent { frame: 1, x: 1, y: 0, polarity: Polarity::Off },
        FrameEvent { frame: 2, x: 1, y: 0, polarity: Polarity::On },
    ];

    /// (OFF, ON) of pixel (1, 0) in hundredths.
    fn counts(name: &str) -> (f32, f32) {
        let planes = planes(name, &EVENTS);
        ((planes[1] * 100.0).round(), (planes[7] * 100.0).round())
    }

    #[test]
    fn events_are_counted_by_the_published_definitions() {
        assert_eq!(counts("eci"), (1.0, 3.0));
        assert_eq!(counts("eci-s"), (4.0, 4.0));
    }

    #[test]
    fn parity_counts_a_pixel_once_a_millisecond() {
        assert_eq!(counts("eci-parity"), (1.0, 2.0));
        assert_eq!(counts("eci-s-parity"), (3.0, 3.0));
    }

    #[test]
    fn another_pixel_in_the_same_frame_is_no_repeat() {
        let planes =
            planes("eci-parity", &[event(1, 0, 0, Polarity::On), event(1, 1, 0, Polarity::On)]);
        assert_eq!(planes[6..8], [0.01, 0.01]);
    }
}
