//! Laws that hold for every stage of the registry, present and future.

use evpose_core::{Event, Micros, Plane, SensorSize, StageNoise};
use evpose_sensor::{
    Block, Citation, Domain, EffectConfig, Parameter, ParameterError, PixelStage, PlaneStage,
    Probe, STAGES, SensorConfig, SensorError, SensorModel, SensorRun, Signature, Stage, StageSpec,
    Strength, Tick, Value,
};
use proptest::prelude::*;

const SIZE: SensorSize = SensorSize { width: 27, height: 17 };
const STEPS: u64 = 12;

/// Common entry of the stages of this test, which are not in the registry.
const OWN: StageSpec = StageSpec {
    name: "own",
    domain: Domain::Photoreceptor,
    summary: "a stage of this test",
    formula: "",
    params: &[],
    source: Citation { key: "test", text: "test" },
    signature: Signature {
        look_for: "",
        probe: Probe::EventImage,
        strength: Strength::Unchanging,
        beside: &[],
    },
    build: |_| Ok(Stage::Pixel(Box::new(Wander))),
};

/// A pixel stage with state and noise: each pixel's voltage takes a random walk.
static WANDER: StageSpec = StageSpec { name: "wander", ..OWN };

/// A plane stage behind the photoreceptor: voltage less a part of the mean of the image.
static MEAN: StageSpec =
    StageSpec { name: "mean", build: |_| Ok(Stage::Plane(Box::new(Mean))), ..OWN };

#[derive(Debug)]
struct Wander;

impl PixelStage for Wander {
    fn state_planes(&self) -> usize {
        1
    }

    fn init(&self, block: &mut Block<'_>, _noise: StageNoise) {
        let [walk] = block.state.planes();
        walk.fill(0.0);
    }

    fn step(&self, _tick: &Tick, block: &mut Block<'_>, noise: StageNoise) {
        let [walk] = block.state.planes();
        for ((pixel, v), w) in block.pixels.clone().zip(block.signal.iter_mut()).zip(walk) {
            *w += 0.15 * noise.normal(pixel, 0);
            *v += *w;
        }
    }
}

#[derive(Debug)]
struct Mean;

impl PlaneStage for Mean {
    fn step(&self, _tick: &Tick, size: SensorSize, plane: &mut Block<'_>, _noise: StageNoise) {
        assert_eq!((plane.signal.len(), plane.photocurrent.len()), (size.pixels(), size.pixels()));
        let mean = plane.signal.iter().sum::<f32>() / size.pixels() as f32;
        for v in plane.signal.iter_mut() {
            *v -= 0.3 * mean;
        }
    }
}

fn registry() -> Vec<&'static StageSpec> {
    STAGES.iter().copied().chain([&WANDER, &MEAN]).collect()
}

/// Noise, a random walk and `spec` itself at a fraction of its typical range.
fn among_others(spec: &StageSpec, fraction: f64) -> Vec<EffectConfig> {
    others(spec).into_iter().chain([typical(spec, fraction)]).collect()
}

/// Noise and a random walk, unless they are `spec`.
fn others(spec: &StageSpec) -> Vec<EffectConfig> {
    let all = [noisy(), EffectConfig::new("wander")];
    all.into_iter().filter(|other| other.name != spec.name).collect()
}

/// A stage with every parameter somewhere in its typical range.
fn typical(spec: &StageSpec, fraction: f64) -> EffectConfig {
    let mut effect = EffectConfig::new(spec.name);
    for param in spec.number_params() {
        let interval = param.typical.unwrap_or(param.range);
        effect = effect.with(param.name, param.between(interval, fraction));
    }
    for choice in spec.params.iter().filter_map(Parameter::as_word) {
        let index = (fraction * choice.allowed.len() as f64) as usize;
        effect = effect.with(choice.name, choice.allowed[index.min(choice.allowed.len() - 1)]);
    }
    for text in spec.params.iter().filter_map(Parameter::as_text) {
        effect = effect.with(text.name, text.example);
    }
    effect
}

/// Bright and dark waves that run over the sensor at about three thresholds per step.
fn moving(step: u64) -> Plane<f32> {
    let mut plane = Plane::for_sensor(SIZE, 0.0);
    for (i, y) in plane.data_mut().iter_mut().enumerate() {
        let phase = i as f32 * 0.37 + step as f32 * 0.6;
        *y = 0.02 + 0.5 * (1.0 + phase.sin());
    }
    plane
}

fn still(_step: u64) -> Plane<f32> {
    moving(0)
}

fn events_of(model: &SensorModel, scene: fn(u64) -> Plane<f32>, seed: u64) -> Vec<Vec<Event>> {
    events_of_run(model.start(SIZE, seed), scene)
}

fn events_of_run(mut run: SensorRun, scene: fn(u64) -> Plane<f32>) -> Vec<Vec<Event>> {
    // Not a whole number of any clock's counts.
    let time = |step: u64| Micros(step as i64 * 1_130);
    (0..STEPS).map(|k| run.expose(&scene(k), time(k)).unwrap().iter().collect()).collect()
}

fn model_of(effects: &[EffectConfig]) -> SensorModel {
    let config = SensorConfig { effects: effects.to_vec() };
    SensorModel::from_config_in(&registry(), &config).unwrap()
}

fn noisy() -> EffectConfig {
    EffectConfig::new("uniform_noise").with("on_hz", 30.0).with("off_hz", 20.0)
}

/// Whether a sensor has exactly one of this stage, so that it cannot be left out.
fn holds_a_place(spec: &'static StageSpec) -> bool {
    let settings = spec.settings(&typical(spec, 0.5)).unwrap();
    (spec.build)(&settings).unwrap().role().is_some()
}

#[test]
fn keys_of_a_stage_are_unique() {
    for spec in &STAGES {
        let mut keys = spec.keys();
        keys.sort_unstable();
        assert!(keys.windows(2).all(|pair| pair[0] != pair[1]), "{}", spec.name);
        assert!(!keys.contains(&"name"), "{}: `name` is the effect's own key", spec.name);
    }
}

#[test]
fn stages_are_listed_in_the_order_of_the_signal() {
    assert!(STAGES.is_sorted_by_key(|spec| spec.domain));
}

#[test]
fn an_empty_chain_is_the_ideal_sensor() {
    let ideal = SensorModel::from_config(&SensorConfig::preset("ideal").unwrap()).unwrap();
    assert_eq!(events_of(&model_of(&[]), moving, 1), events_of(&ideal, moving, 1));
}

#[test]
fn keys_that_a_stage_does_not_have_are_refused() {
    for spec in &STAGES {
        let config = SensorConfig { effects: vec![typical(spec, 0.5).with("strength", 1.0)] };
        let error = SensorModel::from_config(&config).unwrap_err();
        let (effect, key, allowed) = (spec.name, "strength".to_owned(), spec.keys());
        let unknown = ParameterError::UnknownKey { key, allowed };
        assert_eq!(error, SensorError::Parameter { effect, error: unknown });
    }
}

#[test]
fn values_outside_the_range_are_refused() {
    for spec in &STAGES {
        let refused = |key: &str, value: Value| {
            let effects = vec![typical(spec, 0.5).with(key, value)];
            let refused = SensorModel::from_config(&SensorConfig { effects }).err();
            matches!(
                refused,
                Some(SensorError::Parameter { error: ParameterError::BadValue { parameter, .. }, .. })
                    if parameter.name() == key
            )
        };
        for param in spec.number_params() {
            let (low, high) = param.range;
            let below = low - low.abs().max(1.0) - 0.5;
            for value in [below, high * 1.01, f64::NAN] {
                let is_refused = refused(param.name, value.into());
                assert!(is_refused, "{}.{} = {value}", spec.name, param.name);
            }
        }
        for choice in spec.params.iter().filter_map(Parameter::as_word) {
            assert!(refused(choice.name, "otherwise".into()), "{}.{}", spec.name, choice.name);
        }
    }
}

/// A step of a large sensor with as many of each pixel is a few gigabytes.
#[test]
fn no_end_of_a_range_makes_more_than_a_thousand_events_of_a_pixel_in_a_step() {
    for spec in &STAGES {
        let middle = typical(spec, 0.5);
        let high = spec
            .number_params()
            .fold(middle.clone(), |all, param| all.with(param.name, param.range.1));
        let ends = spec.number_params().flat_map(|param| {
            [param.range.0, param.range.1].map(|end| middle.clone().with(param.name, end))
        });
        for effect in ends.chain([high]) {
            let events = events_of(&model_of(std::slice::from_ref(&effect)), moving, 1);
            let most = events.iter().map(Vec::len).max().unwrap_or(0);
            assert!(most <= 1_000 * SIZE.pixels(), "{effect:?}: {most} events in a step");
        }
    }
}

#[test]
fn what_has_no_neutral_value_must_be_given() {
    for spec in &STAGES {
        let is_required =
            |param: &&Parameter| param.as_number().is_some_and(|number| number.default.is_none());
        for parameter in spec.params.iter().filter(is_required) {
            let mut effect = typical(spec, 0.5);
            effect.params.remove(parameter.name());
            let refused = SensorModel::from_config(&SensorConfig { effects: vec![effect] });
            let (effect, error) = (spec.name, ParameterError::MissingKey { parameter });
            assert_eq!(refused.err(), Some(SensorError::Parameter { effect, error }));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn a_neutral_stage_is_as_good_as_none(fraction in 0.0..1.0, seed: u64) {
        for spec in STAGES.iter().filter(|spec| !holds_a_place(spec)) {
            let mut effect = typical(spec, fraction);
            for param in spec.number_params() {
                if let Some(neutral) = param.default {
                    effect = effect.with(param.name, neutral);
                }
            }
            let is_text = |key: &String| {
                spec.params.iter().any(|p| p.as_text().is_some_and(|text| text.name == key))
            };
            effect.params.retain(|key, _| !is_text(key));
            let without = others(spec);
            let with: Vec<EffectConfig> = without.iter().cloned().chain([effect]).collect();
            let model = model_of(&with);
            let row = model.describe().rows.iter().find(|row| row.spec.name == spec.name);
            prop_assert!(row.is_some_and(|row| !row.is_active), "{}", spec.name);
            let expected = events_of(&model_of(&without), moving, seed);
            prop_assert_eq!(events_of(&model, moving, seed), expected, "{}", spec.name);
        }
    }

    #[test]
    fn the_seed_decides_every_event(fraction in 0.0..1.0, seed: u64) {
        for spec in registry() {
            let model = model_of(&among_others(spec, fraction));
            prop_assert_eq!(
                events_of(&model, moving, seed), events_of(&model, moving, seed), "{}", spec.name
            );
        }
    }

    #[test]
    fn neither_the_size_of_blocks_nor_the_number_of_threads_matters(
        fraction in 0.0..1.0, seed: u64,
    ) {
        for spec in registry() {
            let model = model_of(&among_others(spec, fraction));
            let expected = events_of(&model, moving, seed);
            let blocks = [1, 16, 333, 8192].map(|block| model.clone().with_block_pixels(block));
            let threads = [2, 3, 7].map(|threads| model.clone().with_threads(threads));
            for (k, other) in blocks.iter().chain(&threads).enumerate() {
                prop_assert_eq!(&events_of(other, moving, seed), &expected, "{} {}", spec.name, k);
            }
        }
    }

    /// A tap prevents that a block is taken through the whole step before the next one begins.
    #[test]
    fn a_tap_changes_no_event(fraction in 0.0..1.0, seed: u64) {
        for spec in registry() {
            let model = model_of(&among_others(spec, fraction));
            let mut tapped = model.start(SIZE, seed);
            let taps = model.describe().rows.iter().filter(|row| {
                row.is_active && tapped.tap(row.spec.name, (20, 11)).is_ok()
            });
            prop_assert!(taps.count() >= 2, "{}", spec.name);
            let expected = events_of(&model, moving, seed);
            prop_assert_eq!(events_of_run(tapped, moving), expected, "{}", spec.name);
        }
    }

    /// On a still scene the events of a quiet sensor are noise, every one of which must be there
    /// still, in its pixel, whatever a new stage adds to them.
    #[test]
    fn a_new_stage_leaves_the_noise_of_the_others_unmoved(fraction in 0.0..1.0, seed: u64) {
        let noise_of = |effects: &[EffectConfig]| {
            let mut events: Vec<(u16, u16, bool)> = events_of(&model_of(effects), still, seed)
                .concat()
                .iter()
                .map(|e| (e.y, e.x, e.polarity.is_on()))
                .collect();
            events.sort_unstable();
            events
        };
        let expected = noise_of(&[noisy()]);
        prop_assert!(!expected.is_empty());
        for spec in registry() {
            // What is there to take events away, or to deliver them later than this test looks.
            let takes_away = matches!(spec.name, "uniform_noise" | "wander" | "dead_pixels");
            if takes_away || spec.domain >= Domain::Readout {
                continue;
            }
            let found = noise_of(&[typical(spec, fraction), noisy()]);
            let mut left = found.iter();
            let is_there = expected.iter().all(|event| left.any(|other| other == event));
            prop_assert!(is_there, "{}", spec.name);
        }
    }

    /// The same with a stage that has noise of its own in the chain already.
    #[test]
    fn a_stage_draws_the_same_in_any_company(seed: u64) {
        let shot = EffectConfig::new("shot_noise_poisson").with("rate_hz", 100.0);
        let alone = events_of(&model_of(std::slice::from_ref(&shot)), still, seed).concat();
        prop_assert!(!alone.is_empty());
        for other in [
            EffectConfig::new("threshold_mismatch").with("sigma", 0.02),
            EffectConfig::new("uniform_noise").with("on_hz", 20.0),
            EffectConfig::new("leak_on").with("rate_hz", 20.0),
        ] {
            let both = events_of(&model_of(&[other.clone(), shot.clone()]), still, seed).concat();
            let mut left = both.iter();
            prop_assert!(alone.iter().all(|event| left.any(|e| e == event)), "{}", other.name);
        }
    }

    /// Noise that joins the signal takes nothing from it, and the walk of the voltages stays.
    #[test]
    fn taking_the_noise_away_leaves_the_signal(seed: u64) {
        let wander = EffectConfig::new("wander");
        let signal = events_of(&model_of(std::slice::from_ref(&wander)), moving, seed).concat();
        let both = events_of(&model_of(&[wander, noisy()]), moving, seed).concat();
        let mut left = both.iter();
        prop_assert!(both.len() > signal.len());
        prop_assert!(signal.iter().all(|event| left.any(|other| other == event)));
    }

    #[test]
    fn events_come_in_order_from_inside_the_sensor(fraction in 0.0..1.0, seed: u64) {
        for spec in registry() {
            let model = model_of(&among_others(spec, fraction));
            // A clock may be behind that of the scene, round down, or scatter, and events then
            // wait.
            let rounds_down =
                typical(spec, fraction).params.get("rounding") == Some(&"down".into());
            let shows_other_times = rounds_down
                || matches!(spec.name, "clock_offset_drift" | "timestamp_jitter");
            let mut previous = if shows_other_times { Micros(i64::MIN) } else { Micros(-1) };
            for (step, events) in events_of(&model, moving, seed).iter().enumerate() {
                let now = Micros(step as i64 * 1_130);
                let key = |e: &Event| (e.t, e.y, e.x);
                prop_assert!(events.is_sorted_by_key(key), "{}", spec.name);
                for event in events {
                    prop_assert!(previous < event.t && event.t <= now, "{}: {event:?}", spec.name);
                    prop_assert!(SIZE.contains(event.x, event.y));
                }
                let last = events.last().map_or(previous, |event| event.t - Micros(1));
                previous = if shows_other_times { last } else { now };
            }
        }
    }

    #[test]
    fn a_configuration_reads_back_as_it_was_written(
        fraction in 0.0..1.0, chosen in prop::collection::vec(any::<bool>(), STAGES.len()),
    ) {
        let listed = STAGES.iter().zip(chosen).filter(|(_, chosen)| *chosen);
        let config = SensorConfig { effects: listed.map(|(s, _)| typical(s, fraction)).collect() };
        prop_assert_eq!(SensorConfig::from_toml(&config.to_toml()).unwrap(), config);
    }

    #[test]
    fn values_survive_toml_bit_by_bit(value in prop::num::f64::NORMAL) {
        let config = SensorConfig { effects: vec![EffectConfig::new("a").with("b", value)] };
        let read = SensorConfig::from_toml(&config.to_toml()).unwrap();
        prop_assert_eq!(&read.effects[0].params["b"], &Value::Number(value));
    }
}
