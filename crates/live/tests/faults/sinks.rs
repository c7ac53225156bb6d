//! Sinks that misbehave.

use std::io::Write as _;
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use evpose_live::sink::{JsonLines, Sinks};
use evpose_live::{Control, LiveError, run};

use super::dummy::{
    CollectingSink, CountingFrontend, EndlessStream, FailingSink, LONG, SlowSink, events, framed,
    in_time, options, stream, task,
};

/// Two seconds, with a pose every 10 ms.
fn bytes() -> Vec<u8> {
    stream((0..400).map(|k| events(5_000 * k, 500, 10)))
}

#[test]
fn a_slow_sink_drops_its_poses_and_holds_up_nobody() {
    let (kept, slow) = (CollectingSink::default(), CollectingSink::default());
    let mut sinks = Sinks::new();
    sinks.add(kept.clone());
    sinks.add_with_capacity(SlowSink(slow.clone(), Duration::from_millis(100)), 4);
    let (report, lasted, dropped) = in_time(move || {
        let (control, began) = (Control::default(), Instant::now());
        let frontend = CountingFrontend::new(&control);
        let report =
            run(framed(bytes()), task(frontend), &mut sinks, &options(), &control).unwrap();
        (report, began.elapsed(), sinks.finish().unwrap())
    });
    let all = report.network.poses + report.propagated.poses;
    assert!(report.propagated.poses == 199 && report.network.poses > 0, "{report:?}");
    // Had it waited for the slow one, it would have taken twenty seconds.
    assert!(lasted < Duration::from_secs(10), "{lasted:?}");
    assert_eq!(kept.len(), all);
    assert_eq!(dropped[0], ("kept".to_owned(), 0));
    assert_eq!(dropped[1], ("slow".to_owned(), report.dropped_poses));
    assert_eq!(slow.len() + report.dropped_poses, all);
    assert!(report.dropped_poses > 0 && slow.len() >= 4, "{report:?}");
}

#[test]
fn the_error_of_a_sink_is_returned_at_the_end_and_the_others_get_every_pose() {
    let kept = CollectingSink::default();
    let mut sinks = Sinks::new();
    sinks.add(FailingSink(3));
    sinks.add(kept.clone());
    let (report, finished) = in_time(move || {
        let control = Control::default();
        let frontend = CountingFrontend::new(&control);
        let report =
            run(framed(bytes()), task(frontend), &mut sinks, &options(), &control).unwrap();
        (report, sinks.finish())
    });
    assert_eq!((report.events, report.followed), (4_000, 4_000));
    assert_eq!(kept.len(), report.network.poses + report.propagated.poses);
    let Err(LiveError::Sink { sink, source }) = finished else { panic!("{finished:?}") };
    assert_eq!((sink.as_str(), source.kind()), ("broken", std::io::ErrorKind::StorageFull));
}

#[test]
fn a_pipeline_ends_when_every_sink_has_failed() {
    let mut sinks = Sinks::new();
    sinks.add(FailingSink(2));
    sinks.add(FailingSink(5));
    let (report, finished) = in_time(move || {
        let control = Control::default();
        let frontend = CountingFrontend::new(&control);
        let report = run(EndlessStream::source(), task(frontend), &mut sinks, &options(), &control);
        (report.unwrap(), sinks.finish())
    });
    assert!(report.network.poses + report.propagated.poses >= 6);
    assert!(matches!(finished, Err(LiveError::Sink { .. })));
}

#[test]
fn a_viewer_that_is_killed_ends_its_sink_alone() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let socket = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
    let viewer = listener.accept().unwrap().0;
    let kept = CollectingSink::default();
    let mut sinks = Sinks::new();
    sinks.add(JsonLines::new("the viewer", socket));
    sinks.add(kept.clone());
    let (gone, report, finished) = in_time(move || {
        let control = Control::default();
        let frontend = CountingFrontend::new(&control);
        let (meter, stop) = (control.meter.clone(), control.clone());
        let killer = std::thread::spawn(move || {
            let wait = |poses: u64| {
                let began = Instant::now();
                while meter.report().network.poses < poses && began.elapsed() < LONG {
                    std::thread::sleep(Duration::from_millis(2));
                }
            };
            wait(5);
            drop(viewer);
            // Long enough for what is written to come back.
            wait(200);
            stop.stop();
        });
        let report =
            run(EndlessStream::source(), task(frontend), &mut sinks, &options(), &control).unwrap();
        killer.join().unwrap();
        let gone: Vec<String> = sinks.failed().map(str::to_owned).collect();
        (gone, report, sinks.finish())
    });
    assert_eq!(gone, ["the viewer"]);
    assert_eq!(kept.len(), report.network.poses + report.propagated.poses);
    assert!(report.network.poses >= 200, "{report:?}");
    let Err(LiveError::Sink { sink, .. }) = finished else { panic!("{finished:?}") };
    assert_eq!(sink, "the viewer");
}

#[test]
fn a_viewer_that_takes_nothing_holds_up_nobody() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let mut socket = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
    let viewer = listener.accept().unwrap().0;
    // Its buffers are full: what is written next waits.
    socket.set_nonblocking(true).unwrap();
    while socket.write(&[b' '; 1 << 16]).is_ok() {}
    socket.set_nonblocking(false).unwrap();
    let kept = CollectingSink::default();
    let mut sinks = Sinks::new();
    sinks.add_with_capacity(JsonLines::new("the viewer", socket), 16);
    sinks.add(kept.clone());
    let (report, finished) = in_time(move || {
        let control = Control::default();
        let frontend = CountingFrontend::new(&control);
        let report =
            run(framed(bytes()), task(frontend), &mut sinks, &options(), &control).unwrap();
        // Not even the end waits for it.
        let finished = sinks.finish();
        drop(viewer);
        (report, finished)
    });
    let Err(LiveError::Sink { sink, source }) = finished else { panic!("{finished:?}") };
    assert_eq!((sink.as_str(), source.kind()), ("the viewer", std::io::ErrorKind::TimedOut));
    assert!(source.to_string().contains("took nothing"), "{source}");
    assert_eq!(kept.len(), report.network.poses + report.propagated.poses);
    assert!(report.dropped_poses > 100, "{report:?}");
}
