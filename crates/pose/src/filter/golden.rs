//! The Kalman filter against numbers of an independent one.
//!
//! The numbers were printed by filterpy 1.4.5's `KalmanFilter` (Python, NumPy 2.4), configured with
//! the F, Q, R, P and initial state that each test names, and fed with [`wild`].

use evpose_core::Micros;

use super::{ConstantVelocityKalman, KalmanConfig, NoiseSetting, TemporalFilter};

fn filter(config: KalmanConfig, values: usize) -> ConstantVelocityKalman {
    ConstantVelocityKalman::new(config, values).expect("valid settings")
}

/// A sequence without structure whose numbers are exact in binary.
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
