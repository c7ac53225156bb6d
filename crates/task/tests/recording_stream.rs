//! Recordings through the streams of both tasks: every so often and triggered; rests, gaps and late starts.

#![allow(clippy::unwrap_used, reason = "tests")]

use burn::tensor::Device;
use evpose_camera::Calibration;
use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use evpose_io::{Header, MemorySource, OpenOptions, Windows};
use evpose_pose::stream::{InferenceSchedule, InferenceWorker, StreamFrontend};
use evpose_pose::{HandParams, HandPose, PoseEstimate};
use evpose_task::body::{
    BodyCheckpoint, BodyConfig, BodyPredictor, BodyPredictorOptions, body_stream,
};
use evpose_task::hand::{
    HandConfig, HandEstimate, HandWorker, Predictor, calibration_for, hand_recording,
};
use evpose_task::{MAX_SILENCE, RecordingStream, TaskError};

/// The whole of the published size, so that thresholds are the published ones.
const SENSOR: SensorSize = SensorSize::DAVIS240C;
const EVERY_MS: InferenceSchedule = InferenceSchedule::Every(Micros(1_000));
const TEN_DAYS: Micros = Micros(10 * 86_400 * 1_000_000);

/// Predicts a function of the input alone, and counts inputs.
#[derive(Default)]
struct Summing {
    batches: Vec<usize>,
}

impl Predictor for Summing {
    fn predict(
        &mut self,
        inputs: &[f32],
        (height, width): (usize, usize),
    ) -> Result<Vec<HandPose>, TaskError> {
        let pose = |input: &[f32]| {
            let sum: f32 = input.iter().enumerate().map(|(k, value)| value * (k % 7) as f32).sum();
            HandParams { articulation: [1e-3 * sum; 6], ..HandParams::default() }.into()
        };
        let inputs = inputs.chunks_exact(2 * height * width);
        self.batches.push(inputs.len());
        Ok(inputs.map(pose).collect())
    }
}

/// `per_ms` events in every millisecond of `ms`, at pixels that walk over the image.
fn events(ms: std::ops::Range<i64>, per_ms: i64) -> Vec<Event> {
    let event = |k: i64| {
        let at = (k * 7).rem_euclid(SENSOR.pixels() as i64);
        let (x, y) = ((at % 240) as u16, (at / 240) as u16);
        Event { t: Micros(k.div_euclid(per_ms) * 1_000), x, y, polarity: Polarity::On }
    };
    (ms.start * per_ms..ms.end * per_ms).map(event).collect()
}

fn later(events: &[Event], by: Micros) -> Vec<Event> {
    events.iter().map(|event| Event { t: event.t + by, ..*event }).collect()
}

fn windows(events: &[Event]) -> Windows {
    let header = Header { sensor: Some(SENSOR), ..Header::default() };
    let source = MemorySource::new(header, events.iter().copied().collect(), Vec::new());
    Windows::from_source(Box::new(source), &OpenOptions::default()).unwrap()
}

/// The poses of a recording, the batches of its inferences, and how many times were looked at.
fn hands(
    events: &[Event],
    schedule: InferenceSchedule,
) -> (Vec<(Micros, HandEstimate)>, Vec<usize>, u64) {
    let (config, mut predictor) = (HandConfig::default(), Summing::default());
    let camera = calibration_for(&config, SENSOR, None).unwrap();
    let mut stream =
        hand_recording(&config, &mut predictor, windows(events), &camera, schedule).unwrap();
    let poses = stream.by_ref().flat_map(|inferred| inferred.unwrap().poses).collect();
    let strides = stream.strides();
    drop(stream);
    (poses, predictor.batches, strides)
}

/// The poses of a person of a network of random weights.
fn bodies(events: &[Event], batch: usize) -> Vec<(Micros, PoseEstimate)> {
    let mut config = BodyConfig::default();
    config.image.side_px = 32;
    (config.network.width, config.network.expansion) = (0.25, 2);
    // Random weights score low, and every pose is to be compared.
    (config.decoding.confidence, config.detection.min_score) = (0.0, 0.0);
    let network = config.network.init(1, &Device::flex()).unwrap();
    let checkpoint = BodyCheckpoint { config, network, mean_pose: None, data: None };
    let options = BodyPredictorOptions::default();
    let predictor = BodyPredictor::new(&checkpoint, options, None).unwrap();
    let camera = Calibration::guessed(SENSOR);
    let mut stream = body_stream(&checkpoint, &camera, None, predictor).unwrap();
    stream.frontend = stream.frontend.with_batch(batch);
    stream.frontend = stream.frontend.with_filter(checkpoint.config.filter).unwrap();
    let every = InferenceSchedule::Every(Micros(20_000));
    let mut recording = RecordingStream::new(windows(events), stream, every);
    let mut poses = Vec::new();
    while let Some(inferred) = recording.next() {
        let inferred = inferred.unwrap().poses;
        let frontend = &recording.stream().frontend;
        poses.extend(inferred.iter().map(|(t, pose)| (*t, frontend.estimate(pose))));
    }
    poses
}

#[test]
fn a_fast_scene_has_a_pose_a_millisecond_in_batches_of_sixteen() {
    let (poses, batches, _) = hands(&events(0..150, 20), InferenceSchedule::Triggered);
    // From 100 ms on, 50 inputs: three batches, and two inputs that wait for the end.
    assert_eq!(batches, [16, 16, 16, 2]);
    let times: Vec<i64> = poses.iter().map(|(t, _)| t.0).collect();
    assert_eq!(times, (100..150).map(|ms| ms * 1_000).collect::<Vec<_>>());
    assert!(poses[..16].iter().all(|(_, pose)| pose.known == Micros(115_000)));
    assert!(poses.iter().all(|(_, pose)| !pose.is_repeated));
}

/// Two events a millisecond: an input every 6 ms, and a window of 200 pixels with a mean of
/// about a half, which is less than 300.
#[test]
fn a_scene_at_rest_has_fewer_inputs_and_repeats_its_first_predictions() {
    let (poses, batches, _) = hands(&events(0..700, 2), InferenceSchedule::Triggered);
    assert_eq!(batches, [16], "only the first batch is predicted");
    assert!(poses.windows(2).all(|pair| (pair[1].0 - pair[0].0) == Micros(6_000)));
    // From 100 ms on, 600 ms in steps of 6 ms fill six batches of 16.
    assert!(poses.len() >= 96);
    for (i, (_, pose)) in poses.iter().enumerate() {
        assert_eq!(pose.is_repeated, i >= 16);
        assert_eq!(pose.measured, poses[i % 16].1.measured);
    }
}

/// The stream pushed as a whole up to every input, as a camera's would be.
#[test]
fn how_a_recording_is_read_changes_no_pose() {
    let all = events(0..420, 5);
    let config = HandConfig::default();
    let camera = calibration_for(&config, SENSOR, None).unwrap();
    let (poses, ..) = hands(&all, EVERY_MS);
    let mut stream =
        evpose_task::hand::hand_stream(&config, Summing::default(), &camera, EVERY_MS, 1).unwrap();
    let mut pushed = Vec::new();
    for ms in 0..420 {
        let of_ms = all.iter().copied().filter(|event| event.t == Micros(1_000 * ms));
        let of_ms = EventStream::from_events(SENSOR, of_ms).unwrap();
        stream.frontend.push(&of_ms).unwrap();
        if ms >= 100 {
            // The plain schedule takes inputs at the last microsecond of a frame.
            let t = Micros(1_000 * ms + 999);
            stream.frontend.stride(t);
            pushed.extend(stream.infer(t).unwrap());
        }
    }
    let of = |poses: &[(Micros, HandEstimate)]| -> Vec<_> {
        poses.iter().map(|(t, pose)| (*t, pose.measured, pose.filtered)).collect()
    };
    assert_eq!(of(&poses), of(&pushed));
    assert_eq!(poses.len(), 320);
}

/// Ten days are as ten seconds: what is behind a gap has the poses that it would have alone, and
/// nothing is looked at in between.
#[test]
fn time_without_events_costs_nothing_and_what_follows_is_another_recording() {
    let part = events(3..260, 20);
    for (gap, schedule) in [
        (TEN_DAYS, EVERY_MS),
        // The silence is shorter than this shift by the 256 ms that the part lasts.
        (MAX_SILENCE + Micros(300_000), EVERY_MS),
        (TEN_DAYS, InferenceSchedule::Triggered),
    ] {
        let (alone, batches, strides) = hands(&part, schedule);
        let both = [part.clone(), later(&part, gap)].concat();
        let (poses, both_batches, both_strides) = hands(&both, schedule);
        assert_eq!((both_batches, both_strides), (batches.repeat(2), 2 * strides));
        let values = |poses: &[(Micros, HandEstimate)], by: Micros| -> Vec<_> {
            poses.iter().map(|(t, pose)| (*t + by, pose.measured, pose.filtered)).collect()
        };
        let want = [values(&alone, Micros(0)), values(&alone, gap)].concat();
        assert_eq!(values(&poses, Micros(0)), want);
        assert!(alone.len() >= 150, "{}", alone.len());
    }
    let alone = bodies(&part, 1);
    let both = [part.clone(), later(&part, TEN_DAYS)].concat();
    let shifted = alone.iter().map(|(t, pose)| (*t + TEN_DAYS, pose.clone()));
    let want: Vec<_> = alone.iter().cloned().chain(shifted).collect();
    for batch in [1, 5] {
        assert_eq!(bodies(&both, batch), want, "batches of {batch}");
    }
    assert!(alone.len() >= 10, "{}", alone.len());
}

#[test]
fn poses_go_on_in_a_rest_and_a_late_start_is_no_gap() {
    let begin = Micros(7_654_321_000);
    let rest = [events(0..200, 20), later(&events(0..200, 20), Micros(3_000_000))].concat();
    let (poses, ..) = hands(&rest, EVERY_MS);
    // Events end at 3.2 s, and the first window is full at 100 ms.
    assert_eq!(poses.len(), 3_200 - 100);
    assert!(poses.windows(2).all(|pair| pair[1].0 - pair[0].0 == Micros(1_000)));
    let (late, ..) = hands(&later(&rest, begin), EVERY_MS);
    assert_eq!(late.len(), poses.len());
    for ((t, pose), (late_t, late)) in poses.iter().zip(&late) {
        assert_eq!((*t + begin, pose.measured), (*late_t, late.measured));
    }
    let person = bodies(&rest, 1);
    assert!(person.len() > 150, "{}", person.len());
    let late = bodies(&later(&rest, begin), 1);
    assert!(person.iter().zip(&late).all(|(a, b)| (a.0 + begin, &a.1) == (b.0, &b.1)));
}

/// A worker is any predictor's, borrowed ones included.
#[test]
fn a_recording_without_events_has_no_pose() {
    fn is_worker<W: InferenceWorker>() {}
    is_worker::<HandWorker<&mut Summing>>();
    assert_eq!(hands(&[], EVERY_MS), (Vec::new(), Vec::new(), 0));
    assert_eq!(bodies(&[], 3), []);
    // Shorter than a window: the end alone.
    let (poses, ..) = hands(&events(0..40, 20), EVERY_MS);
    assert_eq!(poses.iter().map(|(t, _)| *t).collect::<Vec<_>>(), [Micros(40_000)]);
}
