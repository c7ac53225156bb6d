//! The search knows the effects of the catalogue by what their entries say, and none by its name:
//! no name is written in the code, and an effect that only this test has is found like any other.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::fs;
use std::path::{Path, PathBuf};

use evpose_core::{Plane, StageNoise};
use evpose_gap::LightSequence;
use evpose_gap::verdict::Answer;
use evpose_gap::workflow::{
    ComparisonCase, HeldOut, Inputs, Prepared, findings_of_answer, prepared,
};
use evpose_sensor::{
    Block, Catalogue, Citation, Domain, EffectConfig, NumberSpec, Parameter, PixelStage, Probe,
    STAGES, SensorConfig, Signature, Stage, StageSpec, Strength, Tick,
};

const HALF: Parameter = Parameter::Number(NumberSpec {
    name: "half",
    unit: "white",
    range: (0.01, 100.0),
    typical: Some((0.2, 5.0)),
    default: Some(f64::INFINITY),
    doc: "light at which the photocurrent is half of what it would be",
    ..NumberSpec::LOG
});

/// An effect that is in no catalogue but this test's.
static DROOP: StageSpec = StageSpec {
    name: "supply_droop",
    domain: Domain::Photodiode,
    summary: "photocurrent saturates smoothly",
    formula: "I = I / (1 + I / half)",
    params: &[HALF],
    source: Citation { key: "this test", text: "made up" },
    signature: Signature {
        look_for: "fewer events of every edge, the more the brighter it is",
        probe: Probe::Contrast,
        strength: Strength::Falling(&["half"]),
        beside: &[],
    },
    build: |settings| Ok(Stage::Pixel(Box::new(Droop { half: settings.number(&HALF) as f32 }))),
};

#[derive(Debug)]
struct Droop {
    half: f32,
}

impl PixelStage for Droop {
    fn is_neutral(&self) -> bool {
        self.half.is_infinite()
    }

    fn step(&self, _tick: &Tick, block: &mut Block<'_>, _noise: StageNoise) {
        block.signal.iter_mut().for_each(|light| *light /= 1.0 + *light / self.half);
    }
}

/// Bars that move over 24 x 16 pixels for half a second.
fn bars() -> LightSequence {
    let plane = |k: u16| {
        let light = (0..24 * 16).map(|i| {
            let (x, y, t) = ((i % 24) as f32, (i / 24) as f32, f32::from(k) / 500.0);
            0.3 + 0.25 * (0.5 * x + 0.1 * y - 9.0 * t).sin()
        });
        Plane::from_vec(24, 16, light.collect()).unwrap()
    };
    LightSequence::new(500.0, (0..=250).map(plane).collect()).unwrap()
}

#[test]
fn an_effect_of_the_caller_is_found_like_any_other() {
    let hidden = 0.5;
    let scene = bars().with_catalogue(Catalogue::with_own(&[&DROOP]));
    let mut camera = prepared(&SensorConfig::default(), None).config;
    camera.effects.push(EffectConfig::new(DROOP.name).with(HALF.name(), hidden));
    let inputs = Inputs {
        train: ComparisonCase::new(&scene.events(&camera, 11).unwrap(), scene).unwrap(),
        held_out: HeldOut::Later,
        model: SensorConfig::default(),
        nominal: None,
        left_out: Vec::new(),
        seed: 3,
        is_quick: true,
    };
    let prepared = Prepared::new(inputs).unwrap();
    let splits = prepared.data_splits().unwrap();
    let result = splits.identify(&prepared.model.config, &[], &|_| {}).unwrap();
    assert_eq!(result.answer, Answer::Effects);
    let findings = findings_of_answer(&splits, &result).unwrap();
    let names: Vec<_> = findings.iter().map(|finding| finding.name.as_str()).collect();
    assert_eq!(names, [DROOP.name]);
    let value = findings[0].parameters[HALF.name()].value;
    assert!((value / hidden - 1.0).abs() < 0.02, "{value}");
}

#[test]
fn a_model_with_an_effect_that_the_catalogue_lacks_is_refused() {
    let mut camera = SensorConfig::default();
    camera.effects.push(EffectConfig::new(DROOP.name).with(HALF.name(), 0.3));
    let error = bars().events(&camera, 1).unwrap_err().to_string();
    assert!(error.contains(DROOP.name), "{error}");
}

#[test]
fn no_code_of_the_search_spells_the_name_of_an_effect() {
    let mut spelt = Vec::new();
    for path in sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src")) {
        // The table of what the search must know of them, which is checked against the registry.
        if path.ends_with("search_spec/effects.rs") {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        for literal in literals(without_tests(&text)) {
            if STAGES.iter().any(|spec| spec.name == literal) {
                spelt.push(format!("{}: {literal:?}", path.display()));
            }
        }
    }
    assert!(spelt.is_empty(), "what it knows of them belongs in the table:\n{}", spelt.join("\n"));
}

/// Files of code, without those of tests.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_of_tests =
        |path: &Path| path.file_stem().is_some_and(|stem| stem == "tests" || stem == "testing");
    let found = entries.flat_map(|path| match path.is_dir() {
        true => sources(&path),
        false if is_of_tests(&path) => Vec::new(),
        false => vec![path],
    });
    found.collect()
}

/// A file up to its module of tests, which is the last item.
fn without_tests(text: &str) -> &str {
    text.split_once("#[cfg(test)]\nmod tests {").map_or(text, |(code, _)| code)
}

/// String literals of Rust code, outside of comments.
fn literals(code: &str) -> Vec<String> {
    let (mut found, mut rest) = (Vec::new(), code);
    while let Some(at) = rest.find(['"', '/', '\'']) {
        let from = &rest[at..];
        rest = if from.starts_with("//") {
            from.split_once('\n').map_or("", |(_, behind)| behind)
        } else if let Some(inside) = from.strip_prefix('"') {
            let mut is_escaped = false;
            let end = inside.find(|c| {
                let is_end = c == '"' && !is_escaped;
                is_escaped = c == '\\' && !is_escaped;
                is_end
            });
            let end = end.unwrap();
            found.push(inside[..end].to_owned());
            &inside[end + 1..]
        } else if from.starts_with("'\"'") || from.starts_with("'/'") {
            &from[3..]
        } else {
            &from[1..]
        };
    }
    found
}

#[test]
fn literals_are_found_and_comments_are_not() {
    let code =
        "let a = \"one\"; // not \"two\"\nf('\"', \"th\\\"ree\", b'/');\n/// \"four\"\n\"five\"";
    assert_eq!(literals(code), ["one", "th\\\"ree", "five"]);
    assert_eq!(without_tests("a\n#[cfg(test)]\nmod tests {\nb"), "a\n");
}
