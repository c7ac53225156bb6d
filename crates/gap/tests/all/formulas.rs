//! A formula is found for what the catalogue does not have, and nowhere else. How well eight hidden effects
//! of a camera that shares no code with the model are found is in `benches/gap/formulas.md`.

use evpose_core::Plane;
use evpose_gap::LightSequence;
use evpose_gap::verdict::{Answer, Finding, FindingKind};
use evpose_gap::workflow::{ComparisonCase, HeldOut, Inputs, Prepared, findings_of_answer};
use evpose_sensor::{EffectConfig, STAGES, SensorConfig};

/// Gratings that run over each other on `width` x 16 pixels for 0.4 s.
fn scene(width: usize, seed: u64) -> LightSequence {
    let turn = 0.9 * seed as f64;
    let light = |x: f64, y: f64, t_s: f64| {
        let (u, v) = (turn.cos() * x + turn.sin() * y, turn.cos() * y - turn.sin() * x);
        0.3 + 0.15 * (0.55 * u - 22.0 * t_s).sin() + 0.1 * (0.35 * v + 15.0 * t_s).sin()
    };
    let plane = |k: usize| {
        let pixels = (0..width * 16)
            .map(|i| light((i % width) as f64, (i / width) as f64, k as f64 / 500.0) as f32);
        Plane::from_vec(width, 16, pixels.collect()).unwrap()
    };
    LightSequence::new(500.0, (0..=200).map(plane).collect()).unwrap()
}

/// Answer and findings of a camera with `hidden`, where a few effects of the catalogue are tried beside formulas.
fn identified(hidden: &EffectConfig, width: usize) -> (Answer, Vec<Finding>) {
    let camera = SensorConfig { effects: vec![hidden.clone()] };
    // One camera: what differs between its pixels is the same in both recordings.
    let case = |seed: u64| {
        let scene = scene(width, seed);
        ComparisonCase::new(&scene.events(&camera, 1).unwrap(), scene).unwrap()
    };
    let tried = ["formula", "refractory", "hysteresis"];
    let names = STAGES.iter().map(|stage| stage.name).filter(|name| !tried.contains(name));
    let prepared = Prepared::new(Inputs {
        train: case(1),
        held_out: HeldOut::Recording(case(2)),
        model: SensorConfig::default(),
        nominal: None,
        left_out: names.map(str::to_owned).collect(),
        seed: 3,
        is_quick: true,
    })
    .unwrap();
    let splits = prepared.data_splits().unwrap();
    let result =
        splits.identify(&prepared.model.config, &prepared.left_out, &|_: &str| {}).unwrap();
    (result.answer, findings_of_answer(&splits, &result).unwrap())
}

#[test]
fn thresholds_that_drift_are_a_formula_and_no_name() {
    let hidden = EffectConfig::new("formula").with("stage", "threshold");
    let hidden = hidden.with("expression", "1 + a*time_s").with("a", 0.8);
    let (answer, findings) = identified(&hidden, 12);
    assert_eq!(answer, Answer::NoneOfCatalogue, "{findings:?}");
    assert_eq!(findings.len(), 1, "{findings:?}");
    assert_eq!(findings[0].kind, FindingKind::Formula);
    let formula = findings[0].formula.as_ref().unwrap();
    assert_eq!((formula.stage.as_str(), formula.variable.as_str()), ("threshold", "time_s"));
    // Drawn from 0 to 1 s, which takes it from 1 to 1.8.
    let [time_s, threshold] = *formula.curve.last().unwrap();
    assert!((time_s - 1.0).abs() < 1e-9 && (threshold - 1.8).abs() < 0.1, "{formula:?}");
}

#[test]
fn bad_columns_are_columns_and_no_rows() {
    let hidden = EffectConfig::new("formula").with("stage", "loss");
    for noise in ["column_noise", "row_noise"] {
        let expression = format!("0.7*step({noise} - 0.6)");
        let (_, findings) = identified(&hidden.clone().with("expression", expression.as_str()), 32);
        let formula = findings.iter().find_map(|finding| finding.formula.as_ref());
        let found = formula.map(|found| (found.stage.as_str(), found.variable.as_str()));
        assert_eq!(found, Some(("loss", noise)), "{findings:?}");
    }
}

#[test]
fn an_effect_of_the_catalogue_is_named_and_no_formula_takes_its_place() {
    let (answer, findings) =
        identified(&EffectConfig::new("refractory").with("period_us", 8e3), 12);
    assert_eq!(answer, Answer::Effects, "{findings:?}");
    let named: Vec<&str> = findings.iter().map(|finding| finding.name.as_str()).collect();
    assert_eq!(named, ["refractory"]);
}
