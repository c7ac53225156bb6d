//! Errors of configurations, chains and exposures.

use std::path::PathBuf;

use evpose_core::{CoreError, Micros, ParameterError, SensorSize};

use crate::names::hint;
use crate::{FormulaFault, MapFault};

/// A configuration that describes no sensor, or an exposure that a sensor cannot take.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SensorError {
    /// The text is not a list of effects.
    #[error("not a list of effects: {0}")]
    Toml(#[from] toml::de::Error),
    /// No preset has this name.
    #[error("unknown sensor preset `{name}`; there are: {}{}", allowed.join(", "), hint(name, allowed))]
    UnknownPreset {
        /// The name asked for.
        name: String,
        /// The names there are.
        allowed: Vec<&'static str>,
    },
    /// No stage has this name.
    #[error("unknown effect `{effect}`; there are: {}{}", allowed.join(", "), hint(effect, allowed))]
    UnknownEffect {
        /// The name in the configuration.
        effect: String,
        /// The names there are.
        allowed: Vec<&'static str>,
    },
    /// Events come faster than the model hands them out.
    #[error(
        "at {} s, {waiting} events wait for the readout or their delay: of less light, rarer noise or a faster readout \
         there are fewer, or give `max_wait_us`", *at_us as f64 * 1e-6
    )]
    Backlog {
        /// Number of events that wait.
        waiting: usize,
        /// Time of the exposure, microseconds.
        at_us: i64,
    },
    /// The list does not hold the effect that was to be changed.
    #[error("the list has no effect `{effect}`; it has: {}", listed.join(", "))]
    EffectNotListed {
        /// The effect asked for.
        effect: String,
        /// The effects of the list.
        listed: Vec<String>,
    },
    /// An effect is listed more than once.
    #[error("effect `{effect}` is listed twice; one entry holds all its parameters")]
    DuplicateEffect {
        /// Name of the effect.
        effect: &'static str,
    },
    /// Two effects claim a place that holds exactly one.
    #[error("`{first}` and `{second}` are both a {place}, of which a sensor has one")]
    PlaceTaken {
        /// Role that exactly one effect has.
        place: &'static str,
        /// The effect listed first.
        first: &'static str,
        /// The effect listed second.
        second: &'static str,
    },
    /// A parameter that the effect does not have, a value that one cannot take, or a missing one.
    #[error("{}", of_effect(effect, error))]
    Parameter {
        /// Name of the effect.
        effect: &'static str,
        /// Name of the parameter, and why it is refused.
        error: ParameterError,
    },
    /// A file of a stage cannot be used.
    #[error("effect `{effect}`: `{key}` = {}: {fault}", path.display())]
    Map {
        /// Name of the effect.
        effect: &'static str,
        /// The key in the configuration.
        key: &'static str,
        /// The file of the map.
        path: PathBuf,
        /// Reason why the file is refused.
        fault: MapFault,
    },
    /// The text of a formula is none.
    #[error("effect `formula`: `expression` = {text:?}, at the stage `{stage}`, {fault}")]
    Formula {
        /// Text of the formula.
        text: String,
        /// Stage that it was to act at.
        stage: &'static str,
        /// Place and reason of the fault.
        fault: FormulaFault,
    },
    /// A stage knows every pixel of a sensor of another size.
    #[error("effect `{effect}` is made for a {made_for} sensor, this one is {sensor}")]
    MadeForOther {
        /// Name of the effect.
        effect: &'static str,
        /// The size it knows.
        made_for: SensorSize,
        /// The sensor of the run.
        sensor: SensorSize,
    },
    /// A run can take new parameters, not another chain.
    #[error("a run of `{running}` cannot become `{given}`: only parameters can be retuned")]
    OtherChain {
        /// The stages of the run.
        running: String,
        /// The stages of the model given.
        given: String,
    },
    /// No stage of the chain with this name has a signal to look at.
    #[error("the chain has no signal behind `{stage}`; there is one behind: {}", known.join(", "))]
    NoSignal {
        /// The name asked for.
        stage: String,
        /// The stages that have one.
        known: Vec<&'static str>,
    },
    /// The sensor has no such pixel.
    #[error("pixel ({x}, {y}) is not on a {sensor} sensor")]
    OutsideSensor {
        /// Column.
        x: u16,
        /// Row.
        y: u16,
        /// Size of the sensor.
        sensor: SensorSize,
    },
    /// The luminance plane does not have the size of the sensor.
    #[error("a {width}x{height} plane was shown to a {sensor} sensor")]
    PlaneSize {
        /// Columns of the plane.
        width: usize,
        /// Rows of the plane.
        height: usize,
        /// Size of the sensor.
        sensor: SensorSize,
    },
    /// Exposures must follow each other in time.
    #[error("an exposure at {t} does not come after the one at {previous}")]
    NotLater {
        /// The time of the exposure.
        t: Micros,
        /// The time of the one before.
        previous: Micros,
    },
    /// The chain made events that are no stream: a fault of a stage.
    #[error("a stage made faulty events: {0}")]
    FaultyEvents(#[from] CoreError),
}

fn of_effect(effect: &str, error: &ParameterError) -> String {
    match error {
        ParameterError::UnknownKey { key, allowed } => {
            format!("effect `{effect}` {error}{}", hint(key, allowed))
        }
        ParameterError::BadValue { .. } => format!("effect `{effect}`: {error}"),
        ParameterError::MissingKey { .. } => format!("effect `{effect}` {error}"),
    }
}
