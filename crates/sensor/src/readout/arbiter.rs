//! An arbiter: one bus, on which requests queue.
//!
//! # Model
//! An event takes `1 / rate`. In order of arrival, requests are served first come, first served,
//! and one takes `row_ns` more where its row is not the one served before it:
//! `t_served = max(t_request, t_free) + service time`. In order of rows, the bus
//! [goes around](super::row_bus): it selects a row, which takes `row_ns`, and reads all that waits
//! in it in one burst. With a longest queue of `max_wait_us`, a request that would wait longer is
//! lost.
//!
//! # Source
//! Boahen 2000 for arbitered address events, one by one and in bursts of a row; Brandli et al. 2014
//! for the row-wise bus of a DAVIS.

use evpose_core::SensorSize;

use super::{Readout, RowTimes, WAITING, Waiting};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{
    Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Parameter, Request, StageSpec, WordSpec,
};

const RATE: Parameter = Parameter::Number(NumberSpec {
    name: "rate_hz",
    unit: "Hz",
    range: (1.0, 1e10),
    typical: Some((1e6, 1.65e8)),
    doc: "events per second that the bus can carry",
    ..NumberSpec::LOG
});

const ROW: Parameter = Parameter::Number(NumberSpec {
    name: "row_ns",
    unit: "ns",
    range: (1.0, 1e5),
    typical: Some((10.0, 500.0)),
    doc: "time to go over to another row, or to select one",
    ..LOG_OFF_AT_ZERO
});

const MAX_WAIT: Parameter = Parameter::Number(NumberSpec {
    name: "max_wait_us",
    unit: "us",
    range: (1.0, 1e6),
    typical: Some((1e3, 1e5)),
    default: Some(f64::INFINITY),
    doc: "requests that would wait longer are lost",
    ..NumberSpec::LOG
});

const ORDER: Parameter = Parameter::Word(WordSpec {
    name: "order",
    allowed: &["arrival", "rows"],
    default: Some("arrival"),
    doc: "first come, first served, or row by row: a busy bus goes on to the next row with \
          requests, around and around, and what waits there is served in one burst, its k-th at \
          t_selected + row_ns + k / rate_hz",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "arbiter",
    domain: Domain::Readout,
    summary: "requests queue for one bus; a pixel waits until it is served",
    formula: "t_served = max(t_request, t_free) + 1 / rate_hz (+ row_ns in a new row)",
    params: &[RATE, ROW, MAX_WAIT, ORDER, WAITING],
    source: Citation {
        key: "Boahen 2000",
        text: "K. A. Boahen: Point-to-Point Connectivity Between Neuromorphic Chips Using Address \
               Events, IEEE TCAS-II 47(5), 2000",
    },
    signature: Signature {
        look_for: "behind a flash rows come in bunches, the last ones late by their number over \
                   the rate; pixels wait in the meantime",
        probe: Probe::FlashRaster,
        strength: Strength::Falling(&["rate_hz"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Readout(Box::new(Arbiter {
            service_s: 1.0 / settings.number(&RATE),
            row_s: settings.number(&ROW) * 1e-9,
            max_wait_s: settings.number(&MAX_WAIT) * 1e-6,
            waiting: Waiting::from_settings(settings),
            reads_rows: settings.word(&ORDER) == Some("rows"),
        })))
    },
};

/// A single server. Its state in order of arrival: when it is free, and its row, counted from one.
#[derive(Debug)]
struct Arbiter {
    service_s: f64,
    row_s: f64,
    max_wait_s: f64,
    waiting: Waiting,
    reads_rows: bool,
}

impl Readout for Arbiter {
    fn waiting(&self) -> Waiting {
        self.waiting
    }

    fn row_times(&self) -> Option<RowTimes> {
        let Self { row_s, service_s: event_s, max_wait_s, .. } = *self;
        self.reads_rows.then_some(RowTimes { row_s, event_s, max_wait_s })
    }

    fn state_len(&self, _size: SensorSize) -> usize {
        2
    }

    fn acknowledge(&self, request: &Request, size: SensorSize, state: &mut [f64]) -> Option<f64> {
        let [free_s, last_row] = state else { return Some(request.t_s) };
        let row = f64::from(request.pixel / u32::from(size.width) + 1);
        // A state of zero is a bus that has never been used, not one that was free at time zero.
        let start_s = if *last_row > 0.0 { request.t_s.max(*free_s) } else { request.t_s };
        if start_s - request.t_s > self.max_wait_s {
            return None;
        }
        let change_s = if (row - *last_row).abs() > 0.5 { self.row_s } else { 0.0 };
        *free_s = start_s + change_s + self.service_s;
        *last_row = row;
        Some(*free_s)
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Polarity;

    use super::*;
    use crate::Origin;

    const SIZE: SensorSize = SensorSize { width: 10, height: 10 };

    fn arbiter(row_s: f64, max_wait_s: f64) -> Arbiter {
        let waiting = Waiting::Reset;
        Arbiter { service_s: 1e-6, row_s, max_wait_s, waiting, reads_rows: false }
    }

    fn served(arbiter: &Arbiter, requests: &[(f64, u32)]) -> Vec<Option<f64>> {
        let mut state = vec![0.0; arbiter.state_len(SIZE)];
        let serve = |&(t_s, pixel): &(f64, u32)| {
            let request = Request { t_s, pixel, polarity: Polarity::On, origin: Origin::Signal };
            arbiter.acknowledge(&request, SIZE, &mut state)
        };
        requests.iter().map(serve).collect()
    }

    #[test]
    fn a_burst_leaves_at_the_rate_of_the_bus() {
        let arbiter = arbiter(0.0, f64::INFINITY);
        let burst: Vec<(f64, u32)> = (0..50).map(|pixel| (1.0, pixel)).collect();
        for (k, t) in served(&arbiter, &burst).into_iter().enumerate() {
            assert!((t.unwrap() - 1.0 - (k + 1) as f64 * 1e-6).abs() < 1e-12);
        }
        // With room between requests nobody waits for another.
        let slow: Vec<(f64, u32)> = (0..50).map(|k| (f64::from(k) * 1e-5, k)).collect();
        for ((t, _), served) in slow.iter().zip(served(&arbiter, &slow)) {
            assert!((served.unwrap() - t - 1e-6).abs() < 1e-12);
        }
    }

    #[test]
    fn another_row_takes_longer_and_a_long_queue_loses() {
        let arbiter = arbiter(3e-6, 4.5e-6);
        let out = served(&arbiter, &[(0.0, 0), (0.0, 1), (0.0, 10), (0.0, 11)]);
        let expected = [Some(4e-6), Some(5e-6), None, None];
        for (found, expected) in out.iter().zip(expected) {
            match (found, expected) {
                (Some(t), Some(e)) => assert!((t - e).abs() < 1e-12),
                (found, expected) => assert_eq!(*found, expected),
            }
        }
    }
}
