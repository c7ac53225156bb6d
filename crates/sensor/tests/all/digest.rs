//! Bytes that must never change: recordings made with a published sensor stay reproducible.

use evpose_core::{Micros, Plane, SensorSize};
use evpose_sensor::{SensorConfig, SensorModel};

const SIZE: SensorSize = SensorSize { width: 53, height: 37 };

/// A bright wave over a gradient. Integers only, so that no mathematical library has a say.
fn scene(step: usize) -> Plane<f32> {
    let mut plane = Plane::for_sensor(SIZE, 0.0);
    for (i, y) in plane.data_mut().iter_mut().enumerate() {
        let (column, row) = (i % 53, i / 53);
        let phase = (column * 5 + row * 3 + step * 7) % 64;
        let wave = if phase < 32 { phase } else { 64 - phase };
        *y = (wave * wave + column) as f32 / 1077.0;
    }
    plane
}

/// Count and FNV-1a hash of all events of a preset on the scene.
fn digest(preset: &str) -> (usize, u64) {
    let model = SensorModel::from_config(&SensorConfig::preset(preset).unwrap()).unwrap();
    let mut run = model.start(SIZE, 42);
    let (mut count, mut hash) = (0, 0xcbf2_9ce4_8422_2325_u64);
    for step in 0..200 {
        for event in run.expose(&scene(step), Micros(step as i64 * 1_000)).unwrap().iter() {
            count += 1;
            let fields = [event.t.0 as u64, event.x.into(), event.y.into(), event.polarity as u64];
            for field in fields {
                hash = (hash ^ field).wrapping_mul(0x0000_0100_0000_01b3);
            }
        }
    }
    (count, hash)
}

/// The digest was taken when the chain had eight stages.
#[test]
fn eventhands_gives_the_same_bytes_as_ever() {
    let (count, hash) = digest("eventhands");
    assert_eq!((count, format!("{hash:016x}")), (504_590, "560ba747a26bcfcd".to_owned()));
}
