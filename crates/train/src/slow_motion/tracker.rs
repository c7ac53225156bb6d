//! The slow-motion mode on one stream of events.

use evpose_core::{EventStream, Micros, SensorSize, TimeWindow};
use evpose_pose::HandParams;
use evpose_pose::filter::{AdaptiveHandFilter, StillnessGate};
use evpose_repr::{Representation, StreamWindow, SurfaceTrigger, representation_called};

use crate::TrainError;
use crate::config::HandConfig;
use crate::predictor::Predictor;
use crate::slow_motion::SurfaceBatch;

/// A pose of the slow-motion mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowMotionPose {
    /// Time of the surface it belongs to.
    pub t: Micros,
    /// When its batch was full.
    pub known: Micros,
    /// As predicted, now or for an earlier batch.
    pub measured: HandParams,
    /// After the Kalman filter.
    pub filtered: HandParams,
    /// Whether the scene was at rest and an earlier prediction was repeated.
    pub repeated: bool,
    /// Whether the filter took it with its fast settings.
    pub fast: bool,
}

/// Turns packets of events into poses, in batches.
///
/// Packets may be cut anywhere but between events of one microsecond. Time that jumps back means
/// that the stream started again: everything before is forgotten.
#[derive(Debug)]
pub struct SlowMotionTracker {
    sensor: SensorSize,
    window: Micros,
    surface: Box<dyn Representation>,
    trigger: SurfaceTrigger,
    gate: StillnessGate,
    filter: AdaptiveHandFilter,
    batch_surfaces: usize,
    /// Surfaces that wait for their batch to be full.
    waiting: SurfaceBatch,
    /// Times of the first and of the last event.
    seen: Option<[Micros; 2]>,
}

impl SlowMotionTracker {
    /// The mode as `config` sets it, for events of `sensor`.
    ///
    /// # Errors
    /// If a setting makes no sense.
    pub fn new(config: &HandConfig, sensor: SensorSize) -> Result<Self, TrainError> {
        let mode = &config.slow_motion;
        let window = Micros(i64::from(config.representation.window_ms) * 1_000);
        let order = config.representation.channel_order;
        let representation = representation_called(&config.representation.name)?;
        Ok(Self {
            sensor,
            window,
            surface: representation.start(StreamWindow::new(sensor, window, order)?),
            trigger: SurfaceTrigger::new(&mode.trigger, sensor),
            gate: StillnessGate::new(&mode.stillness, sensor)?,
            filter: AdaptiveHandFilter::new(&mode.filter)?,
            batch_surfaces: mode.batch_surfaces,
            waiting: SurfaceBatch::default(),
            seen: None,
        })
    }

    /// Takes events, and appends the poses of every batch that they complete.
    ///
    /// # Errors
    /// If a prediction fails.
    ///
    /// # Panics
    /// If the events come from a sensor of another size.
    pub fn push(
        &mut self,
        events: &EventStream,
        predictor: &mut dyn Predictor,
        poses: &mut Vec<SlowMotionPose>,
    ) -> Result<(), TrainError> {
        let times = events.t();
        let (Some(&first), Some(&last)) = (times.first(), times.last()) else { return Ok(()) };
        if self.seen.is_some_and(|[_, before]| first < before) {
            self.reset();
        }
        let start = self.seen.map_or(first, |[start, _]| start);
        self.seen = Some([start, last]);
        let mut rest = first;
        let mut from = 0;
        while let Some(taken) = self.trigger.due(&times[from..]) {
            from += taken;
            let now = times[from - 1];
            let after = now + Micros(1);
            self.surface.push(&events.slice(TimeWindow { start: rest, end: after }));
            rest = after;
            if now - start >= self.window {
                self.waiting.add(&mut *self.surface, self.sensor, now);
                if self.waiting.len() == self.batch_surfaces {
                    self.finish(predictor, poses)?;
                }
            }
        }
        self.surface.push(&events.slice(TimeWindow { start: rest, end: last + Micros(1) }));
        Ok(())
    }

    /// Appends the poses of the surfaces that still wait for their batch: at the end of a stream.
    ///
    /// # Errors
    /// If the prediction fails.
    pub fn finish(
        &mut self,
        predictor: &mut dyn Predictor,
        poses: &mut Vec<SlowMotionPose>,
    ) -> Result<(), TrainError> {
        let Some(&known) = self.waiting.times().last() else { return Ok(()) };
        let size = (usize::from(self.sensor.height), usize::from(self.sensor.width));
        let surfaces = self.waiting.values();
        let gated =
            self.gate.pass(surfaces, self.waiting.len(), || predictor.predict(surfaces, size))?;
        for (&t, measured) in self.waiting.times().iter().zip(gated.poses) {
            let filtered = self.filter.update(t, measured);
            let (repeated, fast) = (gated.repeated, self.filter.is_fast());
            poses.push(SlowMotionPose { t, known, measured: *measured, filtered, repeated, fast });
        }
        self.waiting.clear();
        Ok(())
    }

    /// Forgets everything, waiting surfaces too.
    pub fn reset(&mut self) {
        self.surface.reset();
        self.trigger.reset();
        self.gate.reset();
        self.filter.reset();
        self.waiting.clear();
        self.seen = None;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use evpose_core::{Event, Polarity};

    use super::*;

    /// The whole of the published size, so that its numbers are the published ones.
    const SENSOR: SensorSize = SensorSize::DAVIS240C;

    /// Predicts the number of the surface, counted over all that it was shown.
    #[derive(Default)]
    struct Counting {
        shown: usize,
        batches: Vec<usize>,
    }

    impl Predictor for Counting {
        fn predict(
            &mut self,
            surfaces: &[f32],
            (height, width): (usize, usize),
        ) -> Result<Vec<HandParams>, TrainError> {
            let count = surfaces.len() / (2 * height * width);
            self.batches.push(count);
            Ok((0..count)
                .map(|_| {
                    self.shown += 1;
                    let articulation = [self.shown as f32 * 1e-3; 6];
                    HandParams { articulation, ..HandParams::default() }
                })
                .collect())
        }
    }

    /// `per_ms` events every millisecond of `ms`, at pixels that walk over the image.
    fn events(ms: std::ops::Range<i64>, per_ms: usize) -> EventStream {
        let mut stream = EventStream::empty(SENSOR);
        for k in ms {
            for i in 0..per_ms {
                let at = (k as usize * per_ms + i) * 7 % SENSOR.pixels();
                let (x, y) = ((at % 240) as u16, (at / 240) as u16);
                stream.push(Event { t: Micros(k * 1_000), x, y, polarity: Polarity::On }).unwrap();
            }
        }
        stream
    }

    fn tracker() -> SlowMotionTracker {
        SlowMotionTracker::new(&HandConfig::default(), SENSOR).unwrap()
    }

    fn run(stream: &EventStream) -> (Vec<SlowMotionPose>, Counting) {
        let (mut tracker, mut predictor, mut poses) = (tracker(), Counting::default(), Vec::new());
        tracker.push(stream, &mut predictor, &mut poses).unwrap();
        (poses, predictor)
    }

    #[test]
    fn a_fast_scene_has_a_pose_a_millisecond_in_batches_of_sixteen() {
        let (poses, predictor) = run(&events(0..150, 20));
        // From 100 ms on, 50 surfaces: three batches, and two surfaces that wait.
        assert_eq!(predictor.batches, [16, 16, 16]);
        let times: Vec<i64> = poses.iter().map(|pose| pose.t.0).collect();
        assert_eq!(times, (100..148).map(|ms| ms * 1_000).collect::<Vec<_>>());
        assert!(poses[..16].iter().all(|pose| pose.known == Micros(115_000)));
        assert!(poses.iter().all(|pose| !pose.repeated));
    }

    /// Two events a millisecond: a surface every 6 ms, and a window of 200 pixels with a mean of
    /// about a half, which is less than 300.
    #[test]
    fn a_scene_at_rest_has_fewer_surfaces_and_repeats_its_first_predictions() {
        let (poses, predictor) = run(&events(0..700, 2));
        assert_eq!(predictor.batches, [16], "only the first batch is predicted");
        let gaps: Vec<i64> = poses.windows(2).map(|pair| (pair[1].t - pair[0].t).0).collect();
        assert!(gaps.iter().all(|&gap| gap == 6_000), "{gaps:?}");
        assert_eq!(poses.len(), 96);
        for (i, pose) in poses.iter().enumerate() {
            assert_eq!(pose.repeated, i >= 16);
            assert_eq!(pose.measured, poses[i % 16].measured);
        }
    }

    #[test]
    fn how_the_stream_is_cut_does_not_matter_and_the_end_gives_what_waits() {
        let stream = events(0..333, 5);
        let (whole, _) = run(&stream);
        let (mut tracker, mut predictor, mut cut) = (tracker(), Counting::default(), Vec::new());
        for k in 0..333 {
            let (start, end) = (Micros(k * 1_000), Micros(k * 1_000 + 1_000));
            let packet = stream.slice(TimeWindow { start, end });
            tracker.push(&packet, &mut predictor, &mut cut).unwrap();
        }
        assert_eq!(whole, cut);
        let before = cut.len();
        tracker.finish(&mut predictor, &mut cut).unwrap();
        assert!(cut.len() > before && cut.len() < before + 16);
        assert!(cut.windows(2).all(|pair| pair[0].t < pair[1].t));
    }

    #[test]
    fn a_stream_that_starts_again_is_tracked_as_a_new_one() {
        let stream = events(0..200, 20);
        let (mut tracker, mut predictor, mut poses) = (tracker(), Counting::default(), Vec::new());
        tracker.push(&stream, &mut predictor, &mut poses).unwrap();
        let first = poses.len();
        predictor.shown = 0;
        tracker.push(&stream, &mut predictor, &mut poses).unwrap();
        assert_eq!(poses[..first], poses[first..]);
    }
}
