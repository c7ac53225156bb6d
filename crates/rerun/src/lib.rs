//! Recordings of event cameras for the Rerun viewer, as a file or sent to a viewer that runs.
//!
//! * `Recording`: pictures, the events themselves and their rate, over the time of the sensor.
//! * `Moment`: what one picture shows.
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
//!
//! Without the Cargo feature `sdk`, which brings Rerun's SDK, this crate is empty: the names above are
//! no links for that reason.

#[cfg(feature = "sdk")]
mod error;
#[cfg(feature = "sdk")]
mod layout;
#[cfg(feature = "sdk")]
mod recording;
#[cfg(feature = "sdk")]
mod rrd_file;

#[cfg(feature = "sdk")]
pub use error::RerunError;
#[cfg(feature = "sdk")]
pub use layout::TIMELINE;
#[cfg(feature = "sdk")]
pub use recording::{Moment, Recording, Sent};
