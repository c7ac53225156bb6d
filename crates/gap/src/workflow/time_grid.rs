//! Time stamps that lie on the grid of the frames a recording was made from.
//!
//! # Method
//! Programs that make events from frames put them at the frames, or at simple fractions of the time
//! between two. Nothing below a frame can then be compared: measured stamps are moved to the end of
//! their frame, and a clock of that period is among the effects that time stamps prove, so that
//! simulated ones are moved as well. Otherwise the grid would hide every other difference.

use std::collections::HashMap;

use evpose_core::{Event, EventStream, Micros};

use crate::search::common_period_us;
use crate::{GapError, ReferenceScene};

/// Fraction of all phases within a frame that counts as a grid, and the fraction of time stamps
/// that lie on it. Of evenly spread stamps as many lie on it as the first says.
const PHASES: f64 = 0.015;
const ON_GRID: f64 = 0.8;
/// Fraction of time stamps at one phase that is a grid as well: something delays the others.
const AT_ONE_PHASE: f64 = 0.2;
const MIN_EVENTS: usize = 500;
/// Factor by which the phases of single lines are more concentrated than those of all if a readout
/// makes them.
const BY_LINE: f64 = 2.0;
/// Deviation of the counts at all multiples of a period from their mean up to which they are alike.
const ALIKE: f64 = 0.3;
/// Phases below this fraction of a frame may be just behind the frame before, if more than twice as
/// many stamps have them as would by chance.
const AMBIGUOUS: f64 = 0.05;
const AMBIGUOUS_FRACTION: f64 = 0.1;

/// Whether most time stamps lie at a few phases of the step of the scene, or many at one.
pub(super) fn is_on_frame_grid(events: &EventStream, step: Micros) -> bool {
    if events.len() < MIN_EVENTS || step.0 < 2 || is_other_clock(events, step) {
        return false;
    }
    let mut counts = vec![0_usize; step.0 as usize];
    events.t().iter().for_each(|t| counts[t.0.rem_euclid(step.0) as usize] += 1);
    counts.sort_unstable_by(|a, b| b.cmp(a));
    let phases = ((PHASES * step.0 as f64).ceil() as usize).max(1);
    let on_grid: usize = counts.iter().take(phases).sum();
    // With few phases in a step, any stamps would lie on so many of them.
    (phases as f64) < ON_GRID * step.0 as f64
        && (on_grid as f64 >= ON_GRID * events.len() as f64
            || counts[0] as f64 >= AT_ONE_PHASE * events.len() as f64)
        && !is_by_line(events, step, counts[0])
}

/// Whether all stamps are multiples of a period that does not divide the step of the scene, or whose
/// multiples within a step are equally frequent: a program that puts several events between two
/// frames has most of them at the frames.
fn is_other_clock(events: &EventStream, step: Micros) -> bool {
    let period_us = common_period_us(events);
    if period_us <= 1 || period_us % step.0 == 0 {
        return false;
    }
    if step.0 % period_us != 0 {
        return true;
    }
    let mut counts = vec![0_usize; (step.0 / period_us) as usize];
    events.t().iter().for_each(|t| counts[(t.0.rem_euclid(step.0) / period_us) as usize] += 1);
    let mean = events.len() as f64 / counts.len() as f64;
    counts.iter().all(|count| (*count as f64 / mean - 1.0).abs() < ALIKE)
}

/// Whether each row, or each column, has phases of its own, as a readout that scans lines gives
/// them; `largest` is the number of events of the most common phase of all.
fn is_by_line(events: &EventStream, step: Micros, largest: usize) -> bool {
    let is_by = |line: &dyn Fn(&Event) -> u16| {
        let mut counts: HashMap<(u16, i64), usize> = HashMap::new();
        for event in events.iter() {
            // In a scan each line has its phase, and together they explain far more than one phase
            // does.
            *counts.entry((line(&event), event.t.0.rem_euclid(step.0))).or_default() += 1;
        }
        let mut largest_of: HashMap<u16, usize> = HashMap::new();
        for ((line, _), count) in counts {
            let known = largest_of.entry(line).or_default();
            *known = (*known).max(count);
        }
        largest_of.values().sum::<usize>() as f64 > BY_LINE * largest as f64
    };
    is_by(&|event| event.y) || is_by(&|event| event.x)
}

/// The events with their stamps at the end of their frame, or at the frame that they are just
/// behind, whichever is closer to the reference.
///
/// # Errors
/// If the events cannot be ordered.
pub(super) fn moved_to_frames(
    events: &EventStream,
    reference_scene: &ReferenceScene,
    step: Micros,
) -> Result<EventStream, GapError> {
    let phase = |event: &Event| event.t.0.rem_euclid(step.0) as f64 / step.0 as f64;
    // Up, also before time 0.
    let up = |t: Micros| Micros(-(-t.0).div_euclid(step.0) * step.0);
    let is_ambiguous = |event: &Event| (f64::EPSILON..AMBIGUOUS).contains(&phase(event));
    let ambiguous: Vec<Event> = events.iter().filter(is_ambiguous).collect();
    let is_behind = ambiguous.len() as f64 > AMBIGUOUS_FRACTION * events.len() as f64 && {
        let width = usize::from(events.sensor().width);
        let lags = lags_us(&ambiguous, width, reference_scene, &up);
        let count = |lag_us: i64| lags.iter().filter(|lag| **lag == lag_us).count();
        // What delays some events, such as a refractory period, does not move the most common lag.
        count(step.0) > count(0)
    };
    let moved = |event: Event| {
        let end = up(event.t);
        // There is no frame before the first.
        let is_late = is_behind && phase(&event) > 0.0 && end.0 > 0;
        Event { t: if is_late { end - step } else { end }, ..event }
    };
    let mut all: Vec<Event> = events.iter().map(moved).collect();
    all.sort_by_key(|event| event.t);
    EventStream::from_events(events.sensor(), all)
        .map_err(|error| GapError::Recording(error.to_string()))
}

/// Lags of moved events behind the nearest of the reference, whose stamps are moved in the same way,
/// microseconds.
fn lags_us(
    events: &[Event],
    width: usize,
    reference_scene: &ReferenceScene,
    up: &dyn Fn(Micros) -> Micros,
) -> Vec<i64> {
    let lag_us = |event: &Event| {
        let pixel = usize::from(event.y) * width + usize::from(event.x);
        let times = reference_scene.expected.times(pixel, event.polarity.is_on());
        let now = up(event.t).0;
        // Moving keeps the order of times, so that the nearest is one of two neighbours.
        let next = times.partition_point(|t_us| up(Micros(*t_us)).0 < now);
        let neighbours = [next.checked_sub(1).and_then(|i| times.get(i)), times.get(next)];
        let lags = neighbours.into_iter().flatten().map(|t_us| now - up(Micros(*t_us)).0);
        lags.min_by_key(|lag| lag.abs())
    };
    events.iter().filter_map(lag_us).collect()
}

#[cfg(test)]
mod tests {
    use evpose_core::{Plane, SensorSize};
    use evpose_sensor::SensorConfig;

    use super::*;
    use crate::LightSequence;
    use crate::probe::testing::on;

    const STEP: Micros = Micros(1_000);
    const SIZE: SensorSize = SensorSize { width: 4, height: 3 };

    fn stream(times_us: impl Iterator<Item = i64>) -> EventStream {
        let event = |(k, t_us): (usize, i64)| on(t_us, (k % 4) as u16, (k % 3) as u16);
        EventStream::from_events(SIZE, times_us.enumerate().map(event)).unwrap()
    }

    /// All pixels gain the same light from frame to frame.
    fn brightening(by: f32) -> ReferenceScene {
        let plane = |k: u8| Plane::filled(4, 3, 0.2 + by * f32::from(k));
        let scene = LightSequence::new(1_000.0, (0..9).map(plane).collect()).unwrap();
        ReferenceScene::new(scene, &SensorConfig::default()).unwrap()
    }

    #[test]
    fn fractions_of_frames_are_a_grid_and_even_stamps_are_none() {
        let thirds = (0..2_000).map(|k| 1_000 * (k / 15) + [333, 667, 1_000][k as usize / 5 % 3]);
        assert!(is_on_frame_grid(&stream(thirds), STEP));
        assert!(!is_on_frame_grid(&stream((0..2_000).map(|k| 7 * 61 * k)), STEP));
        assert!(!is_on_frame_grid(&stream((0..100).map(|k| 1_000 * k)), STEP));
    }

    #[test]
    fn a_clock_of_another_period_is_no_grid_of_the_frames() {
        let times = |period_us: i64| stream((0..2_000).map(move |k| period_us * (k / 5)));
        assert!(!is_on_frame_grid(&times(1_750), STEP) && !is_on_frame_grid(&times(400), STEP));
        assert!(!is_on_frame_grid(&times(500), STEP) && is_on_frame_grid(&times(2_000), STEP));
        // Two thirds at the frames.
        let uneven = (0..2_000).map(|k| 1_000 * (k / 15) + [500, 1_000, 1_000][k as usize / 5 % 3]);
        assert!(is_on_frame_grid(&stream(uneven), STEP));
    }

    #[test]
    fn lines_that_are_scanned_in_turn_are_no_grid() {
        // Each row is read at a time of its own; `stream` gives event k to row k modulo 3.
        let rows = (0..2_000).map(|k| 1_000 * (k / 3 + 1) + [0, 333, 667][k as usize % 3]);
        assert!(!is_on_frame_grid(&stream(rows), STEP));
    }

    /// Half of the stamps at the frames and half just behind them are of the same frames.
    #[test]
    fn stamps_just_behind_a_frame_move_to_it() {
        let reference = brightening(0.1);
        let at_frames = |pixel: usize| {
            let times = reference.expected.times(pixel, true).iter();
            times.map(|t_us| -(-t_us).div_euclid(1_000) * 1_000).collect::<Vec<i64>>()
        };
        let events = (0..12).flat_map(|pixel| {
            let late_us = i64::from(pixel % 2 == 1);
            let event = move |t_us| on(t_us + late_us, (pixel % 4) as u16, (pixel / 4) as u16);
            at_frames(pixel).into_iter().map(event)
        });
        let mut events: Vec<Event> = events.collect();
        events.sort_by_key(|event| event.t);
        assert!(events.len() > 24);
        let events = EventStream::from_events(SIZE, events).unwrap();
        let moved = moved_to_frames(&events, &reference, STEP).unwrap();
        assert!(moved.t().iter().all(|t| t.0 % 1_000 == 0));
        let expected: usize = (0..12).map(|pixel| at_frames(pixel).len()).sum();
        assert_eq!(moved.len(), expected);
        let first = moved.t().iter().filter(|t| **t == moved.t()[0]).count();
        assert_eq!(first % 12, 0, "the same frame for all pixels");
    }

    #[test]
    fn stamps_move_to_the_end_of_their_frame() {
        let reference = brightening(0.01);
        let moved = moved_to_frames(&stream([333, 1_000, 1_500].into_iter()), &reference, STEP);
        let times: Vec<i64> = moved.unwrap().t().iter().map(|t| t.0).collect();
        assert_eq!(times, [1_000, 1_000, 2_000]);
    }
}
