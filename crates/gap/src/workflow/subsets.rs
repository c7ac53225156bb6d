//! Subsets of a recording for screening and for fits: as long as needed, no longer.

use evpose_core::Micros;

use super::ComparisonCase;

const SCREEN: Micros = Micros(400_000);
/// The screening part is shortened to this many events, though not below the minimum length.
const SCREEN_EVENTS: usize = 30_000;
const MIN_SCREEN: Micros = Micros(120_000);
/// The screening part is extended to this many events.
const MIN_EVENTS: usize = 4_000;
/// Maximum events of the training part, which determine parameters to a fraction of a percent.
const FITTED_EVENTS: usize = 70_000;
/// The same of held-out data.
const HELD_OUT_EVENTS: usize = 50_000;
/// Maximum pixels times frames of the training part in quick runs.
const QUICK_PIXELS: usize = 24_000_000;
/// Minimum length of the training part of sensors of up to [`MIN_FITTED_PIXELS`] pixels.
const MIN_FITTED: Micros = Micros(300_000);
/// Larger sensors show as much in less time: the minimum is in proportion to pixels times seconds.
const MIN_FITTED_PIXELS: usize = 100_000;
/// Minimum length on the largest sensors: six periods of a lamp on 50 Hz mains beside what is held
/// out.
const MIN_FITTED_LARGE: Micros = Micros(100_000);

impl ComparisonCase {
    pub(super) fn screen(&self) -> Self {
        let short = self.time_of(SCREEN_EVENTS).clamp(MIN_SCREEN, SCREEN);
        self.first(short.max(self.time_of(MIN_EVENTS)))
    }

    pub(super) fn training(self, is_quick: bool) -> Self {
        let size = self.scene.size();
        let frames = QUICK_PIXELS / size.pixels();
        let quick = Micros::from_seconds(frames as f64 / self.scene.fps());
        let enough = self.time_of(FITTED_EVENTS);
        let length = if is_quick { enough.min(quick) } else { enough };
        let length = length.max(self.min_fitted());
        if length < self.scene.duration() { self.first(length) } else { self }
    }

    /// The beginning of a single recording that is divided into training and held-out data.
    pub(super) fn compared(self) -> Self {
        self.limited(FITTED_EVENTS + HELD_OUT_EVENTS)
    }

    /// The beginning of a recording that is held out.
    pub(super) fn held_out(self) -> Self {
        self.limited(HELD_OUT_EVENTS)
    }

    fn limited(self, events: usize) -> Self {
        let length = self.time_of(events).max(self.min_fitted());
        if length < self.scene.duration() { self.first(length) } else { self }
    }

    /// Minimum length of the training part.
    fn min_fitted(&self) -> Micros {
        let pixels = self.scene.size().pixels().max(MIN_FITTED_PIXELS);
        Micros(MIN_FITTED.0 * MIN_FITTED_PIXELS as i64 / pixels as i64).max(MIN_FITTED_LARGE)
    }

    /// Time of event number `events`; the end of the scene if there are fewer.
    fn time_of(&self, events: usize) -> Micros {
        let times = self.measured.t();
        times.get(events).map_or(self.scene.duration(), |t| (*t).max(Micros(1)))
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{EventStream, Plane, SensorSize};

    use super::*;
    use crate::LightSequence;
    use crate::probe::testing::on;

    /// Events at an even rate over `seconds` of a scene of 1000 frames per second.
    fn case(size: SensorSize, seconds: f64, events: usize) -> ComparisonCase {
        let frames = (1_000.0 * seconds) as usize + 1;
        let plane = Plane::filled(usize::from(size.width), usize::from(size.height), 0.5_f32);
        let scene = LightSequence::new(1_000.0, vec![plane; frames]).unwrap();
        let step_us = 1e6 * seconds / events as f64;
        let event = |k: usize| on((step_us * k as f64) as i64, 0, 0);
        let events = EventStream::from_events(size, (0..events).map(event)).unwrap();
        ComparisonCase::new(&events, scene).unwrap()
    }

    #[test]
    fn the_screening_part_has_enough_events_and_no_more() {
        let small = SensorSize { width: 8, height: 6 };
        let seconds = |events| case(small, 2.0, events).screen().scene.duration().as_seconds();
        assert!((seconds(100_000) - 0.4).abs() < 2e-3);
        assert!((seconds(400_000) - 0.15).abs() < 2e-3);
        assert!((seconds(2_000_000) - 0.12).abs() < 2e-3);
        assert!((seconds(8_000) - 1.0).abs() < 2e-3);
        assert!((seconds(50) - 2.0).abs() < 2e-3);
    }

    #[test]
    fn large_recordings_are_fitted_in_part() {
        let small = SensorSize { width: 8, height: 6 };
        let large = SensorSize { width: 240, height: 180 };
        let seconds = |size, events, is_quick| {
            case(size, 2.0, events).training(is_quick).scene.duration().as_seconds()
        };
        assert!((seconds(small, 10_000, true) - 2.0).abs() < 1e-9);
        assert!((seconds(large, 10_000, false) - 2.0).abs() < 1e-9);
        assert!((seconds(large, 10_000, true) - 24.0 / 43.2).abs() < 2e-3);
        assert!((seconds(small, 200_000, false) - 0.7).abs() < 2e-3);
        assert!((seconds(small, 4_000_000, false) - 0.3).abs() < 2e-3);
        let seconds = |width, height| {
            let size = SensorSize { width, height };
            case(size, 0.5, 4_000_000).training(false).scene.duration().as_seconds()
        };
        assert!((seconds(400, 250) - 0.3).abs() < 2e-3);
        assert!((seconds(500, 300) - 0.2).abs() < 2e-3);
        assert!((seconds(640, 480) - 0.1).abs() < 2e-3);
    }

    #[test]
    fn of_a_busy_recording_the_beginning_is_compared() {
        let small = SensorSize { width: 8, height: 6 };
        let seconds = |events| case(small, 2.0, events).compared().scene.duration().as_seconds();
        assert!((seconds(100_000) - 2.0).abs() < 1e-9);
        assert!((seconds(240_000) - 1.0).abs() < 2e-3);
        assert!((seconds(4_000_000) - 0.3).abs() < 2e-3);
        let held_out = case(small, 2.0, 250_000).held_out().scene.duration().as_seconds();
        assert!((held_out - 0.4).abs() < 2e-3);
    }
}
