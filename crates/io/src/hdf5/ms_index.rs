//! DSEC's `ms_to_idx`: the first event of every millisecond, so that programs go to any time.
//!
//! Entry `m` is the index of the first event whose time, counted from `t_offset`, is at least `m`
//! milliseconds; there is one for each millisecond up to that of the last event.
//!
//! # Source
//! Gehrig et al., *DSEC*, RA-L 2021; its data format: `t[ms_to_idx[ms]] >= ms * 1000` and
//! `t[ms_to_idx[ms] - 1] < ms * 1000`.

use evpose_core::Micros;

/// Longest recording with an index, in milliseconds: a day, which takes 691 MB.
const MAX_MS: u64 = 86_400_000;
/// A recording whose first event is earlier than this counts from its own zero.
const OWN_CLOCK: std::ops::Range<i64> = 0..3_600_000_000;

/// The index under way.
#[derive(Debug, Default)]
pub(super) struct MsIndex {
    /// Time from which times in the file count; none before the first event.
    offset_us: Option<i64>,
    /// Entries that were not taken yet.
    pub(super) pending: Vec<u64>,
    /// All entries so far.
    entries: u64,
    is_too_long: bool,
}

impl MsIndex {
    /// Time in microseconds that is 0 in the file: 0 for a clock that began with the recording, else
    /// the first event.
    pub(super) fn offset_us(&self) -> i64 {
        self.offset_us.unwrap_or(0)
    }

    /// Takes account of events in order of time, the first of which has index `first`.
    pub(super) fn push(&mut self, times: &[Micros], first: u64) {
        for (index, t) in (first..).zip(times) {
            let start = if OWN_CLOCK.contains(&t.0) { 0 } else { t.0 };
            let offset_us = *self.offset_us.get_or_insert(start);
            // A difference that does not fit is too long in any case.
            let since_us = t.0.checked_sub(offset_us).and_then(|us| u64::try_from(us).ok());
            match since_us.map(|us| us / 1_000) {
                Some(ms) if ms < MAX_MS => {
                    let missing = (ms + 1).saturating_sub(self.entries);
                    self.pending.extend(std::iter::repeat_n(index, missing as usize));
                    self.entries += missing;
                }
                _ => self.is_too_long = true,
            }
        }
    }

    /// Count of entries; 0 if the recording is too long for an index.
    pub(super) fn entries(&self) -> u64 {
        if self.is_too_long { 0 } else { self.entries }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn index(times: &[i64]) -> MsIndex {
        let times: Vec<Micros> = times.iter().map(|t| Micros(*t)).collect();
        let mut index = MsIndex::default();
        // In two batches, as they come.
        let (head, tail) = times.split_at(times.len() / 2);
        index.push(head, 0);
        index.push(tail, head.len() as u64);
        index
    }

    #[test]
    fn an_entry_is_the_first_event_of_its_millisecond_or_later() {
        let times = [300, 999, 1_000, 1_000, 4_100, 4_999, 5_000];
        let index = index(&times);
        assert_eq!((index.offset_us(), index.entries()), (0, 6));
        assert_eq!(index.pending, [0, 2, 4, 4, 4, 6]);
        for (ms, first) in index.pending.iter().map(|first| *first as usize).enumerate() {
            let start_us = 1_000 * ms as i64;
            assert!(times[first] >= start_us && times[..first].iter().all(|t| *t < start_us));
        }
    }

    #[test]
    fn times_of_the_calendar_count_from_the_first_event_and_a_day_is_the_longest() {
        let begin = 1_700_000_000_000_123;
        let calendar = index(&[begin, begin + 1_000]);
        assert_eq!((calendar.offset_us(), calendar.pending), (begin, vec![0, 1]));
        assert_eq!(index(&[-5, 2_000]).offset_us(), -5);
        assert_eq!(index(&[0, 1_000 * MAX_MS as i64]).entries(), 0);
        assert_eq!(index(&[i64::MIN, i64::MAX]).entries(), 0);
        assert_eq!(index(&[]).entries(), 0);
    }
}
