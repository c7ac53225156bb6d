//! Begin and end of a movement on the clock of the cameras.

use evpose_core::{Micros, TimeWindow};

use super::POSE_INTERVAL;

/// Time span of a movement, and its origin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    /// The time, on the clock of the cameras.
    pub window: TimeWindow,
    /// Pulses that bound the movement.
    pub origin: SpanOrigin,
}

/// Origin of the time span of a movement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpanOrigin {
    /// Pulses at its beginning and its end.
    Pulses,
    /// A pulse at its beginning, and the count of its poses.
    Beginning,
    /// A pulse at its end, and the count of its poses.
    End,
    /// Nothing: it is the whole recording.
    Recording,
    /// It is stated, in a file that others have cut.
    Stated,
}

/// More pulses than mark a movement.
#[derive(Debug, Clone, Copy, thiserror::Error)]
#[error("{0} pulses: up to five mark a movement")]
pub(super) struct TooManyPulses(usize);

/// The time of a movement with events from `first` to `last` and a count of `poses`.
///
/// # Model
/// Of three or five pulses the first is the beginning and the last the end, the others repeat the
/// first. One, two or four are all the same one: that of the beginning, unless it is nearer to the
/// last event than to the first. None were seen in one recording.
///
/// # Errors
/// If there are more pulses: such recordings are corrupted.
///
/// # Source
/// The published `Generate_DHP19.m`.
pub(super) fn movement_span(
    pulses: &[Micros],
    (first, last): (Micros, Micros),
    poses: usize,
) -> Result<Span, TooManyPulses> {
    let duration = Micros(POSE_INTERVAL.0.saturating_mul(i64::try_from(poses).unwrap_or(i64::MAX)));
    let span =
        |start: Micros, end: Micros, origin| Ok(Span { window: TimeWindow { start, end }, origin });
    match *pulses {
        // The end is exclusive, and the last event has to be within.
        [] => span(first, last + Micros(1), SpanOrigin::Recording),
        [start, _, end] | [start, _, _, _, end] => span(start, end, SpanOrigin::Pulses),
        [pulse] | [pulse, _] | [pulse, _, _, _] if pulse - first > last - pulse => {
            span(pulse - duration, pulse, SpanOrigin::End)
        }
        [pulse] | [pulse, _] | [pulse, _, _, _] => {
            span(pulse, pulse + duration, SpanOrigin::Beginning)
        }
        _ => Err(TooManyPulses(pulses.len())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(pulses: &[i64]) -> (i64, i64, SpanOrigin) {
        let pulses: Vec<Micros> = pulses.iter().copied().map(Micros).collect();
        let found = movement_span(&pulses, (Micros(0), Micros(100_000)), 3).unwrap();
        (found.window.start.0, found.window.end.0, found.origin)
    }

    #[test]
    fn pulses_give_the_spans_that_the_authors_take_from_them() {
        assert_eq!(span(&[10, 11, 80_000]), (10, 80_000, SpanOrigin::Pulses));
        assert_eq!(span(&[10, 10, 10, 11, 80_000]), (10, 80_000, SpanOrigin::Pulses));
        assert_eq!(span(&[40_000]), (40_000, 70_000, SpanOrigin::Beginning));
        assert_eq!(span(&[60_000]), (30_000, 60_000, SpanOrigin::End));
        assert_eq!(span(&[40_000, 40_001]), (40_000, 70_000, SpanOrigin::Beginning));
        assert_eq!(span(&[60_000, 60_000, 60_000, 60_001]), (30_000, 60_000, SpanOrigin::End));
        assert_eq!(span(&[]), (0, 100_001, SpanOrigin::Recording));
        let many = [Micros(0); 700];
        assert!(
            movement_span(&many, (Micros(0), Micros(1)), 3)
                .unwrap_err()
                .to_string()
                .contains("700")
        );
    }

    /// The time stamps of S5/session4/mov2 and S12/session5/mov4, from the comments of the program.
    #[test]
    fn recordings_that_the_authors_name_come_out_as_they_say() {
        let bounds = (Micros(1_055_513_693), Micros(1_076_195_668));
        let found = movement_span(&[Micros(1_075_788_910)], bounds, 1500).unwrap();
        assert_eq!(found.origin, SpanOrigin::End);
        assert_eq!(found.window.start, Micros(1_060_788_910));
        let bounds = (Micros(408_458_645), Micros(429_666_644));
        let pulses = [411_324_494, 411_324_494, 411_324_494, 411_324_495].map(Micros);
        let found = movement_span(&pulses, bounds, 1500).unwrap();
        assert_eq!((found.origin, found.window.end), (SpanOrigin::Beginning, Micros(426_324_494)));
    }
}
