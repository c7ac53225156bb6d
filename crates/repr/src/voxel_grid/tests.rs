//! The grid against its definition, summed in `f64`.

use evpose_core::{CounterRng, Event, Polarity, SensorSize};
use proptest::prelude::*;

use super::*;
use crate::ChannelOrder;

const SENSOR: SensorSize = SensorSize { width: 2, height: 1 };

fn grid(bins: u32, events: &[(i64, u16, bool)]) -> Vec<f32> {
    let window = StreamWindow::new(SENSOR, Micros(1000), ChannelOrder::OnFirst).unwrap();
    let mut grid = VoxelGrid::new(window, VoxelGridConfig { bins });
    let event = |&(t, x, on): &(i64, u16, bool)| Event {
        t: Micros(t),
        x,
        y: 0,
        polarity: Polarity::from_on(on),
    };
    grid.push(&EventStream::from_events(SENSOR, events.iter().map(event)).unwrap());
    let mut out = vec![f32::NAN; bins as usize * SENSOR.pixels()];
    grid.render(&mut out);
    out
}

/// By hand: three bins over 200 µs, one every 100 µs.
#[test]
fn an_event_is_shared_by_the_bins_on_either_side() {
    let events = [(50, 0, true), (75, 0, false), (200, 1, true), (250, 1, false)];
    let want = [1.0 - 0.75, 0.0, -0.25, 0.5, 0.0, 0.5 - 1.0];
    assert_eq!(grid(3, &events), want);
    assert_eq!(grid(1, &events), [0.0, 0.0]);
}

#[test]
fn events_at_one_time_and_events_before_the_window_make_no_others() {
    assert_eq!(grid(2, &[(7, 0, true), (7, 1, false)]), [1.0, -1.0, 0.0, 0.0]);
    assert_eq!(grid(2, &[(7, 0, true), (2000, 1, false)]), [0.0, -1.0, 0.0, 0.0]);
    assert_eq!(grid(2, &[]), [0.0; 4]);
}

/// The planes by the definition, and how many events each pixel has.
fn defined(events: &[Event], sensor: SensorSize, bins: usize) -> (Vec<f64>, Vec<f64>) {
    let pixels = sensor.pixels();
    let (mut planes, mut counts) = (vec![0.0; bins * pixels], vec![0.0; pixels]);
    let (Some(first), Some(last)) = (events.first(), events.last()) else {
        return (planes, counts);
    };
    let span_us = (last.t.0 - first.t.0).max(1) as f64;
    for event in events {
        let at = usize::from(event.y) * usize::from(sensor.width) + usize::from(event.x);
        let sign = if event.polarity.is_on() { 1.0 } else { -1.0 };
        let place = (bins - 1) as f64 * (event.t.0 - first.t.0) as f64 / span_us;
        counts[at] += 1.0;
        for bin in 0..bins {
            planes[bin * pixels + at] += sign * (1.0 - (bin as f64 - place).abs()).max(0.0);
        }
    }
    (planes, counts)
}

/// Pushes `events` piece by piece, with an image now and then, and compares every image.
fn agrees(
    events: &[Event],
    sensor: SensorSize,
    (bins, length_us): (usize, i64),
    pieces: &[usize],
    of_each_event: f64,
) {
    let window = StreamWindow::new(sensor, Micros(length_us), ChannelOrder::OnFirst).unwrap();
    let mut grid = VoxelGrid::new(window, VoxelGridConfig { bins: bins as u32 });
    let mut out = vec![f32::NAN; bins * sensor.pixels()];
    let mut upto = 0;
    for &piece in pieces.iter().cycle() {
        let end = events.len().min(upto + piece);
        grid.push(&EventStream::from_events(sensor, events[upto..end].iter().copied()).unwrap());
        upto = end;
        if piece % 3 == 0 || upto == events.len() {
            grid.render(&mut out);
            let now = events[upto - 1].t.0;
            let start = events[..upto].partition_point(|event| event.t.0 <= now - length_us);
            let (planes, counts) = defined(&events[start..upto], sensor, bins);
            for (k, (&ours, want)) in out.iter().zip(planes).enumerate() {
                let most = of_each_event * (1.0 + counts[k % sensor.pixels()]);
                assert!((f64::from(ours) - want).abs() < most, "value {k}: {ours} {want}");
            }
        }
        if upto == events.len() {
            return;
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Windows of few events and of many, in which sums are kept, and bursts and pauses in which
    /// one becomes the other.
    #[test]
    fn a_stream_shows_its_definition_at_any_time(
        seed in any::<u32>(), count in 1..3000_usize, bins in 2..9_usize,
        length_us in 1..6000_i64, start in 0..1_i64 << 50,
        pieces in prop::collection::vec(1..400_usize, 1..12),
    ) {
        let sensor = SensorSize { width: 7, height: 5 };
        let mut draw = CounterRng::new(u64::from(seed), "voxel grid", 0);
        let mut t = start;
        let events: Vec<Event> = (0..count).map(|k| {
            t += if k % 700 == 699 { draw.below(20_000) as i64 } else { draw.below(8) as i64 };
            Event {
                t: Micros(t),
                x: draw.below(7) as u16,
                y: draw.below(5) as u16,
                polarity: Polarity::from_on(draw.chance(0.5)),
            }
        }).collect();
        agrees(&events, sensor, (bins, length_us), &pieces, 1e-6);
    }
}

/// More pixels than are drawn at once, by a number that is no multiple of these.
#[test]
fn sums_of_many_pixels_show_the_definition() {
    let sensor = SensorSize { width: 31, height: 23 };
    let mut draw = CounterRng::new(5, "voxel grid of many pixels", 0);
    let events: Vec<Event> = (0..9000_i64)
        .map(|t| Event {
            t: Micros(t),
            x: draw.below(31) as u16,
            y: draw.below(23) as u16,
            polarity: Polarity::from_on(draw.chance(0.5)),
        })
        .collect();
    agrees(&events, sensor, (3, 8000), &[2700], 1e-6);
}

/// More events of one pixel than a sum holds, and times that are further apart.
#[test]
fn sums_that_would_overflow_are_not_used() {
    let sensor = SensorSize { width: 1, height: 1 };
    let event = |t| Event { t: Micros(t), x: 0, y: 0, polarity: Polarity::On };
    let many: Vec<Event> = (0..1_200_000).map(|k| event(k / 1000)).collect();
    // Sums of `f32`, each rounded.
    agrees(&many, sensor, (2, 100_000), &[300_000], 1e-3);
    let slow: Vec<Event> = (0..6000).map(|k| event(170_000 * k)).collect();
    agrees(&slow, sensor, (3, StreamWindow::MAX_LENGTH.0), &[999], 1e-3);
    // Years apart: the origin moves on.
    let rare = (0..9000).map(|k| event(3 * k + k / 1000 * 40_000_000_000_000));
    agrees(&rare.collect::<Vec<_>>(), sensor, (4, 5000), &[333], 1e-6);
}
