//! A bus that reads whole rows: all that waits in a row leaves in one burst.
//!
//! # Model
//! A free bus takes the row of the request that comes first. One that has read a row goes on to
//! the next row in which requests wait, around and around, until there is none. Selecting a row
//! takes `row_s`, each of its requests `event_s`: those that wait at `t_selected` are served at
//! `t_selected + row_s + k event_s`, `k = 1, 2, ...`, in the order in which they were made. What is
//! asked for later, while the row is being read, waits for its next turn. A request that has
//! waited longer than `max_wait_s` when its row's turn comes is lost, and takes no time.
//!
//! The time at which a request is served depends on later requests, so the bus cannot return it at
//! once. The caller triggers the selection when it is due, after all requests of that time.
//!
//! # Source
//! Boahen 2000 for bursts of a row; Brandli et al. 2014 for the row-wise bus of a DAVIS.

use std::collections::BTreeMap;

use crate::Request;

/// Durations of a row-wise bus, in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowTimes {
    /// To select a row.
    pub row_s: f64,
    /// For an event of it.
    pub event_s: f64,
    /// The longest that a request may wait for its row to be selected.
    pub max_wait_s: f64,
}

/// Outcome of a request when its row is selected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Turn {
    /// It is served at its new time.
    Read,
    /// It is lost at its new time, that of the selection.
    Lost,
}

/// The bus, with the requests that wait for it. A `T` stays with each request.
#[derive(Debug)]
pub(crate) struct RowBus<T> {
    /// As of the last request.
    times: RowTimes,
    rows: BTreeMap<u32, Vec<(Request, T)>>,
    /// When a row is selected next; nothing where the bus is free.
    selects_s: Option<f64>,
    /// The row that is being read; none while the bus is free.
    row: Option<u32>,
}

impl<T> RowBus<T> {
    pub(crate) fn new() -> Self {
        let times = RowTimes { row_s: 0.0, event_s: 0.0, max_wait_s: f64::INFINITY };
        Self { times, rows: BTreeMap::new(), selects_s: None, row: None }
    }

    /// When the bus is to [`RowBus::select`]; nothing if it is free.
    pub(crate) fn selects_s(&self) -> Option<f64> {
        self.selects_s
    }

    /// A pixel of `row` asks. Requests come in order of time, and at equal times of pixels.
    pub(crate) fn enqueue(&mut self, times: RowTimes, row: u32, request: Request, stays: T) {
        self.times = times;
        self.selects_s.get_or_insert(request.t_s);
        self.rows.entry(row).or_default().push((request, stays));
    }

    /// Selects a row at the time at which the bus is due, and calls `each` for its requests.
    pub(crate) fn select(&mut self, mut each: impl FnMut(Request, T, Turn)) {
        let Some(now_s) = self.selects_s else { return };
        let RowTimes { row_s, event_s, max_wait_s } = self.times;
        // A row whose requests are all too old takes no time: the bus goes on at once.
        while let Some((row, requests)) = self.take_next_row() {
            self.row = Some(row);
            let mut read = 0_u32;
            for (request, stays) in requests {
                // Too old: the event is lost, but its pixel goes on.
                if now_s - request.t_s > max_wait_s {
                    each(Request { t_s: now_s, ..request }, stays, Turn::Lost);
                    continue;
                }
                read += 1;
                let t_s = now_s + row_s + f64::from(read) * event_s;
                // The bus is due again behind the last event that it read.
                self.selects_s = Some(t_s);
                each(Request { t_s, ..request }, stays, Turn::Read);
            }
            if read > 0 {
                return;
            }
        }
        // Nothing waits: the bus rests until a request comes.
        (self.selects_s, self.row) = (None, None);
    }

    /// The next row with requests, in order from the row that was read last; on a free bus, where all
    /// requests came at the same time, the lowest.
    fn take_next_row(&mut self) -> Option<(u32, Vec<(Request, T)>)> {
        let behind = self.row.map_or(0, |row| row + 1);
        let row = *self.rows.range(behind..).chain(&self.rows).next()?.0;
        self.rows.remove_entry(&row)
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Polarity;

    use super::*;
    use crate::Origin;

    const WIDTH: u32 = 10;
    const TIMES: RowTimes = RowTimes { row_s: 4e-6, event_s: 1e-6, max_wait_s: f64::INFINITY };

    /// Time in microseconds and pixel of what is served, driven to `stops_us` one after the other.
    fn served(times: RowTimes, requests: &[(f64, u32)], stops_us: &[f64]) -> Vec<(f64, u32)> {
        let mut bus = RowBus::new();
        let mut out = Vec::new();
        let mut run = |bus: &mut RowBus<()>, is_due: &dyn Fn(f64) -> bool| {
            while bus.selects_s().is_some_and(is_due) {
                bus.select(|r, (), turn| {
                    if turn == Turn::Read {
                        out.push((r.t_s * 1e6, r.pixel));
                    }
                });
            }
        };
        let mut requests = requests.iter().peekable();
        for &stop_us in stops_us.iter().chain(&[f64::INFINITY]) {
            let stop_s = stop_us * 1e-6;
            while let Some(&(t_us, pixel)) = requests.next_if(|(t_us, _)| *t_us * 1e-6 <= stop_s) {
                let t_s = t_us * 1e-6;
                run(&mut bus, &|at_s| at_s < t_s);
                let request =
                    Request { t_s, pixel, polarity: Polarity::On, origin: Origin::Signal };
                bus.enqueue(times, pixel / WIDTH, request, ());
            }
            run(&mut bus, &|at_s| at_s <= stop_s);
        }
        out
    }

    #[track_caller]
    fn assert_served(times: RowTimes, requests: &[(f64, u32)], expected: &[(f64, u32)]) {
        let found = served(times, requests, &[]);
        let is_equal = |(a, b): (&(f64, u32), &(f64, u32))| (a.0 - b.0).abs() < 1e-6 && a.1 == b.1;
        let are_equal = found.iter().zip(expected).all(is_equal);
        assert!(found.len() == expected.len() && are_equal, "{found:?}, expected {expected:?}");
    }

    #[test]
    fn a_row_leaves_in_one_burst_and_the_next_behind_it() {
        let burst: Vec<(f64, u32)> = (0..10).chain(30..35).map(|pixel| (50.0, pixel)).collect();
        let first = (0..10).map(|k| (50.0 + 4.0 + f64::from(k + 1), k));
        let second = (0..5).map(|k| (64.0 + 4.0 + f64::from(k + 1), 30 + k));
        assert_served(TIMES, &burst, &first.chain(second).collect::<Vec<_>>());
    }

    #[test]
    fn requests_one_by_one_take_a_row_and_an_event_each() {
        let slow: Vec<(f64, u32)> = (0..20).map(|k| (10.0 * f64::from(k), k % 3)).collect();
        let expected: Vec<(f64, u32)> = slow.iter().map(|(t, pixel)| (t + 5.0, *pixel)).collect();
        assert_served(TIMES, &slow, &expected);
    }

    #[test]
    fn a_request_while_its_row_is_read_waits_for_its_next_turn() {
        // Rows 2 and 4 come first: the turn goes around.
        let requests = [(0.0, 10), (0.0, 11), (3.0, 12), (5.5, 13), (5.6, 41), (5.7, 20)];
        let expected = [(5.0, 10), (6.0, 11), (11.0, 20), (16.0, 41), (21.0, 12), (22.0, 13)];
        assert_served(TIMES, &requests, &expected);
        // At the very end of the reading it is in time.
        assert_served(TIMES, &[(0.0, 10), (5.0, 15)], &[(5.0, 10), (10.0, 15)]);
    }

    #[test]
    fn a_busy_bus_goes_around_and_a_free_one_takes_what_comes_first() {
        let around = [(0.0, 50), (1.0, 10), (2.0, 90), (3.0, 51)];
        let expected = [(5.0, 50), (10.0, 90), (15.0, 10), (20.0, 51)];
        assert_served(TIMES, &around, &expected);
        // Free since 5 us; of two at once the first pixel.
        let first = [(0.0, 50), (9.0, 20), (9.0, 60)];
        assert_served(TIMES, &first, &[(5.0, 50), (14.0, 20), (19.0, 60)]);
    }

    #[test]
    fn what_has_waited_too_long_is_lost_and_takes_no_time() {
        let times = RowTimes { max_wait_s: 4.5e-6, ..TIMES };
        // Row 1 has waited for 5 us when its turn comes, the later request in it for 4 us.
        let requests = [(0.0, 0), (0.0, 10), (1.0, 11), (1.5, 20)];
        assert_served(times, &requests, &[(5.0, 0), (10.0, 11)]);
        // A row of which nothing is left is passed over at once.
        let requests = [(0.0, 0), (0.0, 10), (0.0, 11), (1.5, 20)];
        assert_served(times, &requests, &[(5.0, 0), (10.0, 20)]);
    }

    /// Requests as a busy scene makes them, from an integer hash: ties and quiet times among them.
    fn traffic() -> Vec<(f64, u32)> {
        let mut requests: Vec<(f64, u32)> = (0..3_000_u64)
            .map(|k| {
                let hash = k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 16;
                let t_us = (k / 500 * 3_000 + hash % 1_024) as f64 * 0.75;
                (t_us, (hash >> 20) as u32 % 120)
            })
            .collect();
        requests.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        requests
    }

    #[test]
    fn it_does_not_matter_where_time_is_cut() {
        let requests = traffic();
        let whole = served(TIMES, &requests, &[]);
        for step_us in [0.75, 3.1, 47.0, 1_000.0] {
            let stops: Vec<f64> = (1..20_000).map(|k| f64::from(k) * step_us).collect();
            assert_eq!(served(TIMES, &requests, &stops), whole, "{step_us}");
        }
    }

    #[test]
    fn everything_is_served_once_in_order_and_never_before_it_was_asked_for() {
        let requests = traffic();
        let out = served(TIMES, &requests, &[]);
        assert!(out.windows(2).all(|pair| pair[1].0 - pair[0].0 > 0.999));
        for pixel in 0..120 {
            let of = |all: &[(f64, u32)]| -> Vec<f64> {
                all.iter().filter(|(_, p)| *p == pixel).map(|(t, _)| *t).collect()
            };
            let (asked, read) = (of(&requests), of(&out));
            assert_eq!(asked.len(), read.len());
            assert!(asked.iter().zip(&read).all(|(a, r)| r - a > 4.999));
        }
        // Busy rows share the cost of being selected.
        let selections = out.windows(2).filter(|pair| pair[1].0 - pair[0].0 > 1.5).count();
        assert!(selections < out.len() / 2, "{selections} of {}", out.len());
    }
}
