//! Clocks whose high bits come in words of their own and begin again at 0 when they are full.

/// Turns of a clock, and what is behind it, that a writer crosses without an event: two words each.
/// More, and the stamps are more likely to count from 1970 than from the start of the recording.
const MOST_TURNS: i64 = 1 << 20;

/// The high bits of a clock, `BITS` of them in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Clock<const BITS: u32> {
    /// With the turns of the clock above, if any word came.
    high: Option<i64>,
}

impl<const BITS: u32> Clock<BITS> {
    const MASK: i64 = (1 << BITS) - 1;

    pub(super) fn new() -> Self {
        Self { high: None }
    }

    /// Whether any word came.
    pub(super) fn is_set(self) -> bool {
        self.high.is_some()
    }

    /// The high bits with all turns; 0 before any word.
    pub(super) fn high(self) -> i64 {
        self.high.unwrap_or(0)
    }

    /// Takes the value of a word and returns the high bits. A step back by half a turn or more is the
    /// next turn; a smaller one is a step back in time, as in the vendor's decoder.
    pub(super) fn advance(&mut self, value: i64) -> i64 {
        let before = self.high();
        let is_turn = before & Self::MASK >= value + (1 << (BITS - 1));
        let turn = (before >> BITS) + i64::from(is_turn);
        *self.high.insert(turn << BITS | value)
    }

    /// Goes to `high` by words whose values go to `word`. A turn is always the fullest value and then
    /// 0, which every decoder takes for one.
    ///
    /// # Errors
    /// If it is before now, or more turns away than a recording lasts.
    pub(super) fn go_to(&mut self, high: i64, mut word: impl FnMut(i64)) -> Result<(), String> {
        let turns = (high >> BITS) - (self.high() >> BITS);
        if high < self.high() || turns > MOST_TURNS {
            return Err(format!("its clock does not go from {} to {high}", self.high()));
        }
        if self.high.is_none() && high > Self::MASK {
            word(0);
            self.high = Some(0);
        }
        while self.high != Some(high) {
            let now = self.high();
            let last = now | Self::MASK;
            if high <= last {
                word(high & Self::MASK);
                self.high = Some(high);
                break;
            }
            if now != last {
                word(Self::MASK);
            }
            word(0);
            self.high = Some(last + 1);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_large_step_back_is_a_turn_and_a_small_one_is_none() {
        let mut clock = Clock::<12>::new();
        assert_eq!(
            [0xFFF, 0, 5, 3, 0xFFF, 0x7FF].map(|v| clock.advance(v)),
            [0xFFF, 0x1000, 0x1005, 0x1003, 0x1FFF, 0x27FF]
        );
    }

    proptest! {
        #[test]
        fn a_reader_follows_a_writer(mut highs in prop::collection::vec(0_i64..100_000, 1..20)) {
            highs.sort_unstable();
            let (mut writer, mut reader) = (Clock::<12>::new(), Clock::<12>::new());
            for high in highs {
                let mut now = reader.high();
                writer.go_to(high, |value| now = reader.advance(value)).unwrap();
                prop_assert_eq!(now, high);
                prop_assert_eq!(writer, reader);
            }
        }
    }

    #[test]
    fn clocks_do_not_go_back_nor_for_ages() {
        let mut clock = Clock::<12>::new();
        assert!(clock.go_to(-1, |_| ()).is_err() && clock.go_to(1 << 40, |_| ()).is_err());
        assert!(clock.go_to(7, |_| ()).is_ok() && clock.go_to(6, |_| ()).is_err());
    }
}
