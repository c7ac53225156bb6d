//! Sources of events: recordings, sockets and cameras.

#[cfg(feature = "cameras")]
mod camera;
mod connection;
mod named;
mod replay;
mod stream;

use std::sync::Arc;
use std::sync::atomic::AtomicI64;
use std::time::{Duration, Instant};

use evpose_core::{Micros, SensorSize};
use evpose_io::{Columns, IoError};

#[cfg(feature = "cameras")]
pub use camera::CameraSource;
pub use named::{SourceOptions, open};
pub use replay::{Replay, ReplayOptions};
pub use stream::StreamSource;

use crate::LiveError;

/// A backward jump of time by more than this begins another recording; earlier events within it are
/// late ones, which are rejected.
pub(crate) const RESTART_JUMP: Micros = Micros(100_000);

/// Bound of valid time stamps, about 36,000 years: differences of valid ones do not overflow.
pub(crate) const MAX_TIME: Micros = Micros(1 << 60);

/// A source of events. It runs on its own thread and may block.
pub trait Source: Send + 'static {
    /// Name in messages.
    fn name(&self) -> String;

    /// Size of the sensor.
    fn sensor(&self) -> SensorSize;

    /// Waits for events and appends them: about a millisecond, or some thousand. Returns the host
    /// time of the last one, or none at the end.
    ///
    /// # Errors
    /// If the connection fails, or the data are damaged beyond recovery.
    fn next(&mut self, columns: &mut Columns) -> Result<Option<Instant>, LiveError>;

    /// Remarks on the events so far, in sentences without a full stop.
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }

    /// Event time per host time: 1 for a camera, the speed for a recording. None where events are
    /// read as fast as possible.
    fn pace(&self) -> Option<f64> {
        Some(1.0)
    }

    /// Whether every event counts: the source then waits for the pipeline, instead of losing the
    /// oldest events. Recordings and pipes can wait, cameras cannot.
    fn is_lossless(&self) -> bool {
        false
    }

    /// Event time in microseconds up to which a recording has been read: poses are not propagated beyond it, so
    /// that none are of a time after its end. None for cameras and connections, whose time goes on.
    fn horizon(&self) -> Option<Arc<AtomicI64>> {
        None
    }

    /// Index of the repetition that the latest events are of, from 0: each is another recording.
    fn repetition(&self) -> u64 {
        0
    }

    /// Total lag of a recording that could not be read at its playback speed.
    fn slipped(&self) -> Duration {
        Duration::ZERO
    }

    /// Malformed packets skipped so far.
    fn malformed(&self) -> u64 {
        0
    }

    /// Packets lost by the device so far; their number of events is unknown.
    fn lost(&self) -> u64 {
        0
    }

    /// A function that ends a blocked [`Self::next`] from another thread.
    fn waker(&self) -> Option<Box<dyn Fn() + Send + Sync>> {
        None
    }
}

/// Refuses a size of the sensor that is not the one that a stream states.
fn check_sensor(
    name: &str,
    given: Option<SensorSize>,
    stated: SensorSize,
) -> Result<(), LiveError> {
    match given.filter(|given| *given != stated) {
        None => Ok(()),
        Some(given) => Err(IoError::OtherSensor { path: name.into(), given, stated }.into()),
    }
}
