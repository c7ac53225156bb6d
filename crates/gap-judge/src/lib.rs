//! An independent judge: whether a simulator came closer to a recording.
//!
//! Five plain statistics, from the events alone, with code that nothing else of the workflow uses.
//! What a change of the simulator has brought is measured by none of the means that found it.
//!
//! | statistic | distance |
//! |---|---|
//! | ON and OFF counts | of totals, and per pixel: mean absolute difference over the mean |
//! | intervals of a pixel | total variation of the histogram over the logarithm |
//! | rate of all pixels | lag of the best overlap in ms, and relative difference in steps of 5 ms |
//! | counts by brightness | relative difference over eight classes of luminance |
//! | counts by place | relative difference over blocks of 8 x 8 pixels |
//!
//! A simulator with noise is at a distance from itself: that of its runs from each other is the
//! floor below which no distance means anything.
//!
//! ```
//! use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
//! use evpose_gap_judge::{Verdict, judge};
//!
//! let at = |step: i64| {
//!     let event = |k| Event { t: Micros(k * step), x: 1, y: 1, polarity: Polarity::On };
//!     EventStream::from_events(SensorSize { width: 4, height: 3 }, (0..100).map(event))
//! };
//! let (measured, slow) = (at(1_000)?, at(3_000)?);
//! let judgement = judge(&measured, &[slow.clone(), slow], &[at(1_000)?, at(1_000)?], None)?;
//! assert_eq!(judgement.verdict, Verdict::Closer);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod brightness;
mod counts;
mod intervals;
mod judgement;
mod places;
mod rate;

use evpose_core::EventStream;

pub use brightness::Frames;
pub use judgement::{Judgement, Row, Spread, Verdict};

/// Why nothing can be judged.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum JudgeError {
    /// A simulator was not run often enough to know how far it is from itself.
    #[error("{0} runs of the simulator {1}: at least two are needed")]
    Runs(usize, &'static str),
    /// Events of different sensors.
    #[error("the recording is of a sensor of {0}, a run of the simulator of one of {1}")]
    Sensor(evpose_core::SensorSize, evpose_core::SensorSize),
    /// Frames that are not of this sensor.
    #[error("frames of {0}x{1} pixels, but the recording is of a sensor of {2}")]
    Frames(usize, usize, evpose_core::SensorSize),
    /// A recording without events.
    #[error("the recording has no events")]
    Empty,
}

/// A distance between two recordings, zero for the same.
type Distance<'a> = Box<dyn Fn(&EventStream, &EventStream) -> f64 + 'a>;

/// Compares a recording with runs of a simulator before and after it was changed, with several
/// seeds each. Without frames, counts by brightness are left out.
///
/// # Errors
/// If there are fewer than two runs of either, no events, or other sensors.
pub fn judge(
    measured: &EventStream,
    before: &[EventStream],
    after: &[EventStream],
    frames: Option<Frames<'_>>,
) -> Result<Judgement, JudgeError> {
    let sensor = measured.sensor();
    for (runs, when) in [(before, "before"), (after, "after")] {
        if runs.len() < 2 {
            return Err(JudgeError::Runs(runs.len(), when));
        }
        if let Some(other) = runs.iter().map(EventStream::sensor).find(|size| *size != sensor) {
            return Err(JudgeError::Sensor(sensor, other));
        }
    }
    if measured.is_empty() {
        return Err(JudgeError::Empty);
    }
    let mut statistics: Vec<(&'static str, &'static str, Distance<'_>)> = vec![
        ("ON events", "", Box::new(|a, b| counts::of_totals(a, b, true))),
        ("OFF events", "", Box::new(|a, b| counts::of_totals(a, b, false))),
        ("ON events per pixel", "", Box::new(|a, b| counts::per_pixel(a, b, true))),
        ("OFF events per pixel", "", Box::new(|a, b| counts::per_pixel(a, b, false))),
        ("intervals", "", Box::new(intervals::distance)),
        ("lag of the rate", "ms", Box::new(rate::lag_ms)),
        ("rate", "", Box::new(rate::distance)),
    ];
    if let Some(frames) = frames {
        let classes = brightness::Classes::of(frames, sensor)?;
        let distance = move |a: &_, b: &_| classes.distance(a, b);
        statistics.push(("events by brightness", "", Box::new(distance)));
    }
    statistics.push(("events by place", "", Box::new(places::distance)));
    let rows = statistics
        .into_iter()
        .map(|(name, unit, distance)| Row::of(name, unit, &distance, measured, before, after))
        .collect();
    Ok(Judgement::of(rows))
}

/// Sum of absolute differences over the mean of the two sums; zero if both are empty.
fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    let apart: f64 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum();
    let sum: f64 = a.iter().chain(b).sum();
    if sum > 0.0 { 2.0 * apart / sum } else { 0.0 }
}

#[cfg(test)]
mod tests;
