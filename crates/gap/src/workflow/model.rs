//! The sensor model of a comparison, and its reference: the sensor without noise and delays.

use evpose_core::Micros;
use evpose_sensor::{EffectConfig, SensorConfig};

use crate::input::Nominal;

/// Numerical floor of the logarithm, relative to white. A larger one is dark current, an effect of
/// its own.
const DARK_FLOOR: f64 = 1e-5;
/// Largest floor that is replaced without a note.
const USUAL_FLOOR: f64 = 1e-3;
/// Threshold of a model without one, ln.
const THRESHOLD: f64 = 0.2;

/// A sensor model, ready to be compared.
#[derive(Debug, Clone)]
pub struct Model {
    /// The model with the nominal values of the recording.
    pub config: SensorConfig,
    /// Logarithm and thresholds alone: without noise, without delay.
    pub reference: SensorConfig,
    /// Changes, a line each.
    pub notes: Vec<String>,
}

/// Stages that replace the logarithm, and those that replace level crossing.
const RECEPTORS: [&str; 2] = ["lin_log", "brownian_passage"];
const DETECTORS: [&str; 3] = ["frame_difference", "frame_count", "brownian_passage"];

/// Prepares a model for a comparison, with the nominal values of a recording in the place of its
/// own.
pub fn prepared(model: &SensorConfig, nominal: Option<&Nominal>) -> Model {
    let mut config = model.clone();
    let mut notes = Vec::new();
    let has = |config: &SensorConfig, names: &[&str]| {
        names.iter().any(|name| config.effect(name).is_some())
    };
    if !has(&config, &RECEPTORS) {
        let floor = value(&config, "logarithmic", "dark_offset").unwrap_or(DARK_FLOOR);
        if floor > USUAL_FLOOR {
            notes.push(format!(
                "the dark offset of the model, {floor} of white, is taken for a numerical floor: \
                 {DARK_FLOOR} is used"
            ));
        }
        set_value(&mut config, "logarithmic", "dark_offset", floor.min(DARK_FLOOR));
    }
    let has_levels = !has(&config, &DETECTORS);
    if has_levels {
        for key in ["threshold_on", "threshold_off"] {
            if value(&config, "level_crossing", key).is_none() {
                set_value(&mut config, "level_crossing", key, THRESHOLD);
            }
        }
    }
    let mut set = |name: &str, key: &str, nominal: Option<f64>| {
        let Some(nominal) = nominal else { return };
        let given = value(&config, name, key).unwrap_or(0.0);
        if given != nominal {
            notes
                .push(format!("{name}.{key} is {nominal} as nominal, not {given} as in the model"));
            set_value(&mut config, name, key, nominal);
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
    // Noise and mismatch of zero are dropped, so that they are candidates of the search.
    let is_idle = |effect: &EffectConfig, keys: &[&str]| {
        keys.iter().all(|key| effect.number(key).unwrap_or(0.0) == 0.0)
    };
    config.effects.retain(|effect| match effect.name.as_str() {
        "uniform_noise" => !is_idle(effect, &["on_hz", "off_hz"]),
        "threshold_mismatch" => !is_idle(effect, &["sigma"]),
        _ => true,
    });
    let threshold = |key| value(&config, "level_crossing", key).unwrap_or(THRESHOLD);
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

/// `model` with the period of a file format's time stamps: a format that counts milliseconds is no
/// effect of the camera.
pub fn with_stamp_period(model: &SensorConfig, tick: Micros) -> SensorConfig {
    let mut model = model.clone();
    if tick > Micros(1) && model.effect("timestamp_quantisation").is_none() {
        set_value(&mut model, "timestamp_quantisation", "period_us", tick.0 as f64);
    }
    model
}

fn value(config: &SensorConfig, effect: &str, key: &str) -> Option<f64> {
    config.effect(effect).and_then(|effect| effect.number(key))
}

fn set_value(config: &mut SensorConfig, effect: &str, key: &str, value: f64) {
    if config.effect(effect).is_none() {
        config.effects.push(EffectConfig::new(effect));
    }
    for listed in config.effects.iter_mut().filter(|listed| listed.name == effect) {
        *listed = listed.clone().with(key, value);
    }
}
