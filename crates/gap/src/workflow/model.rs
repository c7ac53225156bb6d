//! The model that is compared, and the reference that probes take times and places from.

use evpose_core::Micros;
use evpose_sensor::{EffectConfig, SensorConfig};

use crate::input::Nominal;

/// Light that is added before the logarithm, of white: a numerical floor. Where it is more it is
/// dark current, which has a name of its own.
const DARK_FLOOR: f64 = 1e-5;
/// The same in the ideal sensor, which is no reason for a note.
const USUAL_FLOOR: f64 = 1e-3;
/// Threshold of a model that says nothing of it, ln.
const THRESHOLD: f64 = 0.2;

/// A sensor model, ready to be compared.
#[derive(Debug, Clone)]
pub struct Model {
    /// The model with what the maker of the recording says.
    pub config: SensorConfig,
    /// Logarithm and thresholds alone: without noise, without delay.
    pub reference: SensorConfig,
    /// What was changed, a line each.
    pub notes: Vec<String>,
}

/// Stages that take the place of the logarithm, and of the crossing of levels.
const RECEPTORS: [&str; 2] = ["lin_log", "brownian_passage"];
const DETECTORS: [&str; 3] = ["frame_difference", "frame_count", "brownian_passage"];

/// `model` with the nominal values of a recording in the place of its own.
pub fn prepared(model: &SensorConfig, nominal: Option<&Nominal>) -> Model {
    let mut config = model.clone();
    let mut notes = Vec::new();
    let has = |config: &SensorConfig, names: &[&str]| {
        names.iter().any(|name| config.effect(name).is_some())
    };
    if !has(&config, &RECEPTORS) {
        let floor = number(&config, "logarithmic", "dark_offset").unwrap_or(DARK_FLOOR);
        if floor > USUAL_FLOOR {
            notes.push(format!(
                "the dark offset of the model, {floor} of white, is taken for a numerical floor: \
                 {DARK_FLOOR} is used"
            ));
        }
        put(&mut config, "logarithmic", "dark_offset", floor.min(DARK_FLOOR));
    }
    let has_levels = !has(&config, &DETECTORS);
    if has_levels {
        for key in ["threshold_on", "threshold_off"] {
            if number(&config, "level_crossing", key).is_none() {
                put(&mut config, "level_crossing", key, THRESHOLD);
            }
        }
    }
    let mut set = |name: &str, key: &str, value: Option<f64>| {
        let Some(value) = value else { return };
        let had = number(&config, name, key).unwrap_or(0.0);
        if had != value {
            notes.push(format!("{name}.{key} is {value} as nominal, not {had} as in the model"));
            put(&mut config, name, key, value);
        }
    };
    let nominal = nominal.copied().unwrap_or_default();
    if has_levels {
        set("level_crossing", "threshold_on", nominal.threshold_on);
        set("level_crossing", "threshold_off", nominal.threshold_off);
        set("threshold_mismatch", "sigma", nominal.threshold_sigma);
    }
    set("uniform_noise", "on_hz", nominal.noise_on_hz);
    set("uniform_noise", "off_hz", nominal.noise_off_hz);
    // Without noise and spread there is nothing to simulate, and effects may still be found.
    let is_idle = |effect: &EffectConfig, keys: &[&str]| {
        keys.iter().all(|key| effect.number(key).unwrap_or(0.0) == 0.0)
    };
    config.effects.retain(|effect| match effect.name.as_str() {
        "uniform_noise" => !is_idle(effect, &["on_hz", "off_hz"]),
        "threshold_mismatch" => !is_idle(effect, &["sigma"]),
        _ => true,
    });
    let threshold = |key| number(&config, "level_crossing", key).unwrap_or(THRESHOLD);
    let reference = SensorConfig {
        effects: vec![
            EffectConfig::new("logarithmic").with("dark_offset", DARK_FLOOR),
            EffectConfig::new("level_crossing")
                .with("threshold_on", threshold("threshold_on"))
                .with("threshold_off", threshold("threshold_off")),
        ],
    };
    Model { config, reference, notes }
}

/// A model whose stamps count as those of a recording do: where a format has frames of a
/// millisecond, that is no effect of the camera.
pub fn stamped(model: &SensorConfig, tick: Micros) -> SensorConfig {
    let mut model = model.clone();
    if tick > Micros(1) && model.effect("timestamp_quantisation").is_none() {
        put(&mut model, "timestamp_quantisation", "period_us", tick.0 as f64);
    }
    model
}

fn number(config: &SensorConfig, effect: &str, key: &str) -> Option<f64> {
    config.effect(effect).and_then(|effect| effect.number(key))
}

fn put(config: &mut SensorConfig, effect: &str, key: &str, value: f64) {
    if config.effect(effect).is_none() {
        config.effects.push(EffectConfig::new(effect));
    }
    for listed in config.effects.iter_mut().filter(|listed| listed.name == effect) {
        *listed = listed.clone().with(key, value);
    }
}
