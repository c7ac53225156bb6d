//! How visible an effect is: the recording with it against the same one without, same draws.
//!
//! Events of a pixel and polarity are aligned by the cheapest pairing (a pair costs its distance in
//! time over 8 ms, an event without partner one half). An event *differs* if it has no partner or
//! has *moved*. Moved means
//! * in optics, photoreceptor, detector and background: by more than 100 us and more than a tenth
//!   of the time to the nearest other event of the pixel without the effect (a tenth of a
//!   threshold, about);
//! * in readout and clock: by more than 200 us.
//!
//! An effect is *visible* if at least 3 % as many events differ as there are without it, or if at
//! least 60 events are added in pixels that have at most one event without it. Someone who knows
//! physics and has the truth at hand would then see it.

use serde::Serialize;

use crate::effect::CameraStage;
use crate::event::{Event, Recording};

/// Distance in time at which a pair costs as much as two events without partner.
const WINDOW_US: f64 = 8000.0;
/// Smallest shift that counts, in the pixel.
const SHIFT_US: f64 = 100.0;
/// Smallest shift that counts, relative to the spacing of the pixel's events.
const SHIFT_SHARE: f64 = 0.1;
/// Smallest shift that counts, in readout and clock.
const CLOCK_SHIFT_US: f64 = 200.0;
/// Share of events that must differ.
pub const VISIBLE_SHARE: f64 = 0.03;
/// Events that must be added in quiet pixels.
pub const VISIBLE_ADDED: usize = 60;

/// Measured difference between recordings with and without an effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Evidence {
    /// Events without the effect.
    pub without: usize,
    /// Events with it.
    pub with: usize,
    /// Events that only the recording with the effect has.
    pub added: usize,
    /// Events that only the recording without it has.
    pub removed: usize,
    /// Events that moved.
    pub moved: usize,
    /// Events added in pixels with at most one event otherwise.
    pub added_in_quiet: usize,
    /// Median of the absolute shifts of all pairs, us.
    pub median_shift_us: f64,
    /// The verdict.
    pub visible: bool,
}

impl Evidence {
    /// Events that differ, relative to those without the effect.
    pub fn share(&self) -> f64 {
        (self.added + self.removed + self.moved) as f64 / self.without.max(1) as f64
    }
}

/// Compares a recording with an effect to the same one without.
pub fn compare(without: &Recording, with: &Recording, stage: CameraStage) -> Evidence {
    let before = by_pixel(without);
    let after = by_pixel(with);
    let in_clock = matches!(stage, CameraStage::Readout | CameraStage::Clock);
    let (mut added, mut removed, mut moved, mut added_in_quiet) = (0, 0, 0, 0);
    let mut shifts_us = Vec::new();
    for (old, new) in before.iter().zip(&after) {
        // Where next to nothing happened before, an added event shows.
        let quiet = old[0].len() + old[1].len() <= 1;
        let all = spacing_times(old);
        for (old, new) in old.iter().zip(new) {
            let pairs = align(old, new);
            // What has no partner is gone, or new.
            removed += old.len() - pairs.len();
            added += new.len() - pairs.len();
            if quiet {
                added_in_quiet += new.len() - pairs.len();
            }
            for (old_us, new_us) in pairs {
                let shift_us = (new_us - old_us).abs();
                // Readout and clock delay events of all pixels: their limit is fixed. Elsewhere a
                // shift also has to be large for the spacing of the pixel's events.
                let min_shift_us = if in_clock {
                    CLOCK_SHIFT_US
                } else {
                    SHIFT_US.max(SHIFT_SHARE * spacing_us(&all, old_us))
                };
                moved += usize::from(shift_us > min_shift_us);
                shifts_us.push(shift_us);
            }
        }
    }
    shifts_us.sort_by(f64::total_cmp);
    let median_shift_us = shifts_us.get(shifts_us.len() / 2).copied().unwrap_or(0.0);
    let mut evidence = Evidence {
        without: without.events.len(),
        with: with.events.len(),
        added,
        removed,
        moved,
        added_in_quiet,
        median_shift_us,
        visible: false,
    };
    evidence.visible = evidence.share() >= VISIBLE_SHARE || added_in_quiet >= VISIBLE_ADDED;
    evidence
}

/// Times of the OFF and ON events of each pixel, us.
fn by_pixel(recording: &Recording) -> Vec<[Vec<f64>; 2]> {
    let mut pixels = vec![[Vec::new(), Vec::new()]; recording.width * recording.height];
    for Event { t_us, x, y, on } in &recording.events {
        let pixel = usize::from(*y) * recording.width + usize::from(*x);
        pixels[pixel][usize::from(*on)].push(*t_us as f64);
    }
    pixels
}

fn spacing_times(pixel: &[Vec<f64>; 2]) -> Vec<f64> {
    let mut all = pixel.concat();
    all.sort_by(f64::total_cmp);
    all
}

/// Time from an event to the nearest other one of the sorted `times_us`.
fn spacing_us(times_us: &[f64], at_us: f64) -> f64 {
    let first = times_us.partition_point(|&t| t < at_us);
    let left = first.checked_sub(1).map_or(f64::INFINITY, |i| at_us - times_us[i]);
    let right = times_us.get(first + 1).map_or(f64::INFINITY, |t| t - at_us);
    // A lonely event is compared with the length of a slow edge.
    left.min(right).min(50_000.0)
}

/// The cheapest order-preserving pairing of two sorted lists.
fn align(old: &[f64], new: &[f64]) -> Vec<(f64, f64)> {
    let columns = new.len() + 1;
    let mut costs = vec![0.0; (old.len() + 1) * columns];
    // An edit distance: an event alone costs a half, so that a pair may cost up to 1.
    for i in 0..=old.len() {
        for j in 0..=new.len() {
            if i == 0 || j == 0 {
                costs[i * columns + j] = 0.5 * (i + j) as f64;
                continue;
            }
            let pair = costs[(i - 1) * columns + j - 1] + pair_cost(old[i - 1], new[j - 1]);
            let alone = costs[(i - 1) * columns + j].min(costs[i * columns + j - 1]) + 0.5;
            costs[i * columns + j] = pair.min(alone);
        }
    }
    // Back along the cheapest way.
    let (mut i, mut j) = (old.len(), new.len());
    let mut pairs = Vec::new();
    while i > 0 && j > 0 {
        let here = costs[i * columns + j];
        let pair = costs[(i - 1) * columns + j - 1] + pair_cost(old[i - 1], new[j - 1]);
        // The sum is the one above, bit by bit, so that the comparison is exact.
        if pair <= here {
            pairs.push((old[i - 1], new[j - 1]));
            (i, j) = (i - 1, j - 1);
        } else if costs[(i - 1) * columns + j] <= costs[i * columns + j - 1] {
            i -= 1;
        } else {
            j -= 1;
        }
    }
    pairs
}

fn pair_cost(old_us: f64, new_us: f64) -> f64 {
    (new_us - old_us).abs() / WINDOW_US
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(events: &[(u64, u16, bool)]) -> Recording {
        let events = events.iter().map(|&(t_us, x, on)| Event { t_us, y: 0, x, on }).collect();
        Recording { events, width: 8, height: 1, duration_s: 1.0 }
    }

    #[test]
    fn equal_recordings_show_nothing() {
        let same = recording(&[(100, 0, true), (900, 0, true), (1500, 3, false)]);
        let evidence = compare(&same, &same, CameraStage::Detector);
        assert_eq!((evidence.added, evidence.removed, evidence.moved), (0, 0, 0));
        assert!(!evidence.visible);
    }

    #[test]
    fn a_lost_event_does_not_move_the_others() {
        let before =
            recording(&[(1000, 0, true), (2000, 0, true), (3000, 0, true), (4000, 0, true)]);
        let after = recording(&[(2000, 0, true), (3000, 0, true), (4000, 0, true)]);
        let evidence = compare(&before, &after, CameraStage::Detector);
        assert_eq!((evidence.added, evidence.removed, evidence.moved), (0, 1, 0));
    }

    #[test]
    fn a_shift_counts_from_100_us_in_the_pixel_and_from_200_us_in_the_clock() {
        let before = recording(&[(1000, 0, true), (2000, 0, true)]);
        let after = recording(&[(1150, 0, true), (2150, 0, true)]);
        assert_eq!(compare(&before, &after, CameraStage::Detector).moved, 2);
        assert_eq!(compare(&before, &after, CameraStage::Clock).moved, 0);
    }
}
