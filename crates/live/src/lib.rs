//! Poses online: events in as they happen, poses out with the time that they describe and their latency.
//!
//! ```text
//!  Source ─► feeder ─► PacketQueue ─► task: representation ─► newest image ─► network ┐
//!  (file, socket, camera)  (drops the oldest)   └──────── filter, poses between ◄─────┘─► Sinks
//! ```
//!
//! * [`source`]: where events come from; [`Packet`]s of them with the moment when they happened.
//! * [`PacketQueue`]: between the source and all else; what does not fit is dropped, the oldest first, and
//!   counted.
//! * [`PoseStream`](evpose_pose::stream::PoseStream): its front end follows events on one thread, its worker
//!   infers the newest input on another.
//! * [`run`]: all of it on three threads, until the source ends or somebody stops it.
//! * [`sink`]: where poses go. A slow sink drops poses, and never holds up the others.
//! * [`page`]: events, poses and figures in a browser, live.
//! * [`Meter`]: what came, what was dropped where, and how late poses were.
//!
//! Poses of the network and poses between them are counted apart, and every queue has a bound.

mod error;
mod meter;
mod packet;
pub mod page;
mod pipeline;
mod pose;
mod queue;
pub mod sink;
pub mod source;

pub use error::LiveError;
pub use meter::{Latencies, Latency, Meter, Report};
pub use packet::Packet;
pub use pipeline::{Control, LiveOptions, Observer, run};
pub use pose::{LivePose, Origin};
pub use queue::PacketQueue;
