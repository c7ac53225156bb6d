//! Recordings of event cameras for the Rerun viewer, as a file or sent to a viewer that runs.
//!
//! * `Recording`: pictures, the events themselves and their rate, over the time of the sensor.
//! * `Moment`: what one picture shows.
//! * `PoseRecording`, `PoseMoment`: events with poses over them, latencies and rates, while they come.
//! * `RerunError`: a file that cannot be written, a viewer that does not answer.
//!
//! What is seen in the viewer, on the timeline `TIMELINE`:
//!
//! | entity | what it is |
//! |---|---|
//! | `picture` | the representation, as PNG images of the sensor's own size |
//! | `events/on`, `events/off` | a point in the middle of the pixel for every event |
//! | `events/sensor` | the border of the sensor |
//! | `rate/on`, `rate/off` | events a second since the picture before |
//! | `events/network`, `events/between` | bones of the newest pose of the network, and of that between |
//! | `hand` | the surface of a hand, in pixels to the right, down, and away from the camera |
//! | `latency/network`, `latency/between` | milliseconds that 99 of 100 poses are late at most |
//! | `poses/network`, `poses/between` | poses a second |
//!
//! Without the Cargo feature `sdk`, which brings Rerun's SDK, this crate is empty: the names above are
//! no links for that reason.

#[cfg(feature = "sdk")]
mod error;
#[cfg(feature = "sdk")]
mod layout;
#[cfg(feature = "sdk")]
mod outlet;
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
pub use poses::{PoseFigures, PoseLayout, PoseMoment, PoseRecording};
#[cfg(feature = "sdk")]
pub use recording::{Moment, Recording, Sent};
