//! A whole recording: draws of one effect do not depend on another being on.

use std::collections::HashSet;

use gapbench_pixel::camera::record;
use gapbench_pixel::circuit::HotPixels;
use gapbench_pixel::draw::{Purpose, Sequence};
use gapbench_pixel::{Circuit, Effect, Event, Scene, SceneKind, Seeds};

#[test]
fn another_effect_does_not_reshuffle_the_hot_pixels() {
    let scene = Scene::new(SceneKind::Rest, 3);
    let seeds = Seeds { camera: 4, run: 5 };
    let events = |circuit: &Circuit| -> HashSet<Event> {
        record(circuit, &scene, seeds).events.into_iter().collect()
    };
    let added_by_hot = |circuit: &Circuit| -> HashSet<Event> {
        let mut hot = circuit.clone();
        hot.background.hot = Some(HotPixels { count: 9.0, median_hz: 80.0, spread_ln: 0.5 });
        events(&hot).difference(&events(circuit)).copied().collect()
    };
    let ideal = Circuit::ideal();
    let mut other = Circuit::ideal();
    let mut draws = Sequence::new(1, Purpose::Plan, 0);
    Effect::Refractory.install(3, &mut other, &mut draws);
    Effect::ThresholdMismatch.install(3, &mut other, &mut draws);
    assert_ne!(events(&ideal), events(&other));
    let added = added_by_hot(&ideal);
    assert!(added.len() > 100);
    assert_eq!(added, added_by_hot(&other));
}
