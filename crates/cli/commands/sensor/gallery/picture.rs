//! Events and counts as pictures.

use evpose_core::{Event, Micros, Plane, SensorSize};
use image::{Rgb, RgbImage};

use crate::report::canvas::Canvas;

/// Events in one pixel that give full colour.
const FULL: f32 = 3.0;

/// Events later than `from`, ON blue and OFF red.
pub(super) fn events(events: &[Event], size: SensorSize, from: Micros) -> RgbImage {
    let (mut on, mut off) = (Plane::for_sensor(size, 0.0), Plane::for_sensor(size, 0.0));
    for event in events.iter().filter(|event| event.t > from) {
        let plane = if event.polarity.is_on() { &mut on } else { &mut off };
        let count: &mut f32 = plane.at_mut(usize::from(event.x), usize::from(event.y));
        *count += 1.0;
    }
    for plane in [&mut on, &mut off] {
        for count in plane.data_mut() {
            // One event is seen, more are seen better.
            *count = if *count > 0.0 { (0.4 + 0.6 * (*count / FULL)).min(1.0) } else { 0.0 };
        }
    }
    Canvas::events(&on, &off, 1).into_image()
}

/// Numbers per pixel, black for `low` over orange to white for `high`; each pixel three by three.
pub(super) fn map(values: &[f64], width: usize, (low, high): (f64, f64)) -> RgbImage {
    const SCALE: u32 = 3;
    let height = values.len() / width.max(1);
    RgbImage::from_fn(width as u32 * SCALE, height as u32 * SCALE, |x, y| {
        let value = values[(y / SCALE) as usize * width + (x / SCALE) as usize];
        let share = ((value - low) / (high - low).max(1e-12)).clamp(0.0, 1.0);
        // Black, red, orange, white: each channel rises in its part of the way.
        let channel = |from: f64| (255.0 * ((share - from) / 0.45).clamp(0.0, 1.0)) as u8;
        Rgb([channel(0.0), channel(0.25), channel(0.55)])
    })
}
