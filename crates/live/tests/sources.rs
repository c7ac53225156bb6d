//! Sources by name: files, connections, cameras.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::io::Write;
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::channel;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use evpose_io::framed::FramedWriter;
use evpose_io::{Columns, FORMATS, OpenOptions};
use evpose_live::source::{ReplayOptions, Source, SourceOptions, open};

const SENSOR: SensorSize = SensorSize { width: 346, height: 260 };

/// Timeout of the tests.
const LONG: Duration = Duration::from_secs(20);

fn events(range: std::ops::Range<i64>) -> EventStream {
    let event = |k: i64| Event {
        t: Micros(1_000_000 + 10 * k),
        x: (k % 346) as u16,
        y: (k % 260) as u16,
        polarity: Polarity::from_on(k % 2 == 0),
    };
    EventStream::from_events(SENSOR, range.map(event)).unwrap()
}

/// Listens, gives its address, and does `work` with whoever connects.
fn server(work: impl FnOnce(TcpStream) + Send + 'static) -> (String, JoinHandle<()>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("tcp://{}", listener.local_addr().unwrap());
    (address, std::thread::spawn(move || work(listener.accept().unwrap().0)))
}

fn options() -> SourceOptions {
    SourceOptions { timeout: Duration::from_millis(300), ..SourceOptions::default() }
}

fn reading(open: OpenOptions) -> SourceOptions {
    SourceOptions { replay: ReplayOptions { open, ..ReplayOptions::default() }, ..options() }
}

/// Why a source is not opened, as a user sees it: with what is behind it.
fn message(text: &str) -> String {
    let error = open(text, &options()).err().unwrap();
    let mut message = error.to_string();
    let mut source = std::error::Error::source(&error);
    while let Some(cause) = source {
        message += &format!(": {cause}");
        source = cause.source();
    }
    message
}

fn gather(source: &mut dyn Source) -> Columns {
    let mut columns = Columns::new();
    while source.next(&mut columns).unwrap().is_some() {}
    columns
}

fn file_of(format: &str, events: &EventStream) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("recording");
    FORMATS.find(format).unwrap().write(&path, events).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn a_framed_stream_comes_over_a_connection_packet_by_packet() {
    let (go_on, wait) = channel::<()>();
    let (address, sender) = server(move |socket| {
        let mut writer = FramedWriter::begin("socket", socket, SENSOR).unwrap();
        for k in 0..3 {
            writer.push(&events(100 * k..100 * k + 100)).unwrap();
            wait.recv_timeout(LONG).unwrap();
        }
    });
    let mut source = open(&address, &options()).unwrap();
    assert_eq!((source.name(), source.sensor()), (address, SENSOR));
    let mut columns = Columns::new();
    for k in 1..=3 {
        let asked = Instant::now();
        let host_time = source.next(&mut columns).unwrap().unwrap();
        assert!(host_time >= asked, "events happen when they come");
        assert_eq!(columns.len(), 100 * k, "no packet waits for the next");
        go_on.send(()).unwrap();
    }
    assert_eq!(source.next(&mut columns).unwrap(), None);
    assert!(columns.iter().eq(events(0..300).iter()));
    sender.join().unwrap();
}

#[test]
fn a_stream_of_dv_is_detected_by_its_first_bytes() {
    let golden = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../io/tests/golden/aedat4-network/dv_network_lz4.bin"
    );
    let of_network = std::fs::read(golden).unwrap();
    for (bytes, count) in [(of_network, 161), (file_of("aedat4", &events(0..500)), 500)] {
        // Of a file, the table at its end is not asked for.
        let (address, sender) = server(move |mut socket| {
            bytes.chunks(97).for_each(|piece| drop(socket.write_all(piece)));
        });
        let mut source = open(&address, &options()).unwrap();
        assert_eq!(source.sensor(), SENSOR);
        assert_eq!(gather(source.as_mut()).len(), count);
        sender.join().unwrap();
    }
}

#[test]
fn the_camera_and_the_sensor_of_a_stream_are_chosen_as_of_a_file() {
    let bytes = file_of("aedat4", &events(0..10));
    let serve = |bytes: Vec<u8>| server(move |mut socket| drop(socket.write_all(&bytes)));
    let (address, sender) = serve(bytes.clone());
    let second = reading(OpenOptions { camera: Some(1), ..OpenOptions::default() });
    let message = open(&address, &second).err().unwrap().to_string();
    assert!(message.contains("no camera 1: the stream has 1 of them"), "{message}");
    sender.join().unwrap();
    let (address, sender) = serve(bytes);
    let larger = SensorSize { width: 640, height: 480 };
    let given = reading(OpenOptions { sensor: Some(larger), ..OpenOptions::default() });
    let message = open(&address, &given).err().unwrap().to_string();
    assert!(message.contains("states a sensor of 346x260, not of 640x480"), "{message}");
    sender.join().unwrap();
    // Of a framed stream, too.
    let framed = |given| {
        let (address, sender) = server(|socket| {
            drop(FramedWriter::begin("socket", &socket, SENSOR));
        });
        let given = reading(OpenOptions { sensor: Some(given), ..OpenOptions::default() });
        let opened = open(&address, &given).map(|source| source.sensor());
        sender.join().unwrap();
        opened
    };
    assert_eq!(framed(SENSOR).unwrap(), SENSOR);
    let message = framed(larger).unwrap_err().to_string();
    assert!(message.contains("states a sensor of 346x260, not of 640x480"), "{message}");
}

#[test]
fn who_waits_for_a_connection_is_woken() {
    let (done, wait) = channel::<()>();
    let (address, sender) = server(move |socket| {
        FramedWriter::begin("socket", &socket, SENSOR).unwrap();
        let _ = wait.recv_timeout(LONG);
    });
    let mut source = open(&address, &options()).unwrap();
    let wake = source.waker().unwrap();
    let waiting = std::thread::spawn(move || source.next(&mut Columns::new()).unwrap());
    // Longer than the header was waited for: now there is no hurry.
    std::thread::sleep(Duration::from_millis(400));
    assert!(!waiting.is_finished());
    let began = Instant::now();
    wake();
    assert_eq!(waiting.join().unwrap(), None);
    assert!(began.elapsed() < LONG / 2);
    done.send(()).unwrap();
    sender.join().unwrap();
}

#[test]
fn what_is_no_stream_is_refused_with_what_came() {
    let refused = |bytes: &'static [u8]| {
        let (address, sender) = server(move |mut socket| socket.write_all(bytes).unwrap());
        let message = message(&address);
        sender.join().unwrap();
        assert!(message.starts_with(&format!("{address}: ")), "{message}");
        message
    };
    let http = refused(b"HTTP/1.1 400 Bad Request\r\n");
    assert!(http.contains("begins with `HTTP/1.1 400`, neither as a framed stream"), "{http}");
    assert!(refused(b"").contains("ended before anything came"));
    assert!(refused(b"EVPOSE1\n\0\0\0\0\0\0\0\0").contains("byte 8: a sensor of 0x0"));
    assert!(refused(b"EVPOSE1\n\x08\0\x08\0").contains("ends 12 bytes into its header"));
}

#[test]
fn a_silent_or_missing_server_is_not_waited_for() {
    let (done, wait) = channel::<()>();
    let (address, sender) = server(move |_socket| {
        let _ = wait.recv_timeout(LONG);
    });
    let began = Instant::now();
    let silent = message(&address);
    assert!(silent.contains("nothing came for 0.3 s"), "{silent}");
    assert!(began.elapsed() < LONG / 2);
    done.send(()).unwrap();
    sender.join().unwrap();
    // Nobody listens there any more.
    let refused = message(&address);
    assert!(refused.starts_with(&format!("{address}: ")), "{refused}");
    for text in ["tcp://127.0.0.1", "tcp://127.0.0.1:port", "tcp://"] {
        assert!(message(text).starts_with(text), "{}", message(text));
    }
}

#[test]
fn texts_name_files_and_nothing_is_guessed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("recording.evs");
    std::fs::write(&path, file_of("framed", &events(0..50))).unwrap();
    let mut source = open(path.to_str().unwrap(), &options()).unwrap();
    assert_eq!(gather(source.as_mut()).len(), 50);
    assert!(message("udp://127.0.0.1:7000").contains("tcp://HOST:PORT"));
    assert!(message("/no/such/file").contains("/no/such/file"));
    let camera = message("camera:no-such-serial-number");
    assert!(camera.starts_with("camera: "), "{camera}");
    if !cfg!(feature = "cameras") {
        assert!(camera.contains("--features live"), "{camera}");
        assert_eq!(message("camera"), camera);
    }
}
