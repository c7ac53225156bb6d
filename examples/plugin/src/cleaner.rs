//! Removes events of the pixels at the border of the sensor.

use evpose_clean::{Cleaner, CleanerSpec};
use evpose_core::{EventStream, NumberSpec, Parameter, SensorSize};

const PIXELS: Parameter = Parameter::Number(NumberSpec {
    name: "pixels",
    range: (0.0, 1000.0),
    default: Some(1.0),
    doc: "width of the border",
    ..NumberSpec::LINEAR
});

pub(crate) static BORDER: CleanerSpec = CleanerSpec {
    name: "border",
    summary: "removes events at the border of the sensor",
    params: &[PIXELS],
    displaces: false,
    build: |settings, sensor| {
        let pixels = settings.number(&PIXELS) as u16;
        Ok(Box::new(Border { sensor, pixels }))
    },
};

#[derive(Debug)]
struct Border {
    sensor: SensorSize,
    pixels: u16,
}

impl Cleaner for Border {
    fn clean(&mut self, events: &mut EventStream) {
        let is_inside = |at: u16, size: u16| at.min(size - 1 - at) >= self.pixels;
        let sensor = self.sensor;
        events
            .retain(|event| is_inside(event.x, sensor.width) && is_inside(event.y, sensor.height));
    }

    fn reset(&mut self) {}
}
