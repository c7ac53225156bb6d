//! Mismatches between a recording and a scene, detected before anything is compared.

use std::fmt;

use evpose_core::{EventStream, Micros, SensorSize};

use super::symmetry::{self, Orientation};
use super::{LoadedRecording, units};

const DURATION_TOLERANCE: f64 = 0.02;
/// Minimum shift that is a mistake; smaller ones are clock offsets.
const MIN_SHIFT_S: f64 = 0.05;
/// Minimum step of the cross-correlation of rates, seconds.
const STEP_S: f64 = 0.002;
/// Maximum steps of the cross-correlation over the duration.
const MAX_STEPS: f64 = 2_000.0;
/// Minimum correlation of rates that determines the start.
const MIN_AGREEMENT: f64 = 0.3;
/// Minimum increase of the correlation by a shift.
const MIN_GAIN: f64 = 0.1;

/// A mismatch.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// Count of events of the file outside the sensor.
    #[error("{0} events outside the sensor are left out")]
    Outside(usize),
    /// The recording is of another sensor.
    #[error("the recording is of a sensor of {recording}, the scene of one of {scene}")]
    Size {
        /// Sensor size of the recording.
        recording: SensorSize,
        /// Sensor size of the scene.
        scene: SensorSize,
    },
    /// Time stamps are not microseconds.
    #[error(
        "the recording is {too_long_by} times as long as the scene: stamps seem to be {}",
        units::words(*too_long_by)
    )]
    Unit {
        /// Factor by which the recording is too long.
        too_long_by: f64,
    },
    /// Time zero of the recording is not that of the scene.
    #[error("the recording begins at {first_s:.6} s; {shift_s:+.6} s would lay it on the scene")]
    Start {
        /// Time of the first event.
        first_s: f64,
        /// Shift that must be added to time stamps.
        shift_s: f64,
    },
    /// The recording is longer or shorter than the scene.
    #[error("the recording ends at {recording_s:.4} s, the scene at {scene_s:.4} s")]
    Duration {
        /// Time of the last event, with the start corrected.
        recording_s: f64,
        /// End of the scene.
        scene_s: f64,
    },
    /// Columns, rows or polarities are swapped or inverted.
    #[error("{}", fit(.0))]
    Orientation(Orientation),
}

/// All mismatches of a recording and a scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Problems {
    /// Mismatches in the order in which they are corrected.
    pub list: Vec<Problem>,
}

impl Problems {
    /// Detects mismatches. `reference` are the simulated events of the scene, which lasts
    /// `duration_s`.
    pub fn find(recording: &LoadedRecording, duration_s: f64, reference: &EventStream) -> Self {
        let mut list = Vec::new();
        if recording.outside > 0 {
            list.push(Problem::Outside(recording.outside));
        }
        let mut events = recording.events.clone();
        if events.sensor() != reference.sensor() {
            let (recording, scene) = (events.sensor(), reference.sensor());
            list.push(Problem::Size { recording, scene });
        }
        // In this order: stamps in a wrong unit are at a wrong start and of a wrong length as well.
        let expected_s = units::span_s(reference).filter(|_| reference.len() > 1);
        if let Some(too_long_by) = units::too_long_by(&events, expected_s.unwrap_or(duration_s)) {
            list.push(Problem::Unit { too_long_by });
            // Later checks see the stamps as they would be corrected.
            events = units::divided(&events, too_long_by);
        }
        if let Some(shift_s) = shift_s(&events, reference, duration_s) {
            let first_s = events.t()[0].as_seconds();
            list.push(Problem::Start { first_s, shift_s });
            events = units::shifted(&events, Micros::from_seconds(shift_s));
        }
        let end_s = events.t()[events.len() - 1].as_seconds();
        if is_other_length(&events, reference, duration_s) {
            list.push(Problem::Duration { recording_s: end_s, scene_s: duration_s });
        }
        // Last, since images can be compared only where times agree.
        if let Some(orientation) = symmetry::find(&events, reference).filter(|o| o.is_clear) {
            list.push(Problem::Orientation(orientation));
        }
        Self { list }
    }

    /// Whether there is no mismatch.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Whether no correction makes a comparison possible.
    pub fn is_uncorrectable(&self) -> bool {
        let turned = self.list.iter().any(|problem| {
            matches!(problem, Problem::Orientation(orientation) if orientation.best.transposes)
        });
        self.list.iter().any(|problem| match problem {
            // A transposed recording is of the transposed size, which its correction corrects.
            Problem::Size { .. } => !turned,
            Problem::Unit { too_long_by } => *too_long_by < 1e-4,
            _ => false,
        })
    }

    /// Corrects unit, start and orientation of a recording.
    pub fn repair(&self, events: &EventStream) -> EventStream {
        let mut events = events.clone();
        // The list has the unit before the start, which is stated in corrected seconds.
        for problem in &self.list {
            match problem {
                Problem::Unit { too_long_by } => events = units::divided(&events, *too_long_by),
                Problem::Start { shift_s, .. } => {
                    events = units::shifted(&events, Micros::from_seconds(*shift_s));
                }
                Problem::Orientation(orientation) => events = orientation.best.apply(&events),
                Problem::Outside(_) | Problem::Size { .. } | Problem::Duration { .. } => {}
            }
        }
        events
    }
}

/// Shift that must be added to time stamps, if it is larger than a clock offset.
fn shift_s(events: &EventStream, reference: &EventStream, duration_s: f64) -> Option<f64> {
    let limit_s = MIN_SHIFT_S.max(DURATION_TOLERANCE * duration_s);
    let first_s = events.t()[0].as_seconds();
    let last_s = events.t()[events.len() - 1].as_seconds();
    let expected_s = reference.t().first().map_or(0.0, |t| t.as_seconds());
    let begins = (-limit_s..=expected_s + limit_s).contains(&first_s);
    if begins && last_s <= duration_s + limit_s {
        return None;
    }
    let step_s = STEP_S.max(duration_s / MAX_STEPS);
    let steps = (duration_s / step_s).ceil() as i64;
    let place = |t_s: f64| (t_s / step_s).floor() as i64;
    let count = |events: &EventStream, from_s: f64| {
        let mut counts = vec![0.0; 2 * steps as usize];
        for t in events.t() {
            if let Some(count) = counts.get_mut(place(t.as_seconds() - from_s) as usize) {
                *count += 1.0;
            }
        }
        counts
    };
    let (seen, mut wanted) = (count(events, first_s), count(reference, 0.0));
    wanted.truncate(steps as usize);
    // Correlation of the rates at a lag of the recording, from its first event on.
    let agreement = |lag: i64| {
        let then = |k: i64| usize::try_from(k + lag).ok().and_then(|k| seen.get(k)).copied();
        let late: Vec<f64> = (0..steps).map(|k| then(k).unwrap_or(0.0)).collect();
        symmetry::correlation(&late, &wanted)
    };
    let as_it_is = agreement(place(-first_s));
    let mut best = (f64::NEG_INFINITY, 0);
    for lag in -steps..steps {
        let correlation = agreement(lag);
        if correlation > best.0 {
            best = (correlation, lag);
        }
    }
    if begins && as_it_is >= best.0 - MIN_GAIN {
        return None;
    }
    let shift_s = if best.0 >= MIN_AGREEMENT {
        -(first_s + best.1 as f64 * step_s)
    } else if begins {
        // The rates do not determine a shift, and only the end is late.
        return None;
    } else {
        // Nothing but the first event says where it begins.
        expected_s - first_s
    };
    (shift_s.abs() > limit_s).then_some(shift_s)
}

/// Whether events end later than the scene, or earlier than the reference events.
fn is_other_length(events: &EventStream, reference: &EventStream, duration_s: f64) -> bool {
    let tolerance_s = DURATION_TOLERANCE * duration_s;
    let last_s = events.t()[events.len() - 1].as_seconds();
    if last_s > duration_s + tolerance_s {
        return true;
    }
    let end = Micros::from_seconds(last_s + tolerance_s);
    // A short recording is one only if the scene goes on having events: it may end at rest.
    let missing = reference.len() - reference.t().partition_point(|t| *t <= end);
    missing as f64 > (DURATION_TOLERANCE * reference.len() as f64).max(20.0)
}

fn fit(orientation: &Orientation) -> String {
    let Orientation { best, score, as_it_is, as_good, .. } = orientation;
    let as_it_is = as_it_is.map_or_else(
        || ", and not at all as it is".to_owned(),
        |score| format!(", against {score:.2} as it is"),
    );
    let as_good: String = as_good.iter().map(|other| format!("; {other} fits as well")).collect();
    format!("the recording fits the scene with {best}: agreement {score:.2}{as_it_is}{as_good}")
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.list.iter().try_for_each(|problem| writeln!(f, "{problem}"))
    }
}
