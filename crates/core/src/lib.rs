//! The types that all crates of evpose share: events and their streams, time, sensor geometry,
//! cameras, planes of pixels, and counter-based noise.
//!
//! * [`Event`], [`Polarity`], [`EventStream`]: events in time order, checked once at construction.
//! * [`Micros`], [`TimeWindow`]: integer microseconds, half-open windows.
//! * [`SensorSize`], [`Plane`], [`Pinhole`], [`LensCamera`]: image geometry.
//! * [`StageNoise`], [`CounterRng`]: random numbers that depend on the purpose of a draw, not on
//!   the order of draws.
//! * [`atomic_write`]: output files are complete or absent.
//! * [`Registry`]: the built-in entries of one kind, and those that other crates register.
//! * [`Parameter`], [`Settings`]: parameters of effects, cleaners and representations, and their checked values.
//! * [`stats`]: quantiles, moments, tails, intervals, the bootstrap, linear systems.
//!
//! ```
//! use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize, TimeWindow};
//!
//! let event = |ms: i64, x| Event { t: Micros(1_000 * ms), x, y: 90, polarity: Polarity::On };
//! let stream = EventStream::from_events(SensorSize::DAVIS240C, (0..100).map(|ms| event(ms, 7)))?;
//!
//! // The 30 ms before 60 ms; windows are half-open.
//! let window = TimeWindow { start: Micros(30_000), end: Micros(60_000) };
//! let events = stream.slice(window);
//! assert_eq!(events.len(), 30);
//! assert_eq!(events.t().first(), Some(&Micros(30_000)));
//!
//! // Order and bounds are checked.
//! let outside = EventStream::from_events(SensorSize::DAVIS240C, [event(0, 240)]);
//! assert!(outside.is_err());
//! # Ok::<(), evpose_core::CoreError>(())
//! ```

mod camera;
mod error;
mod event;
mod noise;
mod output;
mod parameter;
mod plane;
mod registry;
pub mod stats;
mod stream;
mod text;
mod time;

pub use camera::{Distortion, LensCamera, LensError, LookAt, Pinhole, PlacedCamera, ViewingRay};
pub use error::CoreError;
pub use event::{Event, Polarity, SensorSize};
pub use noise::{CounterRng, StageNoise, seed_for};
pub use output::{
    AtomicFile, atomic_write, is_same_file, remove_abandoned_files, temporary_target,
};
pub use parameter::{
    FileSpec, Given, NumberKind, NumberSpec, Parameter, ParameterError, Scale, Setting, Settings,
    TextSpec, WordSpec,
};
pub use plane::Plane;
pub use registry::{Registry, RegistryEntry, RegistryError};
pub use stream::{EventStream, EventStreamBuilder, Rejected};
pub use text::{BOM, bytes_without_bom, without_bom};
pub use time::{Micros, TimeWindow};
