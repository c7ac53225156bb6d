//! The time-stamper: latency, jitter, the counter's period and its zero.

use crate::circuit::Clock;
use crate::draw::{Purpose, Stream};
use crate::event::{Event, Spike};
use crate::pixel::Seeds;

/// Stamps the spikes of a recording: sorted by stamp, row and column. A stamp is the count at the
/// counter's next tick; the unit period of 1 us is rounded instead. Stamps from `duration_s` on
/// are outside the recording; those before its start read 0.
pub fn stamp(clock: &Clock, seeds: Seeds, spikes: &[Spike], duration_s: f64) -> Vec<Event> {
    let jitter = Stream::new(seeds.run, Purpose::Jitter, 0);
    let end_us = (duration_s * 1e6) as u64;
    let mut events: Vec<Event> = spikes
        .iter()
        .zip(0..)
        .filter_map(|(spike, index)| {
            let mut t_us = spike.t_s * 1e6 + clock.latency_us + clock.offset_us;
            if clock.jitter_us > 0.0 {
                t_us += clock.jitter_us * jitter.normal(index);
            }
            let counted_us = if clock.period_us > 1.0 {
                (t_us / clock.period_us).ceil() * clock.period_us
            } else {
                t_us.round()
            };
            let t_us = counted_us.max(0.0) as u64;
            (t_us < end_us).then_some(Event {
                t_us,
                y: spike.row() as u16,
                x: spike.column() as u16,
                on: spike.on,
            })
        })
        .collect();
    events.sort_unstable();
    events
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::circuit::Circuit;

    const SEEDS: Seeds = Seeds { camera: 1, run: 2 };

    fn spike(t_s: f64) -> Spike {
        Spike { t_s, pixel: 100, on: true }
    }

    #[test]
    fn a_counter_of_500_us_stamps_its_next_tick() {
        let clock = Clock { period_us: 500.0, ..Circuit::ideal().clock };
        let events = stamp(&clock, SEEDS, &[spike(0.000_1), spike(0.000_5), spike(0.000_501)], 1.0);
        let stamps: Vec<u64> = events.iter().map(|event| event.t_us).collect();
        assert_eq!(stamps, [500, 500, 1000]);
    }

    #[test]
    fn latency_and_offset_add_to_the_time() {
        let clock = Clock { latency_us: 250.0, offset_us: 3000.0, ..Circuit::ideal().clock };
        assert_eq!(stamp(&clock, SEEDS, &[spike(0.1)], 1.0)[0].t_us, 103_250);
    }

    #[test]
    fn jitter_has_its_standard_deviation() {
        let clock = Clock { jitter_us: 300.0, ..Circuit::ideal().clock };
        let spikes: Vec<Spike> = (0..20_000).map(|_| spike(0.5)).collect();
        let events = stamp(&clock, SEEDS, &spikes, 1.0);
        let square: f64 = events.iter().map(|event| (event.t_us as f64 - 5e5).powi(2)).sum();
        let deviation_us = (square / events.len() as f64).sqrt();
        assert!((deviation_us - 300.0).abs() < 4.0 * 300.0 / (2.0 * 20_000.0_f64).sqrt());
    }
}
