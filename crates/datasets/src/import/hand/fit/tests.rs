//! Fits to joints of hands with known parameters.

use evpose_camera::Calibration;
use evpose_core::SensorSize;
use evpose_pose::JointFrame;
use evpose_task::hand::{HandConfig, canonical_view};

use super::*;

const SENSOR: SensorSize = SensorSize { width: 346, height: 260 };

fn fitter(is_mirrored: bool) -> HandFitter {
    let config = HandConfig::default();
    let adaptor =
        ViewAdaptor::new(&Calibration::from_vertical_fov(SENSOR, 50.0), &canonical_view(&config));
    let view = HandView::new(&config).unwrap();
    HandFitter::new(view, adaptor, HandSide::Right, is_mirrored, FitOptions::default())
}

/// A hand before the camera of the default config, bent by `bend` and turned by `turn` radians.
fn hand(fitter: &HandFitter, bend: f32, turn: f32) -> HandParams {
    let at_m = Vec3::new(0.02, -0.01, 0.45);
    let zero = fitter.model_m(&Guess { params: HandParams::default(), scale: 1.0 })[0];
    HandParams {
        articulation: [bend, -0.5 * bend, 0.3 * bend, 0.0, 0.2 * bend, -0.1],
        translation_m: fitter.world_from_camera(at_m - zero),
        rotation: Vec3::new(0.3, turn, -0.4),
    }
}

/// Joints in the frame of the camera, and on the sensor.
fn joints(fitter: &HandFitter, params: &HandParams, scale: f64) -> ([Vec3; 21], [Vec2; 21]) {
    let at_m = fitter.model_m(&Guess { params: *params, scale });
    (at_m, at_m.map(|at_m| fitter.adaptor.sensor_from_view(fitter.view_px(at_m))))
}

fn max_distance_m(a: &[Vec3; 21], b: &[Vec3; 21]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

#[test]
fn joints_in_space_give_the_pose_from_any_rotation() {
    let fitter = fitter(false);
    for turn in [-2.6, -1.0, 0.7, 2.2] {
        let truth = hand(&fitter, 1.0, turn);
        let (at_m, _) = joints(&fitter, &truth, 1.0);
        let label = HandJoints::Metres(at_m.map(Some), JointFrame::Camera);
        let fitted = fitter.fit(&label, None).unwrap();
        let (back_m, _) = joints(&fitter, &fitted.params, 1.0);
        assert!(max_distance_m(&at_m, &back_m) < 5e-4, "{turn}: {fitted:?}");
        assert!(fitted.residual_m.unwrap() < 3e-4 && !fitter.is_poor(&fitted));
    }
}

#[test]
fn joints_on_the_image_are_met_and_the_pose_before_is_followed() {
    let fitter = fitter(false);
    let mut before = None;
    for turn in [0.7, 0.75, 0.8] {
        let (at_m, at_px) = joints(&fitter, &hand(&fitter, 0.8, turn), 1.0);
        let mut labels = at_px.map(Some);
        labels[4] = None;
        let fitted = fitter.fit(&HandJoints::Pixels(labels), before.as_ref()).unwrap();
        let (back_m, back_px) = joints(&fitter, &fitted.params, 1.0);
        let max_px = at_px.iter().zip(&back_px).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(max_px < 1.0, "{turn}: {max_px} px");
        assert!(max_distance_m(&at_m, &back_m) < 0.02, "{turn}");
        before = Some(fitted.params);
    }
}

#[test]
fn a_mirrored_left_hand_is_a_right_one() {
    let fitter = fitter(true);
    let truth = hand(&fitter, 0.5, 1.0);
    let (at_m, _) = joints(&fitter, &truth, 1.0);
    let left_m = at_m.map(|at_m| Some(at_m * Vec3::new(-1.0, 1.0, 1.0)));
    let fitted = fitter.fit(&HandJoints::Metres(left_m, JointFrame::Camera), None).unwrap();
    assert!(fitted.residual_m.unwrap() < 3e-4, "{fitted:?}");
}

#[test]
fn the_size_of_a_hand_follows_from_joints_in_space() {
    let fitter = fitter(false);
    let (at_m, at_px) = joints(&fitter, &hand(&fitter, 0.5, 1.0), 1.12);
    let label = HandJoints::Metres(at_m.map(Some), JointFrame::Camera);
    let scale = fitter.fit_scale(&label).unwrap();
    assert!((scale - 1.12).abs() < 5e-3, "{scale}");
    assert_eq!(fitter.fit_scale(&HandJoints::Pixels(at_px.map(Some))), None);
    let fitted = fitter.with_scale(scale).fit(&label, None).unwrap();
    assert!(fitted.residual_m.unwrap() < 5e-4, "{fitted:?}");
}

#[test]
fn few_joints_are_no_hand_and_joints_of_no_hand_are_poor() {
    let fitter = fitter(false);
    let mut labels = [None; 21];
    labels[..5].fill(Some(Vec3::Z));
    assert_eq!(fitter.fit(&HandJoints::Metres(labels, JointFrame::Camera), None), None);
    let apart: [Option<Vec3>; 21] =
        std::array::from_fn(|k| Some(Vec3::new(0.1 * (k % 3) as f32, 0.1 * (k % 5) as f32, 0.6)));
    let fitted = fitter.fit(&HandJoints::Metres(apart, JointFrame::Camera), None).unwrap();
    assert!(fitter.is_poor(&fitted), "{fitted:?}");
}

/// Of two fingers nothing is labelled, and of the others other joints are missing in each image.
#[test]
fn on_the_image_a_hand_is_fitted_to_the_joints_that_are_labelled() {
    let fitter = fitter(false);
    let mut before = None;
    for (k, turn) in [0.7, 0.75, 0.8].into_iter().enumerate() {
        let (_, at_px) = joints(&fitter, &hand(&fitter, 0.8, turn), 1.0);
        let mut labels = at_px.map(Some);
        // Ring finger and pinky, and one joint more.
        for missing in [4, 5, 12, 13, 14, 15, 16, 17, 6 + k] {
            labels[missing] = None;
        }
        let fitted = fitter.fit(&HandJoints::Pixels(labels), before.as_ref()).unwrap();
        let (_, back_px) = joints(&fitter, &fitted.params, 1.0);
        for (joint, (want, got)) in at_px.iter().zip(&back_px).enumerate() {
            let max_px = if labels[joint].is_some() { 1.0 } else { 8.0 };
            assert!(want.distance(*got) < max_px, "{turn}, {joint}: {want} {got}");
        }
        before = Some(fitted.params);
    }
}
