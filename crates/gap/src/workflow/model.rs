//! The sensor model of a comparison, and its reference: the sensor without noise and delays.

use crate::common_parameter::CommonParameter;
use crate::common_parameter::CommonParameter::{
    DarkOffset, NoiseOff, NoiseOn, ThresholdMismatch, ThresholdOff, ThresholdOn,
};
use crate::recording_mark::RecordingMark;
use evpose_core::Micros;
use evpose_sensor::{Compares, Domain, EffectConfig, STAGES, SensorConfig, Stage, StageSpec};

use crate::input::Nominal;
use crate::search_spec::Searched;

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

/// Prepares a model for a comparison, with the nominal values of a recording
/// in the place of its own.
pub fn prepared(model: &SensorConfig, nominal: Option<&Nominal>) -> Model {
    let mut config = model.clone();
    let mut notes = Vec::new();
    if !replaces(&config, DarkOffset) {
        let floor = value(&config, DarkOffset).unwrap_or(DARK_FLOOR);
        if floor > USUAL_FLOOR {
            notes.push(format!(
                "the dark offset of the model, {floor} of white, is taken for a numerical floor: \
                 {DARK_FLOOR} is used"
            ));
        }
        set_value(&mut config, DarkOffset, floor.min(DARK_FLOOR));
    }
    let has_levels = !replaces(&config, ThresholdOn);
    if has_levels {
        for threshold in [ThresholdOn, ThresholdOff] {
            if value(&config, threshold).is_none() {
                set_value(&mut config, threshold, THRESHOLD);
            }
        }
    }
    let mut set = |parameter: CommonParameter, nominal: Option<f64>| {
        let Some(nominal) = nominal else { return };
        let given = value(&config, parameter).unwrap_or(0.0);
        if given != nominal {
            let (owner, key) = parameter.place();
            let name = owner.name;
            notes
                .push(format!("{name}.{key} is {nominal} as nominal, not {given} as in the model"));
            set_value(&mut config, parameter, nominal);
        }
    };
    let nominal = nominal.copied().unwrap_or_default();
    if has_levels {
        set(ThresholdOn, nominal.threshold_on);
        set(ThresholdOff, nominal.threshold_off);
        set(ThresholdMismatch, nominal.threshold_sigma);
    }
    set(NoiseOn, nominal.noise_on_hz);
    set(NoiseOff, nominal.noise_off_hz);
    // Noise and mismatch of zero are dropped, so that they are candidates of the search.
    for (owner, _) in [NoiseOn.place(), ThresholdMismatch.place()] {
        let is_zero = |effect: &EffectConfig, key| effect.number(key).unwrap_or(0.0) == 0.0;
        let is_idle = |effect: &EffectConfig| {
            owner.search().common.iter().all(|(_, key)| is_zero(effect, key))
        };
        config.effects.retain(|effect| effect.name != owner.name || !is_idle(effect));
    }
    // Light and thresholds alone: all else is what is searched for.
    let mut reference = SensorConfig { effects: Vec::new() };
    set_value(&mut reference, DarkOffset, DARK_FLOOR);
    for threshold in [ThresholdOn, ThresholdOff] {
        set_value(&mut reference, threshold, value(&config, threshold).unwrap_or(THRESHOLD));
    }
    Model { config, reference, notes }
}

/// Whether a model has another stage in the place of the one that owns a parameter: another law of
/// the photoreceptor, for which a detector that sees light itself counts as well, or another
/// detector.
fn replaces(model: &SensorConfig, parameter: CommonParameter) -> bool {
    let (owner, _) = parameter.place();
    let is_other = |spec: &&'static StageSpec| {
        // Asked of the stage itself, so that stages that other crates register count as well.
        let Ok(stage) = spec.typical_stage() else { return false };
        spec.name != owner.name
            && match owner.domain {
                Domain::Photoreceptor => match stage {
                    Stage::Photoreceptor(_) => true,
                    Stage::Detector(detector) => detector.traits().compares == Compares::Light,
                    _ => false,
                },
                _ => matches!(stage, Stage::Detector(_)),
            }
    };
    model.effects.iter().filter_map(|effect| STAGES.find(&effect.name)).any(|spec| is_other(&spec))
}

/// `model` with the period of a file format's time stamps: a format that counts milliseconds is no
/// effect of the camera.
pub fn with_stamp_period(model: &SensorConfig, tick: Micros) -> SensorConfig {
    let mut model = model.clone();
    let grid = RecordingMark::TimeGrid.effect().name;
    if tick > Micros(1) && model.effect(grid).is_none() {
        model.effects.push(EffectConfig::new(grid).with("period_us", tick.0 as f64));
    }
    model
}

fn value(config: &SensorConfig, parameter: CommonParameter) -> Option<f64> {
    let (owner, key) = parameter.place();
    config.effect(owner.name).and_then(|effect| effect.number(key))
}

fn set_value(config: &mut SensorConfig, parameter: CommonParameter, value: f64) {
    let (owner, key) = parameter.place();
    if config.effect(owner.name).is_none() {
        config.insert(EffectConfig::new(owner.name));
    }
    for listed in config.effects.iter_mut().filter(|listed| listed.name == owner.name) {
        *listed = listed.clone().with(key, value);
    }
}
