use evpose_core::{CounterRng, Event, Polarity};

use super::*;

fn event(x: u16, y: u16) -> Event {
    Event { t: Micros(0), x, y, polarity: Polarity::Off }
}

fn pushed(mut representation: Eros, events: &[Event]) -> Eros {
    let sensor = representation.since.sensor();
    representation.push(&EventStream::from_events(sensor, events.iter().copied()).unwrap());
    representation
}

fn rendered(representation: &Eros) -> Vec<f32> {
    let mut out = vec![f32::NAN; representation.since.sensor().pixels()];
    representation.render(&mut out);
    out
}

/// By hand: a square of 3 halves after three events nearby.
#[test]
fn an_event_is_255_and_its_neighbours_decay() {
    let sensor = SensorSize { width: 5, height: 2 };
    let config = ErosConfig { kernel_px: 3, decay: 0.125 };
    let events = [event(0, 0), event(1, 1), event(2, 0), event(4, 1), event(3, 1)];
    let half = 127.5;
    let want = [half, 0.0, half, 0.0, 0.0, 0.0, half, 0.0, 255.0, half];
    for representation in [Eros::new(sensor, config), Eros::hpe_core(sensor, config)] {
        assert_eq!(rendered(&pushed(representation, &events)), want);
    }
    let mut grey = [7; 10];
    pushed(Eros::new(sensor, config), &events).render_u8(&mut grey);
    assert_eq!(grey, [128, 0, 128, 0, 0, 0, 128, 0, 255, 128]);
}

/// By hand: columns `x - 2` to `x + 1`, and 255·0.86 = 219.4, 219·0.86 = 188.4.
#[test]
fn the_published_python_reaches_further_left_and_drops_fractions() {
    let sensor = SensorSize { width: 6, height: 1 };
    let representation = Eros::python(sensor, ErosConfig { kernel_px: 4, decay: 0.86f64.powi(4) });
    let representation =
        pushed(representation, &[event(0, 0), event(4, 0), event(2, 0), event(2, 0)]);
    assert_eq!(rendered(&representation), [188.0, 0.0, 255.0, 0.0, 255.0, 0.0]);
}

#[test]
fn representations_that_never_or_at_once_decay_are_none_too_many() {
    let sensor = SensorSize { width: 3, height: 1 };
    let twice = |n| [vec![event(0, 0)], vec![event(1, 0); n]].concat();
    type Constructor = fn(SensorSize, ErosConfig) -> Eros;
    for (start, kernel_px) in [
        (Eros::new as Constructor, 3),
        (Eros::hpe_core as Constructor, 3),
        (Eros::python as Constructor, 4),
    ] {
        let never = || start(sensor, ErosConfig { kernel_px, decay: 1.0 });
        assert_eq!(rendered(&pushed(never(), &twice(65_534))), [255.0, 255.0, 0.0]);
        assert_eq!(rendered(&pushed(never(), &twice(65_535))), [0.0, 255.0, 0.0]);
        let at_once = start(sensor, ErosConfig { kernel_px, decay: 0.0 });
        assert_eq!(rendered(&pushed(at_once, &twice(1))), [0.0, 255.0, 0.0]);
        let slowly = start(sensor, ErosConfig { kernel_px, decay: 0.999_999 });
        let left = rendered(&pushed(slowly, &twice(60_000)))[0];
        assert!(left > 200.0 || kernel_px == 4, "{left}");
    }
}

/// OpenCV's blur and resizing, as sums over weights.
#[test]
fn images_of_any_size_are_blurred_and_resized() {
    let mut rng = CounterRng::new(4, "framer", 0);
    for (width, height) in [(1, 1), (2, 1), (1, 3), (3, 2), (4, 7), (37, 19), (70, 33)] {
        let sensor = SensorSize { width, height };
        let (w, h) = (usize::from(width), usize::from(height));
        let mut draw = |most: u16| rng.uniform(0.0, f32::from(most)) as u16 % most;
        let events: Vec<_> = (0..w * h).map(|_| event(draw(width), draw(height))).collect();
        let representation = pushed(Eros::new(sensor, ErosConfig::ONLINE), &events);
        let mut grey = vec![0; w * h];
        representation.render_u8(&mut grey);

        // cba|abc would repeat the edge; this is cb|abc|ba.
        let at = |i: i64, n: usize| {
            let last = n as i64 - 1;
            let mut i = i;
            while i < 0 || i > last {
                i = if last == 0 {
                    0
                } else if i < 0 {
                    -i
                } else {
                    2 * last - i
                };
            }
            i as usize
        };
        let weights = [1u32, 4, 6, 4, 1];
        let mut want = Vec::new();
        for y in 0..h as i64 {
            for x in 0..w as i64 {
                let mut sum = 0;
                for (v, a) in (-2..).zip(weights) {
                    for (u, b) in (-2..).zip(weights) {
                        sum += a * b * u32::from(grey[at(y + v, h) * w + at(x + u, w)]);
                    }
                }
                want.push(((sum + 128) / 256) as u8);
            }
        }
        let mut framer = ErosFramer::new(sensor, w, h);
        let (mut blurred, mut resized) = (vec![0; w * h], vec![0; w * h]);
        framer.blurred(&representation, &mut blurred);
        assert_eq!(blurred, want, "{sensor}");
        // To its own size, every pixel lies on one.
        framer.resized(&representation, &mut resized);
        assert_eq!(resized, want, "{sensor}");
        let mut framer = ErosFramer::new(sensor, 2 * w + 1, h.div_ceil(3));
        let mut resized = vec![0; (2 * w + 1) * h.div_ceil(3)];
        framer.resized(&representation, &mut resized);
        let (least, most) = (want.iter().min(), want.iter().max());
        assert!(resized.iter().all(|value| Some(value) >= least && Some(value) <= most));
    }
}
