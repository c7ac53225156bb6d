//! Event time in host time.

use std::time::{Duration, Instant};

use evpose_core::Micros;

/// Poses are propagated by the clock after twice the usual interval of packets without one, but not
/// before this: below it, jitter of the scheduler would look like a gap.
const MIN_WAIT: Duration = Duration::from_millis(2);
/// Upper bound of the same: packets that are further apart are no continuous stream.
const MAX_WAIT: Duration = Duration::from_millis(50);
const AVERAGED_PACKETS: u32 = 16;

/// Map from event time to host time, updated with the last event of every packet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clock {
    /// Event time per host time; none where the two are unrelated.
    pace: Option<f64>,
    /// Host time without packets that counts as a stall.
    stall: Duration,
    /// Event time and host time of the newest event.
    newest: Option<(Micros, Instant)>,
    last_packet: Instant,
    /// Moving average of the interval of packets.
    interval: Duration,
}

impl Clock {
    /// A clock before the first packet.
    pub(super) fn new(pace: Option<f64>, stall: Duration) -> Self {
        let last_packet = Instant::now();
        Self { pace, stall, newest: None, last_packet, interval: MIN_WAIT }
    }

    /// Takes the event time and the host time of the last event of a packet.
    pub(super) fn update(&mut self, last: Micros, host_time: Instant) {
        let now = Instant::now();
        let passed = now.saturating_duration_since(self.last_packet).min(MAX_WAIT);
        self.interval = (self.interval * (AVERAGED_PACKETS - 1) + passed) / AVERAGED_PACKETS;
        (self.newest, self.last_packet) = (Some((last, host_time)), now);
    }

    /// Event time of the newest event.
    pub(super) fn newest(&self) -> Option<Micros> {
        self.newest.map(|(t, _)| t)
    }

    /// Host time since the last packet.
    pub(super) fn silence(&self) -> Duration {
        self.last_packet.elapsed()
    }

    /// Host time since event time `t`: zero in the future, and before the first packet.
    pub(super) fn since(&self, t: Micros) -> Duration {
        self.due(t).map_or(Duration::ZERO, |due| Instant::now().saturating_duration_since(due))
    }

    /// Host time to wait until event time `t`, if no packet comes before. None where the clock is
    /// unknown: without packets, after a stall, and for sources that are read as fast as possible.
    pub(super) fn until(&self, t: Option<Micros>) -> Option<Duration> {
        self.pace?;
        let quiet = self.last_packet + (2 * self.interval).clamp(MIN_WAIT, MAX_WAIT);
        let due = self.due(t?)?.max(quiet);
        // No poses within a stall, as after it.
        (due < self.last_packet + self.stall).then(|| due.saturating_duration_since(Instant::now()))
    }

    /// Host time of event time `t`.
    fn due(&self, t: Micros) -> Option<Instant> {
        let (newest, host_time) = self.newest?;
        let Some(pace) = self.pace else { return Some(host_time) };
        let later_s = (t - newest).as_seconds() / pace;
        let apart = Duration::try_from_secs_f64(later_s.abs()).ok()?;
        if later_s < 0.0 { host_time.checked_sub(apart) } else { host_time.checked_add(apart) }
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
    fn event_time_passes_at_the_pace_of_the_recording() {
        let now = Instant::now();
        for (pace, seconds) in [(1.0, 2), (4.0, 8), (0.5, 1)] {
            let mut clock = Clock::new(Some(pace), STALL);
            assert_eq!(clock.since(Micros(3)), Duration::ZERO, "nothing is known yet");
            clock.update(Micros(0), now);
            let before = Micros(-seconds * 1_000_000);
            assert!(near(clock.since(before), 2_000 * MS), "{pace}: {:?}", clock.since(before));
            assert_eq!(clock.since(Micros(600_000_000)), Duration::ZERO, "to come");
        }
    }

    #[test]
    fn without_a_pace_the_host_time_is_that_of_arrival() {
        let mut clock = Clock::new(None, STALL);
        clock.update(Micros(7_000_000), Instant::now());
        assert!(near(clock.since(Micros(0)), Duration::ZERO));
        assert_eq!(clock.until(Some(Micros(8_000_000))), None);
    }

    #[test]
    fn the_clock_goes_on_until_the_source_has_stalled() {
        let mut clock = Clock::new(Some(1.0), STALL);
        assert_eq!(clock.until(Some(Micros(0))), None, "nothing has come");
        clock.update(Micros(0), Instant::now());
        assert_eq!(clock.until(None), None);
        assert!(clock.until(Some(Micros(1_000))).is_some_and(|left| left <= 4 * MS));
        assert!(clock.until(Some(Micros(300_000))).is_some_and(|left| left <= 300 * MS));
        assert_eq!(clock.until(Some(Micros(600_000))), None, "the stall begins before that");
    }
}
