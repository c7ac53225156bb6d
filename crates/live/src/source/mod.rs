//! Where events come from.

#[cfg(feature = "cameras")]
mod camera;
mod dv;
mod framed;
mod named;
mod replay;
mod wire;

use std::time::{Duration, Instant};

use evpose_core::{Micros, SensorSize};
use evpose_io::Columns;

#[cfg(feature = "cameras")]
pub use camera::Camera;
pub use dv::Dv;
pub use framed::Framed;
pub use named::{SourceOptions, open};
pub use replay::{Replay, ReplayOptions};

use crate::LiveError;

/// Time that jumps back by more than this means that another recording begins; what is earlier by less came
/// late.
pub(crate) const JUMP: Micros = Micros(100_000);

/// Times farther from 0, about 36,000 years, are noise: differences of all others are times, too.
pub(crate) const FARTHEST: Micros = Micros(1 << 60);

/// Gives events as they happen. Lives on a thread of its own, which it may hold up.
pub trait Source: Send + 'static {
    /// What it is, for messages.
    fn name(&self) -> String;

    /// The sensor.
    fn sensor(&self) -> SensorSize;

    /// Waits for events and appends them, some thousand at most or those of a millisecond. Returns when
    /// the last of them happened, or none when no more will come.
    ///
    /// # Errors
    /// If the connection fails or what comes is damaged beyond what can be passed over.
    fn next(&mut self, columns: &mut Columns) -> Result<Option<Instant>, LiveError>;

    /// How much time of its events passes in the same time of this machine: 1 for what happens now. None
    /// where events come as fast as they are taken.
    fn pace(&self) -> Option<f64> {
        Some(1.0)
    }

    /// For how long in all events came later than they should, because they could not be read as fast as
    /// they are to be played.
    fn slipped(&self) -> Duration {
        Duration::ZERO
    }

    /// Packets that were passed over because they made no sense, so far.
    fn malformed(&self) -> u64 {
        0
    }

    /// Packets that were lost before they could be taken, so far; how many events they had is not known.
    fn lost(&self) -> u64 {
        0
    }

    /// A function that ends a [`Self::next`] which waits, called from another thread.
    fn waker(&self) -> Option<Box<dyn Fn() + Send + Sync>> {
        None
    }
}

impl Source for Box<dyn Source> {
    fn name(&self) -> String {
        (**self).name()
    }

    fn sensor(&self) -> SensorSize {
        (**self).sensor()
    }

    fn next(&mut self, columns: &mut Columns) -> Result<Option<Instant>, LiveError> {
        (**self).next(columns)
    }

    fn pace(&self) -> Option<f64> {
        (**self).pace()
    }

    fn slipped(&self) -> Duration {
        (**self).slipped()
    }

    fn malformed(&self) -> u64 {
        (**self).malformed()
    }

    fn lost(&self) -> u64 {
        (**self).lost()
    }

    fn waker(&self) -> Option<Box<dyn Fn() + Send + Sync>> {
        (**self).waker()
    }
}
