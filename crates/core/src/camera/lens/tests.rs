//! Closed forms, and results of OpenCV.

mod golden;

use super::*;
use golden::{CAMERAS, Golden};

/// Precision of the printed results.
const TOLERANCE_PX: f64 = 1e-8;

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
fn directions_project_to_the_points_of_opencv() {
    for golden in CAMERAS {
        let camera = golden.camera();
        for &[x, y, image_x, image_y] in golden.distorted {
            let wanted = DVec2::new(image_x, image_y) + 0.5;
            let got = camera.image_from_direction(DVec2::new(x, y));
            assert!((got - wanted).length() < TOLERANCE_PX, "{}: {got} of {wanted}", golden.name);
            let point_m = DVec3::new(3.0 * x, -3.0 * y, -3.0);
            let got = camera.image_from_camera(point_m).unwrap();
            assert!((got - wanted).length() < TOLERANCE_PX, "{}: {got} of {wanted}", golden.name);
            assert_eq!(camera.image_from_camera(-point_m), None);
        }
    }
}

#[test]
fn five_undistortion_steps_are_those_of_opencv_converged_or_not() {
    for golden in CAMERAS {
        let camera = golden.camera();
        for &[x, y, undistorted_x, undistorted_y, ..] in golden.undistorted {
            let ray = camera.direction_from_image(DVec2::new(x, y) + 0.5, 5);
            let got = camera.pinhole_image_from_direction(ray.direction) - 0.5;
            let off = (got - DVec2::new(undistorted_x, undistorted_y)).length();
            assert!(off < TOLERANCE_PX, "{}: {got} at {x}, {y}", golden.name);
        }
    }
}

#[test]
fn undistortion_converges_to_the_points_of_opencv_or_has_an_error() {
    let mut diverged = Vec::new();
    for golden in CAMERAS {
        let camera = golden.camera();
        for &[x, y, .., undistorted_x, undistorted_y] in golden.undistorted {
            let ray = camera.direction_from_image(DVec2::new(x, y) + 0.5, 500);
            let has_converged = ray.error_px < 1e-6;
            if !has_converged {
                diverged.push((golden.name, x, y));
                continue;
            }
            let got = camera.pinhole_image_from_direction(ray.direction) - 0.5;
            let off = (got - DVec2::new(undistorted_x, undistorted_y)).length();
            assert!(off < 1e-7, "{}: {got} at {x}, {y}", golden.name);
        }
    }
    // The barrel ends 0.905 focal lengths from the axis: no direction projects beyond.
    let beyond = [(0, 0), (639, 0), (0, 160), (639, 160), (0, 479), (639, 479)];
    assert_eq!(diverged, beyond.map(|(x, y)| ("brown", f64::from(x), f64::from(y))));
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
    let distorted = distortion.distort(DVec2::new(0.3, 0.4));
    assert!((distorted - DVec2::new(0.3, 0.4) * (1.0 - 0.2 * 0.25)).length() < 1e-15);
}

#[test]
fn coefficients_come_back_in_opencvs_order_and_other_counts_are_refused() {
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

#[test]
fn a_camera_of_a_file_has_its_values_and_faulty_ones_name_their_field() {
    let fields = ["focal", "point", "lens"];
    let read = |focal, point, distortion: &[f64]| {
        LensCamera::from_file(focal, point, distortion).map_err(|error| error.in_field(fields))
    };
    let good = ([310.0, 311.0], [-2.0, 129.5], [-0.3, 0.1, 0.0, 0.0]);
    let camera = read(good.0, good.1, &good.2).unwrap();
    assert_eq!((camera.focal_px, camera.principal_px), (good.0.into(), good.1.into()));
    assert_eq!(Some(camera.distortion), Distortion::from_opencv(&good.2));
    let refused = |camera: Result<LensCamera, String>, field: &str| {
        let message = camera.unwrap_err();
        assert!(message.starts_with(&format!("{field}: ")), "{message}");
    };
    for k in 0..2 {
        let with = |mut pair: [f64; 2], value| {
            pair[k] = value;
            pair
        };
        for focal in [0.0, -0.0, -310.0, f64::INFINITY, f64::NAN] {
            refused(read(with(good.0, focal), good.1, &good.2), "focal");
        }
        refused(read(good.0, with(good.1, f64::NAN), &good.2), "point");
    }
    refused(read(good.0, good.1, &[0.0; 3]), "lens");
    refused(read(good.0, good.1, &[0.0, f64::INFINITY, 0.0, 0.0]), "lens");
}
