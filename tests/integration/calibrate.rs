//! Camera parameters, from frames and events that another command makes.

use evpose_core::EventStream;

use crate::harness::Sandbox;

const WIDTH: usize = 32;
const HEIGHT: usize = 24;
const FRAMES: usize = 400;

/// A wave of light that moves to and fro, as f32.
fn light() -> Vec<u8> {
    let value = |k: usize, x: usize, y: usize| {
        // To and fro, so that both polarities come everywhere.
        let shift = 9.0 * (0.012 * k as f32).sin();
        let wave = (0.4 * (x as f32 - shift)).sin() * (0.3 * y as f32).cos();
        0.3 * (0.9 * wave).exp()
    };
    let mut all = Vec::new();
    for k in 0..FRAMES {
        for i in 0..WIDTH * HEIGHT {
            all.extend(value(k, i % WIDTH, i / WIDTH).to_le_bytes());
        }
    }
    array("<f4", &all)
}

/// The frames as an array of a type.
fn array(descr: &str, values: &[u8]) -> Vec<u8> {
    let shape = format!("({FRAMES}, {HEIGHT}, {WIDTH})");
    // The header is padded to a multiple of 64 bytes, as NumPy does.
    let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    [b"\x93NUMPY\x01\x00\x76\x00", format!("{header:<117}\n").as_bytes(), values].concat()
}

/// The light in codes of 8 bits, frame after frame.
fn codes(light: &[u8]) -> Vec<u8> {
    let values = light[128..].as_chunks::<4>().0.iter();
    values.map(|y| (255.0 * f32::from_le_bytes(*y)).round() as u8).collect()
}

/// Bytes behind their length.
fn sized(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes()[..], bytes].concat()
}

/// A recording of ROS 1 in MCAP: the topic `/cam/events` of these events, 5 s later, and a frame on each topic of
/// images in each millisecond of them.
fn bag(events: &EventStream, frames: &[u8], topics_of_images: &[&str]) -> Vec<u8> {
    /// The time of ROS that is 5 s on the clock of the events.
    const BASE_US: i64 = 1_700_000_000_000_000;
    let mut file = b"\x89MCAP0\r\n".to_vec();
    let mut record = |kind: u8, body: &[u8]| {
        file.push(kind);
        file.extend((body.len() as u64).to_le_bytes());
        file.extend(body);
    };
    let kinds = ["event_camera_msgs/msg/EventPacket", "sensor_msgs/msg/Image"];
    let topics = std::iter::once(&"/cam/events").chain(topics_of_images);
    for (id, topic) in (1_u16..).zip(topics) {
        let kind = kinds[usize::from(id > 1)];
        let id = id.to_le_bytes();
        record(3, &[&id[..], &sized(kind.as_bytes()), &sized(b"ros1msg"), &[0; 4]].concat());
        record(4, &[&id[..], &id, &sized(topic.as_bytes()), &sized(b"ros1"), &[0; 4]].concat());
    }
    let header = |after_us: i64| {
        let stamp_us = (BASE_US + after_us).cast_unsigned();
        let (s, ns) = ((stamp_us / 1_000_000) as u32, 1_000 * (stamp_us % 1_000_000) as u32);
        [&[0; 4][..], &s.to_le_bytes(), &ns.to_le_bytes(), &sized(b"cam")].concat()
    };
    let size = [HEIGHT as u32, WIDTH as u32].map(u32::to_le_bytes).concat();
    let first = events.t()[0].0;
    let words = events.iter().flat_map(|event| {
        let pixel = u64::from(event.y) << 48 | u64::from(event.x) << 32;
        let on = u64::from(event.polarity.is_on()) << 63;
        let after_ns = 1_000 * (event.t.0 - first).cast_unsigned();
        (on | pixel | after_ns).to_le_bytes()
    });
    let words = sized(&words.collect::<Vec<u8>>());
    let base_ns = (1_000 * (5_000_000 + first)).to_le_bytes();
    let packet =
        [&header(first)[..], &size, &[0; 8], &base_ns, &sized(b"mono"), &[0], &words].concat();
    // The topic, the number of the message, and two times of the recorder.
    let message = |id: u16, message: &[u8]| [&id.to_le_bytes()[..], &[0; 20], message].concat();
    record(5, &message(1, &packet));
    for (k, frame) in frames.chunks(WIDTH * HEIGHT).enumerate() {
        let (begin, step) = (header(1_000 * k as i64), (WIDTH as u32).to_le_bytes());
        let image = [&begin[..], &size, &sized(b"mono8"), &[0], &step, &sized(frame)].concat();
        for id in 0..topics_of_images.len() as u16 {
            record(5, &message(id + 2, &image));
        }
    }
    record(15, &[0; 4]);
    file
}

/// Events of a camera with these effects.
fn recorded(sandbox: &Sandbox, frames: &[u8], fps: &str, effects: &str) {
    sandbox.write("frames.npy", frames);
    sandbox.write("camera.toml", effects);
    let to = ["events", "--frames", "frames.npy", "--fps", fps, "--out", "rec.npz"];
    sandbox.ok(&[&to[..], &["--sensor", "camera.toml"]].concat());
}

/// The number behind a word of a line.
fn number(said: &str, line: &str, word: &str) -> f64 {
    let line = said.lines().find(|l| l.contains(line)).unwrap();
    let mut words = line.split_whitespace().skip_while(|w| *w != word).skip(1);
    words.next().unwrap().parse().unwrap()
}

const PIXEL: &str = "[[effect]]\nname = 'logarithmic'\ndark_offset = 1e-6\n
[[effect]]\nname = 'level_crossing'\nthreshold_on = 0.15\nthreshold_off = 0.22\n";

#[test]
fn thresholds_come_back_and_make_a_sensor() {
    let sandbox = Sandbox::new();
    recorded(&sandbox, &light(), "1000", PIXEL);
    let args = ["calibrate", "threshold", "--events", "rec.npz", "--frames", "frames.npy"];
    let said = sandbox.ok(&[&args[..], &["--fps", "1000", "--out", "found.toml"]].concat());
    assert!((number(&said, "by steps", "ON") - 0.15).abs() < 0.002, "{said}");
    assert!(said.contains("OFF 0.22") || said.contains("OFF 0.219"), "{said}");
    let shown = sandbox.ok(&["sensor", "show", "found.toml"]);
    assert!(shown.contains("level_crossing"), "{shown}");
    let never = sandbox.fails(&[&args[..], &["--fps", "1e9"]].concat());
    assert!(never.contains("--fps"), "{never}");
}

#[test]
fn frames_of_a_video_are_at_the_times_that_it_states() {
    let sandbox = Sandbox::new();
    let light = light();
    let codes = codes(&light);
    let mut video = format!("YUV4MPEG2 W{WIDTH} H{HEIGHT} F1000:1 Cmono\n").into_bytes();
    for frame in codes.chunks(WIDTH * HEIGHT) {
        video.extend_from_slice(b"FRAME\n");
        video.extend_from_slice(frame);
    }
    sandbox.write("clip.y4m", video);
    sandbox.write("camera.toml", PIXEL);
    let events = ["events", "--frames", "clip.y4m", "--sensor", "camera.toml", "--out", "rec.npz"];
    sandbox.ok(&events);
    let args = ["calibrate", "threshold", "--events", "rec.npz", "--frames", "clip.y4m"];
    let at = |fps| sandbox.ok(&[&args[..], &["--fps", fps]].concat());
    let stated = sandbox.ok(&args);
    assert_eq!(stated, at("1000"));
    assert_ne!(stated, at("700"));
}

#[test]
fn images_of_a_bag_are_at_the_times_of_its_events() {
    let sandbox = Sandbox::new();
    let codes = codes(&light());
    recorded(&sandbox, &array("|u1", &codes), "1000", PIXEL);
    let events = evpose_io::open(sandbox.path("rec.npz")).unwrap().stream;
    let write = |name: &str, topics: &[&str]| {
        sandbox.write(name, bag(&events, &codes, topics));
    };
    write("cam.mcap", &["/cam/image"]);
    let given = "calibrate threshold --events rec.npz --frames frames.npy --fps 1000";
    let given = sandbox.run(given, &[]);
    let threshold = ["calibrate", "threshold", "--events", "cam.mcap", "--frames", "cam.mcap"];
    for more in [&[][..], &["--zero-time"]] {
        let stated = sandbox.ok(&[&threshold[..], more].concat());
        assert!(stated.contains("400 frames"), "{stated}");
        for line in ["by steps", "by totals"] {
            let [given, stated] = [&given, &stated].map(|said| number(said, line, "ON"));
            assert!((given - stated).abs() < 1e-3, "{line}: {given} {stated}");
        }
    }
    // A given rate begins at time 0, which is 5 s before.
    let early = sandbox.fails(&[&threshold[..], &["--fps", "1000"]].concat());
    assert!(early.contains("events while frames last"), "{early}");
    // The same light makes the same events.
    sandbox.run("events --frames cam.mcap --sensor camera.toml --out again.npz", &[]);
    assert!(evpose_io::open(sandbox.path("again.npz")).unwrap().stream == events);
    write("two.mcap", &["/cam/image", "/cam/other"]);
    let several =
        sandbox.fails(&["calibrate", "threshold", "--events", "two.mcap", "--frames", "two.mcap"]);
    let are_listed =
        ["/cam/events", "/cam/image", "/cam/other"].iter().all(|t| several.contains(t));
    assert!(several.contains("not one topic of images") && are_listed, "{several}");
}

#[test]
fn rates_come_back_and_hot_pixels_are_listed() {
    let sandbox = Sandbox::new();
    let moving = light();
    // One frame over and over.
    let (head, frame) = (&moving[..128], &moving[128..128 + 4 * WIDTH * HEIGHT]);
    let still = [head, &frame.repeat(FRAMES)].concat();
    let noise = "\n[[effect]]\nname = 'uniform_noise'\non_hz = 8.0\noff_hz = 2.0\n
[[effect]]\nname = 'hot_pixels'\nfraction = 0.004\nmedian_hz = 2000.0\non_share = 0.5\n";
    recorded(&sandbox, &still, "200", &format!("{PIXEL}{noise}"));
    let args = ["calibrate", "noise", "--events", "rec.npz", "--out", "n.toml", "--hot", "hot.csv"];
    let said = sandbox.ok(&args);
    let on = number(&said, "ON  ", "ON");
    assert!((on / 8.0 - 1.0).abs() < 0.05, "{said}");
    let table = sandbox.text("hot.csv");
    assert!(table.starts_with("x,y,on_hz,off_hz\n") && table.lines().count() > 1, "{table}");
    assert!(sandbox.ok(&["sensor", "show", "n.toml"]).contains("uniform_noise"));
    let skip = |seconds| ["calibrate", "noise", "--events", "rec.npz", "--skip", seconds];
    let short = sandbox.ok(&skip("1.5"));
    assert!((number(&short, "ON  ", "ON") / 8.0 - 1.0).abs() < 0.1, "{short}");
    assert!(short.contains("are short"), "{short}");
    let late = sandbox.fails(&skip("60"));
    assert!(late.contains("--skip") && late.contains("rec.npz"), "{late}");
}
