//! Every value of every config replaced by values that it should not have.

use evpose_configs::FILES;
use evpose_task::baseline::BaselineConfig;
use evpose_task::body::BodyConfig;
use evpose_task::hand::HandConfig;
use evpose_task::{Experiment, TaskError};
use toml::Value;

use crate::harness::Sandbox;

/// Ends of the names of values that may be as large as an integer can be: nothing is counted or allocated by them.
const WIDE: [&str; 8] = [
    // Any seed is one.
    "seed",
    // A training that diverges ends by its loss, whatever the rate was.
    "learning_rate",
    // Only ratios of variances count.
    "_variance",
    "acceleration",
    "measurement",
    // The loss of hands is divided by these.
    "loss.articulation",
    "loss.translation_m2",
    "loss.rotation_rad2",
];

/// Ends of the names of floats that may be negative. Nothing else can be: counts, lengths, durations, rates, shares.
const SIGNED: [&str; 8] = [
    // Places and directions in the world, and angles.
    "camera.eye_m",
    "camera.centre_m",
    "camera.up",
    "_deg",
    // Bounds of coefficients that vary about 0.
    "motion.articulation_low",
    "motion.articulation_high",
    // Shifts and levels, relative to what is there.
    "augmentation.affine",
    "augmentation.brightness",
];

/// Places of the numeric values of a value: keys, and indices of arrays.
fn places(value: &Value, at: &[String]) -> Vec<Vec<String>> {
    let inner = |(key, value): (String, &Value)| places(value, &[at, &[key]].concat());
    match value {
        Value::Integer(_) | Value::Float(_) => vec![at.to_vec()],
        Value::Table(table) => table.iter().flat_map(|(key, v)| inner((key.clone(), v))).collect(),
        Value::Array(values) => {
            values.iter().enumerate().flat_map(|(i, v)| inner((i.to_string(), v))).collect()
        }
        _ => Vec::new(),
    }
}

fn at<'a>(value: &'a mut Value, place: &[String]) -> &'a mut Value {
    place.iter().fold(value, |value, key| match value {
        Value::Array(values) => &mut values[key.parse::<usize>().unwrap()],
        table => &mut table[key.as_str()],
    })
}

/// Checks a config whose text is complete; returns the count of its numeric values.
fn check<C: Experiment>(name: &str, text: &str) -> usize {
    let whole: Value = Value::Table(toml::from_str(text).unwrap());
    let places = places(&whole, &[]);
    for place in &places {
        let bad = [
            Value::Integer(-1),
            Value::Integer(0),
            Value::Float(-1.0),
            Value::Float(0.0),
            Value::Float(f64::NAN),
            Value::Float(f64::INFINITY),
            Value::Float(1e308),
            Value::Integer(i64::MAX),
        ];
        let names: Vec<&str> =
            place.iter().map(String::as_str).filter(|key| key.parse::<usize>().is_err()).collect();
        let field = names.join(".");
        let ends = |names: &[&str]| names.iter().any(|end| field.ends_with(end));
        let is_wide = ends(&WIDE);
        let is_signed = ends(&SIGNED);
        for value in bad {
            let is_small = [0.0, -1.0].contains(&value.as_float().unwrap_or(-1.0))
                && value.as_integer().is_none_or(|value| value < 1);
            let is_negative = value.as_float() == Some(-1.0) || value.as_integer() == Some(-1);
            let mut changed = whole.clone();
            *at(&mut changed, place) = value.clone();
            let checked = C::parse(&toml::to_string(&changed).unwrap(), &[]);
            // A value is taken only where zero, a sign or a huge count has a meaning.
            match checked {
                Ok(_) => assert!(
                    is_small && (is_signed || !is_negative)
                        || (value == Value::Integer(i64::MAX) && is_wide),
                    "{name}: {field} = {value} is taken"
                ),
                Err(error) => {
                    let message = error.to_string();
                    // The field, or the section of it, by a name of more than one letter.
                    let named = names.iter().any(|name| message.contains(name));
                    assert!(named, "{name}: {field} = {value}: {message}");
                }
            }
        }
    }
    places.len()
}

/// The embedded config of a name, defaults filled in.
fn resolved<C: Experiment>(text: &str) -> String {
    C::parse(text, &[]).and_then(|config| config.to_toml()).unwrap()
}

#[test]
fn every_number_of_every_config_has_a_range() {
    let mut count = 0;
    for (path, text) in FILES {
        count += match path.split_once('/') {
            Some(("hand", _)) => check::<HandConfig>(path, &resolved::<HandConfig>(text)),
            Some(("body", _)) => check::<BodyConfig>(path, &resolved::<BodyConfig>(text)),
            _ => 0,
        };
    }
    for config in [BaselineConfig::dhp19_cnn(), BaselineConfig::lift_mono()] {
        count += check::<BaselineConfig>("baseline", &config.to_toml().unwrap());
    }
    assert!(count > 900, "{count} values");
}

/// Each made NaN, panicked or aborted once.
#[test]
fn what_made_labels_without_a_number_is_refused_by_name() {
    for (change, field) in [
        ("simulation.camera_pose.distance=0.0", "simulation.camera_pose.distance"),
        ("simulation.camera_pose.distance=nan", "simulation.camera_pose.distance"),
        ("simulation.camera_pose.roll_deg=nan", "simulation.camera_pose.roll_deg"),
        ("filter.kalman.measurement_variance=nan", "filter.kalman.measurement_variance"),
        ("simulation.skin.texels=5", "simulation.skin.texels"),
        ("simulation.shape_range=nan", "simulation.shape_range"),
        ("training.batch_size=4294967296", "training.batch_size"),
        ("training.batch_size=9223372036854775807", "training.batch_size"),
    ] {
        let error = HandConfig::parse("task = \"hand\"", &[change.to_owned()]).unwrap_err();
        let (TaskError::Range { .. } | TaskError::Simulation(_)) = &error else {
            panic!("{error}")
        };
        assert!(error.to_string().contains(field), "{change}: {error}");
    }
}

#[test]
fn an_error_in_a_line_of_a_megabyte_is_short() {
    let sandbox = Sandbox::new();
    let line = format!("task = \"hand\"\ntraining = {{ steps = {}x }}\n", "1".repeat(1 << 20));
    sandbox.write("long.toml", line);
    let message = sandbox.fails(&["simulate", "long.toml", "--out", "data"]);
    assert!(message.len() < 2_000 && message.contains("long.toml"), "{} bytes", message.len());
}
