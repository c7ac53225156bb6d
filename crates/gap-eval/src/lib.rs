//! Independent evaluation of a simulator: whether a change of it has brought it closer to a
//! recording.
//!
//! Five plain statistics of the events, with code that nothing else of the gap workflow uses: the
//! change is evaluated by none of the means that found it.
//!
//! | statistic | distance |
//! |---|---|
//! | ON and OFF counts | of totals, and per pixel: mean absolute difference over the mean |
//! | intervals of a pixel | total variation of the histogram over the logarithm |
//! | rate of all pixels | lag of the best overlap in ms, and relative difference in steps of 5 ms |
//! | counts by brightness | relative difference over eight classes of luminance |
//! | counts by place | relative difference over blocks of 8 x 8 pixels |
//!
//! Runs of a noisy simulator differ: the distances between them are the noise floor of all
//! distances.
//!
//! ```
//! use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
//! use evpose_gap_eval::{EvaluationVerdict, evaluate};
//!
//! let at = |step: i64| {
//!     let event = |k| Event { t: Micros(k * step), x: 1, y: 1, polarity: Polarity::On };
//!     EventStream::from_events(SensorSize { width: 4, height: 3 }, (0..100).map(event))
//! };
//! let (measured, slow) = (at(1_000)?, at(3_000)?);
//! let evaluation = evaluate(&measured, &[slow.clone(), slow], &[at(1_000)?, at(1_000)?], None)?;
//! assert_eq!(evaluation.verdict, EvaluationVerdict::Closer);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod brightness;
mod counts;
mod evaluation;
mod image_blocks;
mod intervals;
mod rate;

use evpose_core::EventStream;

pub use brightness::Frames;
pub use evaluation::{Evaluation, EvaluationVerdict, Row, Spread};

/// Inputs that cannot be evaluated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EvalError {
    /// Fewer than two runs of a simulator, between which there is no distance.
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

/// A distance between two recordings, zero for equal ones.
type Distance<'a> = Box<dyn Fn(&EventStream, &EventStream) -> f64 + 'a>;

/// Compares a recording with runs of a simulator before and after a change, with several seeds
/// each. Without frames, counts by brightness are left out.
///
/// # Errors
/// Fewer than two runs of either, no events, or different sensor sizes.
pub fn evaluate(
    measured: &EventStream,
    before: &[EventStream],
    after: &[EventStream],
    frames: Option<Frames<'_>>,
) -> Result<Evaluation, EvalError> {
    let sensor = measured.sensor();
    for (runs, when) in [(before, "before"), (after, "after")] {
        // One run alone would say nothing of how much runs differ by chance.
        if runs.len() < 2 {
            return Err(EvalError::Runs(runs.len(), when));
        }
        if let Some(other) = runs.iter().map(EventStream::sensor).find(|size| *size != sensor) {
            return Err(EvalError::Sensor(sensor, other));
        }
    }
    if measured.is_empty() {
        return Err(EvalError::Empty);
    }
    let mut statistics: Vec<(&'static str, &'static str, Distance<'_>)> = vec![
        ("ON events", "", Box::new(|a, b| counts::total(a, b, true))),
        ("OFF events", "", Box::new(|a, b| counts::total(a, b, false))),
        ("ON events per pixel", "", Box::new(|a, b| counts::per_pixel(a, b, true))),
        ("OFF events per pixel", "", Box::new(|a, b| counts::per_pixel(a, b, false))),
        ("intervals", "", Box::new(intervals::distance)),
        ("lag of the rate", "ms", Box::new(rate::lag_ms)),
        ("rate", "", Box::new(rate::distance)),
    ];
    // Classes are those of the frames, not of either recording: both are counted in the same ones.
    if let Some(frames) = frames {
        let classes = brightness::Classes::new(frames, sensor)?;
        let distance = move |a: &_, b: &_| classes.distance(a, b);
        statistics.push(("events by brightness", "", Box::new(distance)));
    }
    statistics.push(("events by place", "", Box::new(image_blocks::distance)));
    let rows = statistics
        .into_iter()
        .map(|(name, unit, distance)| Row::new(name, unit, &distance, measured, before, after))
        .collect();
    Ok(Evaluation::from_rows(rows))
}

/// Sum of absolute differences relative to the mean of the two sums; zero if both are zero.
fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    let apart: f64 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum();
    let sum: f64 = a.iter().chain(b).sum();
    if sum > 0.0 { 2.0 * apart / sum } else { 0.0 }
}

#[cfg(test)]
mod tests;
