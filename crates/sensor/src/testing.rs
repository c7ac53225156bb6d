//! The scene of the tests that compare short paths with long ones.

use evpose_core::{Event, Micros, Plane, SensorSize};

use crate::{SensorConfig, SensorModel, SensorRun};

pub(crate) const SIZE: SensorSize = SensorSize { width: 40, height: 5 };

/// Events while waves pass at this speed, with short paths if `is_short`; `before` is called before
/// each exposure.
pub(crate) fn events_of_waves(
    config: &SensorConfig,
    speed: f32,
    is_short: bool,
    before: impl Fn(i64, &mut SensorRun),
) -> Vec<Event> {
    let mut run = SensorModel::from_config(config).unwrap().start(SIZE, 3);
    run.array_mut().may_take_short_paths = is_short;
    let mut all = Vec::new();
    for step in 0..30 {
        let mut plane = Plane::for_sensor(SIZE, 0.0);
        for (i, y) in plane.data_mut().iter_mut().enumerate() {
            *y = 0.02 + 0.4 * (1.0 + (i as f32 * 0.21 + speed * step as f32).sin());
        }
        before(step, &mut run);
        all.extend(run.expose(&plane, Micros(step * 1_000)).unwrap().iter());
    }
    all
}
