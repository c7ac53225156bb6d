//! Unwrapping of time stamps that a file stores in a counter of few bits.
//!
//! A counter of `n` bits begins again at 0 after 2ⁿ ticks (a *wraparound*). Stored stamps also go
//! back a little without one, since events of a sensor's readout arrive slightly out of order.
//! Every format decides by the size of the fall; formats differ in what else they accept:
//!
//! | format | counter | fall by half a period | rise by more than half a period |
//! |---|---|---|---|
//! | EVT 2.0, 2.1 | 28 bits of 64 µs | wraparound | time goes on |
//! | EVT 3.0 | 12 bits of 4096 µs | wraparound | time goes on |
//! | DAT | 32 bits of 1 µs | wraparound | late stamp of the previous period |
//! | AEDAT 1.0, 2.0 | 32 bits of 1 µs | step back | step back into the previous period |
//! | N-MNIST | 23 bits of 1 µs | step back | time goes on |
//! | YARP | 24 to 32 bits, found out while reading | step back | time goes on |
//!
//! Larger falls are wraparounds and smaller ones steps back in time in all of them. Steps back are
//! passed on; readers of whole recordings sort or reject such events.

/// Meaning of a fall by exactly half a period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HalfPeriodFall {
    /// The counter has wrapped around, as in OpenEB's decoders.
    Wraparound,
    /// Time goes back.
    StepBack,
}

/// A counter of ticks that wraps around, followed over whole periods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct WraparoundCounter {
    /// Ticks until the counter begins again at 0.
    period: i64,
    half: HalfPeriodFall,
    /// Ticks of all completed periods.
    completed: i64,
    /// The last stamp as stored.
    last: i64,
    wraparounds: u64,
    is_set: bool,
}

impl WraparoundCounter {
    /// A counter of `bits` bits that has not seen a stamp.
    pub(crate) const fn new(bits: u32, half: HalfPeriodFall) -> Self {
        Self { period: 1 << bits, half, completed: 0, last: 0, wraparounds: 0, is_set: false }
    }

    /// Whether a stamp has been taken.
    pub(crate) fn is_set(&self) -> bool {
        self.is_set
    }

    /// Unwrapped value of the last stamp; 0 before the first.
    #[inline(always)]
    pub(crate) fn value(&self) -> i64 {
        self.completed + self.last
    }

    /// Count of wraparounds so far.
    pub(crate) fn wraparounds(&self) -> u64 {
        self.wraparounds
    }

    /// Takes the next stamp and returns its unwrapped value.
    #[inline(always)]
    pub(crate) fn advance(&mut self, stamp: i64) -> i64 {
        let tolerated = self.period / 2 - i64::from(self.half == HalfPeriodFall::Wraparound);
        if self.last - stamp > tolerated {
            self.completed += self.period;
            self.wraparounds += 1;
        }
        self.last = stamp;
        self.is_set = true;
        self.completed + stamp
    }

    /// As [`Self::advance`], but behind a wraparound a rise by more than half a period is a late
    /// stamp of the previous period, which does not move the counter.
    #[inline(always)]
    pub(crate) fn advance_or_late(&mut self, stamp: i64) -> i64 {
        if stamp - self.last > self.period / 2 && self.completed > 0 {
            return self.completed - self.period + stamp;
        }
        self.advance(stamp)
    }

    /// As [`Self::advance`], but a rise by half a period or more is a step back into the previous
    /// period: the value is the one nearest to the last.
    #[inline(always)]
    pub(crate) fn advance_to_nearest(&mut self, stamp: i64) -> i64 {
        if self.is_set && stamp - self.last >= self.period / 2 {
            self.completed -= self.period;
            self.last = stamp;
            return self.completed + stamp;
        }
        self.advance(stamp)
    }

    /// Lengthens the period to the next power of two that holds `stamp`, for counters whose width a
    /// file does not state.
    #[inline]
    pub(crate) fn widen_to(&mut self, stamp: u32) {
        if i64::from(stamp) >= self.period {
            self.period = (u64::from(stamp) + 1).next_power_of_two().cast_signed();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counter(bits: u32, half: HalfPeriodFall) -> WraparoundCounter {
        WraparoundCounter::new(bits, half)
    }

    #[test]
    fn a_large_fall_is_a_wraparound_and_a_small_one_a_step_back() {
        let mut time_high = counter(12, HalfPeriodFall::Wraparound);
        assert_eq!(
            [0xFFF, 0, 5, 3, 0xFFF, 0x7FF].map(|stamp| time_high.advance(stamp)),
            [0xFFF, 0x1000, 0x1005, 0x1003, 0x1FFF, 0x27FF]
        );
        assert_eq!(time_high.wraparounds(), 2);
        let mut tolerant = counter(12, HalfPeriodFall::StepBack);
        assert_eq!([0xFFF, 0x7FF, 0].map(|stamp| tolerant.advance(stamp)), [0xFFF, 0x7FF, 0]);
        assert_eq!([0xFFF, 0x7FE].map(|stamp| tolerant.advance(stamp)), [0xFFF, 0x17FE]);
    }

    #[test]
    fn late_stamps_behind_a_wraparound_stay_in_their_period() {
        const PERIOD: i64 = 1 << 32;
        let mut counter = counter(32, HalfPeriodFall::Wraparound);
        let stamps = [5, 3, PERIOD - 1, 2, PERIOD - 2, 7, 1 << 31];
        assert_eq!(
            stamps.map(|stamp| counter.advance_or_late(stamp)),
            [5, 3, PERIOD - 1, PERIOD + 2, PERIOD - 2, PERIOD + 7, PERIOD + (1 << 31)]
        );
    }

    #[test]
    fn the_nearest_value_is_that_of_a_signed_difference_of_stamps() {
        let stamps = [7_u32, u32::MAX, 0, 1 << 31, 5, (1 << 31) + 5, 3, u32::MAX, 1 << 30];
        let mut counter = counter(32, HalfPeriodFall::StepBack);
        let (mut before, mut expected) = (None, 0);
        for stamp in stamps {
            expected = match before {
                None => stamp.into(),
                Some(before) => expected + i64::from(stamp.wrapping_sub(before) as i32),
            };
            before = Some(stamp);
            assert_eq!(counter.advance_to_nearest(stamp.into()), expected, "{stamp}");
        }
    }

    #[test]
    fn a_counter_of_unknown_width_widens() {
        let mut counter = counter(24, HalfPeriodFall::StepBack);
        counter.widen_to((1 << 24) - 1);
        assert_eq!(counter.period, 1 << 24);
        for (stamp, period) in [(1 << 24, 1 << 25), (3 << 24, 1 << 26), (u32::MAX, 1 << 32)] {
            counter.widen_to(stamp);
            assert_eq!(counter.period, period);
        }
    }
}
