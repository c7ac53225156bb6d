//! What every other crate of evpose speaks: events and their streams, time, sensor geometry,
//! cameras, planes of pixels, and counter-based noise.
//!
//! * [`Event`], [`Polarity`], [`EventStream`]: events in time order, checked once at construction.
//! * [`Micros`], [`TimeWindow`]: integer microseconds, half-open windows.
//! * [`SensorSize`], [`Plane`], [`Pinhole`], [`LensCamera`]: image geometry.
//! * [`StageNoise`], [`CounterRng`]: random numbers that depend on *what* is drawn, never on when.
//! * [`atomic_write`]: outputs appear whole or not at all.

mod camera;
mod error;
mod event;
mod noise;
mod output;
mod plane;
mod stream;
mod time;

pub use camera::{Distortion, LensCamera, LookAt, Pinhole, Sight};
pub use error::CoreError;
pub use event::{Event, Polarity, SensorSize};
pub use noise::{CounterRng, StageNoise, seed_for};
pub use output::{AtomicFile, atomic_write, temporary_target};
pub use plane::Plane;
pub use stream::{EventStream, EventStreamBuilder, Rejected};
pub use time::{Micros, TimeWindow};
