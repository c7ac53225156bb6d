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
//! * [`Task`]: what is done with events: an [`Eye`] that follows them, a [`Network`] that is shown what
//!   the eye sees, whenever it is free.
//! * [`run`]: all of it on three threads, until the source ends or somebody stops it.
//! * [`sink`]: where poses go. A slow sink drops poses, and never holds up the others.
//! * [`page`]: events, poses and figures in a browser, live.
//! * [`Meter`]: what came, what was dropped where, and how late poses were.
//!
//! * `body_task`, `hand_task` (feature `networks`): the tasks of evpose.
//!
//! Poses of the network and poses between them are counted apart, and every queue has a bound.

#[cfg(feature = "networks")]
mod body;
mod error;
#[cfg(feature = "networks")]
mod hand;
mod meter;
mod packet;
pub mod page;
mod pipeline;
mod pose;
mod queue;
pub mod sink;
pub mod source;
mod task;

#[cfg(feature = "networks")]
pub use body::{BodyEye, BodyNetwork, body_task};
pub use error::LiveError;
#[cfg(feature = "networks")]
pub use hand::{HandEye, HandNetwork, hand_mesh, hand_task};
pub use meter::{Latencies, Latency, Meter, Report};
pub use packet::Packet;
pub use pipeline::{Control, LiveOptions, Observer, run};
pub use pose::{Answer, LivePose, Origin};
pub use queue::PacketQueue;
pub use task::{Eye, Network, Task};
