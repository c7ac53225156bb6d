//! The time-stamper: latency, jitter, the counter's period and its zero.

use crate::circuit::{CellCounter, Clock, NoiseAddress};
use crate::draw::{Purpose, Stream};
use crate::event::{Event, HEIGHT, Spike, WIDTH};
use crate::pixel::Seeds;

/// Stamps the spikes of a recording: sorted by stamp, row and column. A stamp is the count at the
/// counter's next tick; the unit period of 1 us is rounded instead. Stamps from `duration_s` on
/// are outside the recording; those before its start read 0.
pub fn stamp(
    clock: &Clock,
    address: NoiseAddress,
    seeds: Seeds,
    spikes: &[Spike],
    duration_s: f64,
) -> Vec<Event> {
    let mut jitter = Jitter::new(address, seeds.run);
    let end_us = (duration_s * 1e6) as u64;
    let mut events: Vec<Event> = spikes
        .iter()
        .zip(0..)
        .filter_map(|(spike, index)| {
            let mut t_us =
                // The counter counts from its own zero.
                spike.t_s * 1e6 + latency_us(clock, seeds.camera, spike) + clock.offset_us;
            if clock.jitter_us > 0.0 {
                t_us += clock.jitter_us * jitter.normal(spike, index);
            }
            let counted_us = if clock.period_us > 1.0 {
                (t_us / clock.period_us).ceil() * clock.period_us
            } else {
                t_us.round()
            };
            // What comes before the recording reads zero, as a counter that is reset does.
            let t_us = counted_us.max(0.0) as u64;
            (t_us < end_us).then_some(Event {
                t_us,
                y: spike.row() as u16,
                x: spike.column() as u16,
                on: spike.on,
            })
        })
        .collect();
    // Jitter and latency have changed the order.
    events.sort_unstable();
    events
}

fn latency_us(clock: &Clock, camera_seed: u64, spike: &Spike) -> f64 {
    if clock.latency_spread_ln == 0.0 {
        return clock.latency_us;
    }
    let xi = Stream::new(camera_seed, Purpose::Latency, u64::from(spike.pixel)).normal(0);
    clock.latency_us * (clock.latency_spread_ln * xi).exp()
}

/// Standard normal draws of the events.
struct Jitter {
    run_seed: u64,
    /// A counter for each pixel and polarity; none where events are counted over the recording.
    cells: Option<Vec<CellCounter>>,
}

impl Jitter {
    fn new(address: NoiseAddress, run_seed: u64) -> Self {
        let is_timed = address == NoiseAddress::Time;
        let cells = is_timed.then(|| vec![CellCounter::default(); 2 * WIDTH * HEIGHT]);
        Self { run_seed, cells }
    }

    fn normal(&mut self, spike: &Spike, index: u64) -> f64 {
        let (key, index) = match &mut self.cells {
            None => (0, index),
            Some(cells) => {
                // Each polarity of a pixel has its own draws, which events of the other do not
                // shift.
                let key = 2 * spike.pixel as usize + usize::from(spike.on);
                (key as u64 + 1, cells[key].index(spike.t_s))
            }
        };
        Stream::new(self.run_seed, Purpose::Jitter, key).normal(index)
    }
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
        let events = stamp(
            &clock,
            NoiseAddress::Count,
            SEEDS,
            &[spike(0.000_1), spike(0.000_5), spike(0.000_501)],
            1.0,
        );
        let stamps: Vec<u64> = events.iter().map(|event| event.t_us).collect();
        assert_eq!(stamps, [500, 500, 1000]);
    }

    #[test]
    fn latency_and_offset_add_to_the_time() {
        let clock = Clock { latency_us: 250.0, offset_us: 3000.0, ..Circuit::ideal().clock };
        assert_eq!(stamp(&clock, NoiseAddress::Count, SEEDS, &[spike(0.1)], 1.0)[0].t_us, 103_250);
    }

    #[test]
    fn jitter_has_its_standard_deviation() {
        let clock = Clock { jitter_us: 300.0, ..Circuit::ideal().clock };
        let spikes: Vec<Spike> = (0..20_000).map(|_| spike(0.5)).collect();
        let events = stamp(&clock, NoiseAddress::Count, SEEDS, &spikes, 1.0);
        let square: f64 = events.iter().map(|event| (event.t_us as f64 - 5e5).powi(2)).sum();
        let deviation_us = (square / events.len() as f64).sqrt();
        assert!((deviation_us - 300.0).abs() < 4.0 * 300.0 / (2.0 * 20_000.0_f64).sqrt());
    }
}
