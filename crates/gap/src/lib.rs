//! Identification of the effects that a sensor model lacks, from a recording of a known scene.
//!
//! ```text
//! recording + scene + sensor model
//!   -> ReferenceScene   the scene, its classes, the events of the reference sensor
//!   -> Layout           summary statistics, the same of measured and of simulated events
//!   -> Objective        discrepancy of a model: deviations from its simulated runs
//!   -> Identification   parameters refitted first, then effects of the catalogue selected
//!   -> Verdict          no gap, a parameter, effects, none of the catalogue, undecided
//! ```
//!
//! A camera that leaks, compared with the ideal sensor model:
//!
//! ```
//! use evpose_core::Plane;
//! use evpose_gap::LightSequence;
//! use evpose_gap::verdict::Answer;
//! use evpose_gap::workflow::{ComparisonCase, HeldOut, Inputs, Prepared, prepared};
//! use evpose_sensor::{EffectConfig, STAGES, SensorConfig};
//!
//! // Bars that move over 24 x 16 pixels for half a second.
//! let plane = |k: u16| {
//!     let light = (0..24 * 16).map(|i| {
//!         let (x, y, t) = ((i % 24) as f32, (i / 24) as f32, f32::from(k) / 500.0);
//!         0.3 + 0.25 * (0.5 * x + 0.1 * y - 9.0 * t).sin()
//!     });
//!     Plane::from_vec(24, 16, light.collect())
//! };
//! let scene = LightSequence::new(500.0, (0..=250).map(plane).collect::<Result<_, _>>()?)?;
//! let mut camera = prepared(&SensorConfig::default(), None).config;
//! camera.effects.push(EffectConfig::new("leak_on").with("rate_hz", 3.0));
//!
//! // Every effect of the catalogue takes its time: here two are asked for.
//! let of_catalogue = STAGES.iter().map(|stage| stage.name.to_owned());
//! let left_out: Vec<String> =
//!     of_catalogue.filter(|name| !["leak_on", "refractory"].contains(&name.as_str())).collect();
//! let inputs = Inputs {
//!     train: ComparisonCase::new(&scene.events(&camera, 11)?, scene.clone())?,
//!     held_out: HeldOut::Later,
//!     model: SensorConfig::default(),
//!     nominal: None,
//!     left_out,
//!     seed: 3,
//!     is_quick: true,
//! };
//! let prepared = Prepared::new(inputs)?;
//! let splits = prepared.data_splits()?;
//! let result = splits.identify(&prepared.model.config, &prepared.left_out, &|_| {})?;
//! assert_eq!(result.answer, Answer::Effects);
//! assert_eq!(result.added_effects[0].name(), "leak_on");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod c2st;
pub mod camera;
pub mod candidate;
mod classes;
mod common_parameter;
pub mod compare;
pub mod davis;
mod discovery_rate;
mod entry;
mod error;
pub mod fit;
mod fourier;
pub mod free_parameter;
mod goodness;
pub mod input;
mod layout;
mod light_behind_optics;
mod light_sequence;
pub mod locate;
mod objective;
pub mod parameters;
pub mod probe;
mod recording_mark;
pub mod report;
pub mod run_files;
pub mod search;
mod search_spec;
mod simulate;
pub mod surrogate;
pub mod verdict;
mod view;
pub mod workflow;

pub use classes::{Cell, Classes};
pub use common_parameter::CommonParameter;
pub use compare::{Expectation, by_block, discrepancy, gap, rho, rho_of_chance};
pub use entry::{Entry, StatisticBlock, StatisticKind};
pub use error::GapError;
pub use layout::Layout;
pub use light_sequence::LightSequence;
pub use objective::Objective;
pub use search_spec::SceneSource;
pub use view::{EventFeatures, Expected, ReferenceScene, View};
