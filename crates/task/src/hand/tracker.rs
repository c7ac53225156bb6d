//! Offline schedules of the hand's stream: the slow-motion mode, and every millisecond.

use evpose_core::{EventStream, Micros, SensorSize, TimeWindow};
use evpose_repr::RepresentationTrigger;

use super::batch::InputBatch;
use super::config::HandConfig;
use super::estimator::{HandEstimate, HandEstimator};
use super::predictor::Predictor;
use crate::TaskError;

/// Inputs that are inferred together offline.
const OFFLINE_BATCH: usize = 64;

/// The slow-motion mode: events trigger inputs, which are inferred in batches.
///
/// Packets may be cut anywhere but between events of one microsecond. Time that jumps back means
/// that the stream started again: everything before is forgotten.
#[derive(Debug)]
pub struct SlowMotionTracker {
    estimator: HandEstimator,
    window: Micros,
    trigger: RepresentationTrigger,
    /// Times of the first and of the last event.
    span: Option<[Micros; 2]>,
}

impl SlowMotionTracker {
    /// The mode as `config` sets it, for events of `sensor`.
    ///
    /// # Errors
    /// If the representation is not known or a setting is out of range.
    pub fn new(config: &HandConfig, sensor: SensorSize) -> Result<Self, TaskError> {
        let mode = &config.slow_motion;
        Ok(Self {
            estimator: HandEstimator::slow_motion(config, sensor, mode.batch_inputs)?,
            window: config.representation.window(),
            trigger: RepresentationTrigger::new(&mode.trigger, sensor),
            span: None,
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
        poses: &mut Vec<HandEstimate>,
    ) -> Result<(), TaskError> {
        let times = events.t();
        let (Some(&first), Some(&last)) = (times.first(), times.last()) else { return Ok(()) };
        if self.span.is_some_and(|[_, before]| first < before) {
            self.reset();
        }
        let start = self.span.map_or(first, |[start, _]| start);
        self.span = Some([start, last]);
        let mut rest = first;
        let mut from = 0;
        // The packet is cut after every event that triggers an input.
        while let Some(taken) = self.trigger.due(&times[from..]) {
            from += taken;
            let now = times[from - 1];
            let after = now + Micros(1);
            self.estimator.push(&events.slice(TimeWindow { start: rest, end: after }));
            rest = after;
            if now - start >= self.window {
                self.estimator.sample(now, now);
                if self.estimator.is_full() {
                    self.finish(predictor, poses)?;
                }
            }
        }
        self.estimator.push(&events.slice(TimeWindow { start: rest, end: last + Micros(1) }));
        Ok(())
    }

    /// Appends the poses of the inputs that wait for their batch: at the end of a stream.
    ///
    /// # Errors
    /// If the prediction fails.
    pub fn finish(
        &mut self,
        predictor: &mut dyn Predictor,
        poses: &mut Vec<HandEstimate>,
    ) -> Result<(), TaskError> {
        complete(&mut self.estimator, predictor, poses)
    }

    /// Forgets everything, waiting inputs too.
    pub fn reset(&mut self) {
        self.estimator.reset();
        self.trigger.reset();
        self.span = None;
    }
}

/// Appends the poses of the batch, full or not, and empties it.
fn complete(
    estimator: &mut HandEstimator,
    predictor: &mut dyn Predictor,
    poses: &mut Vec<HandEstimate>,
) -> Result<(), TaskError> {
    if estimator.is_empty() {
        return Ok(());
    }
    if let Some(repeated) = estimator.repeat_at_rest() {
        poses.extend(repeated);
        return Ok(());
    }
    let SensorSize { width, height } = estimator.sensor();
    let batch = estimator.take(InputBatch::default());
    let outputs = predictor.predict(batch.values(), (height.into(), width.into()))?;
    poses.extend(estimator.accept(&batch, outputs));
    Ok(())
}

/// Poses of a recording at every millisecond, from the end of the first full window on; only the
/// last one where the recording is shorter. The pose at `k` ms is that of the events before, as in
/// training: record `k` of a `.meta` is the pose at the end of frame `k`. `progress` is called with the
/// number of poses that were added.
///
/// # Errors
/// If a setting is out of range or a prediction fails.
pub fn poses_every_ms(
    config: &HandConfig,
    events: &EventStream,
    predictor: &mut dyn Predictor,
    progress: &mut dyn FnMut(usize),
) -> Result<Vec<HandEstimate>, TaskError> {
    let (Some(&first), Some(&last)) = (events.t().first(), events.t().last()) else {
        return Ok(Vec::new());
    };
    let mut estimator = HandEstimator::plain(config, events.sensor(), OFFLINE_BATCH)?;
    let last_ms = last.0.div_euclid(1000);
    let first_ms =
        (first.0.div_euclid(1000) + i64::from(config.representation.window_ms)).min(last_ms);
    let mut poses = Vec::with_capacity((last_ms - first_ms + 1) as usize);
    let mut pushed = Micros(i64::MIN);
    for ms in first_ms..=last_ms {
        let end = Micros((ms + 1) * 1000);
        estimator.push(&events.slice(TimeWindow { start: pushed, end }));
        pushed = end;
        estimator.sample(end - Micros(1), end);
        if estimator.is_full() || ms == last_ms {
            let before = poses.len();
            complete(&mut estimator, predictor, &mut poses)?;
            progress(poses.len() - before);
        }
    }
    Ok(poses)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use evpose_core::{Event, Polarity};
    use evpose_pose::HandParams;

    use super::*;

    /// The whole of the published size, so that thresholds are the published ones.
    const SENSOR: SensorSize = SensorSize::DAVIS240C;

    /// Predicts the index of the input, counted over all that it was given.
    #[derive(Default)]
    struct Counting {
        shown: usize,
        batches: Vec<usize>,
    }

    impl Predictor for Counting {
        fn predict(
            &mut self,
            inputs: &[f32],
            (height, width): (usize, usize),
        ) -> Result<Vec<HandParams>, TaskError> {
            let count = inputs.len() / (2 * height * width);
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

    fn run(stream: &EventStream) -> (Vec<HandEstimate>, Counting) {
        let (mut tracker, mut predictor, mut poses) = (tracker(), Counting::default(), Vec::new());
        tracker.push(stream, &mut predictor, &mut poses).unwrap();
        (poses, predictor)
    }

    #[test]
    fn a_fast_scene_has_a_pose_a_millisecond_in_batches_of_sixteen() {
        let (poses, predictor) = run(&events(0..150, 20));
        // From 100 ms on, 50 inputs: three batches, and two inputs that wait.
        assert_eq!(predictor.batches, [16, 16, 16]);
        let times: Vec<i64> = poses.iter().map(|pose| pose.t.0).collect();
        assert_eq!(times, (100..148).map(|ms| ms * 1_000).collect::<Vec<_>>());
        assert!(poses[..16].iter().all(|pose| pose.known == Micros(115_000)));
        assert!(poses.iter().all(|pose| !pose.is_repeated));
    }

    /// Two events a millisecond: an input every 6 ms, and a window of 200 pixels with a mean of
    /// about a half, which is less than 300.
    #[test]
    fn a_scene_at_rest_has_fewer_inputs_and_repeats_its_first_predictions() {
        let (poses, predictor) = run(&events(0..700, 2));
        assert_eq!(predictor.batches, [16], "only the first batch is predicted");
        let gaps: Vec<i64> = poses.windows(2).map(|pair| (pair[1].t - pair[0].t).0).collect();
        assert!(gaps.iter().all(|&gap| gap == 6_000), "{gaps:?}");
        assert_eq!(poses.len(), 96);
        for (i, pose) in poses.iter().enumerate() {
            assert_eq!(pose.is_repeated, i >= 16);
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
