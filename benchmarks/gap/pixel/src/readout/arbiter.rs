//! Request and acknowledge: rows in turn, all waiting pixels of a row in one burst.
//!
//! A free arbiter takes the request that comes first. A busy one goes on to the next row with
//! requests, around and around; selecting a row costs `row_s`, each event `event_s`. Requests that
//! come while their row is being read wait for its next turn. A request is stamped when it has been
//! read.

use std::collections::VecDeque;

use crate::event::{HEIGHT, Spike};

/// Serves time-ordered requests; nothing is lost.
pub(super) fn serve(requests: &[Spike], row_s: f64, event_s: f64) -> Vec<Spike> {
    let mut waiting: Vec<VecDeque<Spike>> = vec![VecDeque::new(); HEIGHT];
    let mut read = Vec::with_capacity(requests.len());
    let mut pending = 0_usize;
    let mut next = 0_usize;
    let mut row = 0_usize;
    let mut now_s = 0.0_f64;
    while read.len() < requests.len() {
        // The bus is idle until the next request.
        if pending == 0 {
            now_s = now_s.max(requests[next].t_s);
        }
        while next < requests.len() && requests[next].t_s <= now_s {
            waiting[requests[next].row()].push_back(requests[next]);
            pending += 1;
            next += 1;
        }
        // Rows in turn from the last one, so that none waits without an end.
        while waiting[row].is_empty() {
            row = (row + 1) % HEIGHT;
        }
        now_s += row_s;
        // The whole row: what it requests meanwhile waits for the next turn.
        for spike in std::mem::take(&mut waiting[row]) {
            now_s += event_s;
            pending -= 1;
            read.push(Spike { t_s: now_s, ..spike });
        }
        row = (row + 1) % HEIGHT;
    }
    read
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::WIDTH;

    fn request(t_s: f64, row: usize, column: usize) -> Spike {
        Spike { t_s, pixel: (row * WIDTH + column) as u32, on: true }
    }

    #[test]
    fn events_of_one_row_leave_one_event_time_apart() {
        let requests: Vec<Spike> = (0..10).map(|column| request(0.5, 3, column)).collect();
        let read = serve(&requests, 4e-6, 1e-6);
        for (k, spike) in read.iter().enumerate() {
            assert!((spike.t_s - (0.5 + 4e-6 + (k + 1) as f64 * 1e-6)).abs() < 1e-12);
        }
    }

    #[test]
    fn events_of_different_rows_leave_a_row_and_an_event_apart() {
        let requests: Vec<Spike> = (0..10).map(|row| request(0.5, row, 7)).collect();
        let read = serve(&requests, 4e-6, 1e-6);
        for (k, spike) in read.iter().enumerate() {
            assert!((spike.t_s - (0.5 + (k + 1) as f64 * 5e-6)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_request_during_the_reading_of_its_row_waits_for_the_next_turn() {
        let requests = [request(0.0, 1, 0), request(0.0, 1, 1), request(5.5e-6, 1, 2)];
        let read = serve(&requests, 4e-6, 1e-6);
        let times_us: Vec<f64> = read.iter().map(|spike| spike.t_s * 1e6).collect();
        for (time_us, expected_us) in times_us.iter().zip([5.0, 6.0, 11.0]) {
            assert!((time_us - expected_us).abs() < 1e-9, "{times_us:?}");
        }
    }
}
