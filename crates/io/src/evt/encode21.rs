//! Writes EVT 2.1, the lower half of a word first.

use evpose_core::{EventStream, SensorSize};

use super::WordEncoder;
use super::encode2::{head, write_time_high};
use super::evt21::PIXELS;
use super::time_high::{EncodeError, TimeHigh};

/// Turns events into words of EVT 2.1: one for the events that follow each other within one of the
/// blocks of 32 pixels, at one time, of one polarity and from left to right.
#[derive(Debug)]
pub struct Evt21Encoder {
    time_high: TimeHigh<28>,
}

impl WordEncoder for Evt21Encoder {
    const NAMES: (&'static str, &'static str) = ("2.1", "EVT21;endianness=little");

    fn new(_: SensorSize) -> Self {
        Self { time_high: TimeHigh::default() }
    }

    fn encode(&mut self, events: &EventStream, words: &mut Vec<u8>) -> Result<(), EncodeError> {
        let mut word = |upper: u32, mask: u32| {
            words.extend((u64::from(upper) << 32 | u64::from(mask)).to_le_bytes());
        };
        let mut rest = events.iter().peekable();
        while let Some(first) = rest.next() {
            // High bits of the time first, if they changed: readers add the low ones to them.
            write_time_high(&mut self.time_high, first.t.0, |upper| word(upper, 0))?;
            let block = first.x - first.x % PIXELS;
            let mut mask = 1_u32 << (first.x - block);
            while let Some(event) = rest.next_if(|event| {
                (event.t, event.y, event.polarity) == (first.t, first.y, first.polarity)
                    && event.x - event.x % PIXELS == block
                    // To the right of all before, or they would come in another order.
                    && mask >> (event.x - block) == 0
            }) {
                mask |= 1 << (event.x - block);
            }
            word(head(first.t.0, block, first.y, first.polarity as u32), mask);
        }
        Ok(())
    }
}
