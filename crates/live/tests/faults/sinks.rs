//! Sinks that misbehave.

use std::io::Write as _;
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use evpose_live::page::{Page, PageInfo, Skeleton};
use evpose_live::sink::{JsonLines, Sinks};
use evpose_live::source::Source;
use evpose_live::{Control, LiveError, Report, run};

use super::dummy::{
    CollectingSink, CountingFrontend, EndlessStream, FailingSink, LONG, SENSOR, SlowSink, events,
    framed, in_time, options, stream, task,
};

/// Two seconds, with a pose every 10 ms.
fn bytes() -> Vec<u8> {
    stream((0..400).map(|k| events(5_000 * k, 500, 10)))
}

type Finished = Result<Vec<(String, u64)>, LiveError>;

/// Runs a source to its end. Returns the report, and how the sinks ended.
fn to_the_end(source: Box<dyn Source>, mut sinks: Sinks) -> (Report, Finished) {
    in_time(move || {
        let control = Control::default();
        let frontend = CountingFrontend::new(&control);
        let report = run(source, task(frontend), &mut sinks, &options(), &control).unwrap();
        (report, sinks.finish())
    })
}

#[test]
fn a_slow_sink_drops_its_poses_and_holds_up_nobody() {
    let (kept, slow) = (CollectingSink::default(), CollectingSink::default());
    let mut sinks = Sinks::new();
    sinks.add(kept.clone());
    sinks.add_with_capacity(SlowSink(slow.clone(), Duration::from_millis(100)), 4);
    let (report, finished) = to_the_end(framed(bytes()), sinks);
    let dropped = finished.unwrap();
    let all = report.network.poses + report.propagated.poses;
    assert!(report.propagated.poses == 199 && report.network.poses > 0, "{report:?}");
    // Had it waited for the slow one, it would have taken twenty seconds.
    assert!(report.seconds < 10.0, "{report:?}");
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
    let (report, finished) = to_the_end(framed(bytes()), sinks);
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
    let (report, finished) = to_the_end(EndlessStream::source(), sinks);
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
    // Not even the end waits for it.
    let (report, finished) = to_the_end(framed(bytes()), sinks);
    drop(viewer);
    let Err(LiveError::Sink { sink, source }) = finished else { panic!("{finished:?}") };
    assert_eq!((sink.as_str(), source.kind()), ("the viewer", std::io::ErrorKind::TimedOut));
    assert!(source.to_string().contains("took nothing"), "{source}");
    assert_eq!(kept.len(), report.network.poses + report.propagated.poses);
    assert!(report.dropped_poses > 100, "{report:?}");
}

/// One viewer never reads, another is gone in the middle of it.
#[test]
fn viewers_of_a_page_that_misbehave_hold_up_nobody() {
    let mut control = Control::default();
    let info = PageInfo {
        title: "A test".to_owned(),
        source: "endless".to_owned(),
        sensor: SENSOR,
        skeleton: Skeleton::Body,
        hosts: Vec::new(),
        hand_mesh: None,
    };
    let address = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
    let page = Page::serve(address, info, control.meter.clone()).unwrap();
    let (view, seen) = (page.view(), Arc::new(AtomicU64::new(0)));
    let counted = seen.clone();
    control.observer = Some(Arc::new(move |events| {
        view.push(events);
        counted.fetch_add(events.len() as u64, Ordering::Relaxed);
    }));
    let mut sinks = Sinks::new();
    sinks.add(page.sink());
    let watch = || {
        let stream = TcpStream::connect(page.local_addr()).unwrap();
        let address = format!("ws://{}/ws", page.local_addr());
        tungstenite::client(address, stream).unwrap().0
    };
    let _silent = watch();
    let mut killed = watch();
    let stop = control.clone();
    let (report, dropped) = in_time(move || {
        let killer = std::thread::spawn(move || {
            // In the middle of it, without a word.
            (0..10).for_each(|_| drop(killed.read().unwrap()));
            killed.get_ref().shutdown(Shutdown::Both).unwrap();
            while page.watchers() > 1 {
                std::thread::sleep(Duration::from_millis(5));
            }
            stop.stop();
            page
        });
        let frontend = CountingFrontend::new(&control);
        let report =
            run(EndlessStream::source(), task(frontend), &mut sinks, &options(), &control).unwrap();
        let _page = killer.join().unwrap();
        (report, sinks.finish().unwrap())
    });
    assert_eq!(seen.load(Ordering::Relaxed), report.followed, "the observer sees every event");
    assert_eq!((report.dropped_packets, report.dropped_poses, dropped[0].1), (0, 0, 0));
}
