//! Output to the Rerun viewer, with the Cargo feature `rerun`: a file, or a running viewer.
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
//! A recording of one frame in a file of the viewer:
//!
//! ```
//! use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
//! use evpose_live::rerun::{FrameContents, RerunRecording};
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

mod error;
mod layout;
mod output;
mod poses;
mod recording;
mod rrd_file;

pub use error::RerunError;
pub use layout::TIMELINE;
pub use poses::{PoseFrame, PoseLayout, PoseRecording, PoseStatus};
pub use recording::{FrameContents, RerunRecording, SendCounts};
