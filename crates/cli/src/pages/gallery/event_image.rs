//! Events and counts as images.

use evpose_core::{Event, Micros, Plane, SensorSize};
use image::{Rgb, RgbImage};

use evpose_report::colour::{OFF, ON};

/// Events in one pixel that give full colour.
const FULL: f32 = 6.0;

const PAPER: [f32; 3] = [252.0, 252.0, 253.0];

/// Events later than `from`: ON blue, OFF red, both violet, the stronger the more they are.
pub(super) fn events(events: &[Event], size: SensorSize, from: Micros) -> RgbImage {
    let mut counts = Plane::for_sensor(size, [0.0_f32; 2]);
    for event in events.iter().filter(|event| event.t > from) {
        let count = counts.at_mut(usize::from(event.x), usize::from(event.y));
        count[usize::from(event.polarity.is_on())] += 1.0;
    }
    RgbImage::from_fn(size.width.into(), size.height.into(), |x, y| {
        let [off, on] = *counts.at(x as usize, y as usize);
        let all = on + off;
        if all == 0.0 {
            return Rgb(PAPER.map(|channel| channel as u8));
        }
        // One event is seen, more are seen better.
        let strength = (0.35 + 0.65 * (all - 1.0) / (FULL - 1.0)).min(1.0);
        let inks = [(ON.0, OFF.0), (ON.1, OFF.1), (ON.2, OFF.2)];
        Rgb(std::array::from_fn(|c| {
            let ink = (f32::from(inks[c].0) * on + f32::from(inks[c].1) * off) / all;
            (PAPER[c] + (ink - PAPER[c]) * strength) as u8
        }))
    })
}

/// Values per pixel, black for `low` over orange to white for `high`; each pixel three by three.
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
