//! Closed forms, and numbers of OpenCV.

#![allow(clippy::unwrap_used, reason = "tests")]

use super::*;

/// What OpenCV 4.14.0 and 5.0.0 (`opencv-python-headless`, the same numbers of both) say of a camera,
/// pixel centres at whole numbers.
struct Golden {
    name: &'static str,
    focal_px: (f64, f64),
    centre_px: (f64, f64),
    coefficients: &'static [f64],
    /// Of `projectPoints`: direction, image.
    seen: &'static [[f64; 4]],
    /// Of `undistortPoints` with `P = K`: image, image without distortion after the five steps that
    /// it takes by default, and after 500 or a step below 1e-12.
    straight: &'static [[f64; 6]],
}

fn golden() -> [Golden; 3] {
    [
        Golden {
            name: "davis240c",
            focal_px: (252.91294004, 253.08270535),
            centre_px: (129.63181808, 89.72598511),
            coefficients: &[
                -33.0783118,
                340.196626,
                -0.000319491618,
                -0.000628058571,
                167.31902,
                -32.7436981,
                329.048638,
                285.123812,
            ],
            seen: &[
                [-0.427_024_413_95, -0.320_053_477_73, 29.784_187_284_64, 14.851_162_210_03],
                [0.213_512_206_97, -0.320_053_477_73, 181.245_390_775_48, 12.258_388_790_76],
                [-0.213_512_206_97, -0.106_684_492_58, 76.591_116_391_62, 63.205_552_473_47],
                [0.427_024_413_95, -0.106_684_492_58, 231.567_427_975_76, 64.218_724_662_54],
                [0.0, 0.106_684_492_58, 129.630_010_182_56, 116.621_002_876_25],
                [-0.427_024_413_95, 0.320_053_477_73, 29.828_361_186_93, 164.521_623_553_37],
                [0.213_512_206_97, 0.320_053_477_73, 181.223_303_824_34, 167.136_513_585_04],
            ],
            straight: &[
                [
                    0.0,
                    0.0,
                    -17.017_739_440_07,
                    -11.795_366_897_94,
                    -17.021_604_708_26,
                    -11.798_047_299_92,
                ],
                [
                    60.0,
                    0.0,
                    55.320_477_860_37,
                    -6.060_279_509_44,
                    55.320_390_127_71,
                    -6.060_393_224_1,
                ],
                [
                    120.0,
                    0.0,
                    119.613_404_852_22,
                    -3.802_816_232_32,
                    119.613_403_874_04,
                    -3.802_825_909_48,
                ],
                [
                    239.0,
                    0.0,
                    250.875_271_381_91,
                    -9.652_672_426_99,
                    250.876_727_182_53,
                    -9.653_852_723_01,
                ],
                [
                    0.0,
                    60.0,
                    -12.074_508_854_1,
                    57.247_237_514_16,
                    -12.075_322_006_25,
                    57.247_052_387_76,
                ],
                [
                    60.0,
                    60.0,
                    57.957_321_640_3,
                    59.129_250_993_19,
                    57.957_320_710_09,
                    59.129_250_596_7,
                ],
                [
                    120.0,
                    60.0,
                    119.954_160_723_65,
                    59.852_194_625_88,
                    119.954_160_723_64,
                    59.852_194_625_87,
                ],
                [
                    239.0,
                    60.0,
                    246.589_531_926_99,
                    57.967_628_055_02,
                    246.589_697_865_35,
                    57.967_583_733_79,
                ],
                [
                    0.0,
                    179.0,
                    -17.076_406_411_58,
                    190.866_946_827_85,
                    -17.080_441_217_17,
                    190.869_759_597_77,
                ],
                [
                    60.0,
                    179.0,
                    55.305_012_735_35,
                    185.088_762_684_76,
                    55.304_920_549_48,
                    185.088_882_468_79,
                ],
                [
                    120.0,
                    179.0,
                    119.611_824_938_82,
                    182.819_512_641_28,
                    119.611_823_900_39,
                    182.819_522_926_07,
                ],
                [
                    239.0,
                    179.0,
                    250.913_875_306_5,
                    188.704_236_008_34,
                    250.915_394_871_79,
                    188.705_473_012_34,
                ],
            ],
        },
        Golden {
            name: "all14",
            focal_px: (300.0, 305.0),
            centre_px: (170.0, 131.0),
            coefficients: &[
                -0.31, 0.12, 0.0008, -0.0005, -0.02, 0.05, -0.01, 0.004, 0.003, -0.002, -0.001,
                0.004, 0.02, -0.035,
            ],
            seen: &[
                [-0.519, -0.383_606_557_38, 37.156_389_928_23, 31.151_040_766_22],
                [0.259_5, -0.383_606_557_38, 242.548_801_483_5, 22.307_427_824_29],
                [-0.259_5, -0.127_868_852_46, 95.268_883_542_28, 93.499_095_579_84],
                [0.519, -0.127_868_852_46, 313.622_830_998_66, 95.267_527_254_99],
                [0.0, 0.127_868_852_46, 170.012_140_740_9, 169.886_001_939_28],
                [-0.519, 0.383_606_557_38, 35.204_487_693_12, 232.493_444_653_96],
                [0.259_5, 0.383_606_557_38, 243.697_455_368_26, 241.606_172_126_85],
            ],
            straight: &[
                [
                    0.0,
                    0.0,
                    -56.187_005_259_55,
                    -44.202_827_691_68,
                    -56.669_170_595_62,
                    -44.606_681_203_69,
                ],
                [
                    86.0,
                    0.0,
                    73.922_909_429_9,
                    -18.639_128_750_55,
                    73.918_663_134_79,
                    -18.645_782_573_34,
                ],
                [
                    173.0,
                    0.0,
                    173.114_150_006_02,
                    -11.455_656_718_47,
                    173.114_156_505_91,
                    -11.456_281_772_72,
                ],
                [
                    345.0,
                    0.0,
                    390.582_522_020_03,
                    -35.565_406_243_61,
                    390.993_952_391_39,
                    -35.894_722_158_98,
                ],
                [
                    0.0,
                    86.0,
                    -33.497_394_761_06,
                    77.016_035_757_94,
                    -33.540_690_326_57,
                    77.003_573_011_95,
                ],
                [
                    86.0,
                    86.0,
                    81.515_032_418_16,
                    83.674_401_256_12,
                    81.515_023_145,
                    83.674_396_333_9,
                ],
                [
                    173.0,
                    86.0,
                    173.014_295_021_49,
                    85.516_541_000_37,
                    173.014_295_021_5,
                    85.516_540_999_94,
                ],
                [
                    345.0,
                    86.0,
                    369.984_996_360_84,
                    79.061_203_296_53,
                    370.021_608_872_07,
                    79.050_830_750_64,
                ],
                [
                    0.0,
                    259.0,
                    -47.722_516_051_55,
                    294.003_055_998_51,
                    -47.986_580_976_47,
                    294.188_889_365_05,
                ],
                [
                    86.0,
                    259.0,
                    76.558_971_667_97,
                    273.101_094_323_75,
                    76.556_797_641_6,
                    273.104_294_421_98,
                ],
                [
                    173.0,
                    259.0,
                    173.045_219_178_81,
                    266.645_438_311_31,
                    173.045_221_960_62,
                    266.645_713_506_91,
                ],
                [
                    345.0,
                    259.0,
                    382.621_286_942_34,
                    285.817_127_091_12,
                    382.845_853_865_43,
                    285.970_027_449_43,
                ],
            ],
        },
        Golden {
            name: "brown",
            focal_px: (330.0, 331.0),
            centre_px: (322.5, 241.25),
            coefficients: &[-0.36, 0.16, -0.0012, 0.0003, -0.035],
            seen: &[
                [-0.872_727_272_73, -0.652_567_975_83, 109.336_805_797_37, 80.817_758_483_98],
                [0.436_363_636_36, -0.652_567_975_83, 442.447_854_753_52, 61.174_954_458_81],
                [-0.436_363_636_36, -0.217_522_658_61, 189.575_552_722_37, 174.681_582_669_41],
                [0.872_727_272_73, -0.217_522_658_61, 551.827_018_422_79, 183.616_944_890_41],
                [0.0, 0.217_522_658_61, 322.504_684_294_59, 311.992_708_821_75],
                [-0.872_727_272_73, 0.652_567_975_83, 110.238_915_767_16, 400.062_310_742_15],
                [0.436_363_636_36, 0.652_567_975_83, 441.996_799_768_62, 420.158_907_560_72],
            ],
            straight: &[
                [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                [
                    160.0,
                    0.0,
                    88.959_202_792_12,
                    -104.246_078_342_61,
                    86.746_884_273_18,
                    -107.474_730_859_79,
                ],
                [
                    320.0,
                    0.0,
                    319.236_148_464_35,
                    -63.119_190_369_05,
                    319.232_374_070_2,
                    -63.413_653_978_67,
                ],
                [639.0, 0.0, 639.0, 0.0, 639.0, 0.0],
                [0.0, 160.0, 0.0, 160.0, -243.122_305_191_89, 100.480_962_554_83],
                [
                    160.0,
                    160.0,
                    138.344_535_482_94,
                    149.368_796_320_78,
                    138.333_868_220_17,
                    149.363_576_861_45,
                ],
                [
                    320.0,
                    160.0,
                    319.938_863_126_03,
                    158.245_564_039_31,
                    319.938_863_118_14,
                    158.245_563_813_25,
                ],
                [
                    639.0,
                    160.0,
                    1154.315_974_506_74,
                    30.745_900_749_48,
                    830.359_716_750_19,
                    112.127_456_517_05,
                ],
                [0.0, 479.0, 0.0, 479.0, 0.0, 479.0],
                [
                    160.0,
                    479.0,
                    87.443_641_311_03,
                    585.724_517_593_63,
                    84.688_299_585_56,
                    589.787_489_915_99,
                ],
                [
                    320.0,
                    479.0,
                    319.231_819_275_3,
                    542.629_489_936_2,
                    319.227_300_682_68,
                    542.985_384_770_27,
                ],
                [639.0, 479.0, 639.0, 479.0, 639.0, 479.0],
            ],
        },
    ]
}

/// Digits that were written down.
const CLOSE_PX: f64 = 1e-8;

impl Golden {
    fn camera(&self) -> LensCamera {
        LensCamera::from_opencv(
            self.focal_px.into(),
            self.centre_px.into(),
            Distortion::from_opencv(self.coefficients).unwrap(),
        )
    }
}

#[test]
fn directions_are_seen_where_opencv_sees_them() {
    for golden in golden() {
        let camera = golden.camera();
        for &[x, y, image_x, image_y] in golden.seen {
            let wanted = DVec2::new(image_x, image_y) + 0.5;
            let got = camera.image_from_direction(DVec2::new(x, y));
            assert!((got - wanted).length() < CLOSE_PX, "{}: {got} of {wanted}", golden.name);
            let point_m = DVec3::new(3.0 * x, -3.0 * y, -3.0);
            let got = camera.image_from_camera(point_m).unwrap();
            assert!((got - wanted).length() < CLOSE_PX, "{}: {got} of {wanted}", golden.name);
            assert_eq!(camera.image_from_camera(-point_m), None);
        }
    }
}

#[test]
fn five_steps_of_the_way_back_are_those_of_opencv_converged_or_not() {
    for golden in golden() {
        let camera = golden.camera();
        for &[x, y, straight_x, straight_y, ..] in golden.straight {
            let sight = camera.direction_from_image(DVec2::new(x, y) + 0.5, 5);
            let got = camera.pinhole_image_from_direction(sight.direction) - 0.5;
            let off = (got - DVec2::new(straight_x, straight_y)).length();
            assert!(off < CLOSE_PX, "{}: {got} at {x}, {y}", golden.name);
        }
    }
}

#[test]
fn the_way_back_converges_to_where_opencv_does_or_says_that_it_does_not() {
    let mut unsettled = Vec::new();
    for golden in golden() {
        let camera = golden.camera();
        for &[x, y, .., straight_x, straight_y] in golden.straight {
            let sight = camera.direction_from_image(DVec2::new(x, y) + 0.5, 500);
            if !(sight.error_px < 1e-6) {
                unsettled.push((golden.name, x, y));
                continue;
            }
            let got = camera.pinhole_image_from_direction(sight.direction) - 0.5;
            let off = (got - DVec2::new(straight_x, straight_y)).length();
            assert!(off < 1e-7, "{}: {got} at {x}, {y}", golden.name);
        }
    }
    // The barrel ends 0.905 focal lengths from the axis: no direction is seen beyond.
    let beyond = [(0, 0), (639, 0), (0, 160), (639, 160), (0, 479), (639, 479)];
    assert_eq!(unsettled, beyond.map(|(x, y)| ("brown", f64::from(x), f64::from(y))));
}

#[test]
fn without_coefficients_a_lens_is_a_pinhole() {
    let sensor = crate::SensorSize::DAVIS240C;
    let pinhole = crate::Pinhole::from_vertical_fov(sensor, 45.0);
    let camera = LensCamera {
        focal_px: DVec2::splat(pinhole.focal_px.into()),
        principal_px: pinhole.principal_px.as_dvec2(),
        distortion: Distortion::default(),
    };
    let point_m = glam::Vec3::new(0.1, 0.2, -0.7);
    let got = camera.image_from_camera(point_m.as_dvec3()).unwrap();
    let wanted = pinhole.image_from_camera(point_m).unwrap().as_dvec2();
    assert!((got - wanted).length() < 1e-4, "{got} of {wanted}");
}

#[test]
fn one_radial_coefficient_is_the_textbook_formula() {
    let distortion = Distortion::from_opencv(&[-0.2, 0.0, 0.0, 0.0]).unwrap();
    let seen = distortion.distorted(DVec2::new(0.3, 0.4));
    assert!((seen - DVec2::new(0.3, 0.4) * (1.0 - 0.2 * 0.25)).length() < 1e-15);
}

#[test]
fn coefficients_come_back_in_opencvs_order_and_odd_numbers_of_them_are_refused() {
    let all: [f64; 14] = std::array::from_fn(|i| i as f64 + 1.0);
    for count in [0, 4, 5, 8, 12, 14] {
        let mut wanted = all;
        wanted[count..].fill(0.0);
        assert_eq!(Distortion::from_opencv(&all[..count]).unwrap().to_opencv(), wanted);
    }
    for count in [1, 3, 6, 9, 13] {
        assert_eq!(Distortion::from_opencv(&all[..count]), None);
    }
}
