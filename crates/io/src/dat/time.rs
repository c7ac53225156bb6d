//! Times of 32 bits, which begin again at 0.

/// A turn of the clock in microseconds, about 71 minutes.
const TURN: i64 = 1 << 32;

/// Where the clock is.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Clock {
    /// Turns so far, in microseconds.
    turns: i64,
    last: u32,
}

impl Clock {
    /// The time of a stamp. One that goes back by half a turn or more is of the next turn, and what
    /// then lies that far ahead is a late event of the turn before.
    #[inline(always)]
    pub(super) fn unwrap(&mut self, stamp: u32) -> i64 {
        let step = i64::from(stamp) - i64::from(self.last);
        if step <= -TURN / 2 {
            self.turns += TURN;
        } else if step > TURN / 2 && self.turns > 0 {
            return self.turns - TURN + i64::from(stamp);
        }
        self.last = stamp;
        self.turns + i64::from(stamp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_begin_again_and_late_ones_stay_where_they_belong() {
        let mut clock = Clock::default();
        let times = [5, 3, u32::MAX, 2, u32::MAX - 1, 7, 1 << 31].map(|s| clock.unwrap(s));
        assert_eq!(times, [5, 3, TURN - 1, TURN + 2, TURN - 2, TURN + 7, TURN + (1 << 31)]);
    }
}
