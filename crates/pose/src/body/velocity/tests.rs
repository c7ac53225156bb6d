//! Edges of known motion, and what mirrors and clocks do to velocities.
use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize, StageNoise};
use glam::{DVec2, Vec2};
use proptest::prelude::*;

use super::*;
use crate::body::{BODY_JOINTS, BodyPoints};

const SENSOR: SensorSize = SensorSize { width: 64, height: 48 };
const MIDDLE: Vec2 = Vec2::new(31.5, 23.5);

/// A stream of pixels and their times in µs, in order of time.
fn stream(mut fired: Vec<(i64, u16, u16)>) -> EventStream {
    fired.sort_unstable();
    let event = |(t, x, y)| Event { t: Micros(t), x, y, polarity: Polarity::On };
    EventStream::from_events(SENSOR, fired.into_iter().map(event)).unwrap()
}

fn pixels() -> impl Iterator<Item = (u16, u16)> {
    (0..SENSOR.height).flat_map(|y| (0..SENSOR.width).map(move |x| (x, y)))
}

/// A straight edge that moves across itself with a velocity, past every pixel; times are off by so
/// much of the time for a pixel.
fn edge(velocity_px_per_s: DVec2, noise: f64) -> EventStream {
    let slowness = velocity_px_per_s / velocity_px_per_s.length_squared();
    let draws = StageNoise::new(5, "edge", 0);
    let fired = pixels().enumerate().map(|(k, (x, y))| {
        let jitter = noise * f64::from(draws.normal(k, 0)) * slowness.length();
        let t_s = slowness.dot(DVec2::new(x.into(), y.into())) + jitter;
        ((10e6 + 1e6 * t_s).round() as i64, x, y)
    });
    stream(fired.collect())
}

/// A disc of so many pixels in radius that moves through the middle.
fn disc(velocity_px_per_s: DVec2, radius_px: f64) -> EventStream {
    let speed = velocity_px_per_s.length();
    let along = velocity_px_per_s / speed;
    let fired = pixels().filter_map(|(x, y)| {
        let from = DVec2::new(x.into(), y.into()) - MIDDLE.as_dvec2();
        let (forward, aside) = (from.dot(along), from.perp_dot(along));
        let half = (radius_px * radius_px - aside * aside).sqrt();
        // The edge in front passes when the disc's middle is `half` behind the pixel.
        (!half.is_nan()).then(|| ((10e6 + 1e6 * (forward - half) / speed).round() as i64, x, y))
    });
    stream(fired.collect())
}

fn measured(events: &EventStream, average: FlowAverage, radius_px: u16) -> JointVelocity {
    let config = TripletVelocityConfig { radius_px, gain: 1.0, average, ..Default::default() };
    let mut velocity = TripletVelocity::new(SENSOR, config).unwrap();
    velocity.push(events);
    velocity.query(&only(MIDDLE))[0]
}

fn only(joint: Vec2) -> BodyPoints {
    let mut joints = [None; BODY_JOINTS];
    joints[0] = Some(joint);
    joints
}

const AVERAGES: [FlowAverage; 2] = [FlowAverage::NormalFlow, FlowAverage::Triplets];

#[test]
fn edges_along_rows_columns_and_diagonals_have_their_velocity() {
    for (x, y) in [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)] {
        for speed in [40.0, 500.0, 3000.0] {
            let want = DVec2::new(f64::from(x), f64::from(y)).normalize() * speed;
            for average in AVERAGES {
                let got = measured(&edge(want, 0.0), average, 10);
                let error = (got.px_per_s.as_dvec2() - want).length() / speed;
                // Times are whole microseconds, of which a step at 3000 px/s has 333.
                assert!(error < 2e-3, "{average:?}: {got:?}, not {want}");
                assert!(got.samples >= 17 * 17, "{got:?}");
            }
        }
    }
}

#[test]
fn a_slant_edge_is_exact_when_fitted_and_off_in_the_mean_of_triplets() {
    let worst = |average, noise: f64| -> f64 {
        let of = |degrees: u32| {
            let want = DVec2::from_angle(f64::from(degrees).to_radians()) * 300.0;
            let got = measured(&edge(want, noise), average, 20).px_per_s.as_dvec2();
            (got - want).length() / 300.0
        };
        (0..90).step_by(3).map(of).fold(0.0, f64::max)
    };
    assert!(worst(FlowAverage::NormalFlow, 0.0) < 1e-4);
    assert!(worst(FlowAverage::NormalFlow, 0.03) < 0.02);
    assert!(worst(FlowAverage::NormalFlow, 0.1) < 0.25);
    assert!(worst(FlowAverage::Triplets, 0.0) > 3.0);
    assert!(worst(FlowAverage::Triplets, 0.03) > 0.5);
}

/// Its edges lie all ways; those at its back, seen last, are half of a circle. In the mean over a
/// half circle `n (n · v)` is `v / 2`, but those that run along the motion have no events: it is
/// more.
#[test]
fn a_disc_moves_where_it_goes_and_seems_slower() {
    for average in AVERAGES {
        for degrees in [0.0, 45.0, 110.0, 200.0] {
            let want = DVec2::from_angle(f64::to_radians(degrees)) * 300.0;
            let got = measured(&disc(want, 12.0), average, 20).px_per_s.as_dvec2();
            assert!((0.75..1.0).contains(&(got.dot(want) / 9e4)), "{average:?}: {got}, not {want}");
            assert!(got.angle_to(want).abs() < 0.15, "{average:?}: {got}, not {want}");
        }
    }
}

/// Pixel by pixel as the facts of the published program say it: in seconds and with 0 for no event.
fn published(events: &EventStream, since_s: f64, [left, top, side]: [usize; 3]) -> Option<DVec2> {
    let mut sae = vec![[0.0; SENSOR.width as usize]; SENSOR.height.into()];
    for event in events.iter() {
        sae[usize::from(event.y)][usize::from(event.x)] = event.t.as_seconds();
    }
    let (mut sum, mut count) = (DVec2::ZERO, 0);
    for (y, x) in
        (top + 2..top + side - 2).flat_map(|y| (left + 2..left + side - 2).map(move |x| (y, x)))
    {
        if sae[y][x] <= since_s {
            continue;
        }
        for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
            let at = |k: isize| sae[y.strict_add_signed(k * dy)][x.strict_add_signed(k * dx)];
            let [t0, t1, t2]: [f64; 3] = [at(0), at(1), at(2)];
            let (late, early) = (t0 - t1, t1 - t2);
            if late > 0.0
                && early > 0.0
                && t1 > 0.0
                && t2 > 0.0
                && (1.0 - early / late).abs() <= 0.15
            {
                sum -= DVec2::new(dx as f64, dy as f64) * (2.0 / (late + early));
                count += 1;
            }
        }
    }
    (count > 0).then(|| sum / f64::from(count))
}

/// Any times, few of them equal, many pixels twice.
fn noise(seed: u64, events: usize) -> EventStream {
    let draws = StageNoise::new(seed, "any", 0);
    let number = |k: usize, draw: u32, below: u16| (draws.bits(k, draw) % u64::from(below)) as u16;
    let fired = (0..events).map(|k| {
        (
            1_000 + i64::from(number(k, 0, 60_000)),
            number(k, 1, SENSOR.width),
            number(k, 2, SENSOR.height),
        )
    });
    stream(fired.collect())
}

#[test]
fn triplets_of_any_events_are_the_published_ones() {
    for seed in 0..20 {
        let events = noise(seed, 12_000);
        let config =
            TripletVelocityConfig { radius_px: 10, gain: 1.0, ..TripletVelocityConfig::parity() };
        let mut velocity = TripletVelocity::new(SENSOR, config).unwrap();
        let half = events.len() / 2;
        let part = |range: std::ops::Range<usize>| {
            EventStream::from_events(SENSOR, range.map(|i| events.get(i).unwrap())).unwrap()
        };
        let first = part(0..half);
        velocity.push(&first);
        let place = Vec2::new(30.4, 20.9);
        let before = velocity.query(&only(place))[0];
        velocity.push(&part(half..events.len()));
        let after = velocity.query(&only(place))[0];
        let since_s = first.t().last().unwrap().as_seconds();
        let want =
            [published(&first, 0.0, [20, 10, 21]), published(&events, since_s, [20, 10, 21])];
        for (got, want) in [before, after].into_iter().zip(want) {
            let want = want.unwrap();
            let error = (got.px_per_s.as_dvec2() - want).length();
            assert!(
                got.samples > 0 && error < 1e-5 * want.length().max(1.0),
                "{got:?}, not {want}"
            );
        }
    }
}

#[test]
fn only_pixels_that_fired_since_the_last_query_count() {
    let mut velocity = TripletVelocity::new(SENSOR, TripletVelocityConfig::default()).unwrap();
    assert_eq!(velocity.query(&only(MIDDLE)), [JointVelocity::default(); BODY_JOINTS]);
    velocity.push(&edge(DVec2::new(200.0, 0.0), 0.0));
    let once = velocity.query(&only(MIDDLE));
    assert!(once[0].samples > 0 && once[1..] == [JointVelocity::default(); BODY_JOINTS - 1]);
    assert_eq!(velocity.query(&only(MIDDLE))[0], JointVelocity::default());
}

#[test]
fn a_stream_that_starts_again_is_a_new_one() {
    let events = edge(DVec2::new(200.0, 50.0), 0.0);
    let mut velocity = TripletVelocity::new(SENSOR, TripletVelocityConfig::default()).unwrap();
    velocity.push(&noise(1, 5_000));
    velocity.push(&stream(vec![(60_000_000, 3, 3)]));
    velocity.query(&only(MIDDLE));
    velocity.push(&events);
    let mut new = TripletVelocity::new(SENSOR, TripletVelocityConfig::default()).unwrap();
    new.push(&events);
    assert_eq!(velocity.query(&only(MIDDLE)), new.query(&only(MIDDLE)));
}

#[test]
fn regions_are_cut_by_the_sensor_and_those_below_five_pixels_stand_still() {
    let mut velocity = TripletVelocity::new(
        SENSOR,
        TripletVelocityConfig { radius_px: 10, ..TripletVelocityConfig::default() },
    )
    .unwrap();
    velocity.push(&edge(DVec2::new(200.0, 0.0), 0.0));
    let samples = |x: f32, y: f32| velocity.at(Vec2::new(x, y)).samples;
    // Of 21 pixels, 17 are middles; of 5, one.
    assert_eq!(samples(30.0, 20.0), 17 * 17);
    assert_eq!(samples(-6.0, 20.0), 17);
    assert_eq!(samples(-5.5, 20.0), 17);
    assert_eq!(samples(-6.5, 20.0), 0);
    assert_eq!(samples(69.9, 20.0), 17);
    assert_eq!(samples(70.0, 20.0), 0);
    assert_eq!(samples(30.0, 53.0), 17);
    for lost in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30] {
        assert_eq!(velocity.at(Vec2::new(lost, 20.0)), JointVelocity::default());
        assert_eq!(velocity.at(Vec2::new(20.0, lost)), JointVelocity::default());
    }
}

#[test]
fn times_at_the_ends_of_what_can_be_written_are_taken() {
    let ends = [(i64::MIN, 30, 20), (-5, 31, 20), (i64::MAX, 32, 20)];
    let mut velocity = TripletVelocity::new(SENSOR, TripletVelocityConfig::default()).unwrap();
    velocity.push(&stream(ends.to_vec()));
    assert!(velocity.query(&only(MIDDLE))[0].px_per_s.is_finite());
}

#[test]
fn bad_settings_are_refused_by_name() {
    let good = TripletVelocityConfig::default();
    for (config, name) in [
        (TripletVelocityConfig { radius_px: 1, ..good }, "radius_px"),
        (TripletVelocityConfig { radius_px: u16::MAX, ..good }, "radius_px"),
        (TripletVelocityConfig { tolerance: f64::NAN, ..good }, "tolerance"),
        (TripletVelocityConfig { gain: 0.0, ..good }, "gain"),
    ] {
        let error = TripletVelocity::new(SENSOR, config).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
    }
}

#[test]
fn settings_are_read_from_a_file_and_unknown_ones_refused() {
    let read: TripletVelocityConfig =
        toml::from_str("radius_px = 9\naverage = \"triplets\"").unwrap();
    let average = FlowAverage::Triplets;
    assert_eq!(read, TripletVelocityConfig { radius_px: 9, average, ..Default::default() });
    assert!(toml::from_str::<TripletVelocityConfig>("radius = 9").is_err());
}

proptest! {
    #[test]
    fn a_mirrored_stream_has_mirrored_velocities(seed: u64) {
        let events = noise(seed, 6_000);
        let mirrored = events.iter().map(|e| (e.t.0, SENSOR.width - 1 - e.x, e.y));
        let mirrored = stream(mirrored.collect());
        for average in AVERAGES {
            // The middle of a pixel column and its mirror image.
            let config = TripletVelocityConfig { average, ..Default::default() };
            let at = |events: &EventStream, x: f32| {
                let mut velocity = TripletVelocity::new(SENSOR, config).unwrap();
                velocity.push(events);
                velocity.at(Vec2::new(x, 20.0))
            };
            // Events of one pixel at one time are the same in any order.
            let (left, right) = (at(&events, 28.0), at(&mirrored, f32::from(SENSOR.width) - 1.0 - 28.0));
            prop_assert_eq!(left.samples, right.samples);
            let mirror = Vec2::new(-right.px_per_s.x, right.px_per_s.y);
            prop_assert!((left.px_per_s - mirror).length() <= 1e-4 * left.px_per_s.length().max(1.0));
        }
    }

    #[test]
    fn a_slower_clock_slows_velocities_by_as_much(seed: u64, factor in 2i64..50) {
        let events = noise(seed, 6_000);
        let slowed = stream(events.iter().map(|e| (e.t.0 * factor, e.x, e.y)).collect());
        for average in AVERAGES {
            let (fast, slow) = (measured(&events, average, 20), measured(&slowed, average, 20));
            prop_assert_eq!(fast.samples, slow.samples);
            let error = (fast.px_per_s - slow.px_per_s * factor as f32).length();
            prop_assert!(error <= 1e-4 * fast.px_per_s.length().max(1.0), "{fast:?} {slow:?}");
        }
    }
}
