//! A readout that visits rows or columns in turn.
//!
//! # Model
//! Line `j` of `n` is visited at `t = k T + (j + 1/2) T / n` for whole `k`, counted from the other
//! end where the scan runs backwards. A request is served at the first visit not before it, so that
//! event times are locked to a clock and a coordinate; a pixel that is blind while it waits has one
//! event per visit: where it keeps its level, what it asks for at a visit waits for the next one.
//! Where it goes on and a visit reads one bit, what comes behind the first request is lost.
//!
//! # Source
//! Son et al. 2017 for a scanned event sensor; Hu et al. 2021 discuss the artefact.

use evpose_core::SensorSize;

use super::{Readout, Waiting};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Domain, NumberSpec, Parameter, Request, StageSpec, WordSpec};

const PERIOD: Parameter = Parameter::Number(NumberSpec {
    name: "period_us",
    unit: "us",
    range: (1.0, 1e5),
    typical: Some((20.0, 2e4)),
    doc: "time from one visit of a line to the next",
    ..NumberSpec::LOG
});

const AXIS: Parameter = Parameter::Word(WordSpec {
    name: "axis",
    allowed: &["rows", "columns"],
    default: Some("rows"),
    doc: "what is visited in turn",
});

const DIRECTION: Parameter = Parameter::Word(WordSpec {
    name: "direction",
    allowed: &["forward", "backward"],
    default: Some("forward"),
    doc: "from the first line to the last, or from the last to the first",
});

const WAITING: Parameter = Parameter::Word(WordSpec {
    name: "waiting",
    allowed: &["reset", "kept", "free", "latched"],
    default: Some("reset"),
    doc: "a pixel that waits is blind and then sees what there is, is blind but forgets nothing, \
          goes on making requests, or goes on and loses them",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "scanned_readout",
    domain: Domain::Readout,
    summary: "rows or columns are visited in turn; a pixel waits until it is visited",
    formula: "t_served = the first k T + (j + 1/2) T / n not before t_request",
    params: &[PERIOD, AXIS, DIRECTION, WAITING],
    source: Citation {
        key: "Son et al. 2017",
        text: "B. Son et al.: A 640x480 dynamic vision sensor with a 9 um pixel and 300 Meps \
               address-event representation, ISSCC 2017",
    },
    signature: Signature {
        look_for: "event times lie on parallel slanted lines: a visit of each row or column per \
                   period, one event per visit",
        probe: Probe::FlashRaster,
        strength: Strength::Rising(&["period_us"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Readout(Box::new(Scanned {
            period_s: settings.number(&PERIOD) * 1e-6,
            visits_rows: settings.word(&AXIS) == Some("rows"),
            is_backward: settings.word(&DIRECTION) == Some("backward"),
            waiting: Waiting::from_settings(settings),
        })))
    },
};

/// A scan clock that starts at time zero.
#[derive(Debug)]
struct Scanned {
    period_s: f64,
    visits_rows: bool,
    is_backward: bool,
    waiting: Waiting,
}

impl Readout for Scanned {
    fn waiting(&self) -> Waiting {
        self.waiting
    }

    /// The number of the last visit of every pixel that served it, counted from one.
    fn state_len(&self, size: SensorSize) -> usize {
        if self.waiting == Waiting::Latched { size.pixels() } else { 0 }
    }

    fn acknowledge(&self, request: &Request, size: SensorSize, state: &mut [f64]) -> Option<f64> {
        let width = u32::from(size.width);
        let (line, lines) = if self.visits_rows {
            (request.pixel / width, u32::from(size.height))
        } else {
            (request.pixel % width, width)
        };
        let line = if self.is_backward { lines - 1 - line } else { line };
        let phase = (f64::from(line) + 0.5) / f64::from(lines);
        let visit = (request.t_s / self.period_s - phase).ceil();
        let visit_s = |visit: f64| (visit + phase) * self.period_s;
        // A pixel that has kept its level may ask again in the very moment of its visit.
        let is_over = self.waiting == Waiting::Kept && visit_s(visit) <= request.t_s;
        let visit = if is_over { visit + 1.0 } else { visit };
        if let Some(last) = state.get_mut(request.pixel as usize) {
            if *last >= visit + 1.0 {
                return None;
            }
            *last = visit + 1.0;
        }
        // Rounding must not serve a request before it was made.
        Some(visit_s(visit).max(request.t_s))
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Polarity;

    use super::*;
    use crate::Origin;

    const SIZE: SensorSize = SensorSize { width: 4, height: 5 };

    fn served(visits_rows: bool, is_backward: bool, t_s: f64, pixel: u32) -> f64 {
        let waiting = Waiting::Reset;
        let scan = Scanned { period_s: 1e-3, visits_rows, is_backward, waiting };
        let request = Request { t_s, pixel, polarity: Polarity::On, origin: Origin::Signal };
        scan.acknowledge(&request, SIZE, &mut []).unwrap()
    }

    #[test]
    fn times_are_locked_to_the_line() {
        for pixel in 0..20 {
            let (row, column) = (f64::from(pixel / 4), f64::from(pixel % 4));
            for k in 0..300 {
                let t_s = f64::from(k) * 3.77e-5;
                for (rows, back, phase) in [
                    (true, false, (row + 0.5) / 5.0),
                    (true, true, (4.5 - row) / 5.0),
                    (false, false, (column + 0.5) / 4.0),
                    (false, true, (3.5 - column) / 4.0),
                ] {
                    let t = served(rows, back, t_s, pixel);
                    assert!((0.0..1e-3 + 1e-12).contains(&(t - t_s)));
                    let turns = t / 1e-3 - phase;
                    assert!((turns - turns.round()).abs() < 1e-9);
                }
            }
        }
    }
}
