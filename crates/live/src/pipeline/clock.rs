//! Times of events by the clock of this machine.

use std::time::{Duration, Instant};

use evpose_core::Micros;

/// The next packet is waited for twice as long as usual, but not for less than this, before the clock goes on
/// without it.
const SHORTEST_QUIET: Duration = Duration::from_millis(2);
/// And not for more: packets that come less often are no stream that goes on.
const LONGEST_QUIET: Duration = Duration::from_millis(50);
/// Of how many packets the usual time between two is known.
const USUAL_OF: u32 = 16;

/// When events happen, told from the last of every packet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clock {
    /// Time of events in the same time of this machine; none where both have nothing to do with each other.
    pace: Option<f64>,
    /// A silence of so long is told as a stall.
    stall: Duration,
    /// Time of the newest event, and when it happened.
    newest: Option<(Micros, Instant)>,
    /// When the last packet was taken, or this began.
    heard: Instant,
    /// From one packet to the next, as a rule.
    usual: Duration,
}

impl Clock {
    /// Before the first packet.
    pub(super) fn new(pace: Option<f64>, stall: Duration) -> Self {
        let heard = Instant::now();
        Self { pace, stall, newest: None, heard, usual: SHORTEST_QUIET }
    }

    /// A packet, and when the last of its events happened.
    pub(super) fn take(&mut self, last: Micros, happened: Instant) {
        let now = Instant::now();
        let passed = now.saturating_duration_since(self.heard).min(LONGEST_QUIET);
        self.usual = (self.usual * (USUAL_OF - 1) + passed) / USUAL_OF;
        (self.newest, self.heard) = (Some((last, happened)), now);
    }

    /// Time of the newest event.
    pub(super) fn newest(&self) -> Option<Micros> {
        self.newest.map(|(t, _)| t)
    }

    /// For how long no packet came.
    pub(super) fn silent(&self) -> Duration {
        self.heard.elapsed()
    }

    /// How long ago it was `t`: nothing at times to come, and before the first packet.
    pub(super) fn since(&self, t: Micros) -> Duration {
        self.due(t).map_or(Duration::ZERO, |due| Instant::now().saturating_duration_since(due))
    }

    /// How long to wait until it is `t` and no event will be the next thing to happen. None where the clock
    /// says nothing: there are no packets, or have not been for so long that the source has stalled, or they
    /// come as fast as they are taken.
    pub(super) fn until(&self, t: Option<Micros>) -> Option<Duration> {
        self.pace?;
        let quiet = self.heard + (2 * self.usual).clamp(SHORTEST_QUIET, LONGEST_QUIET);
        let due = self.due(t?)?.max(quiet);
        // What a stall is made of is not told, as behind it.
        (due < self.heard + self.stall).then(|| due.saturating_duration_since(Instant::now()))
    }

    /// When it is, or was, `t`.
    fn due(&self, t: Micros) -> Option<Instant> {
        let (newest, happened) = self.newest?;
        let Some(pace) = self.pace else { return Some(happened) };
        let later_s = (t - newest).as_seconds() / pace;
        let apart = Duration::try_from_secs_f64(later_s.abs()).ok()?;
        if later_s < 0.0 { happened.checked_sub(apart) } else { happened.checked_add(apart) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STALL: Duration = Duration::from_millis(500);
    const MS: Duration = Duration::from_millis(1);

    fn near(is: Duration, want: Duration) -> bool {
        // Threads of tests are held up at times.
        is.abs_diff(want) < 200 * MS
    }

    #[test]
    fn times_are_told_at_the_pace_of_the_recording() {
        let now = Instant::now();
        for (pace, seconds) in [(1.0, 2), (4.0, 8), (0.5, 1)] {
            let mut clock = Clock::new(Some(pace), STALL);
            assert_eq!(clock.since(Micros(3)), Duration::ZERO, "nothing is known yet");
            clock.take(Micros(0), now);
            let before = Micros(-seconds * 1_000_000);
            assert!(near(clock.since(before), 2_000 * MS), "{pace}: {:?}", clock.since(before));
            assert_eq!(clock.since(Micros(600_000_000)), Duration::ZERO, "to come");
        }
    }

    #[test]
    fn what_comes_as_fast_as_it_is_taken_happens_when_it_comes() {
        let mut clock = Clock::new(None, STALL);
        clock.take(Micros(7_000_000), Instant::now());
        assert!(near(clock.since(Micros(0)), Duration::ZERO));
        assert_eq!(clock.until(Some(Micros(8_000_000))), None);
    }

    #[test]
    fn the_clock_goes_on_until_the_source_has_stalled() {
        let mut clock = Clock::new(Some(1.0), STALL);
        assert_eq!(clock.until(Some(Micros(0))), None, "nothing has come");
        clock.take(Micros(0), Instant::now());
        assert_eq!(clock.until(None), None);
        assert!(clock.until(Some(Micros(1_000))).is_some_and(|left| left <= 4 * MS));
        assert!(clock.until(Some(Micros(300_000))).is_some_and(|left| left <= 300 * MS));
        assert_eq!(clock.until(Some(Micros(600_000))), None, "the stall begins before that");
    }
}
