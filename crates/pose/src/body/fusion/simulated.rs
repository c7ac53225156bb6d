//! Motions whose truth is known, measured as a network and events would.
use std::f64::consts::TAU;

use evpose_core::{Micros, StageNoise};
use glam::{DVec2, Vec2};
use proptest::prelude::*;

use super::{BodyFusion, Estimator, FusionConfig, FusionError, ScoredPoints};
use crate::body::{BODY_JOINTS, BodyPoints};

/// A measurement on its arrival.
#[derive(Debug, Clone, Copy)]
enum Arrival {
    Velocity { t: Micros, px_per_s: Vec2 },
    Detection { described: Micros, at: Vec2, now: Micros },
}

impl Arrival {
    fn now(&self) -> Micros {
        match *self {
            Self::Velocity { t, .. } => t,
            Self::Detection { now, .. } => now,
        }
    }

    fn reach(&self, fusion: &mut BodyFusion) -> Result<(), FusionError> {
        match *self {
            Self::Velocity { t, px_per_s } => fusion.velocity(t, &[px_per_s; BODY_JOINTS]),
            Self::Detection { described, at, now } => {
                fusion.detection(described, &seen(at), now).map(|_| ())
            }
        }
    }
}

fn seen(at: Vec2) -> ScoredPoints {
    ScoredPoints { points: [Some(at); BODY_JOINTS], scores: [0.9; BODY_JOINTS] }
}

/// How a motion is measured.
#[derive(Debug, Clone, Copy)]
struct Measuring {
    period_ms: i64,
    latency_ms: i64,
    detection_px: f64,
    velocity_px_per_s: f64,
    /// Of the velocity, is seen.
    part: f64,
}

const EXACT: Measuring = Measuring {
    period_ms: 30,
    latency_ms: 70,
    detection_px: 0.0,
    velocity_px_per_s: 0.0,
    part: 1.0,
};

/// All that is measured in so many seconds, as it comes in: velocities 500 times a second.
fn measured(motion: impl Fn(f64) -> (DVec2, DVec2), seconds: i64, how: &Measuring) -> Vec<Arrival> {
    let noise = StageNoise::new(11, "fusion", 0);
    // Noise depends on time and kind alone, so that other periods have the same noise.
    let draw = |t_ms: i64, k: u32| {
        let both = [0, 1].map(|axis| f64::from(noise.normal(t_ms as usize, 2 * k + axis)));
        DVec2::from(both)
    };
    let mut arrivals = Vec::new();
    for t_ms in (0..1000 * seconds).step_by(2) {
        let px_per_s = motion(1e-3 * t_ms as f64).1 * how.part;
        let px_per_s = (px_per_s + draw(t_ms, 0) * how.velocity_px_per_s).as_vec2();
        arrivals.push(Arrival::Velocity { t: Micros(1_000 * t_ms), px_per_s });
    }
    for t_ms in (0..1000 * seconds - how.latency_ms).step_by(how.period_ms as usize) {
        let at = (motion(1e-3 * t_ms as f64).0 + draw(t_ms, 1) * how.detection_px).as_vec2();
        let now = Micros(1_000 * (t_ms + how.latency_ms));
        arrivals.push(Arrival::Detection { described: Micros(1_000 * t_ms), at, now });
    }
    // The sort is stable: a velocity arrives before a detection of the same time.
    arrivals.sort_by_key(Arrival::now);
    arrivals
}

/// Errors of the head after each arrival from a time on, px.
fn errors(
    config: &FusionConfig,
    arrivals: &[Arrival],
    motion: impl Fn(f64) -> (DVec2, DVec2),
    from_s: f64,
) -> Vec<f64> {
    let mut fusion = BodyFusion::new(config).unwrap();
    let mut errors = Vec::new();
    for arrival in arrivals {
        arrival.reach(&mut fusion).unwrap();
        let t = arrival.now();
        if t.as_seconds() >= from_s {
            let head = fusion.query(t)[0].unwrap().as_dvec2();
            errors.push(head.distance(motion(t.as_seconds()).0));
        }
    }
    errors
}

fn largest(errors: &[f64]) -> f64 {
    errors.iter().copied().fold(0.0, f64::max)
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt()
}

fn uniform(t_s: f64) -> (DVec2, DVec2) {
    let velocity = DVec2::new(310.0, -140.0);
    (DVec2::new(40.0, 700.0) + velocity * t_s, velocity)
}

/// 100 px to the sides and 60 px up and down, up to 628 px/s.
fn swing(t_s: f64) -> (DVec2, DVec2) {
    // Unequal rates along both axes give motion in many directions and speeds.
    let (x, y) = (TAU * t_s, TAU * 0.7 * t_s + 1.0);
    let at = DVec2::new(320.0 + 100.0 * x.sin(), 240.0 + 60.0 * y.sin());
    (at, DVec2::new(100.0 * TAU * x.cos(), 60.0 * TAU * 0.7 * y.cos()))
}

/// Detections overlap: two more are on their way when one comes.
#[test]
fn with_compensation_uniform_motion_is_followed_exactly() {
    let arrivals = measured(uniform, 4, &EXACT);
    for (estimator, from_s) in [
        (Estimator::Integration, 0.1),
        (Estimator::Displacement, 0.1),
        // A Kalman filter needs a while to forget that its first velocity was zero.
        (Estimator::ConstantVelocity, 2.0),
    ] {
        let config = FusionConfig { estimator, ..FusionConfig::default() };
        let worst = largest(&errors(&config, &arrivals, uniform, from_s));
        // Positions are given out to 6e-5 px.
        assert!(worst < 1e-3, "{estimator}: {worst}");
        let late = FusionConfig { latency_compensation: false, ..config };
        let worst = largest(&errors(&late, &arrivals, uniform, 2.0));
        // An uncompensated detection is 70 ms old, in which 340 px/s lead 24 px away.
        assert!(worst > 15.0, "{estimator}: {worst}");
    }
}

/// Errors of a zero-order hold of the last detection.
fn errors_of_hold(
    arrivals: &[Arrival],
    motion: impl Fn(f64) -> (DVec2, DVec2),
    from_s: f64,
) -> Vec<f64> {
    let mut last = None;
    let mut errors = Vec::new();
    for arrival in arrivals {
        if let Arrival::Detection { at, .. } = arrival {
            last = Some(at.as_dvec2());
        }
        let t_s = arrival.now().as_seconds();
        if t_s >= from_s {
            errors.push(last.unwrap().distance(motion(t_s).0));
        }
    }
    errors
}

/// As from a processor: 20 poses a second, 60 ms old and off by 4 px along each axis.
const POSES: Measuring = Measuring {
    period_ms: 50,
    latency_ms: 60,
    detection_px: 4.0,
    velocity_px_per_s: 100.0,
    part: 1.0,
};

#[test]
fn a_swing_is_followed_better_than_by_held_poses() {
    let arrivals = measured(swing, 10, &POSES);
    let with = |estimator, latency_compensation| {
        let config = FusionConfig { estimator, latency_compensation, ..FusionConfig::default() };
        rms(&errors(&config, &arrivals, swing, 1.0))
    };
    let held = rms(&errors_of_hold(&arrivals, swing, 1.0));
    // Held poses are 60 to 110 ms old, and the swing has 480 px/s in root mean square.
    assert!((40.0..43.0).contains(&held), "{held}");
    for (estimator, limit_px) in [
        (Estimator::ConstantVelocity, 5.5),
        (Estimator::Displacement, 6.3),
        (Estimator::Integration, 7.0),
        (Estimator::ConstantPosition, 10.5),
    ] {
        let (compensated, late) = (with(estimator, true), with(estimator, false));
        assert!(compensated < limit_px, "{estimator}: {compensated} px, held {held} px");
        assert!(late > 2.5 * compensated, "{estimator}: {late} px late, {compensated} px");
    }
}

/// As edges show them: shorter than they are.
#[test]
fn velocities_that_are_too_small_still_help() {
    for (part, limit_px) in [(0.8, 12.0), (0.5, 27.0)] {
        let arrivals = measured(swing, 10, &Measuring { part, ..POSES });
        let error = rms(&errors(&FusionConfig::default(), &arrivals, swing, 1.0));
        assert!(error < limit_px, "{part}: {error} px");
        assert!(rms(&errors_of_hold(&arrivals, swing, 1.0)) > 1.5 * error);
    }
}

fn after_all(config: &FusionConfig, arrivals: &[Arrival], at: Micros) -> BodyPoints {
    let mut fusion = BodyFusion::new(config).unwrap();
    for arrival in arrivals {
        arrival.reach(&mut fusion).unwrap();
    }
    fusion.query(at)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Within the history, what comes when does not matter in any bit.
    #[test]
    fn any_order_of_arrival_gives_the_same_pose(seed: u64, period_ms in 7i64..60) {
        let mut arrivals = measured(swing, 1, &Measuring { period_ms, ..POSES });
        let config = FusionConfig { history_s: 2.0, ..FusionConfig::default() };
        for estimator in [Estimator::Integration, Estimator::ConstantPosition, Estimator::ConstantVelocity] {
            let config = FusionConfig { estimator, ..config };
            let want = after_all(&config, &arrivals, Micros(1_000_000));
            let draws = StageNoise::new(seed, "order", 0);
            let mut order: Vec<usize> = (0..arrivals.len()).collect();
            order.sort_by_key(|&k| draws.bits(k, 0));
            arrivals = order.into_iter().map(|k| arrivals[k]).collect();
            prop_assert_eq!(after_all(&config, &arrivals, Micros(1_000_000)), want);
        }
    }
}

/// Every estimator, with parity and without.
fn every() -> impl Iterator<Item = FusionConfig> {
    let both = |estimator| {
        [false, true].map(|parity| FusionConfig { estimator, parity, ..FusionConfig::default() })
    };
    Estimator::ALL.into_iter().flat_map(both)
}

#[test]
fn joints_are_unknown_before_their_first_detection_and_when_lost() {
    let nobody = [None; BODY_JOINTS];
    for config in every().filter(|config| !config.parity) {
        let mut fusion = BodyFusion::new(&config).unwrap();
        let at_ms = |ms: i64| Micros(1_000 * ms);
        // Velocities alone give no position.
        fusion.velocity(at_ms(0), &[Vec2::ONE; BODY_JOINTS]).unwrap();
        assert_eq!(fusion.query(at_ms(0)), nobody);
        let mut pose = seen(Vec2::new(50.0, 60.0));
        // One joint that is not there, and one whose score is too low.
        pose.points[3] = None;
        pose.scores[4] = 0.2;
        assert_eq!(fusion.detection(at_ms(10), &pose, at_ms(20)), Ok(BODY_JOINTS - 2));
        assert_eq!(fusion.query(at_ms(9)), nobody);
        let known = fusion.query(at_ms(1_010)).map(|joint| joint.is_some());
        assert!(!known[3] && !known[4] && known.iter().filter(|&&known| known).count() == 11);
        // The detection is of 10 ms, and a joint is lost a second after its last one.
        assert_eq!(fusion.query(at_ms(1_011)), nobody);
        // What comes after is a new start, whatever has been.
        fusion.velocity(at_ms(2_000), &[Vec2::new(900.0, 0.0); BODY_JOINTS]).unwrap();
        let again = Vec2::new(400.0, 300.0);
        assert_eq!(fusion.detection(at_ms(2_000), &seen(again), at_ms(2_050)), Ok(BODY_JOINTS));
        assert_eq!(fusion.query(at_ms(2_000)), [Some(again); BODY_JOINTS]);
    }
}

#[test]
fn a_pose_that_is_not_believed_changes_nothing() {
    for config in every() {
        let mut fusion = BodyFusion::new(&config).unwrap();
        let mut pose = seen(Vec2::new(50.0, 60.0));
        assert_eq!(fusion.detection(Micros(0), &pose, Micros(0)), Ok(BODY_JOINTS));
        let before = fusion.query(Micros(50_000));
        pose = seen(Vec2::new(150.0, 60.0));
        pose.scores[..3].fill(0.3);
        assert_eq!(fusion.detection(Micros(9_000), &pose, Micros(9_000)), Ok(0));
        assert_eq!(fusion.query(Micros(50_000)), before);
    }
}

#[test]
fn what_comes_too_late_or_too_soon_is_refused_and_changes_nothing() {
    for config in every() {
        let arrivals = measured(swing, 4, &POSES);
        let mut fusion = BodyFusion::new(&config).unwrap();
        for arrival in &arrivals {
            arrival.reach(&mut fusion).unwrap();
        }
        let (now, end) = (Micros(100_000), Micros(4_000_000));
        let before = fusion.query(end);
        let soon = fusion.detection(Micros(100_001), &seen(Vec2::ONE), now).unwrap_err();
        assert_eq!(soon, FusionError::NotYet { t: Micros(100_001), now });
        let late = fusion.detection(now, &seen(Vec2::ONE), now).unwrap_err();
        assert!(matches!(late, FusionError::TooLate { t, .. } if t == now), "{late}");
        assert_eq!(fusion.query(end), before);
        fusion.reset();
        let mut new = BodyFusion::new(&config).unwrap();
        for arrival in &arrivals {
            arrival.reach(&mut fusion).unwrap();
            arrival.reach(&mut new).unwrap();
            assert_eq!(fusion.query(arrival.now()), new.query(arrival.now()));
        }
    }
}

#[test]
fn values_out_of_range_do_no_harm() {
    for config in every() {
        let mut fusion = BodyFusion::new(&config).unwrap();
        let ends = [i64::MIN, -1, 0, 1, i64::MAX].map(Micros);
        for t in ends {
            for value in [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e-30, 1e30] {
                let velocities = [Vec2::new(value, 3.0); BODY_JOINTS];
                // Some are too late for what was remembered, which is said.
                let _refused = fusion.velocity(t, &velocities).is_err();
                let _refused = fusion.detection(t, &seen(Vec2::new(value, 9.0)), t).is_err();
                fusion.query(t);
                fusion.query(Micros(i64::MAX));
            }
        }
    }
}

/// Carried on with the last velocity, and then held.
#[test]
fn without_measurements_a_joint_moves_on_for_a_while() {
    let how = Measuring { latency_ms: 2, ..EXACT };
    let mut fusion = BodyFusion::new(&FusionConfig::default()).unwrap();
    for arrival in measured(uniform, 3, &how) {
        arrival.reach(&mut fusion).unwrap();
    }
    let last_s = 2.998;
    let head = |ms: i64| fusion.query(Micros(2_998_000 + 1_000 * ms))[0].unwrap().as_dvec2();
    // The default limit of extrapolation is 100 ms.
    assert!(head(100).distance(uniform(last_s + 0.1).0) < 1e-2);
    assert_eq!(head(101), head(500));
}
