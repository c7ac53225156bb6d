//! Completeness of the registry and of the presets.

use evpose_sensor::{
    EffectConfig, PRESETS, Parameter, STAGES, SensorConfig, SensorModel, Strength, WordSpec,
};

#[test]
fn every_effect_has_formula_source_and_signature() {
    for spec in &STAGES {
        let name = spec.name;
        for text in
            [spec.summary, spec.formula, spec.source.key, spec.source.text, spec.signature.look_for]
        {
            assert!(!text.trim().is_empty() && text == text.trim(), "{name}: {text:?}");
        }
        // Authors or a standard, and a year.
        assert!(spec.source.key.contains(|c: char| c.is_ascii_digit()), "{name}");
        assert!(spec.source.text.len() > spec.source.key.len(), "{name}");
        assert!(STAGES.iter().filter(|other| other.name == name).count() == 1, "{name}");
    }
}

#[test]
fn every_parameter_has_unit_range_prior_and_meaning() {
    // Dimensionless values are ratios, exponents and counts.
    for spec in &STAGES {
        for param in spec.params {
            assert!(!param.doc().is_empty(), "{}.{}", spec.name, param.name());
            assert!(param.as_file().is_none_or(|file| !file.unit.is_empty()), "{}", spec.name);
            if let Some(WordSpec { allowed, default, .. }) = param.as_word() {
                let has_default = default.is_some_and(|word| allowed.contains(&word));
                assert!(allowed.len() >= 2 && has_default, "{}.{}", spec.name, param.name());
            }
        }
        for param in spec.number_params() {
            let name = format!("{}.{}", spec.name, param.name);
            let (low, high) = param.range;
            assert!(low < high && low.is_finite() && high.is_finite(), "{name}");
            if let Some((from, to)) = param.typical {
                assert!(low <= from && from < to && to <= high, "{name}: {from} to {to}");
            }
            let suffix = param.name.rsplit_once('_').map_or("", |(_, suffix)| suffix);
            for unit in ["Hz", "us", "px", "s", "ns", "deg"] {
                assert!(suffix != unit.to_lowercase() || param.unit == unit, "{name}");
            }
        }
    }
}

#[test]
fn an_effect_is_off_where_neither_its_strength_nor_what_acts_alone_is_given() {
    let effect = |name: &str, values: &[(&str, f64)]| {
        values.iter().fold(EffectConfig::new(name), |effect, (key, value)| effect.with(key, *value))
    };
    for (effect, is_active) in [
        (effect("lens_distortion", &[("focal_px", 300.0)]), false),
        (effect("lens_distortion", &[("focal_px", 300.0), ("k2", 0.05)]), true),
        (effect("clock_offset_drift", &[("offset_us", 5.0)]), true),
        (effect("reset_overshoot", &[("to_exposure", 0.5)]), true),
        (effect("threshold_mismatch", &[("correlation", 0.5)]), false),
        (effect("fixed_pattern", &[]), false),
    ] {
        let config = SensorConfig { effects: vec![effect.clone()] };
        let model = SensorModel::from_config(&config).unwrap();
        let row = model.describe().rows.iter().find(|row| row.spec.name == effect.name);
        assert_eq!(row.unwrap().is_active, is_active, "{effect:?}");
    }
}

/// A quantity without a neutral value is one that the effect cannot do without.
#[test]
fn every_effect_can_be_switched_off_or_takes_a_place() {
    for spec in &STAGES {
        let model = SensorModel::from_config(&SensorConfig { effects: vec![spec.typical()] });
        assert!(model.is_ok(), "{}", spec.name);
        let has_neutral = spec.number_params().any(|param| param.default.is_some());
        if has_neutral || spec.params.iter().any(|param| param.as_file().is_some()) {
            continue;
        }
        let stage = spec.typical_stage().unwrap();
        assert!(stage.role().is_some(), "{} can only be left out", spec.name);
    }
}

#[test]
fn strengths_name_parameters_of_their_effect() {
    for spec in &STAGES {
        let (Strength::Rising(names) | Strength::RisingAlone(names) | Strength::Falling(names)) =
            spec.signature.strength
        else {
            // Files and texts may have values that complete them.
            let says = |p: &Parameter| p.as_file().is_some() || p.as_text().is_some();
            let is_said = spec.params.iter().any(says);
            assert!(is_said || spec.number_params().count() == 0, "{}", spec.name);
            continue;
        };
        assert!(!names.is_empty(), "{}", spec.name);
        for name in names {
            assert!(spec.number_params().any(|param| param.name == *name), "{}", spec.name);
        }
    }
}

/// A number is followed back to a publication, a data sheet or a program, right above it or in the
/// head of the file where all numbers have one source.
#[test]
fn every_number_of_a_preset_says_where_it_comes_from() {
    for preset in &PRESETS {
        let origin = preset.origin();
        assert!(origin.contains("20"), "{}: no year in {origin}", preset.name);
        let words = preset.toml.to_lowercase();
        assert!(!words.contains("# typical"), "{}: typical of what?", preset.name);
        let mut has_comment = false;
        for line in preset.toml.lines() {
            if line.starts_with("[[effect]]") {
                has_comment = false;
            } else if line.starts_with('#') {
                has_comment = true;
            } else if line.contains('=') && !line.starts_with("name") {
                assert!(has_comment, "{}: {line}", preset.name);
            }
        }
    }
}
