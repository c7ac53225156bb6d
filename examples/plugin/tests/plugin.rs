//! Everything of the plugin is found by its name, as if it were built in.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::process::Command;
use std::sync::Once;

use burn::tensor::{Device, Tensor, TensorData};
use evpose_clean::{CLEANERS, CleanRequest, CleanerChain};
use evpose_core::{Event, EventStream, Micros, Plane, Polarity, SensorSize};
use evpose_gap::LightSequence;
use evpose_gap::verdict::Answer;
use evpose_gap::workflow::{
    ComparisonCase, HeldOut, Inputs, Prepared, findings_of_answer, prepared,
};
use evpose_infer::{Engine, EngineOptions};
use evpose_nn::parameters::{slots, trained_count};
use evpose_nn::{BACKBONES, HandRegressorConfig};
use evpose_repr::{ChannelOrder, REPRESENTATIONS, StreamWindow, representation_by_name};
use evpose_sensor::{EffectConfig, STAGES, SensorConfig};
use evpose_task::Experiment as _;
use evpose_task::hand::HandConfig;

/// Tests share the process, and so the registries.
fn register_once() {
    static REGISTERED: Once = Once::new();
    REGISTERED.call_once(|| evpose_plugin::register().unwrap());
}

#[test]
fn the_plugin_comes_last_and_its_names_are_taken() {
    register_once();
    assert_eq!(STAGES.last().unwrap().name, "soft_saturation");
    assert_eq!(REPRESENTATIONS.last().unwrap().name, "signed-lnes");
    assert_eq!(CLEANERS.last().unwrap().name, "border");
    assert_eq!(BACKBONES.last().unwrap().name, "tiny");
    let counts = [STAGES.len(), REPRESENTATIONS.len(), CLEANERS.len(), BACKBONES.len()];
    let error = evpose_plugin::register().unwrap_err().to_string();
    assert_eq!(error, "a sensor effect `soft_saturation` is registered already");
    let after = [STAGES.len(), REPRESENTATIONS.len(), CLEANERS.len(), BACKBONES.len()];
    assert_eq!(after, counts);
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
fn the_gap_workflow_identifies_the_effect() {
    register_once();
    let mut camera = prepared(&SensorConfig::default(), None).config;
    camera.effects.push(EffectConfig::new("soft_saturation").with("half", 0.5));
    let inputs = Inputs {
        train: ComparisonCase::new(&bars().events(&camera, 11).unwrap(), bars()).unwrap(),
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
    assert_eq!(names, ["soft_saturation"]);
    let value = findings[0].parameters["half"].value;
    assert!((value / 0.5 - 1.0).abs() < 0.02, "{value}");
}

/// Events of a row of four pixels: ON, ON and OFF, OFF, none.
fn row(t: i64) -> EventStream {
    let sensor = SensorSize { width: 4, height: 1 };
    let event = |x, polarity| Event { t: Micros(t), x, y: 0, polarity };
    let (on, off) = (Polarity::On, Polarity::Off);
    let events = [event(0, on), event(1, on), event(1, off), event(2, off)];
    EventStream::from_events(sensor, events).unwrap()
}

#[test]
fn the_representation_is_chosen_by_name() {
    register_once();
    for order in [ChannelOrder::OffFirst, ChannelOrder::OnFirst] {
        let window = StreamWindow::new(row(0).sensor(), Micros(4_000), order).unwrap();
        let mut representation = representation_by_name("signed-lnes").unwrap().start(window);
        representation.push(&row(1_000));
        let mut plane = [0.0; 4];
        representation.render(&mut plane);
        assert_eq!(plane, [1.0, 0.0, -1.0, 0.0]);
    }
}

#[test]
fn the_cleaner_is_chosen_by_name() {
    register_once();
    let sensor = SensorSize { width: 5, height: 5 };
    let all = (0..25).map(|i| Event {
        t: Micros(i),
        x: i as u16 % 5,
        y: i as u16 / 5,
        polarity: Polarity::On,
    });
    for (request, count) in [("border", 9), ("border:pixels=2", 1), ("border:pixels=0", 25)] {
        let mut events = EventStream::from_events(sensor, all.clone()).unwrap();
        let request: CleanRequest = request.parse().unwrap();
        CleanerChain::new(sensor, &[request]).unwrap().clean(&mut events).unwrap();
        assert_eq!(events.len(), count);
    }
}

#[test]
fn a_config_names_the_backbone_and_the_representation() {
    register_once();
    let overrides = ["network.backbone=tiny", "representation.name=signed-lnes"];
    let config = HandConfig::parse("task = \"hand\"", &overrides.map(str::to_owned)).unwrap();
    assert_eq!(config.network.backbone, "tiny");
}

#[test]
fn the_backbone_computes_the_same_in_burn_and_in_the_engine() {
    register_once();
    let config = HandRegressorConfig { backbone: "tiny".to_owned(), ..Default::default() };
    let network = config.init(7, &Device::flex()).unwrap();
    assert_eq!(slots(&network)[2].path, "backbone.convolutions.0.conv.weight");
    assert_eq!(trained_count(&network), config.parameter_count().unwrap());

    let image: Vec<f32> = (0..2 * 32 * 48).map(|i| (i * 7 % 13) as f32 / 13.0).collect();
    let planes = TensorData::new(image.clone(), [1, 2, 32, 48]);
    let output = network.forward(Tensor::from_data(planes, &Device::flex()));
    let expected: Vec<f32> = output.into_data().iter().collect();
    let mut engine = Engine::compile(&network.graph(), [2, 32, 48], EngineOptions::default());
    for (ours, theirs) in engine.as_mut().unwrap().run(&image)[0].iter().zip(&expected) {
        assert!((ours - theirs).abs() < 1e-4, "{ours} {theirs}");
    }
}

#[test]
fn the_command_line_lists_the_effect() {
    let program = env!("CARGO_BIN_EXE_evpose-plugin");
    let output =
        Command::new(program).args(["sensor", "show", "soft_saturation"]).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && text.contains("saturates smoothly"), "{text}");
}
