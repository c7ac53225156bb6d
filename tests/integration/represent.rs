//! Windows of a recording as arrays and images on the command line.

use burn::tensor::Device;
use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use evpose_infer::{Engine, EngineOptions};
use evpose_io::poses::read_poses;
use evpose_io::tensors::TensorStack;
use evpose_repr::{ChannelOrder, StreamWindow, representation_by_name};
use evpose_task::hand::HandCheckpoint;

use crate::harness::{Sandbox, bytes, shipped, stderr};

const SENSOR: SensorSize = SensorSize { width: 40, height: 30 };

/// Half a second of pairs of events that go over the whole sensor.
fn recording() -> EventStream {
    let event = |k: i64| Event {
        t: Micros(1_000_000 + 250 * (k / 2)),
        x: (k * 7 % 40) as u16,
        y: ((11 * k + k / 120) % 30) as u16,
        polarity: Polarity::from_on(k % 3 == 0),
    };
    EventStream::from_events(SENSOR, (0..4_000).map(event)).unwrap()
}

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    let format = evpose_io::format_for("rec.npz").unwrap();
    format.write(sandbox.path("rec.npz"), &recording()).unwrap();
    sandbox
}

/// The representation of the events before `end`, as the library gives it.
fn planes(name: &str, length: i64, end: i64) -> Vec<f32> {
    let choice = representation_by_name(name).unwrap();
    let window = StreamWindow::new(SENSOR, Micros(length), ChannelOrder::OffFirst).unwrap();
    let mut representation = choice.start(window);
    let events = recording();
    let before = events.iter().take_while(|event| event.t.0 < end);
    representation.push(&EventStream::from_events(SENSOR, before).unwrap());
    representation.advance(Micros(end - 1));
    let mut planes = vec![0.0; choice.channels() * SENSOR.pixels()];
    representation.render(&mut planes);
    planes
}

#[test]
fn a_stack_holds_what_the_library_gives_for_the_same_windows() {
    let sandbox = sandbox();
    // With and without options, of one and of several channels, by time and by count.
    for name in ["lnes", "eros:kernel=5", "voxel-grid:bins=3", "event-count", "fixed-count"] {
        let length = ["--window-ms", "50", "--every-ms", "20"];
        let args = [&["represent", "rec.npz", "--of", name, "--out", "a.npz"][..], &length];
        let said = sandbox.ok(&args.concat());
        assert!(said.contains("a.npz: 24 windows of"), "{said}");
        let stack = TensorStack::read(sandbox.path("a.npz")).unwrap();
        let channels = stack.shape[1];
        assert_eq!(stack.shape, [24, channels, 30, 40], "{name}");
        let ends: Vec<i64> = stack.ends.unwrap().iter().map(|end| end.0).collect();
        assert_eq!(ends, (0..24).map(|k| 1_050_000 + 20_000 * k).collect::<Vec<_>>());
        let windows = stack.values.chunks_exact((channels * 1200) as usize);
        for (window, end) in windows.zip(ends) {
            // To the bit: the command adds nothing to the library.
            assert!(window == planes(name, 50_000, end), "{name} at {end}");
        }
    }
}

#[test]
fn a_part_is_the_same_windows_and_an_array_is_the_stack_alone() {
    let sandbox = sandbox();
    let of = ["--of", "eros", "--window-ms", "50", "--from", "0.1", "--to", "0.25"];
    sandbox.ok(&[&["represent", "rec.npz", "--out", "part.npy"][..], &of].concat());
    let stack = TensorStack::read(sandbox.path("part.npy")).unwrap();
    assert_eq!((stack.shape, stack.ends), (vec![3, 1, 30, 40], None));
    // An EROS remembers what was before the part.
    assert!(stack.values[..1200] == planes("eros", 50_000, 1_150_000));
    let first = &bytes(&sandbox.path("part.npy"))[..10];
    assert_eq!(first, b"\x93NUMPY\x01\0\x76\0");
}

#[test]
fn a_directory_holds_an_image_or_an_array_per_window() {
    let sandbox = sandbox();
    sandbox.ok(&["represent", "rec.npz", "--window-ms", "100", "--out", "images"]);
    let first = image::open(sandbox.path("images/000000.png")).unwrap().into_rgb8();
    assert_eq!(first.dimensions(), (320, 240));
    // Blue is ON, as in views.
    assert!(first.pixels().any(|pixel| pixel.0 == [30, 100, 200]));
    let table = sandbox.text("images/windows.csv");
    assert!(table.starts_with("file,t_us\n000000.png,1100000\n"), "{table}");
    assert_eq!(table.lines().count(), 6);

    sandbox.ok(&["represent", "rec.npz", "--window-ms", "100", "--each", "--out", "arrays/"]);
    let third = TensorStack::read(sandbox.path("arrays/000002.npy")).unwrap();
    assert_eq!(third.shape, [2, 30, 40]);
    assert!(third.values == planes("lnes", 100_000, 1_300_000));

    let message = sandbox.fails(&["represent", "rec.npz", "--out", "images"]);
    assert!(message.contains("images: the directory is not empty"), "{message}");
}

#[test]
fn events_are_pooled_to_a_smaller_size_and_noise_is_left_out() {
    let sandbox = sandbox();
    let of = ["--of", "binary", "--window-ms", "600"];
    let fired = |name: &str| {
        let stack = TensorStack::read(sandbox.path(name)).unwrap();
        (stack.shape, stack.values.iter().filter(|&&value| value > 0.0).count())
    };
    sandbox.ok(&[&["represent", "rec.npz", "--out", "all.npy"][..], &of].concat());
    assert_eq!(fired("all.npy"), (vec![1, 1, 30, 40], 1200));
    let half = ["--size", "20x15"];
    sandbox.ok(&[&["represent", "rec.npz", "--out", "half.npy"][..], &of, &half].concat());
    let (shape, pixels) = fired("half.npy");
    assert_eq!(shape, [1, 1, 15, 20]);
    assert!(pixels > 150, "{pixels}");
    let quiet = ["--denoise=1"];
    sandbox.ok(&[&["represent", "rec.npz", "--out", "quiet.npy"][..], &of, &quiet].concat());
    let (_, pixels) = fired("quiet.npy");
    assert!(pixels < 600, "{pixels}");
}

#[test]
fn a_file_that_states_no_sensor_is_taken_as_large_as_its_events() {
    let sandbox = sandbox();
    sandbox.ok(&["convert", "rec.npz", "rec.csv"]);
    let represent = ["represent", "rec.csv", "--out", "a.npy", "--window-ms", "100"];
    let said = stderr(&sandbox.evpose(&represent).output().unwrap());
    assert!(said.contains("40x30 is the smallest that holds every event"), "{said}");
    sandbox.ok(&["represent", "rec.npz", "--out", "b.npy", "--window-ms", "100"]);
    assert!(bytes(&sandbox.path("a.npy")) == bytes(&sandbox.path("b.npy")));
}

#[test]
fn what_cannot_be_represented_says_why() {
    let sandbox = sandbox();
    for (args, want) in [
        (&["--out", "a.png"][..], "should end in .npy or .npz"),
        (&["--out", "a.npy", "--each"], "--each writes into a directory"),
        (&["--out", "a.npy", "--of", "nonsense"], "there are lnes"),
        (&["--out", "a.npy", "--of", "eros:kernel=4"], "an odd number"),
        (&["--out", "a.npy", "--size", "80x60"], "the sensor is 40x30"),
        (&["--out", "a.npy", "--window-ms", "0"], "from 0.001 to 1000000"),
        (&["--out", "a.npy", "--every-ms=0"], "from 0.001 to 1000000"),
        (&["--out", "a.npy", "--from", "9"], "the recording ends before"),
        (&["--out", "a.npy", "--denoise=0"], "from 0.001 to 1000000"),
    ] {
        let message = sandbox.fails(&[&["represent", "rec.npz"], args].concat());
        assert!(message.contains(want), "{args:?}: {message}");
    }
    assert!(!sandbox.path("a.npy").exists());
    sandbox.write("long.txt", "4 3\n0 1 1 1\n9000000000000000 1 1 1\n");
    let message = sandbox.fails(&["represent", "long.txt", "--out", "a.npy"]);
    assert!(message.contains("choose a part with --from and --to"), "{message}");
    assert!(!sandbox.path("a.npy").exists());
    // Of a damaged recording, no stack is left.
    sandbox.write("cut.txt", "4 3\n1 1 1 1\n2 1 1 1\n3 1");
    let message = sandbox.fails(&["represent", "cut.txt", "--out", "a.npy"]);
    assert!(message.contains("byte 20"), "{message}");
    assert!(!sandbox.path("a.npy").exists());
}

#[test]
fn help_lists_representations_and_examples() {
    let sandbox = Sandbox::new();
    insta::assert_snapshot!("represent_help", sandbox.ok(&["represent", "--help"]));
}

/// The inputs of `evpose represent --checkpoint` and the graph that `evpose export` writes give the poses of
/// `evpose infer`.
#[test]
fn inputs_of_a_network_and_its_graph_give_the_poses_of_infer() {
    let sandbox = Sandbox::new();
    let simulate = ["simulate", "quick", "--held-out", "--sequences", "1", "--seconds", "0.4"];
    sandbox.ok(&[&simulate[..], &["--out", "data"]].concat());
    let network = shipped("hand-quick.bpk");
    let represent = ["represent", "data/0000.evc", "--checkpoint", &network, "--every-ms", "10"];
    let said = sandbox.ok(&[&represent[..], &["--out", "inputs.npz"]].concat());
    assert!(said.contains("inputs of resnet18"), "{said}");
    let infer = ["infer", "--checkpoint", &network, "--events", "data/0000.evc", "--stride-ms"];
    sandbox.ok(&[&infer[..], &["10", "--unfiltered", "--out", "poses.csv"]].concat());
    let stack = TensorStack::read(sandbox.path("inputs.npz")).unwrap();
    let rows = read_poses(&sandbox.path("poses.csv")).unwrap().poses;
    let ends: Vec<Micros> = rows.iter().map(|row| row.t).collect();
    assert_eq!(stack.ends, Some(ends), "one for each row");
    let checkpoint = HandCheckpoint::load(network.as_ref(), &Device::flex()).unwrap();
    let shape = [1, 2, 3].map(|k| stack.shape[k] as usize);
    let graph = checkpoint.network.graph();
    let mut engine = Engine::compile(&graph, shape, EngineOptions::default()).unwrap();
    let mut compared = 0;
    for (input, row) in stack.values.chunks_exact(shape.iter().product()).zip(&rows) {
        let Some(params) = row.params else { continue };
        for (output, written) in engine.run(input)[0].iter().zip(params.to_array()) {
            assert!((output - written).abs() < 1e-5, "{output} {written} at {}", row.t);
        }
        compared += 1;
    }
    assert!(compared > 20, "{compared} of {}", rows.len());
    let refused =
        sandbox.fails(&[&represent[..], &["--window-ms", "5", "--out", "x.npz"]].concat());
    assert!(refused.contains("--window-ms"), "{refused}");
}
