//! Writes EVT 3.0.

use evpose_core::{EventStream, Polarity, SensorSize};

use super::WordEncoder;
use super::evt3::{ADDR_X, ADDR_Y, TIME_HIGH, TIME_LOW, VECT_8, VECT_12, VECT_BASE_X};
use super::time_high::{EncodeError, TimeHigh};

/// Pixels of a vector: words of 12, 12 and 8, as cameras send them. Some decoders take no others.
const PIXELS: u16 = 32;
/// Words of a vector, without that of its base.
const VECTOR_WORDS: usize = 3;

/// Turns events into words of EVT 3.0.
///
/// Events that follow each other in a row, at one time, of one polarity and from left to right
/// become vectors where these are shorter.
#[derive(Debug)]
pub struct Evt3Encoder {
    time_high: TimeHigh<12>,
    low: Option<i64>,
    row: Option<u16>,
    /// Begin of the next vector if no base is sent.
    base: Option<(u16, Polarity)>,
    width: u16,
    has_vectors: bool,
}

impl Evt3Encoder {
    /// The same without vectors, as cameras send what moves little.
    pub fn without_vectors(self) -> Self {
        Self { has_vectors: false, ..self }
    }

    /// Packs events from index `at` on into a vector: base, mask, and count of events.
    fn vector(&self, events: &EventStream, at: usize) -> Option<(u16, u32, usize)> {
        let first = events.get(at)?;
        // Vectors that reach beyond the sensor are faults to some decoders.
        let last_base = self.width.checked_sub(PIXELS).filter(|_| self.has_vectors)?;
        let goes_on = self.base.filter(|&(base, polarity)| {
            polarity == first.polarity
                && base <= last_base
                && (base..base + PIXELS).contains(&first.x)
        });
        let base = goes_on.map_or(first.x.min(last_base), |(base, _)| base);
        let (mut mask, mut count) = (0_u32, 0);
        while let Some(event) = events.get(at + count)
            && (event.t, event.y, event.polarity) == (first.t, first.y, first.polarity)
            && (base..base + PIXELS).contains(&event.x)
            // To the right of all before, or they would come in another order.
            && mask >> (event.x - base) == 0
        {
            mask |= 1 << (event.x - base);
            count += 1;
        }
        let words = VECTOR_WORDS + usize::from(goes_on.is_none());
        (count > words).then_some((base, mask, count))
    }
}

impl WordEncoder for Evt3Encoder {
    const NAMES: (&'static str, &'static str) = ("3.0", "EVT3");

    fn new(sensor: SensorSize) -> Self {
        Self {
            time_high: TimeHigh::default(),
            low: None,
            row: None,
            base: None,
            width: sensor.width,
            has_vectors: true,
        }
    }

    fn encode(&mut self, events: &EventStream, words: &mut Vec<u8>) -> Result<(), EncodeError> {
        let mut word = |kind: u16, value: u16| words.extend((kind << 12 | value).to_le_bytes());
        let mut at = 0;
        while let Some(event) = events.get(at) {
            let t = event.t.0;
            // The first event, and any in another period of the low bits.
            if !self.time_high.is_set() || self.time_high.value() != t >> 12 {
                self.time_high.advance_to(t, 12, |value| word(TIME_HIGH, value as u16))?;
                // Readers may forget the low bits with a new high time.
                self.low = None;
            }
            // EVT 3.0 keeps state: only what differs from the event before is written.
            if self.low.replace(t & 0xFFF) != Some(t & 0xFFF) {
                word(TIME_LOW, (t & 0xFFF) as u16);
            }
            if self.row.replace(event.y) != Some(event.y) {
                word(ADDR_Y, event.y);
            }
            let polarity = (event.polarity as u16) << 11;
            // A vector is worth its words only if these are fewer than its events.
            let Some((base, mask, count)) = self.vector(events, at) else {
                word(ADDR_X, polarity | event.x);
                at += 1;
                continue;
            };
            // Readers go on behind the last vector: one that begins there needs no base.
            if self.base != Some((base, event.polarity)) {
                word(VECT_BASE_X, polarity | base);
            }
            word(VECT_12, (mask & 0xFFF) as u16);
            word(VECT_12, (mask >> 12 & 0xFFF) as u16);
            word(VECT_8, (mask >> 24) as u16);
            // A vector moves the base of readers behind its last pixel.
            self.base = Some((base + PIXELS, event.polarity));
            at += count;
        }
        Ok(())
    }
}
