//! A front end, networks and sinks that count, and streams to feed them with.

use std::io::{self, Read};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use evpose_io::framed::FramedWriter;
use evpose_live::sink::Sink;
use evpose_live::source::{Source, StreamSource};
use evpose_live::{Control, LiveOptions, LivePose, Meter, PoseOrigin};
use evpose_pose::PoseEstimate;
use evpose_pose::body::BODY_JOINTS;
use evpose_pose::stream::{InferenceWorker, PoseStream, StreamError, StreamFrontend};

pub(crate) const SENSOR: SensorSize = SensorSize { width: 64, height: 48 };

/// Timeout of the tests.
pub(crate) const LONG: Duration = Duration::from_secs(20);

/// Runs work that must not hang.
pub(crate) fn in_time<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> T {
    let (done, wait) = channel();
    let working = std::thread::spawn(move || {
        let result = work();
        let _ = done.send(());
        result
    });
    // Whether it is done or has panicked, the channel says so.
    assert!(wait.recv_timeout(LONG) != Err(RecvTimeoutError::Timeout), "it hangs");
    working.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// So many events, one after the other every so many microseconds, all over the sensor.
pub(crate) fn events(first: i64, step: i64, count: i64) -> EventStream {
    let event = |k: i64| Event {
        t: Micros(first + step * k),
        x: (k % 64) as u16,
        y: (k % 48) as u16,
        polarity: Polarity::from_on(k % 2 == 0),
    };
    EventStream::from_events(SENSOR, (0..count).map(event)).unwrap()
}

pub(crate) fn stream(packets: impl IntoIterator<Item = EventStream>) -> Vec<u8> {
    let mut writer = FramedWriter::begin("test", Vec::new(), SENSOR).unwrap();
    packets.into_iter().for_each(|packet| writer.push(&packet).unwrap());
    writer.into_inner()
}

pub(crate) fn framed(bytes: Vec<u8>) -> Box<dyn Source> {
    Box::new(StreamSource::framed("the stream", io::Cursor::new(bytes), None).unwrap())
}

pub(crate) struct ChannelReader {
    pieces: Receiver<Vec<u8>>,
    piece: io::Cursor<Vec<u8>>,
}

impl ChannelReader {
    pub(crate) fn new(pieces: Receiver<Vec<u8>>) -> Self {
        Self { pieces, piece: io::Cursor::default() }
    }
}

impl Read for ChannelReader {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        loop {
            match self.piece.read(out)? {
                0 => match self.pieces.recv() {
                    Ok(piece) => self.piece = io::Cursor::new(piece),
                    Err(_) => return Ok(0),
                },
                got => return Ok(got),
            }
        }
    }
}

/// An endless stream: a packet of a millisecond about every millisecond.
pub(crate) struct EndlessStream {
    packet: io::Cursor<Vec<u8>>,
    t: i64,
}

impl EndlessStream {
    pub(crate) fn source() -> Box<dyn Source> {
        let packet = io::Cursor::new(stream([]));
        Box::new(StreamSource::framed("endless", Self { packet, t: 0 }, None).unwrap())
    }
}

impl Read for EndlessStream {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        loop {
            match self.packet.read(out)? {
                0 => {
                    std::thread::sleep(Duration::from_millis(1));
                    let header = stream([]).len();
                    let packet = stream([events(self.t, 100, 10)]).split_off(header);
                    self.packet = io::Cursor::new(packet);
                    self.t += 1_000;
                }
                got => return Ok(got),
            }
        }
    }
}

#[derive(Debug, Default, Clone, PartialEq)]
pub(crate) struct FrontendCounts {
    pub events: u64,
    pub resets: u64,
    /// Maximum of the events that waited during a call.
    pub max_waiting: u64,
}

/// A front end that counts events, with a delay.
pub(crate) struct CountingFrontend {
    pub(crate) counts: Arc<Mutex<FrontendCounts>>,
    meter: Arc<Meter>,
    delay: Duration,
    latest: Micros,
}

impl CountingFrontend {
    pub(crate) fn new(control: &Control) -> Self {
        let meter = control.meter.clone();
        Self { counts: Arc::default(), meter, delay: Duration::ZERO, latest: Micros(i64::MIN) }
    }

    pub(crate) fn slow(control: &Control, delay: Duration) -> Self {
        Self { delay, ..Self::new(control) }
    }
}

pub(crate) fn answer() -> PoseEstimate {
    PoseEstimate::Body { joints_px: [None; BODY_JOINTS], scores: [0.0; BODY_JOINTS], score: 0.0 }
}

impl StreamFrontend for CountingFrontend {
    type Input = i64;
    type Output = ();
    type Pose = PoseEstimate;

    fn push(&mut self, events: &EventStream) -> Result<(), StreamError> {
        assert!(events.t().is_empty() || events.t()[0] >= self.latest, "events go back in time");
        self.latest = events.t().last().copied().unwrap_or(self.latest);
        let mut counts = self.counts.lock().unwrap();
        counts.events += events.len() as u64;
        let Meter { events, dropped_events, followed, .. } = &*self.meter;
        // Read in this order, less is never subtracted from.
        let gone = followed.get() + dropped_events.get();
        counts.max_waiting = counts.max_waiting.max(events.get() - gone);
        drop(counts);
        std::thread::sleep(self.delay);
        Ok(())
    }

    fn input(&mut self, t: Micros, _memory: Option<i64>) -> Option<i64> {
        Some(t.0)
    }

    fn accept(
        &mut self,
        t: Micros,
        _image: &i64,
        (): (),
        _now: Micros,
    ) -> Vec<(Micros, PoseEstimate)> {
        vec![(t, answer())]
    }

    fn estimate(&self, pose: &PoseEstimate) -> PoseEstimate {
        pose.clone()
    }

    fn propagate(&mut self, _t: Micros) -> Option<PoseEstimate> {
        Some(answer())
    }

    fn reset(&mut self) {
        self.counts.lock().unwrap().resets += 1;
        self.latest = Micros(i64::MIN);
    }
}

/// Infers `times` inputs, and then calls `then`.
pub(crate) struct ScriptedWorker<F> {
    pub(crate) times: usize,
    pub(crate) then: F,
}

impl<F: FnMut() -> Result<(), StreamError> + Send> InferenceWorker for ScriptedWorker<F> {
    type Input = i64;
    type Output = ();

    fn infer(&mut self, _image: &i64) -> Result<(), StreamError> {
        match self.times.checked_sub(1) {
            Some(left) => {
                self.times = left;
                Ok(())
            }
            None => (self.then)(),
        }
    }
}

/// A front end with a network that never fails.
pub(crate) fn task(
    frontend: CountingFrontend,
) -> PoseStream<CountingFrontend, impl InferenceWorker<Input = i64, Output = ()>> {
    PoseStream::new(frontend, ScriptedWorker { times: 0, then: || Ok(()) })
}

/// Poses propagated every 10 ms, and room for everything.
pub(crate) fn options() -> LiveOptions {
    LiveOptions { propagate_hz: 100.0, max_packets: 10_000, ..LiveOptions::default() }
}

#[derive(Clone, Default)]
pub(crate) struct CollectingSink(Arc<Mutex<Vec<(i64, PoseOrigin)>>>);

impl CollectingSink {
    pub(crate) fn times(&self, origin: PoseOrigin) -> Vec<i64> {
        let kept = self.0.lock().unwrap();
        kept.iter().filter(|pose| pose.1 == origin).map(|pose| pose.0).collect()
    }

    pub(crate) fn len(&self) -> u64 {
        self.0.lock().unwrap().len() as u64
    }
}

impl Sink for CollectingSink {
    fn name(&self) -> String {
        "kept".to_owned()
    }

    fn write(&mut self, pose: &LivePose) -> io::Result<()> {
        self.0.lock().unwrap().push((pose.t.0, pose.origin));
        Ok(())
    }
}

/// A slow sink: each pose takes this long.
pub(crate) struct SlowSink(pub(crate) CollectingSink, pub(crate) Duration);

impl Sink for SlowSink {
    fn name(&self) -> String {
        "slow".to_owned()
    }

    fn write(&mut self, pose: &LivePose) -> io::Result<()> {
        std::thread::sleep(self.1);
        self.0.write(pose)
    }
}

/// A sink that fails after so many poses.
pub(crate) struct FailingSink(pub(crate) usize);

impl Sink for FailingSink {
    fn name(&self) -> String {
        "broken".to_owned()
    }

    fn write(&mut self, _pose: &LivePose) -> io::Result<()> {
        self.0 = self.0.checked_sub(1).ok_or(io::ErrorKind::StorageFull)?;
        Ok(())
    }
}
