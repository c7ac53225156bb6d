//! A viewer that is killed, and one that never reads, leave the pipeline as it was.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use evpose_io::Columns;
use evpose_live::page::{Page, PageInfo, Skeleton};
use evpose_live::sink::Sinks;
use evpose_live::source::Source;
use evpose_live::{Control, LiveError, LiveOptions, run};
use evpose_pose::PoseEstimate;
use evpose_pose::body::BODY_JOINTS;
use evpose_pose::stream::InferenceWorker;
use evpose_pose::stream::PoseStream;
use evpose_pose::stream::StreamError;
use evpose_pose::stream::StreamFrontend;

const SENSOR: SensorSize = SensorSize { width: 64, height: 48 };
const PACKETS: usize = 400;
const EVENTS: u16 = 50;

/// Packets of a millisecond.
struct PacketSource(usize);

impl Source for PacketSource {
    fn name(&self) -> String {
        "given".to_owned()
    }

    fn sensor(&self) -> SensorSize {
        SENSOR
    }

    fn next(&mut self, columns: &mut Columns) -> Result<Option<Instant>, LiveError> {
        if self.0 == PACKETS {
            return Ok(None);
        }
        self.0 += 1;
        std::thread::sleep(Duration::from_millis(2));
        let t = Micros(1_000 * self.0 as i64);
        for k in 0..EVENTS {
            columns.push(Event { t, x: k, y: k % 48, polarity: Polarity::On });
        }
        Ok(Some(Instant::now()))
    }
}

fn answer() -> PoseEstimate {
    PoseEstimate::Body { joints_px: [None; BODY_JOINTS], scores: [0.0; BODY_JOINTS], score: 0.0 }
}

struct ConstantFrontend;

impl StreamFrontend for ConstantFrontend {
    type Input = ();
    type Output = ();
    type Pose = PoseEstimate;

    fn push(&mut self, _: &EventStream) -> Result<(), StreamError> {
        Ok(())
    }

    fn input(&mut self, _: Micros, _: Option<()>) -> Option<()> {
        Some(())
    }

    fn accept(&mut self, t: Micros, (): &(), (): (), _: Micros) -> Vec<(Micros, PoseEstimate)> {
        vec![(t, answer())]
    }

    fn estimate(&self, pose: &PoseEstimate) -> PoseEstimate {
        pose.clone()
    }

    fn propagate(&mut self, _: Micros) -> Option<PoseEstimate> {
        Some(answer())
    }

    fn reset(&mut self) {}
}

struct ConstantWorker;

impl InferenceWorker for ConstantWorker {
    type Input = ();
    type Output = ();

    fn infer(&mut self, (): &()) -> Result<(), StreamError> {
        Ok(())
    }
}

#[test]
fn the_pipeline_goes_on() {
    let mut control = Control::default();
    let info = PageInfo {
        title: "A test".to_owned(),
        source: "given".to_owned(),
        sensor: SENSOR,
        skeleton: Skeleton::Body,
        hosts: Vec::new(),
        hand_mesh: None,
    };
    let address = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
    let page = Page::serve(address, info, control.meter.clone()).unwrap();
    let (view, seen) = (page.view(), Arc::new(AtomicUsize::new(0)));
    let counted = seen.clone();
    control.observer = Some(Arc::new(move |events| {
        view.push(events);
        counted.fetch_add(events.len(), Ordering::Relaxed);
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
    let report = std::thread::scope(|scope| {
        scope.spawn(|| {
            // In the middle of it, without a word.
            (0..10).for_each(|_| drop(killed.read().unwrap()));
            killed.get_ref().shutdown(Shutdown::Both).unwrap();
        });
        // Every packet has its place, however busy the machine is.
        let options = LiveOptions { max_packets: PACKETS, ..LiveOptions::default() };
        run(
            Box::new(PacketSource(0)),
            PoseStream::new(ConstantFrontend, ConstantWorker),
            &mut sinks,
            &options,
            &control,
        )
        .unwrap()
    });
    let all = PACKETS * usize::from(EVENTS);
    assert_eq!(report.followed, all as u64);
    assert_eq!(seen.load(Ordering::Relaxed), all, "the observer sees every event");
    assert_eq!((report.dropped_packets, report.dropped_poses), (0, 0));
    let end = Instant::now() + Duration::from_secs(10);
    while page.watchers() > 1 {
        assert!(Instant::now() < end, "the killed one is not forgotten");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(sinks.finish().unwrap()[0].1, 0);
}
