//! Writes EVT 2.0.

use evpose_core::{EventStream, SensorSize};

use super::WordEncoder;
use super::evt2::{LOW_BITS, TIME_HIGH};
use super::time_high::{EncodeError, TimeHigh};

/// Turns events into words of EVT 2.0.
#[derive(Debug)]
pub struct Evt2Encoder {
    time_high: TimeHigh<28>,
}

impl WordEncoder for Evt2Encoder {
    const NAMES: (&'static str, &'static str) = ("2.0", "EVT2");

    fn new(_: SensorSize) -> Self {
        Self { time_high: TimeHigh::default() }
    }

    fn encode(&mut self, events: &EventStream, words: &mut Vec<u8>) -> Result<(), EncodeError> {
        for event in events.iter() {
            write_time_high(&mut self.time_high, event.t.0, |word| {
                words.extend(word.to_le_bytes());
            })?;
            words.extend(head(event.t.0, event.x, event.y, event.polarity as u32).to_le_bytes());
        }
        Ok(())
    }
}

/// Writes words of high times up to that of `t`.
pub(super) fn write_time_high(
    time_high: &mut TimeHigh<28>,
    t: i64,
    mut word: impl FnMut(u32),
) -> Result<(), EncodeError> {
    if time_high.is_set() && time_high.value() == t >> LOW_BITS {
        return Ok(());
    }
    time_high.advance_to(t, LOW_BITS, |value| word(TIME_HIGH << 28 | value as u32))
}

/// The word of an event, or the upper half of one of EVT 2.1.
pub(super) fn head(t: i64, x: u16, y: u16, polarity: u32) -> u32 {
    polarity << 28 | (t as u32 & 0x3F) << 22 | u32::from(x) << 11 | u32::from(y)
}
