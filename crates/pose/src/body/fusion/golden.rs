//! The estimators against results of independent programs.
//!
//! The values were printed by a program of NumPy 2.4.6 and SciPy 1.17.1 (Python), in double
//! precision and whole matrices, from the same measurements. Without parity it sorts all
//! measurements at each step by their event time stamps and filters all of it anew; process noises
//! are integrals by Van Loan's exponential of a matrix. With parity it steps as hpe-core's sources
//! do, joint by joint in their order.
use evpose_core::Micros;
use glam::Vec2;

use super::{BodyFusion, Estimator, FusionConfig, ScoredPoints};
use crate::body::BODY_JOINTS;

/// Steps of 2 ms after which a detection comes.
const LATENCY_STEPS: i64 = 18;

/// A step, a joint and where it is.
type Golden = (i64, usize, [f64; 2]);

/// Values without structure that are exact in binary.
fn wild(k: i64, i: usize) -> f32 {
    let i = i as i64;
    ((k * k + 7 * i * k + 3 * i) % 64 - 32) as f32 / 16.0
}

/// Velocities at every step and detections of every tenth, compared at some.
fn compare(config: &FusionConfig, golden: &[Golden]) {
    let mut fusion = BodyFusion::new(config).unwrap();
    let at = |step: i64| Micros(2_000 * step);
    for step in 1..=200 {
        // Integers decide the values, so that another program makes the same inputs.
        let velocities = std::array::from_fn(|joint| {
            64.0 * Vec2::new(wild(step, 4 * joint + 2), wild(step, 4 * joint + 3))
        });
        fusion.velocity(at(step), &velocities).unwrap();
        // A detection describes the image of some steps ago, as a network's does.
        let described = step - LATENCY_STEPS;
        if described > 0 && described % 10 == 5 {
            let points = std::array::from_fn(|joint| {
                let [x, y] = [4 * joint, 4 * joint + 1].map(|i| 10.0 * wild(described, i));
                Some(Vec2::new(300.0 + x, 200.0 + y))
            });
            let pose = ScoredPoints { points, scores: [0.9; BODY_JOINTS] };
            assert_eq!(fusion.detection(at(described), &pose, at(step)), Ok(BODY_JOINTS));
        }
        let joints = fusion.query(at(step));
        for &(_, joint, [x, y]) in golden.iter().filter(|&&(k, ..)| k == step) {
            let got = joints[joint].unwrap().as_dvec2();
            // Joints are returned in single precision.
            assert!(
                (got - glam::DVec2::new(x, y)).length() < 5e-5,
                "step {step}, joint {joint}: {got}, not {x}, {y}"
            );
        }
    }
}

fn config(estimator: Estimator, parity: bool) -> FusionConfig {
    FusionConfig {
        estimator,
        parity,
        position_noise_px2_per_s: 100.0,
        displacement_variance_px2: 1.0,
        ..FusionConfig::default()
    }
}

#[test]
fn constant_velocity_is_a_general_kalman_filter_of_sorted_measurements() {
    compare(
        &config(Estimator::ConstantVelocity, false),
        &[
            (23, 0, [296.409_435, 219.747_989]),
            (24, 5, [290.876_219, 214.709_427]),
            (40, 1, [300.915_568, 206.850_345]),
            (77, 0, [298.240_354, 196.749_82]),
            (77, 5, [295.202_749, 207.036_504]),
            (150, 1, [294.416_969, 206.569_569]),
            (200, 0, [299.530_522, 201.629_315]),
            (200, 5, [295.226_852, 197.931_403]),
        ],
    );
}

#[test]
fn constant_position_is_a_general_kalman_filter_of_sorted_measurements() {
    compare(
        &config(Estimator::ConstantPosition, false),
        &[
            (23, 0, [296.043_505, 219.571_153]),
            (24, 5, [290.598_253, 214.558_93]),
            (40, 1, [310.751_712, 194.771_737]),
            (77, 0, [296.638_795, 217.642_373]),
            (77, 5, [291.232_901, 213.970_126]),
            (150, 1, [309.975_528, 196.105_099]),
            (200, 0, [297.645_142, 214.675_122]),
            (200, 5, [293.162_039, 211.004_139]),
        ],
    );
}

#[test]
fn integration_sums_sorted_velocities() {
    compare(
        &config(Estimator::Integration, false),
        &[
            (23, 0, [296.385, 219.823]),
            (24, 5, [290.921, 214.703]),
            (40, 1, [291.377, 218.229]),
            (77, 0, [291.177, 193.189]),
            (77, 5, [301.145, 203.157]),
            (150, 1, [281.121, 210.135]),
            (200, 0, [300.897, 208.517]),
            (200, 5, [290.737, 197.845]),
        ],
    );
}

/// Covariances begin at zero and no time passes for the others, so that nothing corrects them.
#[test]
fn constant_position_with_parity_moves_the_head_alone() {
    compare(
        &config(Estimator::ConstantPosition, true),
        &[
            (24, 0, [295.611_667, 219.333_667]),
            (40, 0, [295.809_447, 218.779_886]),
            (77, 0, [296.266_953, 217.525_874]),
            (150, 0, [296.761_91, 215.651_111]),
            (200, 0, [297.312_532, 214.575_933]),
            (200, 1, [310.625, 194.375]),
            (200, 5, [290.625, 214.375]),
        ],
    );
}

/// Covariances begin at zero and no time passes for the others, so that nothing corrects them.
#[test]
fn constant_velocity_with_parity_moves_the_head_alone() {
    compare(
        &config(Estimator::ConstantVelocity, true),
        &[
            (24, 0, [295.625, 219.375]),
            (40, 0, [296.310_212, 216.463_124]),
            (77, 0, [296.981_186, 203.571_215]),
            (150, 0, [295.646_426, 201.817_369]),
            (200, 0, [299.143_095, 201.742_066]),
            (200, 1, [310.625, 194.375]),
            (200, 5, [290.625, 214.375]),
        ],
    );
}

#[test]
fn displacement_with_parity_forgets() {
    compare(
        &config(Estimator::Displacement, true),
        &[
            (23, 0, [295.625, 219.375]),
            (24, 5, [292.641, 214.039]),
            (40, 1, [309.672_577, 195.770_965]),
            (77, 0, [296.311_695, 205.014_977]),
            (77, 5, [294.247_606, 210.426_369]),
            (150, 1, [296.560_71, 206.332_788]),
            (200, 0, [299.068_489, 201.822_196]),
            (200, 5, [295.970_738, 198.152_126]),
        ],
    );
}

#[test]
fn displacement_with_parity_and_without_compensation() {
    let config = config(Estimator::Displacement, true);
    compare(
        &FusionConfig { latency_compensation: false, ..config },
        &[
            (23, 0, [295.625, 219.375]),
            (24, 5, [290.769, 214.351]),
            (40, 1, [309.901_811, 197.070_468]),
            (77, 0, [297.415_984, 204.382_758]),
            (77, 5, [293.868_443, 208.766_926]),
            (150, 1, [295.476_521, 205.915_485]),
            (200, 0, [299.414_562, 201.769_809]),
            (200, 5, [294.812_333, 197.493_456]),
        ],
    );
}
