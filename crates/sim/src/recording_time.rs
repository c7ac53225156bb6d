//! Parts of the time of recording sequences.

use std::iter::Sum;
use std::time::Duration;

/// Time of the threads that record sequences. Its parts sum to the whole.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RecordingTime {
    /// Scenes, motions and their light.
    pub rendering: Duration,
    /// From light to events.
    pub sensor: Duration,
    /// Everything else: events, labels and digests to their files.
    pub writing: Duration,
}

impl RecordingTime {
    /// The same, of so long a `whole`: what is neither rendering nor sensor is writing.
    #[must_use]
    pub(crate) fn of_whole(self, whole: Duration) -> Self {
        let writing = whole.saturating_sub(self.rendering).saturating_sub(self.sensor);
        Self { writing, ..self }
    }

    /// The parts of `elapsed`, for which several threads ran: each as its share of the threads' time, in words.
    /// In tenths of a second, they sum to it.
    pub fn of(self, elapsed: Duration) -> String {
        if self == Self::default() {
            // All sequences were there.
            return "nothing recorded".to_owned();
        }
        let whole = (self.rendering + self.sensor + self.writing).as_secs_f64();
        let tenths = |share: f64| (10.0 * elapsed.as_secs_f64() * share).round() as i64;
        let share = |part: Duration| part.as_secs_f64() / whole.max(f64::MIN_POSITIVE);
        let [rendering, sensor] = [self.rendering, self.sensor].map(|part| tenths(share(part)));
        // Rounded alone, three parts may miss the sum by a tenth.
        let writing = (tenths(1.0) - rendering - sensor).max(0);
        let [rendering, sensor, writing] =
            [rendering, sensor, writing].map(|tenths| tenths as f64 / 10.0);
        format!("{rendering:.1} s rendering, {sensor:.1} s sensor, {writing:.1} s writing")
    }
}

impl Sum for RecordingTime {
    fn sum<I: Iterator<Item = Self>>(times: I) -> Self {
        times.fold(Self::default(), |all, one| Self {
            rendering: all.rendering + one.rendering,
            sensor: all.sensor + one.sensor,
            writing: all.writing + one.writing,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_sum_to_the_time_on_the_clock_however_many_threads_ran() {
        let seconds = Duration::from_secs_f64;
        let one =
            RecordingTime { rendering: seconds(3.0), sensor: seconds(2.0), writing: seconds(9.0) };
        let one = one.of_whole(seconds(6.0));
        assert_eq!(one.writing, seconds(1.0));
        let both: RecordingTime = [one, one].into_iter().sum();
        // Twelve seconds of two threads in 6.4 s.
        let text = both.of(seconds(6.4));
        assert_eq!(text, "3.2 s rendering, 2.1 s sensor, 1.1 s writing");
        // A third each of a second.
        let thirds =
            RecordingTime { rendering: seconds(1.0), sensor: seconds(1.0), writing: seconds(1.0) };
        assert_eq!(thirds.of(seconds(1.0)), "0.3 s rendering, 0.3 s sensor, 0.4 s writing");
    }
}
