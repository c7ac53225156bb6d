use std::sync::Mutex;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Instant;

use evpose_core::{Event, EventStream, Polarity, SensorSize};
use evpose_io::Columns;
use evpose_pose::body::BODY_JOINTS;

use super::*;
use crate::sink::Sink;
use evpose_pose::PoseEstimate;
use evpose_pose::stream::StreamError;

const SENSOR: SensorSize = SensorSize { width: 8, height: 4 };

/// Packets of events at these times, one after the other, as fast as they are taken.
struct ScriptedSource {
    packets: std::vec::IntoIter<Vec<i64>>,
    /// Call before every packet but the first: may it come?
    wait: Option<Receiver<()>>,
    is_first: bool,
    pace: Option<f64>,
    is_lossless: bool,
    /// Packets of a repetition, and those that came.
    repeated: Option<u64>,
    came: u64,
    horizon: Option<i64>,
}

fn given(packets: Vec<Vec<i64>>) -> ScriptedSource {
    ScriptedSource {
        packets: packets.into_iter(),
        wait: None,
        is_first: true,
        pace: None,
        is_lossless: false,
        repeated: None,
        came: 0,
        horizon: None,
    }
}

impl Source for ScriptedSource {
    fn name(&self) -> String {
        "given".to_owned()
    }

    fn sensor(&self) -> SensorSize {
        SENSOR
    }

    fn next(&mut self, columns: &mut Columns) -> Result<Option<Instant>, LiveError> {
        if !std::mem::take(&mut self.is_first)
            && let Some(wait) = &self.wait
        {
            let _ = wait.recv_timeout(Duration::from_secs(10));
        }
        let Some(times) = self.packets.next() else { return Ok(None) };
        self.came += 1;
        for t in times {
            columns.push(Event { t: Micros(t), x: 1, y: 2, polarity: Polarity::On });
        }
        Ok(Some(Instant::now()))
    }

    fn pace(&self) -> Option<f64> {
        self.pace
    }

    fn is_lossless(&self) -> bool {
        self.is_lossless
    }

    fn horizon(&self) -> Option<Arc<AtomicI64>> {
        self.horizon.map(|t| Arc::new(AtomicI64::new(t)))
    }

    fn repetition(&self) -> u64 {
        self.repeated.map_or(0, |packets| (self.came.max(1) - 1) / packets)
    }
}

/// Calls of a front end.
#[derive(Debug, Clone, PartialEq)]
enum Call {
    Push(Vec<i64>),
    Propagate(i64),
    Input(i64),
    Accept(i64),
    Reset,
}

#[derive(Clone, Default)]
struct CallLog(Arc<Mutex<Vec<Call>>>);

impl CallLog {
    fn add(&self, asked: Call) {
        self.0.lock().unwrap().push(asked);
    }

    fn read(&self) -> Vec<Call> {
        self.0.lock().unwrap().clone()
    }

    /// Times of the propagated poses.
    fn ticks(&self) -> Vec<i64> {
        let tick = |call: Call| if let Call::Propagate(t) = call { Some(t) } else { None };
        self.read().into_iter().filter_map(tick).collect()
    }
}

struct LoggingFrontend(CallLog);

fn answer() -> PoseEstimate {
    PoseEstimate::Body { joints_px: [None; BODY_JOINTS], scores: [0.0; BODY_JOINTS], score: 0.0 }
}

impl StreamFrontend for LoggingFrontend {
    type Input = i64;
    type Output = ();
    type Pose = PoseEstimate;

    fn push(&mut self, events: &EventStream) -> Result<(), StreamError> {
        self.0.add(Call::Push(events.t().iter().map(|t| t.0).collect()));
        Ok(())
    }

    fn input(&mut self, t: Micros, _memory: Option<i64>) -> Option<i64> {
        self.0.add(Call::Input(t.0));
        Some(t.0)
    }

    fn accept(
        &mut self,
        t: Micros,
        image: &i64,
        (): (),
        _now: Micros,
    ) -> Vec<(Micros, PoseEstimate)> {
        assert_eq!(t.0, *image);
        self.0.add(Call::Accept(t.0));
        vec![(t, answer())]
    }

    fn estimate(&self, pose: &PoseEstimate) -> PoseEstimate {
        pose.clone()
    }

    fn propagate(&mut self, t: Micros) -> Option<PoseEstimate> {
        self.0.add(Call::Propagate(t.0));
        Some(answer())
    }

    fn reset(&mut self) {
        self.0.add(Call::Reset);
    }
}

/// A worker that reports its start, and blocks until it may continue.
struct SlowWorker {
    begins: Sender<i64>,
    goes_on: Receiver<()>,
}

impl InferenceWorker for SlowWorker {
    type Input = i64;
    type Output = ();

    fn infer(&mut self, image: &i64) -> Result<(), StreamError> {
        let _ = self.begins.send(*image);
        let _ = self.goes_on.recv_timeout(Duration::from_secs(10));
        Ok(())
    }
}

struct ImmediateWorker;

impl InferenceWorker for ImmediateWorker {
    type Input = i64;
    type Output = ();

    fn infer(&mut self, _image: &i64) -> Result<(), StreamError> {
        Ok(())
    }
}

struct CollectingSink(Arc<Mutex<Vec<LivePose>>>);

impl Sink for CollectingSink {
    fn name(&self) -> String {
        "kept".to_owned()
    }

    fn write(&mut self, pose: &LivePose) -> std::io::Result<()> {
        self.0.lock().unwrap().push(pose.clone());
        Ok(())
    }
}

fn options(propagate_hz: f64) -> LiveOptions {
    LiveOptions { propagate_hz, max_packets: 1_000, ..LiveOptions::default() }
}

fn play(packets: Vec<Vec<i64>>, propagate_hz: f64) -> (CallLog, Report, Vec<LivePose>) {
    let (diary, kept) = (CallLog::default(), Arc::default());
    let mut sinks = Sinks::new();
    sinks.add(CollectingSink(Arc::clone(&kept)));
    let task = PoseStream::new(LoggingFrontend(diary.clone()), ImmediateWorker);
    let (options, control) = (options(propagate_hz), Control::default());
    let report = run(Box::new(given(packets)), task, &mut sinks, &options, &control).unwrap();
    sinks.finish().unwrap();
    let kept = kept.lock().unwrap().clone();
    (diary, report, kept)
}

#[test]
fn propagated_poses_are_evenly_spaced_and_follow_exactly_the_events_before_them() {
    let packets =
        vec![vec![0, 400, 900], vec![1_000, 1_500, 1_899, 1_900], vec![1_901, 3_000, 4_950]];
    let (diary, report, poses) = play(packets.clone(), 1_000.0);
    let ticks = diary.ticks();
    assert_eq!(ticks, [1_900, 2_900, 3_900, 4_900]);
    let mut seen: Vec<i64> = Vec::new();
    for asked in diary.read() {
        match asked {
            Call::Push(times) => seen.extend(times),
            Call::Propagate(tick) => assert!(seen.iter().all(|t| *t < tick), "{tick}: {seen:?}"),
            _ => {}
        }
    }
    assert_eq!(seen, packets.concat(), "every event once, in order");
    assert_eq!(report.propagated.poses, 4);
    assert_eq!(report.network.poses + report.propagated.poses, poses.len() as u64);
    assert!(report.network.poses >= 1 && report.images == report.network.poses);
}

#[test]
fn poses_are_propagated_through_times_without_events() {
    // Ticks fall between packets, and into quiet times.
    let packets = vec![vec![0, 999], vec![1_001, 1_998], vec![2_003, 2_500], vec![9_500, 9_999]];
    let (diary, ..) = play(packets, 1_000.0);
    let ticks = diary.ticks();
    assert_eq!(ticks, (1..=9).map(|k| 999 + 1_000 * k).filter(|t| *t <= 9_999).collect::<Vec<_>>());
}

#[test]
fn behind_a_gap_poses_go_on_without_those_of_the_gap() {
    let (diary, ..) = play(vec![vec![0, 100], vec![5_000_050, 5_004_000]], 1_000.0);
    let ticks = diary.ticks();
    assert_eq!(ticks, [5_000_100, 5_001_100, 5_002_100, 5_003_100]);
}

#[test]
fn the_network_is_shown_the_newest_and_what_it_missed_is_counted() {
    let (begins, begun) = channel();
    let (go_on, goes_on) = channel();
    let (come, may_come) = channel();
    let packets: Vec<Vec<i64>> = (0..10).map(|k| vec![1_000 * k, 1_000 * k + 999]).collect();
    let source = ScriptedSource { wait: Some(may_come), ..given(packets) };
    let diary = CallLog::default();
    let task = PoseStream::new(LoggingFrontend(diary.clone()), SlowWorker { begins, goes_on });
    let control = Control::default();
    let meter = control.meter.clone();
    let report = std::thread::scope(|scope| {
        let control = &control;
        let running = scope.spawn(move || {
            run(Box::new(source), task, &mut Sinks::new(), &options(0.0), control).unwrap()
        });
        assert_eq!(begun.recv_timeout(Duration::from_secs(10)).unwrap(), 999);
        // Six packets pass while the network infers the first.
        (0..6).for_each(|_| come.send(()).unwrap());
        let end = Instant::now() + Duration::from_secs(10);
        while meter.followed.get() < 14 && Instant::now() < end {
            std::thread::yield_now();
        }
        go_on.send(()).unwrap();
        while diary.read().iter().all(|asked| *asked != Call::Accept(999)) && Instant::now() < end {
            std::thread::yield_now();
        }
        come.send(()).unwrap();
        assert_eq!(begun.recv_timeout(Duration::from_secs(10)).unwrap(), 7_999, "the newest");
        drop((come, go_on));
        running.join().unwrap()
    });
    assert!(report.skipped_strides >= 6, "{report:?}");
    assert_eq!(report.images, report.network.poses);
    assert_eq!((report.events, report.followed), (20, 20));
}

#[test]
fn time_that_jumps_back_begins_anew_and_small_disorder_is_rejected() {
    let packets = vec![vec![500_000, 500_500], vec![500_400, 501_000], vec![1_000, 2_000]];
    let (diary, report, _) = play(packets, 0.0);
    let asked = diary.read();
    let reset = asked.iter().position(|asked| *asked == Call::Reset).unwrap();
    let behind = asked[reset + 1..].iter().find(|asked| matches!(asked, Call::Push(_)));
    assert_eq!(behind, Some(&Call::Push(vec![1_000, 2_000])));
    assert_eq!((report.restarts, report.rejected, report.events), (1, 1, 5));
}

#[test]
fn poses_go_on_by_the_clock_while_nothing_happens_until_the_source_has_stalled() {
    let (come, may_come) = channel();
    let packets = vec![vec![0, 999], vec![900_000, 901_500]];
    let source = ScriptedSource { wait: Some(may_come), pace: Some(1.0), ..given(packets) };
    let (diary, kept) = (CallLog::default(), Arc::default());
    let mut sinks = Sinks::new();
    sinks.add(CollectingSink(Arc::clone(&kept)));
    let task = PoseStream::new(LoggingFrontend(diary.clone()), ImmediateWorker);
    let control = Control::default();
    let meter = control.meter.clone();
    let report = std::thread::scope(|scope| {
        let (control, sinks) = (&control, &mut sinks);
        let running =
            scope.spawn(move || run(Box::new(source), task, sinks, &options(100.0), control));
        let end = Instant::now() + Duration::from_secs(10);
        while meter.stalls.get() == 0 && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(5));
        }
        come.send(()).unwrap();
        drop(come);
        running.join().unwrap().unwrap()
    });
    sinks.finish().unwrap();
    let ticks = diary.ticks();
    // From 10 ms behind the first packet to the stall half a second later, and none before events
    // come again.
    let silent = ticks.len() - 1;
    assert!((49..=50).contains(&silent), "{ticks:?}");
    let evenly = (1..).map(|k| 999 + 10_000 * k).take(silent);
    assert_eq!(ticks, evenly.chain([900_999]).collect::<Vec<_>>());
    assert_eq!(report.stalls, 1);
    let late = kept.lock().unwrap().iter().map(|pose| pose.latency).max();
    assert!(late < Some(Duration::from_millis(400)), "{late:?}");
}

#[test]
fn the_clock_of_a_recording_ends_where_the_recording_does() {
    let (come, may_come) = channel();
    // At this speed half a second of silence would be 500 s of poses.
    let source = ScriptedSource {
        wait: Some(may_come),
        pace: Some(1_000.0),
        horizon: Some(50_000),
        ..given(vec![vec![0, 999]])
    };
    let diary = CallLog::default();
    let mut sinks = Sinks::new();
    let task = PoseStream::new(LoggingFrontend(diary.clone()), ImmediateWorker);
    let control = Control::default();
    std::thread::scope(|scope| {
        let (control, sinks) = (&control, &mut sinks);
        let running =
            scope.spawn(move || run(Box::new(source), task, sinks, &options(100.0), control));
        std::thread::sleep(Duration::from_millis(300));
        drop(come);
        running.join().unwrap().unwrap()
    });
    let ticks = diary.ticks();
    assert_eq!(ticks, [10_999, 20_999, 30_999, 40_999]);
}

#[test]
fn a_source_that_waits_loses_nothing_and_every_stride_is_inferred() {
    // A packet of 40 ms, as pipes have them, and more of a millisecond than the queue holds.
    let packets: Vec<Vec<i64>> = std::iter::once((0..400).map(|k| 100 * k).collect())
        .chain((40..400).map(|k| vec![1_000 * k, 1_000 * k + 999]))
        .collect();
    let events = packets.concat();
    let source = ScriptedSource { is_lossless: true, ..given(packets) };
    let (diary, control) = (CallLog::default(), Control::default());
    let (begins, begun) = channel();
    let (go_on, goes_on) = channel();
    let task = PoseStream::new(LoggingFrontend(diary.clone()), SlowWorker { begins, goes_on });
    let slow = std::thread::spawn(move || {
        while begun.recv().is_ok() {
            std::thread::sleep(Duration::from_micros(200));
            let _ = go_on.send(());
        }
    });
    let options = LiveOptions { propagate_hz: 0.0, max_packets: 4, ..LiveOptions::default() };
    let report = run(Box::new(source), task, &mut Sinks::new(), &options, &control).unwrap();
    slow.join().unwrap();
    assert_eq!((report.events, report.followed), (events.len() as u64, events.len() as u64));
    assert_eq!((report.dropped_events, report.skipped_strides), (0, 0));
    assert_eq!((report.images, report.network.poses), (400, 400), "one each millisecond");
    let pushed = |call: Call| if let Call::Push(times) = call { times } else { Vec::new() };
    assert_eq!(diary.read().into_iter().flat_map(pushed).collect::<Vec<_>>(), events);
}

#[test]
fn each_repetition_begins_anew_and_is_followed_as_the_first() {
    let repetition = |k: i64| (0..20).map(move |ms| vec![20_000 * k + 1_000 * ms + 7]);
    let packets: Vec<Vec<i64>> = (0..3).flat_map(repetition).collect();
    let source = ScriptedSource { is_lossless: true, repeated: Some(20), ..given(packets) };
    let (diary, control) = (CallLog::default(), Control::default());
    let task = PoseStream::new(LoggingFrontend(diary.clone()), ImmediateWorker);
    let report =
        run(Box::new(source), task, &mut Sinks::new(), &options(2_000.0), &control).unwrap();
    assert_eq!((report.restarts, report.network.poses), (2, 60));
    let calls = diary.read();
    let parts: Vec<&[Call]> = calls.split(|call| *call == Call::Reset).collect();
    let earlier = |call: &Call, k: i64| {
        let t = |t: &i64| t - 20_000 * k;
        match call {
            Call::Push(times) => Call::Push(times.iter().map(t).collect()),
            Call::Propagate(at) => Call::Propagate(t(at)),
            Call::Input(at) => Call::Input(t(at)),
            Call::Accept(at) => Call::Accept(t(at)),
            Call::Reset => Call::Reset,
        }
    };
    assert_eq!(parts.len(), 3);
    for (k, part) in (0..).zip(&parts) {
        let part: Vec<Call> = part.iter().map(|call| earlier(call, k)).collect();
        assert_eq!(part, parts[0], "repetition {k}");
    }
}
