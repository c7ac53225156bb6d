use evpose_core::{Micros, Plane};
use evpose_sensor::{EffectConfig, SensorConfig};

use super::findings::evidenced_findings;
use super::*;
use crate::free_parameter::FreeParameter;
use crate::input::Nominal;
use crate::parameters::ModelParameter;
use crate::search::DataSplits;
use crate::verdict::Answer;
use crate::{LightSequence, ReferenceScene};

/// Bars that move over a dark ground, 24 x 16 pixels, 0.5 s.
fn scene(phase: f32) -> LightSequence {
    let plane = |k: u16| {
        let t = f32::from(k) / 500.0;
        let light = (0..24 * 16).map(|i| {
            let (x, y) = ((i % 24) as f32, (i / 24) as f32);
            0.3 + 0.25 * (0.5 * x + 0.1 * y - 9.0 * t + phase).sin()
        });
        Plane::from_vec(24, 16, light.collect()).unwrap()
    };
    LightSequence::new(500.0, (0..=250).map(plane).collect()).unwrap()
}

fn recording(scene: &LightSequence, model: &SensorConfig, seed: u64) -> ComparisonCase {
    let reference_scene =
        ReferenceScene::new(scene.clone(), &prepared(model, None).reference).unwrap();
    ComparisonCase::new(&reference_scene.simulate(model, seed).unwrap(), scene.clone()).unwrap()
}

fn inputs(hidden: &SensorConfig) -> Inputs {
    Inputs {
        train: recording(&scene(0.0), hidden, 11),
        held_out: HeldOut::Recording(recording(&scene(2.0), hidden, 12)),
        model: SensorConfig::default(),
        nominal: None,
        left_out: Vec::new(),
        seed: 3,
        is_quick: true,
    }
}

fn ideal() -> SensorConfig {
    prepared(&SensorConfig::default(), None).config
}

#[test]
fn nominal_values_take_the_place_of_those_of_the_model() {
    let nominal = Nominal {
        threshold_on: Some(0.3),
        threshold_sigma: Some(0.02),
        noise_on_hz: Some(0.5),
        noise_off_hz: Some(0.0),
        ..Nominal::default()
    };
    let model = prepared(&SensorConfig::default(), Some(&nominal));
    let value = |effect: &str, key| model.config.effect(effect).unwrap().number(key);
    assert_eq!(value("level_crossing", "threshold_on"), Some(0.3));
    assert_eq!(value("level_crossing", "threshold_off"), Some(0.2));
    assert_eq!(value("threshold_mismatch", "sigma"), Some(0.02));
    assert_eq!(value("uniform_noise", "on_hz"), Some(0.5));
    assert_eq!(value("logarithmic", "dark_offset"), Some(1e-5));
    assert_eq!(model.reference.effects.len(), 2);
    let quiet = Nominal { threshold_sigma: Some(0.0), ..Nominal::default() };
    let model = prepared(&SensorConfig::default(), Some(&quiet));
    assert!(model.config.effect("threshold_mismatch").is_none());
}

#[test]
fn a_model_without_levels_keeps_its_detector() {
    let config = SensorConfig {
        effects: vec![
            EffectConfig::new("frame_count").with("threshold_on", 0.3).with("threshold_off", 0.3),
        ],
    };
    assert!(prepared(&config, None).config.effect("level_crossing").is_none());
}

#[test]
fn the_only_recording_is_held_out_in_its_later_part() {
    let mut all = inputs(&ideal());
    all.held_out = HeldOut::Later;
    let prepared = Prepared::new(all).unwrap();
    let DataSplits { train, held_out, .. } = prepared.data_splits().unwrap();
    assert_eq!(train.window.end, held_out.window.start);
    assert_eq!(held_out.window.end, Micros(500_001));
    assert!(prepared.notes.iter().any(|note| note.contains("only recording")));
}

#[test]
fn a_recording_of_the_model_has_no_gap_and_is_no_surprise() {
    let prepared = Prepared::new(inputs(&ideal())).unwrap();
    let splits = prepared.data_splits().unwrap();
    let result = splits.identify(&prepared.model.config, &[], &|_| {}).unwrap();
    let outcome = outcome(&prepared, &splits, &result, &|_| {}).unwrap();
    assert_eq!(outcome.verdict.verdict, Answer::NoGap);
    assert!(outcome.verdict.effects.is_empty());
    assert!(outcome.verdict.p > 0.5, "{}", outcome.verdict.p);
    assert_eq!(outcome.corrected, prepared.model.config);
    let shown: Vec<&str> = outcome.verdict.limits.iter().map(|limit| limit.name.as_str()).collect();
    assert!(shown.contains(&"leak_on") && shown.contains(&"refractory"), "{shown:?}");
}

#[test]
fn a_run_of_a_model_without_noise_is_no_surprise_and_one_with_noise_is_like_its_replicates() {
    let scene = scene(0.0);
    let quiet = own_run(scene.clone(), &SensorConfig::default(), None, 19, 1).unwrap();
    assert!(quiet.p > 0.999 && quiet.events > 0, "{quiet:?}");
    let noisy = Nominal { noise_on_hz: Some(3.0), noise_off_hz: Some(2.0), ..Nominal::default() };
    let p =
        |seed| own_run(scene.clone(), &SensorConfig::default(), Some(&noisy), 19, seed).unwrap().p;
    let ps: Vec<f64> = (0..12).map(p).collect();
    // Multiples of one in twenty, of which twelve uniform ones have a mean of 0.53 +- 0.08.
    assert!(ps.iter().all(|p| (20.0 * p - (20.0 * p).round()).abs() < 1e-9), "{ps:?}");
    let mean = ps.iter().sum::<f64>() / 12.0;
    assert!((0.2..0.86).contains(&mean), "{ps:?}");
}

#[test]
fn evidence_of_an_effect_goes_with_its_finding() {
    let mut leaky = ideal();
    leaky.effects.push(EffectConfig::new("leak_on").with("rate_hz", 3.0));
    let prepared = Prepared::new(inputs(&leaky)).unwrap();
    let splits = prepared.data_splits().unwrap();
    let result = splits.identify(&prepared.model.config, &[], &|_| {}).unwrap();
    let all = evidenced_findings(&splits, &result).unwrap();
    let leak = all.iter().find(|one| one.finding.name == "leak_on").unwrap();
    let evidence = leak.evidence.unwrap();
    assert!(evidence.log_odds > 0.0, "{evidence:?}");
    assert_eq!(evidence.gap_after, result.after.gap);
    assert_eq!(leak.finding.probability, Some(CALIBRATION.probability(&evidence)));
    let mut of_answer = AnswerEvidence::new(&splits, &result, &all);
    assert_eq!(of_answer.effects["leak_on"], evidence);
    assert_eq!(of_answer.errors["leak_on"], leak.errors);
    assert_eq!(of_answer.contenders[0][0].0, "leak_on");
    assert_eq!(of_answer.events, splits.train.events.len());
    of_answer.restrict(&[]);
    assert!(of_answer.effects.is_empty() && of_answer.errors.is_empty());
    // The gap of a verdict is that of the search.
    let gap = gap_value(&splits.held_out, &result.after.model, 1).unwrap();
    assert_eq!(gap.value, result.after.gap);
    // The interval is what the constants make of the raw error.
    let (raw, quantity) = (leak.errors["rate_hz"], &leak.finding.parameters["rate_hz"]);
    let free = FreeParameter::by_name("leak_on", "rate_hz").unwrap();
    let half = 0.5 * free.steps(quantity.lo90, quantity.hi90);
    let error = CALIBRATION.error(ParameterOwner::OfEffect, raw.steps());
    assert!((half - 1.645 * error).abs() < 1e-6, "{half} {error}");
}

/// Events of a scene of little contrast are fewer than one over the threshold says.
#[test]
fn thresholds_that_are_far_off_are_parameters_with_their_values() {
    let mut dull = ideal();
    ModelParameter::ThresholdOn.set(&mut dull, 1.45 * ModelParameter::ThresholdOn.value(&ideal()));
    ModelParameter::ThresholdOff
        .set(&mut dull, 1.38 * ModelParameter::ThresholdOff.value(&ideal()));
    let prepared = Prepared::new(inputs(&dull)).unwrap();
    let splits = prepared.data_splits().unwrap();
    let result = splits.identify(&prepared.model.config, &[], &|_| {}).unwrap();
    assert_eq!(result.answer, Answer::Parameter);
    for parameter in [ModelParameter::ThresholdOn, ModelParameter::ThresholdOff] {
        let steps = parameter.steps(parameter.value(&dull), parameter.value(&result.after.model));
        assert!(steps.abs() < 0.5, "{parameter:?} is {steps} steps off");
    }
}

/// The lag of the pixels is no more than a millisecond; this is a clock.
#[test]
fn a_clock_that_is_off_is_a_parameter_with_its_offset() {
    let mut late = ideal();
    late.effects.push(EffectConfig::new("clock_offset_drift").with("offset_us", 4_000.0));
    let prepared = Prepared::new(inputs(&late)).unwrap();
    let splits = prepared.data_splits().unwrap();
    let result = splits.identify(&prepared.model.config, &[], &|_| {}).unwrap();
    assert_eq!(result.answer, Answer::Parameter);
    let found = findings_of_answer(&splits, &result).unwrap();
    let [offset] = found.as_slice() else { panic!("{found:?}") };
    assert_eq!(offset.name, "clock_offset");
    let value = offset.parameters["clock_offset"].value;
    assert!((value - 4_000.0).abs() < 200.0, "{value}");
}

/// Names of the findings for a camera with one more effect, and the value of its strength.
fn named(hidden: EffectConfig, strength: &str) -> (Vec<String>, f64) {
    let mut camera = ideal();
    let name = hidden.name.clone();
    camera.insert(hidden);
    let prepared = Prepared::new(inputs(&camera)).unwrap();
    let splits = prepared.data_splits().unwrap();
    let result = splits.identify(&prepared.model.config, &[], &|_| {}).unwrap();
    let found = result.after.model.effect(&name).and_then(|effect| effect.number(strength));
    let names =
        findings_of_answer(&splits, &result).unwrap().into_iter().map(|finding| finding.name);
    (names.collect(), found.unwrap_or(f64::NAN))
}

#[test]
fn a_rate_control_is_named_with_its_rate() {
    // Half of the busiest window gets through.
    let events = recording(&scene(0.0), &ideal(), 11).measured;
    let windows = events.t().chunk_by(|a, b| a.0 / 4_000 == b.0 / 4_000).map(<[Micros]>::len);
    let given_hz = (windows.max().unwrap() / 2) as f64 / 4e-3 + 1.0;
    let control = EffectConfig::new("event_rate_control")
        .with("rate_hz", given_hz)
        .with("window_us", 4_000.0)
        .with("drop", "late");
    let (names, rate_hz) = named(control, "rate_hz");
    assert_eq!(names, ["event_rate_control"]);
    assert!((rate_hz / given_hz - 1.0).abs() < 0.03, "{rate_hz} {given_hz}");
}

/// Seven thirds of the time between two frames: on a grid of the frames they would be lost.
#[test]
fn a_clock_that_counts_down_in_a_period_of_its_own_is_named() {
    let clock = EffectConfig::new("timestamp_quantisation")
        .with("period_us", 4_666.0)
        .with("rounding", "down");
    let (names, period_us) = named(clock, "period_us");
    assert_eq!(names, ["timestamp_quantisation"]);
    assert!((period_us - 4_666.0).abs() < 1.0, "{period_us}");
}

#[test]
fn intervals_of_a_gap_hold_it_and_are_the_same_every_time() {
    let mut noisy = ideal();
    noisy.effects.push(EffectConfig::new("leak_on").with("rate_hz", 3.0));
    let prepared = Prepared::new(inputs(&noisy)).unwrap();
    let held_out = prepared.data_splits().unwrap().held_out;
    let gap = gap_value(&held_out, &prepared.model.config, 1).unwrap();
    assert!(gap.lo <= gap.value && gap.value <= gap.hi && gap.lo < gap.hi, "{gap:?}");
    assert!(gap.value > 1.0, "{gap:?}");
    assert_eq!(gap, gap_value(&held_out, &prepared.model.config, 1).unwrap());
}

#[test]
fn a_disagreement_along_one_effect_is_of_its_domain() {
    let prepared = Prepared::new(inputs(&ideal())).unwrap();
    let screen = prepared.data_splits().unwrap().screen;
    let directions = Directions::simulate(&screen, &prepared.model.config, &[]).unwrap();
    let leak = directions.all.iter().find(|direction| direction.name == "leak_on").unwrap();
    let shares = directions.shares(&leak.change);
    assert!((shares["detector"] - 1.0).abs() < 1e-9, "{shares:?}");
    let i = directions.all.iter().position(|direction| direction.name == "leak_on").unwrap();
    assert!((directions.likeness(i, i) - 1.0).abs() < 1e-9);
}
