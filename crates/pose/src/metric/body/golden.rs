//! Errors of bodies against those of independent programs.
//!
//! The values were printed by a NumPy 2.4.6 program (Python 3.11, SciPy 1.17.1) that follows the
//! protocol by itself (`numpy.arange`, `numpy.interp`, `scipy.interpolate.interp1d`), on the track
//! of [`truth`] and [`predicted`]. Those of [`MissingJoints::Published`] are what the classes
//! `PCK`, `MPJPE` and `RMSE` of hpe-core (revision 4e31dd9) compute for its instants, with (-640,
//! -480) and (-1, -1) where something is missing; without anything missing both agree. Root mean
//! squares in pixels and what is counted are the program's own, with NaN where something is
//! missing.

use glam::Vec2;

use super::*;

/// Joint `j` of label `k`; all numbers are exact in binary.
fn at(k: usize, j: usize) -> Vec2 {
    let x = 220.0 + (20 * (j * 5 % 13)) as f32 + ((3 * k * k + 7 * j * k) % 64) as f32 / 4.0;
    let y = 100.0 + (25 * (j * 4 % 13)) as f32 + ((k * k + 5 * j * k + 3 * j) % 64) as f32 / 4.0;
    Vec2::new(x, y)
}

/// 3 s at 50 Hz; with gaps, joint 4 is not labelled for 0.4 s and the size not known for 0.2 s.
fn truth(has_gaps: bool) -> Vec<BodyTruth> {
    let label = |k: usize| {
        let is_gap = |j: usize| has_gaps && j == 4 && (40..60).contains(&k);
        let size_px = 90.0 + (7 * k % 32) as f32 / 4.0;
        BodyTruth {
            t_s: k as f64 / 50.0,
            joints_px: std::array::from_fn(|j| (!is_gap(j)).then(|| at(k, j))),
            size_px: (!(has_gaps && (100..110).contains(&k))).then_some(size_px),
        }
    };
    (0..151).map(label).collect()
}

/// 200 predictions out of order, with gaps one joint in 17 is not found.
fn predicted(has_gaps: bool) -> Vec<BodyPrediction> {
    let joint = |m: usize, j: usize| {
        let error = [(m * m + 11 * j) % 48, (5 * m + 3 * j * m) % 48].map(|e| e as f32 - 24.0);
        let is_gap = has_gaps && (m + 3 * j).is_multiple_of(17);
        (!is_gap).then(|| at(m * 10 / 11, j) + (1 + j % 3) as f32 * Vec2::from(error))
    };
    let prediction = |m: usize| BodyPrediction {
        t_s: m as f64 / 55.0 + 0.001 * (m * m % 5) as f64,
        delay_s: 0.0,
        joints_px: std::array::from_fn(|j| joint(m, j)),
    };
    (0..200).map(|m| prediction(m * 37 % 200)).collect()
}

/// Errors printed by the independent program.
struct Said {
    instants: u64,
    /// At 5, 10, 20, 40, 60 and 80 percent.
    pck: [f64; 6],
    auc: f64,
    mpjpe_px: f64,
    rmse_px: f64,
    rmse_percent: f64,
    /// MPJPE and RMSE in percent of joint 4.
    joint_4: (f64, f64),
}

fn compare(errors: &BodyErrors, said: &Said) {
    let joint = &errors.joints[4];
    let ours = [5, 10, 20, 40, 60, 80].map(|percent| errors.pck(percent)).into_iter().chain([
        errors.auc(),
        errors.mpjpe_px(),
        errors.rmse_px(),
        errors.rmse_percent(),
        joint.distance_px.mean(),
        joint.squares.percent(),
    ]);
    let said_of = said.pck.into_iter().chain([
        said.auc,
        said.mpjpe_px,
        said.rmse_px,
        said.rmse_percent,
        said.joint_4.0,
        said.joint_4.1,
    ]);
    assert_eq!(errors.instants, said.instants);
    for (k, (ours, said)) in ours.zip(said_of).enumerate() {
        assert!((ours.unwrap() - said).abs() < 1e-9 * said, "{k}: {ours:?}, not {said}");
    }
}

#[test]
fn errors_of_a_whole_track_are_those_of_the_published_program() {
    for protocol in [BodyProtocol::default(), BodyProtocol::published(640.0, 480.0)] {
        let sequence = BodySequence::evaluate(&truth(false), &predicted(false), &protocol).unwrap();
        compare(
            &sequence.raw,
            &Said {
                instants: 178,
                pck: [
                    0.015_989_628_349_178_91,
                    0.068_280_034_572_169_4,
                    0.241_140_881_590_319_82,
                    0.611_927_398_444_252_4,
                    0.815_038_893_690_579,
                    0.955_488_331_892_826_3,
                ],
                auc: 0.631_127_917_026_793_5,
                mpjpe_px: 35.334_086_115_905_535,
                rmse_px: 38.203_697_941_024_43,
                rmse_percent: 12.790_433_920_814_941,
                joint_4: (40.643_031_790_523_58, 15.267_647_827_093_07),
            },
        );
        compare(
            &sequence.resampled,
            &Said {
                instants: 4_000,
                pck: [
                    0.026_846_153_846_153_85,
                    0.116_173_076_923_076_95,
                    0.356_519_230_769_230_75,
                    0.716_711_538_461_538_5,
                    0.896_596_153_846_154,
                    0.982_634_615_384_615_4,
                ],
                auc: 0.698_020_961_538_461_6,
                mpjpe_px: 29.025_431_668_825_71,
                rmse_px: 31.907_725_428_707_39,
                rmse_percent: 10.931_658_271_915_738,
                joint_4: (35.071_051_242_690_08, 11.288_945_461_164_458),
            },
        );
    }
}

#[test]
fn what_is_missing_counts_as_wrong_and_is_counted() {
    let protocol = BodyProtocol::default();
    let sequence = BodySequence::evaluate(&truth(true), &predicted(true), &protocol).unwrap();
    compare(
        &sequence.raw,
        &Said {
            instants: 178,
            pck: [
                0.015_366_468_563_873_569,
                0.066_414_123_411_343_06,
                0.230_438_699_391_433_4,
                0.577_778_569_900_905_5,
                0.768_906_718_860_379_6,
                0.898_698_613_712_515_2,
            ],
            auc: 0.595_057_940_206_225_7,
            mpjpe_px: 35.285_989_256_569_955,
            rmse_px: 38.181_223_110_839_72,
            rmse_percent: 12.749_533_351_449_777,
            joint_4: (39.715_517_850_721_504, 14.745_505_145_894_642),
        },
    );
    compare(
        &sequence.resampled,
        &Said {
            instants: 4_000,
            pck: [
                0.023_027_231_812_556_097,
                0.104_521_752_563_379_03,
                0.321_609_117_341_277,
                0.648_944_669_397_996,
                0.803_652_341_818_532_2,
                0.881_678_676_639_501,
            ],
            auc: 0.628_188_278_927_482_4,
            mpjpe_px: 28.948_670_875_242_815,
            rmse_px: 31.833_342_355_967_75,
            rmse_percent: 10.931_416_375_309_139,
            joint_4: (32.568_735_643_260_94, 10.259_159_872_884_43),
        },
    );
    for (errors, said) in
        [(&sequence.raw, [155, 134, 156]), (&sequence.resampled, [3_581, 5_242, 2_847])]
    {
        let missing = errors.joints.iter().map(|joint| joint.missing).sum();
        let unmeasured = errors.joints.iter().map(|joint| joint.unmeasured).sum();
        assert_eq!([errors.joints[4].labelled, missing, unmeasured], said);
    }
}

#[test]
fn missing_joints_are_evaluated_as_by_the_published_program() {
    let protocol = BodyProtocol::published(640.0, 480.0);
    let sequence = BodySequence::evaluate(&truth(true), &predicted(true), &protocol).unwrap();
    compare(
        &sequence.raw,
        &Said {
            instants: 178,
            pck: [
                0.014_318_823_665_420_673,
                0.062_345_512_499_380_69,
                0.215_731_988_615_406_63,
                0.541_266_398_383_696,
                0.719_180_947_871_994_7,
                0.841_367_142_125_747_8,
            ],
            auc: 0.557_153_824_133_356,
            mpjpe_px: 105.759_275_658_080_33,
            rmse_px: 303.088_737_742_306_8,
            rmse_percent: 109.327_722_670_431_5,
            joint_4: (116.632_088_001_730_04, 125.098_409_911_444_12),
        },
    );
    compare(
        &sequence.resampled,
        &Said {
            instants: 4_000,
            pck: [
                0.021_806_693_306_693_308,
                0.099_024_342_678_598_01,
                0.304_950_554_764_384_54,
                0.617_433_614_258_082_3,
                0.765_921_775_033_477_2,
                0.842_125_236_465_662,
            ],
            auc: 0.598_945_651_582_46,
            mpjpe_px: 94.732_832_303_022_38,
            rmse_px: 239.623_333_220_227_15,
            rmse_percent: 92.951_865_768_781_53,
            joint_4: (219.646_269_268_113_02, 299.045_365_383_575_3),
        },
    );
}
