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

#[rustfmt::skip]
fn golden() -> [Golden; 3] {
    [
        Golden {
            name: "davis240c",
            focal_px: (252.91294004, 253.08270535),
            centre_px: (129.63181808, 89.72598511),
            coefficients: &[-33.0783118, 340.196626, -0.000319491618, -0.000628058571, 167.31902, -32.7436981, 329.048638, 285.123812],
            seen: &[
                [-0.42702441395, -0.32005347773, 29.78418728464, 14.85116221003],
                [0.21351220697, -0.32005347773, 181.24539077548, 12.25838879076],
                [-0.21351220697, -0.10668449258, 76.59111639162, 63.20555247347],
                [0.42702441395, -0.10668449258, 231.56742797576, 64.21872466254],
                [0.0, 0.10668449258, 129.63001018256, 116.62100287625],
                [-0.42702441395, 0.32005347773, 29.82836118693, 164.52162355337],
                [0.21351220697, 0.32005347773, 181.22330382434, 167.13651358504],
            ],
            straight: &[
                [0.0, 0.0, -17.01773944007, -11.79536689794, -17.02160470826, -11.79804729992],
                [60.0, 0.0, 55.32047786037, -6.06027950944, 55.32039012771, -6.0603932241],
                [120.0, 0.0, 119.61340485222, -3.80281623232, 119.61340387404, -3.80282590948],
                [239.0, 0.0, 250.87527138191, -9.65267242699, 250.87672718253, -9.65385272301],
                [0.0, 60.0, -12.0745088541, 57.24723751416, -12.07532200625, 57.24705238776],
                [60.0, 60.0, 57.9573216403, 59.12925099319, 57.95732071009, 59.1292505967],
                [120.0, 60.0, 119.95416072365, 59.85219462588, 119.95416072364, 59.85219462587],
                [239.0, 60.0, 246.58953192699, 57.96762805502, 246.58969786535, 57.96758373379],
                [0.0, 179.0, -17.07640641158, 190.86694682785, -17.08044121717, 190.86975959777],
                [60.0, 179.0, 55.30501273535, 185.08876268476, 55.30492054948, 185.08888246879],
                [120.0, 179.0, 119.61182493882, 182.81951264128, 119.61182390039, 182.81952292607],
                [239.0, 179.0, 250.9138753065, 188.70423600834, 250.91539487179, 188.70547301234],
            ],
        },
        Golden {
            name: "all14",
            focal_px: (300.0, 305.0),
            centre_px: (170.0, 131.0),
            coefficients: &[-0.31, 0.12, 0.0008, -0.0005, -0.02, 0.05, -0.01, 0.004, 0.003, -0.002, -0.001, 0.004, 0.02, -0.035],
            seen: &[
                [-0.519, -0.38360655738, 37.15638992823, 31.15104076622],
                [0.2595, -0.38360655738, 242.5488014835, 22.30742782429],
                [-0.2595, -0.12786885246, 95.26888354228, 93.49909557984],
                [0.519, -0.12786885246, 313.62283099866, 95.26752725499],
                [0.0, 0.12786885246, 170.0121407409, 169.88600193928],
                [-0.519, 0.38360655738, 35.20448769312, 232.49344465396],
                [0.2595, 0.38360655738, 243.69745536826, 241.60617212685],
            ],
            straight: &[
                [0.0, 0.0, -56.18700525955, -44.20282769168, -56.66917059562, -44.60668120369],
                [86.0, 0.0, 73.9229094299, -18.63912875055, 73.91866313479, -18.64578257334],
                [173.0, 0.0, 173.11415000602, -11.45565671847, 173.11415650591, -11.45628177272],
                [345.0, 0.0, 390.58252202003, -35.56540624361, 390.99395239139, -35.89472215898],
                [0.0, 86.0, -33.49739476106, 77.01603575794, -33.54069032657, 77.00357301195],
                [86.0, 86.0, 81.51503241816, 83.67440125612, 81.515023145, 83.6743963339],
                [173.0, 86.0, 173.01429502149, 85.51654100037, 173.0142950215, 85.51654099994],
                [345.0, 86.0, 369.98499636084, 79.06120329653, 370.02160887207, 79.05083075064],
                [0.0, 259.0, -47.72251605155, 294.00305599851, -47.98658097647, 294.18888936505],
                [86.0, 259.0, 76.55897166797, 273.10109432375, 76.5567976416, 273.10429442198],
                [173.0, 259.0, 173.04521917881, 266.64543831131, 173.04522196062, 266.64571350691],
                [345.0, 259.0, 382.62128694234, 285.81712709112, 382.84585386543, 285.97002744943],
            ],
        },
        Golden {
            name: "brown",
            focal_px: (330.0, 331.0),
            centre_px: (322.5, 241.25),
            coefficients: &[-0.36, 0.16, -0.0012, 0.0003, -0.035],
            seen: &[
                [-0.87272727273, -0.65256797583, 109.33680579737, 80.81775848398],
                [0.43636363636, -0.65256797583, 442.44785475352, 61.17495445881],
                [-0.43636363636, -0.21752265861, 189.57555272237, 174.68158266941],
                [0.87272727273, -0.21752265861, 551.82701842279, 183.61694489041],
                [0.0, 0.21752265861, 322.50468429459, 311.99270882175],
                [-0.87272727273, 0.65256797583, 110.23891576716, 400.06231074215],
                [0.43636363636, 0.65256797583, 441.99679976862, 420.15890756072],
            ],
            straight: &[
                [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                [160.0, 0.0, 88.95920279212, -104.24607834261, 86.74688427318, -107.47473085979],
                [320.0, 0.0, 319.23614846435, -63.11919036905, 319.2323740702, -63.41365397867],
                [639.0, 0.0, 639.0, 0.0, 639.0, 0.0],
                [0.0, 160.0, 0.0, 160.0, -243.12230519189, 100.48096255483],
                [160.0, 160.0, 138.34453548294, 149.36879632078, 138.33386822017, 149.36357686145],
                [320.0, 160.0, 319.93886312603, 158.24556403931, 319.93886311814, 158.24556381325],
                [639.0, 160.0, 1154.31597450674, 30.74590074948, 830.35971675019, 112.12745651705],
                [0.0, 479.0, 0.0, 479.0, 0.0, 479.0],
                [160.0, 479.0, 87.44364131103, 585.72451759363, 84.68829958556, 589.78748991599],
                [320.0, 479.0, 319.2318192753, 542.6294899362, 319.22730068268, 542.98538477027],
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
            let is_settled = sight.error_px < 1e-6;
            if !is_settled {
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
