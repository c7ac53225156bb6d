//! High bits of time stamps, which RAW files send in words of their own (`EVT_TIME_HIGH`).

use crate::time_stamp::{HalfPeriodFall, WraparoundCounter};

/// Maximal wraparounds, of this counter and of what is above it, that a writer bridges without an
/// event: two words each. More, and the stamps are more likely to count from 1970 than from the
/// start of the recording.
const MAX_WRAPAROUNDS: i64 = 1 << 20;

/// A time that an encoding does not hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("event at {t} µs: its clock does not go from {from} to {to}")]
pub struct EncodeError {
    t: i64,
    from: i64,
    to: i64,
}

/// The high bits of time stamps, `BITS` of them in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TimeHigh<const BITS: u32>(WraparoundCounter);

impl<const BITS: u32> Default for TimeHigh<BITS> {
    fn default() -> Self {
        Self(WraparoundCounter::new(BITS, HalfPeriodFall::Wraparound))
    }
}

impl<const BITS: u32> TimeHigh<BITS> {
    const MASK: i64 = (1 << BITS) - 1;

    /// Whether any word came.
    pub(super) fn is_set(&self) -> bool {
        self.0.is_set()
    }

    /// The unwrapped high bits; 0 before any word.
    pub(super) fn value(&self) -> i64 {
        self.0.value()
    }

    /// Takes the value of a word and returns the unwrapped high bits.
    pub(super) fn advance(&mut self, word: i64) -> i64 {
        self.0.advance(word)
    }

    /// Advances to the time `t` without its low bits, by words whose values go to `write`. A wraparound
    /// is always the largest value and then 0, which every decoder recognises.
    ///
    /// # Errors
    /// If `t` is before the current value, or further away than a recording lasts.
    pub(super) fn advance_to(
        &mut self,
        t: i64,
        low_bits: u32,
        mut write: impl FnMut(i64),
    ) -> Result<(), EncodeError> {
        let target = t >> low_bits;
        let wraparounds = (target >> BITS) - (self.value() >> BITS);
        if target < self.value() || wraparounds > MAX_WRAPAROUNDS {
            return Err(EncodeError { t, from: self.value(), to: target });
        }
        let is_first = !self.is_set();
        let mut value = self.value();
        let mut put = |word| {
            write(word);
            self.advance(word)
        };
        if is_first && target > Self::MASK {
            // Readers count wraparounds from the first word, so that one is of the first period.
            value = put(0);
        }
        while value >> BITS < target >> BITS {
            if value & Self::MASK != Self::MASK {
                put(Self::MASK);
            }
            value = put(0);
        }
        // The first word is always written; a later one unless a wraparound has led there.
        if value != target || (is_first && target <= Self::MASK) {
            put(target & Self::MASK);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_reader_follows_a_writer(mut targets in prop::collection::vec(0_i64..100_000, 1..20)) {
            targets.sort_unstable();
            let (mut writer, mut reader) = (TimeHigh::<12>::default(), TimeHigh::<12>::default());
            for target in targets {
                let mut value = reader.value();
                writer.advance_to(target, 0, |word| value = reader.advance(word)).unwrap();
                prop_assert_eq!(value, target);
                prop_assert_eq!(writer, reader);
            }
        }
    }

    #[test]
    fn writers_neither_go_back_nor_bridge_years() {
        let mut time_high = TimeHigh::<12>::default();
        assert!(time_high.advance_to(-1, 0, |_| ()).is_err());
        assert!(time_high.advance_to(1 << 40, 0, |_| ()).is_err());
        assert!(time_high.advance_to(7, 0, |_| ()).is_ok());
        assert!(time_high.advance_to(6, 0, |_| ()).is_err());
    }

    #[test]
    fn words_of_a_first_late_time_begin_at_zero() {
        let (mut time_high, mut words) = (TimeHigh::<12>::default(), Vec::new());
        time_high.advance_to(0x2005, 0, |word| words.push(word)).unwrap();
        assert_eq!(words, [0, 0xFFF, 0, 0xFFF, 0, 5]);
    }
}
