//! Recordings of a camera with frames and events, made by our own simulator, through the workflow.

use evpose_core::{Event, EventStream, Micros, Plane, SensorSize};
use evpose_gap::davis::{LoadedShots, Response, load_shots};
use evpose_gap::parameters::ModelParameter;
use evpose_gap::search::Identification;
use evpose_gap::verdict::Answer;
use evpose_gap::workflow::{ComparisonCase, FRAME_NUISANCE, HeldOut, Inputs, Prepared, prepared};
use evpose_gap::{GapError, LightSequence};
use evpose_io::OpenOptions;
use evpose_io::aedat4::{
    Aedat4Packet, Compression, Content, Frame, PixelFormat, Stream, StreamKind, Writer,
};
use evpose_sensor::{EffectConfig, SensorConfig};

const SIZE: SensorSize = SensorSize { width: 32, height: 24 };
/// Such files count microseconds since 1970.
const EPOCH: i64 = 1_700_000_000_000_000;

/// The scene in front of the camera, and how its frames are taken.
#[derive(Clone, Copy)]
struct Shooting {
    /// Speed of the bars in pixels a second.
    speed_px_s: f64,
    frames_hz: f64,
    exposure_us: i64,
    response: Response,
    millis: usize,
}

const USUAL: Shooting = Shooting {
    speed_px_s: 70.0,
    frames_hz: 40.0,
    exposure_us: 8_000,
    response: Response::Srgb,
    millis: 1_200,
};

impl Shooting {
    /// Bars move in the lower half of the image, over a ground that is at rest in the upper.
    fn light(self, t_s: f64, x: f64, y: f64) -> f64 {
        let ground = 0.12 + 0.25 * x / 32.0 + 0.05 * (0.9 * y).sin();
        let place = (x + 0.3 * y - self.speed_px_s * t_s).rem_euclid(19.0) - 7.0;
        let bar = (0.7 * (4.0 - place.abs()) + 0.5).clamp(0.0, 1.0);
        if y < 11.0 { ground } else { ground + (0.15 + 0.02 * y) * bar }
    }

    fn scene(self) -> LightSequence {
        let plane = |k: usize| {
            let light = (0..SIZE.pixels()).map(|i| {
                let (x, y) = ((i % 32) as f64, (i / 32) as f64);
                self.light(k as f64 / 1_000.0, x, y) as f32
            });
            Plane::from_vec(32, 24, light.collect()).unwrap()
        };
        LightSequence::new(1_000.0, (0..=self.millis).map(plane).collect()).unwrap()
    }

    fn frame(self, start_us: i64) -> Frame {
        let samples = 16;
        let code = |i: usize| {
            let (x, y) = ((i % 32) as f64, (i / 32) as f64);
            let light: f64 = (0..samples)
                .map(|sample| {
                    let share = (f64::from(sample) + 0.5) / f64::from(samples);
                    let t_us = start_us as f64 + self.exposure_us as f64 * share;
                    self.light(1e-6 * t_us, x, y) / f64::from(samples)
                })
                .sum();
            (255.0 * self.response.code(light)).round() as u8
        };
        let [start, end] = [0, self.exposure_us].map(|us| Micros(EPOCH + start_us + us));
        Frame {
            t: start,
            readout_start: end,
            readout_end: end + Micros(3_000),
            exposure_start: start,
            exposure_end: end,
            format: PixelFormat::GREY,
            width: SIZE.width,
            height: SIZE.height,
            position: (0, 0),
            origin: 1,
            pixels: (0..SIZE.pixels()).map(code).collect(),
        }
    }

    /// A file of a camera with this sensor; frames are of this origin.
    fn record(self, sensor: &SensorConfig, origin: i8) -> (tempfile::TempDir, std::path::PathBuf) {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rec.aedat4");
        let stream = |id, kind, name: &str| Stream {
            id,
            kind,
            name: name.to_owned(),
            source: "DAVIS".to_owned(),
            size: Some(SIZE),
        };
        let streams =
            [stream(0, StreamKind::Events, "events"), stream(1, StreamKind::Frames, "frames")];
        let mut writer = Writer::create(&path, Compression::default(), &streams).unwrap();
        let events = self.scene().events(sensor, 17).unwrap();
        let shifted = events.iter().map(|e| Event { t: Micros(e.t.0 + EPOCH), ..e });
        writer.events(0, &EventStream::from_events(SIZE, shifted).unwrap()).unwrap();
        let step_us = (1e6 / self.frames_hz) as i64;
        let last_us = 1_000 * self.millis as i64 - self.exposure_us;
        for start_us in (3_000..last_us).step_by(step_us as usize) {
            let frame = Frame { origin, ..self.frame(start_us) };
            writer.packet(&Aedat4Packet { stream: 1, content: Content::Frame(frame) }).unwrap();
        }
        writer.finish().unwrap();
        (dir, path)
    }

    /// Identifies effects in a recording of this sensor, with frames of an assumed response curve.
    fn identified(self, sensor: &SensorConfig, response: Response) -> Identification {
        let (_dir, path) = self.record(sensor, 1);
        let LoadedShots { shots, recording } =
            load_shots(&path, response, 2.0, &OpenOptions::default()).unwrap();
        let inputs = Inputs {
            train: ComparisonCase::new(&recording.events, shots.scene().unwrap()).unwrap(),
            held_out: HeldOut::Later,
            model: SensorConfig::default(),
            nominal: None,
            left_out: Vec::new(),
            seed: 3,
            is_quick: true,
        };
        let sample = |i| shots.twin(i, 3);
        let prepared = Prepared::with_nuisance(inputs, &FRAME_NUISANCE, &sample, None).unwrap();
        let splits = prepared.data_splits().unwrap();
        let mut result =
            splits.identify(&prepared.model.config, &prepared.left_out, &|_| {}).unwrap();
        FRAME_NUISANCE.restrict_identification(&mut result);
        result
    }
}

fn names(result: &Identification) -> Vec<&'static str> {
    result.added_effects.iter().map(evpose_gap::search::AddedEffect::name).collect()
}

fn camera(effect: Option<EffectConfig>) -> SensorConfig {
    let mut sensor = prepared(&SensorConfig::default(), None).config;
    if effect.as_ref().is_some_and(|effect| effect.name == "scanned_readout") {
        sensor.effects.retain(|effect| effect.name != "ideal_readout");
    }
    sensor.effects.extend(effect);
    sensor
}

#[track_caller]
fn assert_nothing_is_named(result: &Identification) {
    let gaps = [result.before.gap, result.after.gap];
    assert_eq!((result.answer, names(result)), (Answer::NoGap, Vec::new()), "{gaps:?}");
}

/// Slow and fast motion, of which frames show much and hardly anything, and long exposures.
#[test]
fn what_frames_do_to_light_is_no_effect_of_the_sensor() {
    for shooting in [
        USUAL,
        Shooting { speed_px_s: 20.0, ..USUAL },
        Shooting { speed_px_s: 400.0, ..USUAL },
        Shooting { frames_hz: 25.0, exposure_us: 20_000, ..USUAL },
    ] {
        assert_nothing_is_named(&shooting.identified(&camera(None), shooting.response));
    }
}

/// Contrast is less than half of what it was, and that is all there is.
#[test]
fn a_response_curve_that_is_another_is_no_effect_of_the_sensor() {
    assert_nothing_is_named(&USUAL.identified(&camera(None), Response::Linear));
}

#[test]
fn a_leak_and_a_scanned_readout_are_named_in_spite_of_it() {
    let leak = EffectConfig::new("leak_on").with("rate_hz", 8.0);
    let scan = EffectConfig::new("scanned_readout")
        .with("period_us", 2_000.0)
        .with("axis", "rows")
        .with("direction", "forward")
        .with("waiting", "kept");
    for (effect, key, value) in [(leak, "rate_hz", 8.0), (scan, "period_us", 2_000.0)] {
        let result = USUAL.identified(&camera(Some(effect.clone())), USUAL.response);
        assert_eq!((result.answer, names(&result)), (Answer::Effects, vec![effect.name.as_str()]));
        let found = result.after.model.effect(&effect.name).and_then(|found| found.number(key));
        assert!((found.unwrap() / value - 1.0).abs() < 0.1, "{found:?}");
    }
}

#[test]
fn background_is_a_parameter_of_the_model() {
    let noise = EffectConfig::new("uniform_noise").with("on_hz", 4.0).with("off_hz", 2.0);
    let result = USUAL.identified(&camera(Some(noise)), USUAL.response);
    assert_eq!((result.answer, names(&result)), (Answer::Parameter, Vec::new()));
    for (parameter, value) in [(ModelParameter::NoiseOn, 4.0), (ModelParameter::NoiseOff, 2.0)] {
        let found = parameter.value(&result.after.model);
        assert!((found / value - 1.0).abs() < 0.15, "{parameter:?} {found}");
    }
}

#[test]
fn a_recording_without_frames_of_its_own_is_refused_with_what_to_do() {
    let (_dir, path) = USUAL.record(&camera(None), 2);
    let refused = load_shots(&path, Response::Srgb, 2.0, &OpenOptions::default()).unwrap_err();
    assert!(matches!(refused, GapError::NoFrames { .. }), "{refused}");
    let message = refused.to_string();
    assert!(message.contains("computed from events"), "{message}");
    assert!(message.contains("--scene none"), "{message}");
}

/// Bytes behind their length.
fn sized(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes(), bytes].concat()
}

/// A record of a bag of ROS 1: a type, fields `name=value`, and data.
fn record(op: u8, fields: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let field = |(name, value): &(&str, &[u8])| sized(&[name.as_bytes(), b"=", value].concat());
    let fields: Vec<u8> = fields.iter().flat_map(field).collect();
    [sized(&[field(&("op", &[op])), fields].concat()), sized(data)].concat()
}

/// Seconds and nanoseconds.
fn time(t: Micros) -> Vec<u8> {
    let us = t.0 as u64;
    [(us / 1_000_000) as u32, (us % 1_000_000 * 1_000) as u32].map(u32::to_le_bytes).concat()
}

#[test]
fn frames_of_a_bag_of_ros_are_those_of_the_same_recording_in_aedat4() {
    // Messages do not say how long exposures are.
    let instant = Shooting { exposure_us: 0, ..USUAL };
    let (dir, path) = instant.record(&camera(None), 1);
    let mut messages = Vec::new();
    for (id, topic, kind) in [
        (0_u32, "/dvs/events", &b"dvs_msgs/EventArray"[..]),
        (1, "/dvs/image_raw", b"sensor_msgs/Image"),
    ] {
        let about = sized(&[b"type=", kind].concat());
        let fields: [(&str, &[u8]); 2] = [("conn", &id.to_le_bytes()), ("topic", topic.as_bytes())];
        messages.extend(record(7, &fields, &about));
    }
    // Of a message: its number, its time, a frame without a name, and the size of the sensor.
    let size = [u32::from(SIZE.height), u32::from(SIZE.width)].map(u32::to_le_bytes).concat();
    let mut put = |id: u32, t: Micros, fields: &[&[u8]]| {
        let message = [&[0; 4], &time(t)[..], &[0; 4], &size, &fields.concat()].concat();
        messages.extend(record(2, &[("conn", &id.to_le_bytes()), ("time", &time(t))], &message));
    };
    for event in evpose_io::open(&path).unwrap().stream.iter() {
        let pixel = [event.x, event.y].map(u16::to_le_bytes).concat();
        let polarity = [u8::from(event.polarity.is_on())];
        put(0, event.t, &[&1_u32.to_le_bytes(), &pixel, &time(event.t), &polarity]);
    }
    for packet in evpose_io::aedat4::Packets::open(&path).unwrap() {
        let Content::Frame(frame) = packet.unwrap().content else { continue };
        let step = u32::from(SIZE.width).to_le_bytes();
        put(1, frame.t, &[&sized(b"mono8"), &[0], &step, &sized(&frame.pixels)]);
    }
    // Without an index, as of a recorder that was killed.
    let none: [(&str, &[u8]); 3] =
        [("index_pos", &[0; 8]), ("conn_count", &[0; 4]), ("chunk_count", &[0; 4])];
    let length = (messages.len() as u32).to_le_bytes();
    let chunk = record(5, &[("compression", b"none"), ("size", &length)], &messages);
    let bag = dir.path().join("rec.bag");
    let bytes = [&b"#ROSBAG V2.0\n"[..], &record(3, &none, &[]), &chunk].concat();
    std::fs::write(&bag, bytes).unwrap();
    let read = |path| load_shots(path, Response::Srgb, 2.0, &OpenOptions::default()).unwrap();
    let (want, got) = (read(&path), read(&bag));
    assert_eq!(got.recording.events, want.recording.events);
    assert!(got.shots == want.shots && got.shots.planes() > 20);
}
