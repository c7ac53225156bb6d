//! Online pose estimation: events in as they arrive, poses out with their time stamps and
//! latencies.
//!
//! ```text
//!  Source ─► feeder ─► PacketQueue ─► task: representation ─► newest image ─► network ┐
//!  (file, socket, camera)  (drops the oldest)   └──────── filter, propagation ◄──────┘─► Sinks
//! ```
//!
//! * [`source`]: recordings, sockets and cameras; [`Packet`]s of events with their host time.
//! * [`PacketQueue`]: a bounded queue behind the source; the oldest packets are dropped and
//!   counted, or a source that [is lossless](source::Source::is_lossless) waits.
//! * [`PoseStream`](evpose_pose::stream::PoseStream): its front end follows events on one thread,
//!   its worker infers the newest input on another.
//! * [`run`]: the pipeline on three threads, until the source ends or [`Control::stop`] is called.
//! * [`sink`]: consumers of poses. A slow sink drops poses, and never blocks the others.
//! * [`page`]: events, poses and measurements in a browser.
//! * `rerun`: the same in the Rerun viewer, with the Cargo feature of this name.
//! * [`Meter`]: counts of events, drops and poses, and latency histograms.
//!
//! Inferred and propagated poses are counted separately, and every queue is bounded.
//!
//! A recording is replayed as fast as it can be read through a front end that counts events:
//!
//! ```
//! use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
//! use evpose_live::sink::{JsonLines, Sinks};
//! use evpose_live::source::{Replay, ReplayOptions};
//! use evpose_live::{Control, LiveOptions, run};
//! use evpose_pose::PoseEstimate;
//! use evpose_pose::body::BODY_JOINTS;
//! use evpose_pose::stream::{InferenceWorker, PoseStream, StreamError, StreamFrontend};
//!
//! /// Counts events; the network marks no joint.
//! struct Counting(u64);
//!
//! impl StreamFrontend for Counting {
//!     type Input = u64;
//!     type Output = PoseEstimate;
//!     type Pose = PoseEstimate;
//!
//!     fn push(&mut self, events: &EventStream) -> Result<(), StreamError> {
//!         self.0 += events.len() as u64;
//!         Ok(())
//!     }
//!     fn input(&mut self, _: Micros, _: Option<u64>) -> Option<u64> {
//!         Some(self.0)
//!     }
//!     fn accept(
//!         &mut self,
//!         t: Micros,
//!         _: &u64,
//!         pose: PoseEstimate,
//!         _: Micros,
//!     ) -> Vec<(Micros, PoseEstimate)> {
//!         vec![(t, pose)]
//!     }
//!     fn estimate(&self, pose: &PoseEstimate) -> PoseEstimate {
//!         pose.clone()
//!     }
//!     fn propagate(&mut self, _: Micros) -> Option<PoseEstimate> {
//!         None
//!     }
//!     fn reset(&mut self) {}
//! }
//!
//! struct NoNetwork;
//!
//! impl InferenceWorker for NoNetwork {
//!     type Input = u64;
//!     type Output = PoseEstimate;
//!
//!     fn infer(&mut self, _: &u64) -> Result<PoseEstimate, StreamError> {
//!         Ok(PoseEstimate::Body { joints_px: [None; BODY_JOINTS], scores: [0.0; BODY_JOINTS], score: 0.0 })
//!     }
//! }
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("recording.evs");
//! let event = |k: i64| Event { t: Micros(100 * k), x: 3, y: 2, polarity: Polarity::On };
//! let sensor = SensorSize { width: 8, height: 4 };
//! let events = EventStream::from_events(sensor, (0..1_000).map(event))?;
//! evpose_io::format_for(&path)?.write(&path, &events)?;
//!
//! let source = Replay::open(&path, ReplayOptions { speed: f64::INFINITY, ..Default::default() })?;
//! let stream = PoseStream::new(Counting(0), NoNetwork);
//! let mut sinks = Sinks::new();
//! sinks.add(JsonLines::new("poses", std::io::sink()));
//! // A recording waits for the pipeline: nothing is dropped, however fast it is read.
//! let options = LiveOptions { propagate_hz: 0.0, ..LiveOptions::default() };
//! let report = run(Box::new(source), stream, &mut sinks, &options, &Control::default())?;
//! sinks.finish()?;
//! assert_eq!((report.events, report.dropped_events), (1_000, 0));
//! assert_eq!(report.network.poses, 100, "one each millisecond");
//! # Ok(())
//! # }
//! ```

mod error;
mod meter;
mod packet;
pub mod page;
mod pipeline;
mod pose;
mod queue;
#[cfg(feature = "rerun")]
pub mod rerun;
pub mod sink;
pub mod source;

pub use error::LiveError;
pub use meter::{LatencyBaseline, LatencySummary, Meter, Report};
pub use packet::Packet;
pub use pipeline::{Control, LiveOptions, Observer, run};
pub use pose::LivePose;
pub use queue::PacketQueue;

pub use evpose_pose::PoseOrigin;
