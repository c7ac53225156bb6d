//! Every preset at work.

use evpose_core::{Micros, Plane, SensorSize};
use evpose_sensor::{PRESETS, SensorConfig, SensorModel};

const SIZE: SensorSize = SensorSize { width: 60, height: 40 };

/// A bright bar that runs to the right, a pixel per millisecond.
fn bar(step: usize) -> Plane<f32> {
    let mut plane = Plane::for_sensor(SIZE, 0.1);
    for (i, y) in plane.data_mut().iter_mut().enumerate() {
        if (i % 60 + 240 - step) % 60 < 10 {
            *y = 0.8;
        }
    }
    plane
}

#[test]
fn a_bar_makes_on_events_in_front_and_off_events_behind() {
    for preset in &PRESETS {
        let model = SensorModel::from_config(&SensorConfig::preset(preset.name).unwrap()).unwrap();
        let mut run = model.start(SIZE, 3);
        run.expose(&bar(0), Micros(0)).unwrap();
        let (mut on, mut off) = (0, 0);
        for step in 1..200 {
            let events = run.expose(&bar(step), Micros(step as i64 * 1_000)).unwrap();
            on += events.iter().filter(|e| e.polarity.is_on()).count();
            off += events.iter().filter(|e| !e.polarity.is_on()).count();
        }
        // Each step brightens forty pixels and darkens forty, by ln 8 = 2.08.
        let steps = 199 * 40;
        for count in [on, off] {
            let per_edge = count as f64 / f64::from(steps);
            assert!((0.5..20.0).contains(&per_edge), "{}: {per_edge}", preset.name);
        }
    }
}
