//! Times that no clock has, and more events at one time than any sensor or simulator gives.

use evpose_core::Micros;

/// Events that may have one time stamp: four of each pixel of the largest sensor that cameras of events have,
/// 2048 x 2048, or eighteen of each of 1280 x 720. When a simulation begins, each crosses several thresholds.
const MAX_AT_ONCE: usize = 1 << 24;
/// The latest time that is read, and without its sign the earliest: some days before 64 bits end, so
/// that windows behind it have an end.
const LATEST: Micros = Micros(i64::MAX - 1_000_000_000_000);

/// Times that are refused.
#[derive(Debug, Clone, Copy, thiserror::Error)]
pub(super) enum TimeFault {
    #[error("an event at {} µs, which no clock reaches: state its unit with --time-unit", .0.0)]
    NoClock(Micros),
    #[error(
        "more than {MAX_AT_ONCE} events at {:.6} s: no sensor sends as many, or the clock is too coarse",
        .0.as_seconds()
    )]
    Crowd(Micros),
}

/// A check of times, batch by batch. Files of a few megabytes hold hundreds of millions of events at
/// one time.
#[derive(Debug, Default)]
pub(super) struct TimeCheck {
    /// The time of the latest event, and how many events in a row have it.
    standing: (Micros, usize),
}

impl TimeCheck {
    /// Checks the times of a batch in order.
    ///
    /// # Errors
    /// If one of them is impossible or too many events have it.
    pub(super) fn check(&mut self, times: &[Micros]) -> Result<(), TimeFault> {
        let mut ends = times.first().into_iter().chain(times.last());
        if let Some(t) = ends.find(|t| t.0.unsigned_abs() > LATEST.0.unsigned_abs()) {
            return Err(TimeFault::NoClock(*t));
        }
        // A crowd has two samples that are half of it apart: the times between are not read.
        let samples: Vec<&Micros> = times.iter().step_by(MAX_AT_ONCE / 2).collect();
        let crowds = samples.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]);
        for t in times.first().into_iter().chain(crowds) {
            let before = if self.standing.0 == *t { self.standing.1 } else { 0 };
            let [from, to] = [Micros(t.0 - 1), *t].map(|t| times.partition_point(|at| *at <= t));
            refuse_crowd(*t, before + to - from)?;
        }
        self.check_end(times)
    }

    /// Checks the run of one time at the end of a batch in any order.
    ///
    /// # Errors
    /// If it has too many events.
    pub(super) fn check_end(&mut self, times: &[Micros]) -> Result<(), TimeFault> {
        let Some(last) = times.last() else { return Ok(()) };
        let same = times.iter().rev().take_while(|t| *t == last).count();
        let goes_on = same == times.len() && self.standing.0 == *last;
        self.standing = (*last, if goes_on { self.standing.1 + same } else { same });
        refuse_crowd(*last, self.standing.1)
    }
}

fn refuse_crowd(t: Micros, events: usize) -> Result<(), TimeFault> {
    if events > MAX_AT_ONCE { Err(TimeFault::Crowd(t)) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Input, OpenOptions, Windows, read_as, source};

    /// Both ways of reading: whole, and window by window.
    fn refusals(input: impl Fn() -> Input) -> [String; 2] {
        let options = OpenOptions::default();
        let whole = read_as(input(), &options).unwrap_err();
        let windows = source(input(), &options)
            .and_then(|(_, source)| Windows::from_source(source, &options)?.end());
        [whole, windows.unwrap_err()].map(|error| error.to_string())
    }

    #[test]
    fn more_events_at_one_time_than_sensors_send_are_refused() {
        // A vector of EVT 3.0 is twelve events in two bytes.
        let head = b"% evt 3.0\n% format EVT3;height=720;width=1280\n% end\n";
        let words = [0x8000_u16, 0x6000, 0x0000, 0x3000];
        let mut bytes: Vec<u8> = head.to_vec();
        bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        let vectors = [0x3000_u16, 0x4fff].repeat(MAX_AT_ONCE / 12 + 400_000);
        bytes.extend(vectors.iter().flat_map(|word| word.to_le_bytes()));
        for refusal in refusals(|| Input::memory("one.raw", bytes.clone())) {
            assert!(refusal.contains("16777216 events at 0.000000 s"), "{refusal}");
        }
    }

    /// A batch of an array is as long as the array, and its crowd need not be at its end.
    #[test]
    fn crowds_within_an_array_are_refused() {
        let npy = |crowd: usize| {
            let row = |t: i64| [&t.to_le_bytes()[..], &[1; 3]].concat();
            let header = format!(
                "{{'descr': [('t', '<i8'), ('x', '|u1'), ('y', '|u1'), ('p', '|u1')], \
                 'fortran_order': False, 'shape': ({},), }}\n",
                crowd + 1_000
            );
            let head = [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..]].concat();
            let before: Vec<u8> = (0..500).flat_map(row).collect();
            let behind: Vec<u8> = (800..1_300).flat_map(row).collect();
            [head, header.into_bytes(), before, row(700).repeat(crowd), behind].concat()
        };
        let crowded = npy(MAX_AT_ONCE + 1);
        for refusal in refusals(|| Input::memory("crowd.npy", crowded.clone())) {
            assert!(refusal.contains("16777216 events at 0.000700 s"), "{refusal}");
        }
        let most = npy(MAX_AT_ONCE);
        let read = read_as(Input::memory("most.npy", most.clone()), &OpenOptions::default());
        assert_eq!(read.unwrap().stream.len(), MAX_AT_ONCE + 1_000);
        let (_, source) = source(Input::memory("most.npy", most), &OpenOptions::default()).unwrap();
        let mut windows = Windows::from_source(source, &OpenOptions::default()).unwrap();
        assert_eq!(windows.end().unwrap(), Micros(1_299));
    }

    /// By the rule of order, whatever reads: an impossible time is far from all others, too.
    #[test]
    fn impossible_times_far_from_all_others_are_left_out() {
        for stray in [i64::MAX, i64::MAX - 5, i64::MIN + 5] {
            for at in [0, 1_500, 3_000] {
                let mut times: Vec<i64> = (0..3_000).map(|k| 667 * k - 1_000_000).collect();
                times.insert(at, stray);
                let lines = times.iter().map(|t| format!("{t} 1 1 1\n"));
                let text = "4 3\n".to_owned() + &lines.collect::<String>();
                let input = || Input::memory("stray.txt", text.clone().into_bytes());
                let options = OpenOptions::default();
                let whole = read_as(input(), &options).unwrap();
                let (_, source) = source(input(), &options).unwrap();
                let mut windows = Windows::from_source(source, &options).unwrap();
                assert_eq!(windows.end().unwrap(), *whole.stream.t().last().unwrap());
                assert_eq!(whole.stream.len(), 3_000, "{stray} at {at}");
                assert_eq!(windows.remarks(), whole.remarks, "{stray} at {at}");
                assert!(whole.remarks[0].starts_with("1 events"), "{:?}", whole.remarks);
            }
        }
    }

    #[test]
    fn times_at_the_end_of_the_clock_are_refused() {
        let text = "4 3\n1 1 1 1\n2 1 1 1\n9223372036854775807 1 1 1\n";
        for refusal in refusals(|| Input::memory("late.txt", text.as_bytes().to_vec())) {
            assert!(refusal.contains("no clock reaches"), "{refusal}");
        }
    }
}
