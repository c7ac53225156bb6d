//! Ranges of the numeric fields of configs, by their dotted names.
//!
//! Bounds of memory and of meaning; what fields have to do with each other is checked by the configs.

use serde::Serialize;
use toml::Value;

use crate::TaskError;

/// Range of fields without another: nothing that is configured is larger.
const USUAL: [f64; 2] = [-1e6, 1e6];
/// Variances and weights, which are positive.
const POSITIVE: [f64; 2] = [1e-30, 1e30];
const NOT_NEGATIVE: [f64; 2] = [0.0, 1e6];
const SHARE: [f64; 2] = [0.0, 1.0];
const STEPS: [f64; 2] = [1.0, 1e9];
/// A sensor checks its own parameters.
const SENSOR: &str = "simulation.sensor";

/// Fields, or the ends of their names, with their least and greatest values. Of arrays, every element.
const RANGES: [(&str, [f64; 2]); 67] = [
    ("seed", [0.0, i64::MAX as f64]),
    ("simulation.sequences", [1.0, 1e6]),
    ("evaluation.sequences", [1.0, 1e6]),
    ("seconds", [1e-3, 1e6]),
    ("simulation.step_hz", [1.0, 1e6]),
    ("simulation.label_hz", [1.0, 1e6]),
    // Event cameras have at most 1280 columns. Those of hands may be larger before they are scaled.
    ("simulation.sensor_size.width", [1.0, 4096.0]),
    ("simulation.sensor_size.height", [1.0, 4096.0]),
    ("simulation.camera_pose.roll_deg", [-360.0, 360.0]),
    ("simulation.camera_pose.orbit_deg", [-360.0, 360.0]),
    ("simulation.camera_pose.distance", [0.01, 100.0]),
    ("simulation.shape_range", [0.0, 10.0]),
    ("simulation.light_level", [0.0, 1e4]),
    ("simulation.threshold_sd", [0.0, 1.0]),
    ("simulation.camera_turn_deg", [0.0, 360.0]),
    ("simulation.backgrounds.source.procedural", [1.0, 256.0]),
    ("simulation.backgrounds.scale", [0.1, 4.0]),
    ("simulation.backgrounds.offset", SHARE),
    ("simulation.backgrounds.gamma", [0.1, 10.0]),
    ("simulation.surroundings.source.procedural", [1.0, 256.0]),
    ("simulation.surroundings.gamma", [0.1, 10.0]),
    ("simulation.surroundings.distractors", [0.0, 256.0]),
    ("simulation.skin.variation_sd", [0.0, 100.0]),
    ("simulation.skin.sleeves", SHARE),
    ("simulation.skin.gloves", SHARE),
    ("simulation.skin.rings", SHARE),
    ("simulation.frame.levels", [0.0, 65_536.0]),
    ("representation.window_ms", [1.0, 60_000.0]),
    ("shortest_frames", [1.0, 60_000.0]),
    ("longest_frames", [1.0, 60_000.0]),
    ("tau_ms", [1e-3, 1e6]),
    ("network.width", [1e-3, 8.0]),
    ("network.expansion", [1.0, 32.0]),
    ("network.joints", [1.0, 256.0]),
    ("network.stages", [1.0, 32.0]),
    ("image.side_px", [32.0, 1024.0]),
    ("image.width_px", [1.0, 2048.0]),
    ("image.height_px", [1.0, 2048.0]),
    ("decoding.confidence", SHARE),
    ("data.stills", [1.0, 1e7]),
    ("data.every_ms", [1.0, 1e6]),
    ("evaluation.every_ms", [1.0, 1e6]),
    ("mean_of", [1.0, 1e7]),
    ("training.batch_size", [1.0, 4096.0]),
    ("training.devices", [1.0, 64.0]),
    ("training.learning_rate", POSITIVE),
    ("training.steps", [0.0, 1e9]),
    ("training.steps_per_validation", STEPS),
    ("training.validation_samples", [1.0, 1e7]),
    ("training.schedule.warm_up_steps", [0.0, 1e9]),
    // The loss of hands is divided by these, that of bodies multiplied.
    ("loss.articulation", POSITIVE),
    ("loss.translation_m2", POSITIVE),
    ("loss.rotation_rad2", POSITIVE),
    ("loss.heatmap", NOT_NEGATIVE),
    ("loss.bone", NOT_NEGATIVE),
    ("loss.center", NOT_NEGATIVE),
    ("loss.regs", NOT_NEGATIVE),
    ("loss.offsets", NOT_NEGATIVE),
    ("slow_motion.batch_inputs", [1.0, 1024.0]),
    ("rest_sum", [0.0, 1e12]),
    ("innovation_limit", [0.0, 1e12]),
    ("acceleration_variance", POSITIVE),
    ("measurement_variance", POSITIVE),
    ("acceleration", POSITIVE),
    ("measurement", POSITIVE),
    ("bootstrap.seed", [0.0, i64::MAX as f64]),
    ("bootstrap.resamples", NOT_NEGATIVE),
];

/// Checks every number of a config, sections of sensors left out.
///
/// # Errors
/// [`TaskError::Range`] of the first that is outside of its range, or is none.
pub(crate) fn check_ranges(config: &impl Serialize) -> Result<(), TaskError> {
    let value = Value::try_from(config)
        .map_err(|error| TaskError::Config { path: "config".into(), message: error.to_string() })?;
    check("", &value)
}

fn check(field: &str, value: &Value) -> Result<(), TaskError> {
    let number = match value {
        Value::Integer(number) => *number as f64,
        Value::Float(number) => *number,
        Value::Array(values) => return values.iter().try_for_each(|value| check(field, value)),
        Value::Table(table) => {
            return table.iter().try_for_each(|(name, value)| {
                let inner = if field.is_empty() { name.clone() } else { format!("{field}.{name}") };
                if inner == SENSOR { Ok(()) } else { check(&inner, value) }
            });
        }
        _ => return Ok(()),
    };
    let [min, max] = range_of(field);
    // Within, so that NaN is refused.
    if (min..=max).contains(&number) {
        return Ok(());
    }
    Err(TaskError::Range { field: field.to_owned(), value: number, min, max })
}

fn range_of(field: &str) -> [f64; 2] {
    let ends = |name: &str| {
        field.strip_suffix(name).is_some_and(|rest| rest.is_empty() || rest.ends_with('.'))
    };
    RANGES.iter().find(|(name, _)| ends(name)).map_or(USUAL, |(_, range)| *range)
}
