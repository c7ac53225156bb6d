//! Columns visited in turn: column `j` is read at `(n W + j) column_s`.
//!
//! A pixel latches its first event and shows it at the next visit; what it would say until then is
//! lost.

use crate::event::{HEIGHT, Spike, WIDTH};

pub(super) fn visit(requests: &[Spike], column_s: f64) -> Vec<Spike> {
    let period_s = column_s * WIDTH as f64;
    let mut next_visit_s = vec![f64::NEG_INFINITY; WIDTH * HEIGHT];
    let mut read = Vec::with_capacity(requests.len());
    for spike in requests {
        let latched = &mut next_visit_s[spike.pixel as usize];
        // A pixel holds one event until it is read; others are lost.
        if spike.t_s <= *latched {
            continue;
        }
        let phase_s = spike.column() as f64 * column_s;
        let turns = ((spike.t_s - phase_s) / period_s).ceil();
        let t_s = turns * period_s + phase_s;
        *latched = t_s;
        read.push(Spike { t_s, ..*spike });
    }
    read
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_is_read_when_its_column_is_next_visited() {
        let column_s = 1e-5;
        let spike = |t_s, column: u32| Spike { t_s, pixel: 5 * WIDTH as u32 + column, on: false };
        let read = visit(&[spike(0.0, 40), spike(0.0005, 10), spike(0.0006, 10)], column_s);
        let times_s: Vec<f64> = read.iter().map(|spike| spike.t_s).collect();
        // The third comes while the second is still latched.
        assert_eq!(read.len(), 2);
        assert!((times_s[0] - 40.0 * column_s).abs() < 1e-12);
        assert!((times_s[1] - (96.0 + 10.0) * column_s).abs() < 1e-12);
    }
}
