//! Events of EVT 2.1 on their way into columns, each as a word of EVT 2.0 with its high time.
//!
//! | bits | content |
//! |---|---|
//! | 0 to 10 | row |
//! | 11 to 21 | column |
//! | 22 to 27 | low time |
//! | 28 | polarity |
//! | 32 to 63 | high time, counted from that of the batch |
//!
//! One store an event, whatever the high time: columns are made of many at once, which vectors do.

use evpose_core::{Micros, Polarity};
use evpose_cpu::vectorize;

use super::evt2::LOW_BITS;
use super::mask_bits::put_bits;
use crate::Columns;

/// Places for events.
const PLACES: usize = 2048;
/// Places that a mask may fill.
const MASK: usize = 32;
/// Events of a mask that are put one by one: where events are scattered, most words have one.
const FEW: usize = 3;
/// Bit offset of the column.
const X: u32 = 11;
/// Bit offset of the low time.
const LOW: u32 = 22;
/// Bit offset of the polarity.
const IS_ON: u32 = 28;
/// Bit offset of the high time.
const HIGH: u32 = 32;
/// Coordinates of a word.
const COORDINATE: u64 = 0x7FF;
/// Low times.
const TIME: u64 = (1 << LOW_BITS) - 1;

/// Some events of nearly one high time.
pub(super) struct Words {
    places: [u64; PLACES],
    events: usize,
    /// The high time that others count from.
    base: i64,
    /// The high time, from there on, at its place in a word.
    high: u64,
}

impl Words {
    pub(super) fn new() -> Self {
        Self { places: [0; PLACES], events: 0, base: 0, high: 0 }
    }

    /// Sets the high time of all events from here on.
    #[inline(always)]
    pub(super) fn set_high(&mut self, high: i64, columns: &mut Columns) {
        match u32::try_from(high.wrapping_sub(self.base)) {
            Ok(since) => self.high = u64::from(since) << HIGH,
            Err(_) => {
                // Events that wait count from the old base, so that they are written first.
                self.flush(columns);
                (self.base, self.high) = (high, 0);
            }
        }
    }

    /// Puts events of the row, time and polarity of `word`, at its column and what bits of `mask`
    /// are set further right.
    #[inline(always)]
    pub(super) fn spread(&mut self, word: u32, mask: u32, columns: &mut Columns) {
        // Room for all bits of a mask, so that no place is checked.
        if self.events > PLACES - MASK {
            self.flush(columns);
        }
        // So far right a column could run into the bits above: those go the slow way.
        if u64::from(word >> X) & COORDINATE > COORDINATE - (MASK as u64 - 1) {
            return self.spread_far(word, mask, columns);
        }
        let first = u64::from(word) | self.high;
        // Few bits: a loop of fixed length needs no guess of its end.
        let count = mask.count_ones() as usize;
        if count <= FEW {
            let places = &mut self.places[self.events..self.events + FEW];
            let mut rest = mask;
            for place in places {
                // What is behind the last is overwritten.
                *place = first.wrapping_add(u64::from(rest.trailing_zeros()) << X);
                rest &= rest.wrapping_sub(1);
            }
            self.events += count;
            return;
        }
        put_bits::<{ MASK / 8 }>(first, mask, X, &mut self.places[..], &mut self.events);
    }

    /// The same further right than words go, where no camera has pixels.
    #[cold]
    fn spread_far(&mut self, word: u32, mask: u32, columns: &mut Columns) {
        self.flush(columns);
        let first = u64::from(word) | self.high;
        for bit in (0..MASK as u16).filter(|bit| mask >> bit & 1 == 1) {
            columns.t.push(time(first, self.base));
            columns.x.push((first >> X & COORDINATE) as u16 + bit);
            columns.y.push((first & COORDINATE) as u16);
            columns.polarity.push(Polarity::from_on(first >> IS_ON & 1 == 1));
        }
    }

    /// Appends the events to `columns`.
    #[inline(never)]
    pub(super) fn flush(&mut self, columns: &mut Columns) {
        let (words, base) = (&self.places[..self.events], self.base);
        vectorize(
            #[inline(always)]
            || {
                columns.t.extend(words.iter().map(|&word| time(word, base)));
                columns.x.extend(words.iter().map(|word| (word >> X & COORDINATE) as u16));
                columns.y.extend(words.iter().map(|word| (word & COORDINATE) as u16));
                let is_on = words.iter().map(|word| Polarity::from_on(word >> IS_ON & 1 == 1));
                columns.polarity.extend(is_on);
            },
        );
        self.events = 0;
    }
}

/// The time of an event, whose high time counts from `base`.
#[inline(always)]
fn time(word: u64, base: i64) -> Micros {
    let high = base + (word >> HIGH) as i64;
    Micros(high << LOW_BITS | (word >> LOW & TIME) as i64)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Few and many events of a word, columns beyond any camera, and high times that go back
        /// and further on than a word holds.
        #[test]
        fn words_become_the_events_that_their_bits_say(
            words in prop::collection::vec(
                (0..1_u32 << 29, any::<u32>(), any::<u32>(), prop::option::of(0..1_i64 << 40)),
                0..400,
            ),
        ) {
            let (mut got, mut want) = (Columns::new(), Columns::new());
            let (mut batch, mut high) = (Words::new(), 0);
            for (word, mask, sparse, jump) in words {
                // Half of the masks have few bits.
                let mask = if sparse & 1 == 1 { mask & sparse & sparse.rotate_left(9) } else { mask };
                if let Some(jump) = jump.filter(|_| sparse & 6 == 0) {
                    high = if sparse & 8 == 0 { jump } else { high + (jump & 0xFF) };
                    batch.set_high(high, &mut got);
                }
                batch.spread(word, mask, &mut got);
                for bit in (0..32).filter(|bit| mask >> bit & 1 == 1) {
                    want.t.push(Micros(64 * high + i64::from(word >> 22 & 0x3F)));
                    want.x.push((word >> 11 & 0x7FF) as u16 + bit);
                    want.y.push((word & 0x7FF) as u16);
                    want.polarity.push(Polarity::from_on(word >> 28 == 1));
                }
            }
            batch.flush(&mut got);
            prop_assert_eq!(got, want);
        }
    }
}
