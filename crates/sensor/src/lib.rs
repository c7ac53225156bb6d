//! The event camera as a chain of physical stages.
//!
//! A [`SensorConfig`] lists effects; [`SensorModel`] places them in the order of the signal;
//! a [`SensorRun`] turns luminance into events:
//!
//! ```text
//! luminance (linear, relative to white)
//!   OPTICS         lens
//!   PHOTODIODE     irradiance to photocurrent
//!   PHOTORECEPTOR  photocurrent to log voltage
//!   DETECTOR       log voltage to requests, at exact times
//!   BACKGROUND     requests without a cause in the light
//!   READOUT        requests to events
//!   CLOCK          times to timestamps
//! events
//! ```
//!
//! ```
//! use evpose_core::{Micros, Plane, SensorSize};
//! use evpose_sensor::{SensorConfig, SensorModel};
//!
//! let model = SensorModel::from_config(&SensorConfig::preset("ideal")?)?;
//! let size = SensorSize { width: 4, height: 3 };
//! let mut run = model.start(size, 1);
//! run.expose(&Plane::for_sensor(size, 0.2), Micros(0))?;
//! let events = run.expose(&Plane::for_sensor(size, 0.3), Micros(1_000))?;
//! // ln(0.301 / 0.201) = 0.40: two thresholds of 0.2 in each of twelve pixels.
//! assert_eq!(events.len(), 24);
//! # Ok::<(), evpose_sensor::SensorError>(())
//! ```
//!
//! # A new effect
//! is one file in the folder of its domain, with its formula, its source, its tests and its
//! [`StageSpec`], and one line in the registry, [`STAGES`]. Configurations, tables and the laws
//! that hold for all stages then know it.
//!
//! # Time
//! Exposures and events are stamped in whole microseconds; between them all times are `f64`
//! seconds.

mod background;
mod blur;
mod chain;
mod chain_table;
mod changes;
mod clock;
mod config;
mod delivery;
mod detector;
mod effect;
mod error;
mod explain;
mod exponential;
mod formula;
mod front;
mod front_band;
mod gaussian;
mod linear_optics;
mod map;
mod model;
mod names;
mod natural_log;
mod optics;
mod photodiode;
mod photoreceptor;
mod plan;
mod preset;
mod readout;
mod registry;
mod request;
mod run;
mod signature;
mod spec;
mod stage;
mod stamped;
mod strength_level;
mod tap;
#[cfg(test)]
mod testing;
mod tick;
mod traits;

pub use background::BackgroundStage;
pub use chain_table::{ChainRow, ChainTable};
pub use clock::ClockStage;
pub use config::SensorConfig;
pub use detector::{
    Change, ChangeDetector, NoiseEvent, PixelStep, PixelTerm, PixelTraits, Recovery, TermTable,
};
pub use effect::{EffectConfig, Value};
pub use error::SensorError;
pub use formula::{Formula, FormulaFault, formula_curve};
pub use linear_optics::LinearOptics;
pub use map::MapFault;
pub use model::SensorModel;
pub use names::nearest;
pub use optics::AdaptiveSteps;
pub use photoreceptor::Photoreceptor;
pub use preset::{PRESETS, Preset};
pub use readout::{Readout, RowTimes, Waiting};
pub use registry::STAGES;
pub use request::{Origin, Request};
pub use run::SensorRun;
pub use signature::{Probe, Signature, Strength};
pub use spec::{Citation, Domain, StageSpec};
pub(crate) use spec::{LINEAR_OFF_AT_ZERO, LOG_OFF_AT_ZERO};
pub use stage::{Block, PixelStage, PlaneStage, Stage, State};
pub use strength_level::StrengthLevel;
pub use tap::Tap;
pub use tick::Tick;
pub use traits::{ActsOn, Compares, Traits};

pub use evpose_core::{
    FileSpec, NumberSpec, Parameter, ParameterError, Scale, Setting, Settings, TextSpec, WordSpec,
};
