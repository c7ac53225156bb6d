//! Output to the Rerun viewer: a file, or a running viewer.
//!
//! * `RerunRecording`, `FrameContents`: event images, events and their rate over event time.
//! * `PoseRecording`, `PoseFrame`: events with poses, latencies and rates, online.
//! * `RerunError`: a file that cannot be written, a viewer that does not answer.
//!
//! Entities in the viewer, on the timeline `TIMELINE`:
//!
//! | entity | content |
//! |---|---|
//! | `event_image` | the representation, as PNG images of the sensor's size |
//! | `events/on`, `events/off` | a point at the pixel centre of every event |
//! | `events/sensor` | the border of the sensor |
//! | `rate/on`, `rate/off` | events per second since the frame before |
//! | `events/network`, `events/propagated` | bones of the newest inferred and propagated pose |
//! | `hand` | the mesh of a hand, in pixels to the right, down, and away from the camera |
//! | `latency/network`, `latency/propagated` | 0.99 quantile of latency, in milliseconds |
//! | `poses/network`, `poses/propagated` | poses per second |
//!
//! Without the Cargo feature `sdk`, which brings Rerun's SDK, this crate is empty; the names above
//! are not linked for that reason.
//!
//! A recording of one frame in a file of the viewer:
//!
#![cfg_attr(feature = "sdk", doc = "```")]
#![cfg_attr(not(feature = "sdk"), doc = "```ignore")]
//! use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
//! use evpose_rerun::{FrameContents, RerunRecording};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let sensor = SensorSize { width: 8, height: 6 };
//! let event = Event { t: Micros(10), x: 3, y: 2, polarity: Polarity::On };
//! let events = EventStream::from_events(sensor, [event])?;
//! let folder = tempfile::tempdir()?;
//! let mut recording = RerunRecording::create(&folder.path().join("dot.rrd"), "dot", sensor)?;
//! let (t, length) = (Micros(1_000), Micros(1_000));
//! recording.send(&FrameContents { t, length, events: &events, event_image: b"a PNG file" })?;
//! assert_eq!(recording.finish()?.events, 1);
//! # Ok(())
//! # }
//! ```

#[cfg(feature = "sdk")]
mod error;
#[cfg(feature = "sdk")]
mod layout;
#[cfg(feature = "sdk")]
mod output;
#[cfg(feature = "sdk")]
mod poses;
#[cfg(feature = "sdk")]
mod recording;
#[cfg(feature = "sdk")]
mod rrd_file;

#[cfg(feature = "sdk")]
pub use error::RerunError;
#[cfg(feature = "sdk")]
pub use layout::TIMELINE;
#[cfg(feature = "sdk")]
pub use poses::{PoseFrame, PoseLayout, PoseRecording, PoseStatus};
#[cfg(feature = "sdk")]
pub use recording::{FrameContents, RerunRecording, SendCounts};
