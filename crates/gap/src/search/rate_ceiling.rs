//! Windows of an event rate control, read from the counts of events: many windows are full to the
//! same event, which no light does.

use evpose_core::EventStream;

use super::recording_marks::Reading;

/// Lengths of windows that are tried, microseconds.
const WINDOWS_US: [i64; 9] = [250, 500, 1_000, 2_000, 2_500, 4_000, 5_000, 10_000, 20_000];
/// Phases that are tried, fractions of a window.
const PHASES: i64 = 20;
/// Fewest events of a full window: smaller counts are equal by chance.
const MIN_BUDGET: usize = 20;
const MIN_FULL: usize = 8;
/// Windows with more than this fraction of the budget that are not full are natural ones.
const NEARLY_FULL: f64 = 0.9;
/// Full windows for each that is nearly full, from which a ceiling is proven.
const FULL_PER_NEARLY_FULL: usize = 2;
/// Rates that differ by less are of one ceiling; its period is the shortest window.
const SAME_RATE: f64 = 0.02;

/// Windows `(phase + (k - 1) length, phase + k length]`, and the events that fit into one.
#[derive(Debug, Clone, Copy)]
struct Windows {
    length_us: i64,
    phase_us: i64,
    budget: usize,
}

impl Windows {
    fn rate_hz(&self) -> f64 {
        1e6 * self.budget as f64 / self.length_us as f64
    }
}

/// Rate and windows of an event rate control; none if windows are not full.
pub(super) fn rate_ceiling(events: &EventStream) -> Option<Reading> {
    let t_us: Vec<i64> = events.t().iter().map(|t| t.0).collect();
    let mut best: Option<Windows> = None;
    for length_us in WINDOWS_US {
        // A clock that counts from zero begins its windows one microsecond before a multiple.
        let phases = (0..PHASES).flat_map(|i| [i * length_us / PHASES, i * length_us / PHASES - 1]);
        for phase_us in phases {
            let Some(budget) = full(&t_us, length_us, phase_us) else { continue };
            let found = Windows { length_us, phase_us, budget };
            let limit_hz = best.map_or(f64::INFINITY, |best| best.rate_hz() * (1.0 - SAME_RATE));
            // The lowest rate: part of a full window may hold all of its events.
            if found.rate_hz() < limit_hz {
                best = Some(found);
            }
        }
    }
    let Windows { length_us, phase_us, budget } = best?;
    // Windows end with the last stamp of any: stamps may lie on a grid.
    let slack_us = t_us.iter().map(|t| (phase_us - t).rem_euclid(length_us)).min()?;
    let params = [
        // Half an event more, so that rounding does not take one away.
        ("rate_hz", (1e6 * (budget as f64 + 0.5) / length_us as f64).into()),
        ("window_us", (length_us as f64).into()),
        ("phase_us", ((phase_us - slack_us).rem_euclid(length_us) as f64).into()),
    ];
    Some(Reading::new(params, 1.0))
}

/// Events of a full window; none if there are not enough of them.
fn full(t_us: &[i64], length_us: i64, phase_us: i64) -> Option<usize> {
    // Less one, since the end of a window belongs to it.
    let window = |t: &i64| (t - phase_us - 1).div_euclid(length_us);
    let counts: Vec<usize> =
        t_us.chunk_by(|a, b| window(a) == window(b)).map(<[i64]>::len).collect();
    let budget = counts.iter().copied().max().filter(|budget| *budget >= MIN_BUDGET)?;
    let full = counts.iter().filter(|count| **count == budget).count();
    let least = NEARLY_FULL * budget as f64;
    let nearly = counts.iter().filter(|count| **count as f64 > least).count() - full;
    (full >= MIN_FULL && full >= FULL_PER_NEARLY_FULL * nearly).then_some(budget)
}

#[cfg(test)]
mod tests {
    use evpose_core::SensorSize;

    use super::*;
    use crate::probe::testing::on;

    /// Events at a varying rate; `budget` of them pass in each window of `length_us`.
    fn controlled(length_us: i64, phase_us: i64, budget: usize, step_us: i64) -> EventStream {
        let size = SensorSize { width: 20, height: 30 };
        let (mut window, mut passed) = (i64::MIN, 0);
        let mut kept = Vec::new();
        let mut t = 0.0_f64;
        while t < 400_000.0 {
            t += 18.0 + 12.0 * (t / 40_000.0).sin();
            let stamp = (t as i64 / step_us + 1) * step_us;
            let here = (stamp - phase_us).div_euclid(length_us);
            (window, passed) = if here == window { (window, passed + 1) } else { (here, 1) };
            if passed <= budget {
                kept.push(on(stamp, 3, 4));
            }
        }
        EventStream::from_events(size, kept).unwrap()
    }

    #[test]
    fn windows_that_are_full_to_the_same_event_show_rate_length_and_phase() {
        for (length_us, phase_us, step_us, expected_us) in
            [(2_000, 0, 1, 1_999), (2_000, 0, 1_000, 1_000), (5_000, 1_250, 1, 1_249)]
        {
            let budget = (length_us / 24) as usize;
            let reading = rate_ceiling(&controlled(length_us, phase_us, budget, step_us)).unwrap();
            let value = |key| reading.number(key).unwrap();
            assert_eq!(value("window_us"), length_us as f64);
            assert_eq!((value("rate_hz") * length_us as f64 * 1e-6) as usize, budget);
            assert_eq!(value("phase_us"), f64::from(expected_us), "{reading:?}");
        }
    }

    #[test]
    fn a_rate_that_sways_freely_has_no_ceiling() {
        assert!(rate_ceiling(&controlled(2_000, 0, usize::MAX, 1)).is_none());
        assert!(rate_ceiling(&controlled(2_000, 0, usize::MAX, 1_000)).is_none());
    }
}
