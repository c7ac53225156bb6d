//! The Kalman filter against results of an independent one.
//!
//! The values were printed by filterpy 1.4.5's `KalmanFilter` (Python, NumPy 2.4), configured with
//! the F, Q, R, P and initial state that each test names, and fed with [`wild`].

use evpose_core::Micros;

use super::{
    AdaptiveFilterConfig, AdaptiveHandFilter, ConstantVelocityKalman, KalmanConfig, NoiseSetting,
};
use crate::HandParams;

fn filter(config: KalmanConfig, values: usize) -> ConstantVelocityKalman {
    ConstantVelocityKalman::new(config, values).expect("valid settings")
}

/// A sequence without structure whose values are exact in binary.
fn wild(k: usize, i: usize) -> f32 {
    (((k * k + 7 * i * k + 3 * i) % 64) as f32 - 32.0) / 16.0
}

/// Runs 200 steps of `wild` and compares some estimates, given as (step, value, estimate).
fn compare(setting: NoiseSetting, golden: &[(usize, usize, f64)]) {
    let mut kalman = filter(KalmanConfig::parity(setting), 12);
    let mut out = [0.0; 12];
    for k in 0..200 {
        let z: [f32; 12] = std::array::from_fn(|i| wild(k, i));
        kalman.update(Micros(k as i64), &z, &mut out);
        for &(_, i, want) in golden.iter().filter(|&&(at, ..)| at == k) {
            assert!((f64::from(out[i]) - want).abs() < 1e-6, "step {k}, output {i}");
            // Offline, the first output is the measurement, while the state mixes up its values.
            if k > 0 || setting == NoiseSetting::LiveFast {
                let ours = kalman.positions().nth(i).expect("12 values");
                assert!((ours - want).abs() < 1e-9, "step {k}, value {i}: {ours}, not {want}");
            }
        }
    }
}

/// 24 states: 12 positions and velocities in turn, all published, `x = [z, 0]` at step 0.
#[test]
fn parity_offline_is_the_published_program() {
    compare(
        NoiseSetting::Regular,
        &[
            (0, 5, -1.0625),
            (1, 0, -3.276_785_714_285_709_5),
            (1, 5, 0.294_642_857_142_860_3),
            (1, 11, 0.267_857_142_857_145_24),
            (2, 3, -0.309_426_209_443_891_3),
            (5, 0, -1.670_833_085_427_433_1),
            (5, 7, 0.686_666_642_417_696_6),
            (20, 2, 0.660_120_044_269_320_5),
            (20, 11, -0.452_338_661_403_166_5),
            (100, 1, 0.071_678_055_555_701_61),
            (199, 0, -0.633_524_364_795_467_4),
            (199, 6, 0.173_506_728_591_191_31),
        ],
    );
}

/// As above from `x = 0`, with step 0 predicted and updated as well.
#[test]
fn parity_live_is_the_published_program() {
    compare(
        NoiseSetting::LiveFast,
        &[
            (0, 0, -1.000_000_000_000_018_9),
            (0, 11, 0.031_250_000_000_000_59),
            (1, 4, -0.069_078_907_488_983_27),
            (10, 3, 0.497_056_136_534_177_85),
            (60, 8, -0.371_132_962_588_226_26),
            (199, 11, 0.144_199_749_888_455_05),
        ],
    );
}

/// Two states, F and Q made anew for steps of 1, 3 and 2 ms in turn, `P = diag(R, √(σ²R))`:
/// (step, position, velocity).
#[test]
fn uneven_steps_are_those_of_a_general_kalman_filter() {
    let golden = [
        (1, -0.749_951_388_127_543_3, 0.097_227_182_170_099_53),
        (2, -0.018_923_907_859_862_088, 0.818_557_160_820_665_2),
        (7, -0.251_164_744_242_011_63, -0.183_143_277_471_529_25),
        (30, -0.158_759_135_324_148_8, -1.723_091_458_217_516_3),
        (199, -0.017_423_288_292_663_826, -0.209_943_942_070_243),
    ];
    let mut kalman = filter(KalmanConfig::default(), 1);
    let mut t = Micros(0);
    for k in 0..200 {
        t = t + if k == 0 { Micros(0) } else { Micros([2_000, 1_000, 3_000][k % 3]) };
        kalman.update(t, &[wild(k, 3)], &mut [0.0]);
        for &(_, position, velocity) in golden.iter().filter(|&&(at, ..)| at == k) {
            let [x, v] = [kalman.positions().next(), kalman.velocities().next()]
                .map(|value| value.expect("one value"));
            assert!((x - position).abs() < 1e-9, "step {k}: {x}, not {position}");
            assert!((v - velocity).abs() < 1e-9, "step {k}: {v}, not {velocity}");
        }
    }
}

/// Two filters of 24 states from zero, written out in NumPy: the innovation of one chooses the
/// noise of the other. Calm and wild stretches of 50 steps in turn: (step, value, estimate, fast).
#[test]
fn parity_adaptive_is_the_published_live_program() {
    let golden = [
        (0, 0, -0.028_571_428_997_176_112, false),
        (1, 5, 0.012_243_851_937_310_868, false),
        (30, 3, -0.009_968_630_960_362_377, false),
        (60, 7, 0.000_971_283_899_957_565_8, true),
        (99, 2, 0.165_964_806_218_871_1, true),
        (120, 11, -0.052_644_324_598_542_87, false),
        (150, 8, -0.223_903_972_712_575_9, true),
        (199, 4, -0.360_878_073_592_880_2, true),
    ];
    let mut filter = AdaptiveHandFilter::new(&AdaptiveFilterConfig::parity()).expect("valid");
    let mut fast_steps = 0;
    for k in 0..200 {
        let size = if (k / 50) % 2 == 0 { 0.05 } else { 1.0 };
        let z = std::array::from_fn(|i| (size * f64::from(wild(k, i))) as f32);
        let out = filter.update(Micros(k as i64), &HandParams::from_array(z)).to_array();
        fast_steps += u32::from(filter.is_fast());
        for &(_, i, want, fast) in golden.iter().filter(|&&(at, ..)| at == k) {
            assert!((f64::from(out[i]) - want).abs() < 1e-6, "step {k}, value {i}: {}", out[i]);
            assert_eq!(filter.is_fast(), fast, "step {k}");
        }
    }
    assert_eq!(fast_steps, 111);
}
