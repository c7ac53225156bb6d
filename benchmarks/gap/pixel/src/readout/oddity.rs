//! Faults of the readout that no catalogue knows.

use crate::circuit::ReadoutOddity;
use crate::draw::{Purpose, Stream};
use crate::event::{DURATION_S, Spike, WIDTH, sort_spikes};

/// Applies a fault to time-ordered spikes; the result is ordered again.
pub(super) fn disturb(oddity: ReadoutOddity, run_seed: u64, spikes: Vec<Spike>) -> Vec<Spike> {
    let stream = Stream::new(run_seed, Purpose::Oddity, 0);
    match oddity {
        ReadoutOddity::Echo { share, delay_s } => {
            add(spikes, stream, share, |spike| Some(Spike { t_s: spike.t_s + delay_s, ..*spike }))
        }
        ReadoutOddity::NeighbourCopy { share, delay_s } => add(spikes, stream, share, |spike| {
            // The last column has no neighbour on the right.
            (spike.column() + 1 < WIDTH).then_some(Spike {
                t_s: spike.t_s + delay_s,
                pixel: spike.pixel + 1,
                ..*spike
            })
        }),
        ReadoutOddity::BurstLoss { share, bad_s, good_s } => {
            let spells = Stream::new(run_seed, Purpose::Oddity, 1);
            lose(spikes, stream, share, &bad_spells(spells, bad_s, good_s))
        }
    }
}

fn add(
    spikes: Vec<Spike>,
    stream: Stream,
    share: f64,
    copy: impl Fn(&Spike) -> Option<Spike>,
) -> Vec<Spike> {
    // Of the spikes as they are: a copy is not copied again.
    let copies: Vec<Spike> = spikes
        .iter()
        .zip(0..)
        .filter(|&(_, index)| stream.uniform(index) < share)
        .filter_map(|(spike, _)| copy(spike))
        .collect();
    let mut all = spikes;
    all.extend(copies);
    sort_spikes(&mut all);
    all
}

fn lose(spikes: Vec<Spike>, stream: Stream, share: f64, bad: &[(f64, f64)]) -> Vec<Spike> {
    let is_bad = |t_s: f64| {
        let after = bad.partition_point(|spell| spell.0 <= t_s);
        after > 0 && t_s < bad[after - 1].1
    };
    spikes
        .into_iter()
        .zip(0..)
        .filter(|(spike, index)| !(is_bad(spike.t_s) && stream.uniform(*index) < share))
        .map(|(spike, _)| spike)
        .collect()
}

/// Start and end of the bad spells, both states of exponential length.
fn bad_spells(stream: Stream, bad_s: f64, good_s: f64) -> Vec<(f64, f64)> {
    let mut spells = Vec::new();
    let mut t_s = 0.0;
    for index in 0.. {
        let start_s = t_s + good_s * stream.exponential(2 * index);
        if start_s > DURATION_S {
            break;
        }
        t_s = start_s + bad_s * stream.exponential(2 * index + 1);
        spells.push((start_s, t_s));
    }
    spells
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spikes(count: u32) -> Vec<Spike> {
        let place = |k: u32| Spike {
            t_s: f64::from(k) * 0.9 / f64::from(count),
            pixel: k % 6912,
            on: k.is_multiple_of(2),
        };
        (0..count).map(place).collect()
    }

    #[test]
    fn every_echo_has_its_event_one_delay_before() {
        let before = spikes(500);
        let oddity = ReadoutOddity::Echo { share: 0.3, delay_s: 0.03 };
        let after = disturb(oddity, 1, before.clone());
        let echoes: Vec<&Spike> = after.iter().filter(|spike| !before.contains(spike)).collect();
        // Four standard deviations of the binomial count.
        assert!((echoes.len() as f64 - 150.0).abs() < 4.0 * (500.0_f64 * 0.3 * 0.7).sqrt());
        for echo in echoes {
            let source = Spike { t_s: echo.t_s - 0.03, ..*echo };
            assert!(before.iter().any(|spike| {
                spike.pixel == source.pixel && (spike.t_s - source.t_s).abs() < 1e-12
            }));
        }
    }

    #[test]
    fn events_are_lost_in_bad_spells_only() {
        let before = spikes(20_000);
        let oddity = ReadoutOddity::BurstLoss { share: 1.0, bad_s: 0.02, good_s: 0.05 };
        let after = disturb(oddity, 4, before.clone());
        let spells = bad_spells(Stream::new(4, Purpose::Oddity, 1), 0.02, 0.05);
        assert!(!spells.is_empty());
        for spike in &before {
            let bad = spells.iter().any(|&(from, to)| from <= spike.t_s && spike.t_s < to);
            assert_eq!(!bad, after.contains(spike));
        }
    }
}
