use evpose_core::{CounterRng, Event, Micros, Polarity};

use super::*;

const SENSOR: SensorSize = SensorSize { width: 45, height: 38 };

/// Cell by cell, with squares clipped to the sensor.
fn clipped(
    events: &EventStream,
    kernel: u32,
    fired: u16,
    rule: impl Fn(u16, u16) -> u16,
) -> Vec<u16> {
    let (width, height) = (i64::from(SENSOR.width), i64::from(SENSOR.height));
    let mut cells = vec![0; SENSOR.pixels()];
    let kernel = i64::from(kernel);
    for event in events.iter() {
        let (x, y) = (i64::from(event.x), i64::from(event.y));
        let centre = cells[(y * width + x) as usize];
        for v in (y - kernel / 2).max(0)..(y - kernel / 2 + kernel).min(height) {
            for u in (x - kernel / 2).max(0)..(x - kernel / 2 + kernel).min(width) {
                let cell = &mut cells[(v * width + u) as usize];
                *cell = rule(*cell, centre);
            }
        }
        cells[(y * width + x) as usize] = fired;
    }
    cells
}

#[test]
fn every_kernel_changes_the_square_around_an_event_and_nothing_else() {
    let mut rng = CounterRng::new(1, "neighbourhood", 0);
    let mut events = EventStream::empty(SENSOR);
    for t in 0..600 {
        let x = rng.uniform(0.0, f32::from(SENSOR.width)) as u16;
        let y = rng.uniform(0.0, f32::from(SENSOR.height)) as u16;
        // Many on the border.
        let (x, y) = if t % 3 == 0 { (x / 40 * 44, y) } else { (x, y / 30 * 37) };
        events.push(Event { t: Micros(t), x, y, polarity: Polarity::On }).unwrap();
    }
    let rule = |cell: u16, centre: u16| cell.wrapping_add(1 + centre % 7);
    for kernel in 1..=MAX_KERNEL {
        let mut representation = Neighbourhood::new(SENSOR, kernel, 0);
        representation.push(&events, 5, rule);
        let mut cells = vec![0; SENSOR.pixels()];
        representation.render(&mut cells, |cell| cell);
        assert_eq!(cells, clipped(&events, kernel, 5, rule), "{kernel}");
    }
}
