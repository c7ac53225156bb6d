//! The latest events of a simulation, as an image.

use evpose_core::{EventStream, Micros, Plane, SensorSize};
use glam::Vec2;

use evpose_report::canvas::Canvas;

/// The time stamp of the newest event of each pixel and polarity.
pub(crate) struct RecentEvents {
    sensor: SensorSize,
    /// Of OFF and of ON events.
    newest: [Plane<Option<Micros>>; 2],
    /// How long an event is shown.
    window: Micros,
}

impl RecentEvents {
    pub(crate) fn new(sensor: SensorSize, window: Micros) -> Self {
        let newest = [(); 2].map(|()| Plane::for_sensor(sensor, None));
        Self { sensor, newest, window }
    }

    pub(crate) fn push(&mut self, events: &EventStream) {
        for event in events.iter() {
            let plane = &mut self.newest[usize::from(event.polarity.is_on())];
            *plane.at_mut(usize::from(event.x), usize::from(event.y)) = Some(event.t);
        }
    }

    /// Pixels with an event within the window before `now`, between two corners.
    pub(crate) fn count(&self, now: Micros, [from, to]: [Vec2; 2]) -> usize {
        let is_recent = |plane: &Plane<Option<Micros>>, x, y| {
            plane.at(x, y).is_some_and(|t: Micros| now.0 - t.0 < self.window.0)
        };
        let columns =
            from.x.max(0.0) as usize..(to.x.max(0.0) as usize).min(self.sensor.width.into());
        let rows =
            from.y.max(0.0) as usize..(to.y.max(0.0) as usize).min(self.sensor.height.into());
        let pixels = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
        pixels.filter(|&(x, y)| self.newest.iter().any(|plane| is_recent(plane, x, y))).count()
    }

    /// The events of the window before `now`, newer ones darker, each pixel `scale` by `scale`.
    pub(crate) fn image(&self, now: Micros, scale: u32) -> image::RgbImage {
        let [off, on] = self.newest.each_ref().map(|newest| self.faded(newest, now));
        Canvas::events(&on, &off, scale).into_image()
    }

    /// 1 for an event of now, 0 for none within the window.
    fn faded(&self, newest: &Plane<Option<Micros>>, now: Micros) -> Plane<f32> {
        let mut faded = Plane::for_sensor(self.sensor, 0.0);
        for (value, t) in faded.data_mut().iter_mut().zip(newest.data()) {
            if let Some(t) = t {
                *value = (1.0 - (now.0 - t.0) as f32 / self.window.0 as f32).max(0.0);
            }
        }
        faded
    }
}
