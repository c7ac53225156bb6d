//! Marks that a readout and a clock leave in the time stamps and in the order of events.

use std::f64::consts::TAU;

use crate::probe::interface::StatisticProbe;
use crate::probe::scan::{self, Spot};
use crate::{Entry, StatisticBlock, View};

/// Phases of time stamps, shared stamps, successive events, and scans.
pub(super) static PROBE: StatisticProbe = StatisticProbe { name: "readout", entries, measure };

/// Periods of stamps whose phases are tested. All divide [`COMMON_US`].
const PERIODS_US: [usize; 13] = [2, 5, 10, 20, 50, 100, 125, 200, 250, 500, 1_000, 2_000, 5_000];
const COMMON_US: usize = 10_000;
/// Logarithm to base two of the phase bins of the scene's time step.
const STEP_BITS: u32 = 10;
/// Largest interval between stamps of one pass of the readout.
const CLOSE_US: i64 = 100;
/// Prior count that shrinks fractions of few events towards zero.
const SETTLED: f64 = 20.0;
const TOLERANCE: f64 = 0.02;

/// Resultant length of `n` unit vectors with sum `(x, y)`, corrected for its value by chance.
fn resultant(x: f64, y: f64, n: f64) -> f64 {
    if n < 2.0 {
        return 0.0;
    }
    ((x * x + y * y - n) / (n * (n - 1.0))).clamp(0.0, 1.0).sqrt()
}

/// Resultant length of events that are counted by phase.
fn of_phases(phases: &[u32]) -> f64 {
    let (mut x, mut y, mut n) = (0.0, 0.0, 0.0);
    for (phase, &events) in phases.iter().enumerate() {
        let (sin, cos) = (TAU * phase as f64 / phases.len() as f64).sin_cos();
        x += f64::from(events) * cos;
        y += f64::from(events) * sin;
        n += f64::from(events);
    }
    resultant(x, y, n)
}

/// Phase locking of stamps to each period, and to the time step of the scene.
fn residues(view: &View<'_>, out: &mut Vec<f64>) {
    let mut common = vec![0_u32; COMMON_US];
    let mut in_step = [0_u32; 1 << STEP_BITS];
    // Turns as a fraction of 2^64: whole turns overflow.
    let turn_per_us = (1e-6 * view.reference_scene.scene.fps() * 2_f64.powi(64)) as u64;
    for event in view.events() {
        common[event.t_us.rem_euclid(COMMON_US as i64) as usize] += 1;
        let turn = (event.t_us as u64).wrapping_mul(turn_per_us);
        // Rounded, so that stamps of one phase fall into one bin and not into two.
        let half = 1_u64 << (63 - STEP_BITS);
        in_step[(turn.wrapping_add(half) >> (64 - STEP_BITS)) as usize] += 1;
    }
    out.extend(PERIODS_US.map(|period_us| {
        let mut phases = vec![0_u32; period_us];
        for part in common.chunks_exact(period_us) {
            phases.iter_mut().zip(part).for_each(|(sum, n)| *sum += n);
        }
        of_phases(&phases)
    }));
    out.push(of_phases(&in_step));
}

/// The lines (rows or columns) that a group of events has touched.
struct Touched {
    group_of: Vec<usize>,
    again: f64,
}

impl Touched {
    fn new(lines: u16) -> Self {
        Self { group_of: vec![0; usize::from(lines)], again: 0.0 }
    }

    fn touch(&mut self, line: u16, group: usize) {
        let last = &mut self.group_of[usize::from(line)];
        if *last == group {
            self.again += 1.0;
        }
        *last = group;
    }
}

/// Fractions of events that share a stamp, and that share rows and columns with others of their
/// stamp. No statistic depends on the order of events with one stamp, which is a convention of
/// files.
fn shared(view: &View<'_>, spots: &[Spot], out: &mut Vec<f64>) {
    let size = view.size();
    let (mut rows, mut columns) = (Touched::new(size.height), Touched::new(size.width));
    let (mut groups, mut in_company, mut log_size) = (0, 0.0, 0.0);
    for group in spots.chunk_by(|a, b| a.t_us == b.t_us) {
        groups += 1;
        if group.len() < 2 {
            continue;
        }
        in_company += group.len() as f64;
        log_size += (group.len() as f64).ln();
        for event in group {
            // Counted by group number, so that the tables of lines need not be cleared for each
            // stamp.
            rows.touch(event.y, groups);
            columns.touch(event.x, groups);
        }
    }
    let n = spots.len() as f64;
    out.push(in_company / (n + SETTLED));
    out.push(log_size / (groups as f64 + SETTLED));
    out.push(rows.again / (in_company + SETTLED));
    out.push(columns.again / (in_company + SETTLED));
}

/// Fraction of stamps whose mean position is in the row or column of the previous stamp, and the
/// mean direction of rows and columns between stamps that are close in time.
fn succession(spots: &[Spot], out: &mut Vec<f64>) {
    let (mut pairs, mut row, mut column) = (0.0, 0.0, 0.0);
    let (mut close, mut down, mut right) = (0.0, 0.0, 0.0);
    let mut last: Option<(i64, f32, f32)> = None;
    for group in spots.chunk_by(|a, b| a.t_us == b.t_us) {
        let (x, y) = middle(group);
        let t_us = group[0].t_us;
        let Some((t_before_us, x_before, y_before)) = last.replace((t_us, x, y)) else { continue };
        let (dx, dy) = (x - x_before, y - y_before);
        pairs += 1.0;
        row += f64::from(u8::from(dy.abs() < 0.5));
        column += f64::from(u8::from(dx.abs() < 0.5));
        // Between distant stamps a scan has gone around, and its direction is lost.
        if t_us - t_before_us < CLOSE_US {
            close += 1.0;
            down += sign(dy);
            right += sign(dx);
        }
    }
    // Few pairs shrink shares towards none.
    out.extend([row, column].map(|same| same / (pairs + SETTLED)));
    out.extend([down, right].map(|sum| sum / (close + SETTLED)));
}

fn middle(group: &[Spot]) -> (f32, f32) {
    let (x, y) = group
        .iter()
        .fold((0_u32, 0_u32), |(x, y), spot| (x + u32::from(spot.x), y + u32::from(spot.y)));
    (x as f32 / group.len() as f32, y as f32 / group.len() as f32)
}

fn sign(difference: f32) -> f64 {
    f64::from(u8::from(difference > 0.0)) - f64::from(u8::from(difference < 0.0))
}

fn entries() -> Vec<Entry> {
    let value = |name: String| Entry::value(StatisticBlock::Readout, name, TOLERANCE);
    let residues = PERIODS_US.iter().map(|us| value(format!("stamps modulo {us} us")));
    let others = [
        "stamps modulo the step of the scene",
        "share of events that share their stamp",
        "mean log number of events with one stamp",
        "share of events with one stamp that share their row",
        "share of events with one stamp that share their column",
        "share of stamps in the row of the stamp before",
        "share of stamps in the column of the stamp before",
        "rows go up between close stamps",
        "columns go up between close stamps",
    ];
    let scans = scan::AXES.iter().flat_map(|axis| {
        (0..scan::BANDS).map(move |band| value(format!("clock locked to {axis}, band {band}")))
    });
    residues.chain(others.map(|name| value(name.to_owned()))).chain(scans).collect()
}

fn measure(view: &View<'_>, out: &mut Vec<f64>) {
    residues(view, out);
    let spots = Spot::from_view(view);
    shared(view, &spots, out);
    succession(&spots, out);
    out.extend(scan::resultants(view, &spots));
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, EventStream, Micros};

    use super::*;
    use crate::probe::testing;

    fn stamped(stamp: impl Fn(i64) -> i64) -> EventStream {
        testing::changed(|event| Some(Event { t: Micros(stamp(event.t.0)), ..event }))
    }

    #[test]
    fn quantised_stamps_keep_to_one_phase_of_the_period_and_its_parts() {
        let quantised = stamped(|t| t.div_euclid(250) * 250);
        let locking = |us| testing::value(&PROBE, &quantised, &format!("stamps modulo {us} us"));
        for us in [2, 5, 10, 50, 125, 250] {
            assert!((locking(us) - 1.0).abs() < 1e-9, "{us}: {}", locking(us));
        }
        // Four phases of a millisecond.
        assert!(locking(1_000) < 0.1, "{}", locking(1_000));
        let free = stamped(|t| t);
        assert!(testing::value(&PROBE, &free, "stamps modulo 250 us") < 0.1);
    }

    #[test]
    fn nothing_depends_on_the_order_of_events_with_one_stamp() {
        let quantised = stamped(|t| t.div_euclid(1_000) * 1_000);
        let backward = testing::stream({
            let mut events: Vec<Event> = quantised.iter().collect();
            events.reverse();
            events
        });
        assert_ne!(quantised, backward);
        for entry in entries() {
            let [a, b] =
                [&quantised, &backward].map(|events| testing::value(&PROBE, events, &entry.name));
            // Sums of waves are rounded in another order.
            assert!((a - b).abs() < 1e-6, "{}: {a} {b}", entry.name);
        }
        let share = "share of events that share their stamp";
        assert!(testing::value(&PROBE, &quantised, share) > 0.9);
    }

    #[test]
    fn rows_that_go_up_with_the_stamp_are_noticed() {
        let name = "rows go up between close stamps";
        let sorted = testing::changed(|event| {
            let t = event.t.0.div_euclid(1_000) * 1_000 + i64::from(event.y) * 5;
            Some(Event { t: Micros(t), ..event })
        });
        assert!(testing::value(&PROBE, &sorted, name) > 0.9);
        assert!(testing::value(&PROBE, testing::events(), name).abs() < 0.2);
    }
}
