//! Hands that are fitted to their own joints, exact, disturbed and in part.

use evpose_core::CounterRng;
use glam::Quat;

use super::*;
use crate::fingers::GESTURES;
use prior::flat;

/// Cells to one unit of a ray: of a crop as the configs make them.
const FOCAL_CELLS: f32 = 60.0;

fn fit() -> HandFit {
    let model = BodyModel::procedural_arm();
    HandFit::new(&model, &model.shaped(&[]), HandSide::Right)
}

/// A gesture as somebody makes it, turned and placed.
fn pose(fit: &HandFit, sample: u64) -> FittedPose {
    let mut rng = CounterRng::new(9, "fitted hands", sample);
    let axis = Vec3::from_array([(); 3].map(|()| rng.uniform(-1.8, 1.8)));
    let angles = GESTURES[sample as usize % GESTURES.len()].angles().varied(1.0, &mut rng);
    let rotations = fit.axes.rotations(&angles);
    FittedPose {
        angles,
        rotations,
        articulation: fit.skeleton.coefficients(&rotations),
        rotation: Mat3::from_quat(Quat::from_scaled_axis(axis)),
        position_m: Vec3::new(
            rng.uniform(-0.08, 0.08),
            rng.uniform(-0.08, 0.08),
            rng.uniform(-0.6, -0.3),
        ),
    }
}

fn observed(fit: &HandFit, pose: &FittedPose) -> JointObservation {
    let at_m = fit.points_m(pose);
    JointObservation {
        rays: at_m.map(|at| at.truncate() / -at.z),
        depths: at_m.map(|at| (pose.position_m.z - at.z) / fit.palm_m()),
        spread_cells: [0.0; JOINTS],
        scores: [1.0; JOINTS],
        presence: 1.0,
    }
}

fn mean_error_m(a: &[Vec3; JOINTS], b: &[Vec3; JOINTS]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).sum::<f32>() / JOINTS as f32
}

#[test]
fn exact_joints_give_the_hand_they_are_of() {
    let (fit, count) = (fit(), 2 * GESTURES.len() as u64);
    let (mut error_m, mut of_shape_m, mut of_angles_rad) = (0.0, 0.0, 0.0);
    for sample in 0..count {
        let pose = pose(&fit, sample);
        let fitted = fit.fit(&observed(&fit, &pose), FOCAL_CELLS);
        let [found, want] = [fitted, pose].map(|pose| fit.points_m(&pose));
        error_m += mean_error_m(&found, &want);
        let from_wrist = |points_m: [Vec3; JOINTS]| points_m.map(|point_m| point_m - points_m[0]);
        of_shape_m += mean_error_m(&from_wrist(found), &from_wrist(want));
        let pairs = flat(&pose.angles).into_iter().zip(flat(&fitted.angles));
        of_angles_rad += pairs.map(|(a, b)| (a - b).abs()).sum::<f32>() / ANGLES as f32;
    }
    // The prior pulls towards the mean hand, and the distance is what joints say least about.
    let of = |sum: f32| sum / count as f32;
    assert!(of(error_m) < 0.01, "{} m", of(error_m));
    assert!(of(of_shape_m) < 0.004, "{} m", of(of_shape_m));
    assert!(of(of_angles_rad) < 0.1, "{}", of(of_angles_rad));
}

#[test]
fn errors_of_half_a_cell_stay_millimetres_and_joints_that_may_be_anywhere_do_not_count() {
    let fit = fit();
    let mut sum_m = 0.0;
    for sample in 0..50 {
        let pose = pose(&fit, sample);
        let mut rng = CounterRng::new(2, "errors of joints", sample);
        let mut observed = observed(&fit, &pose);
        for joint in 0..JOINTS {
            observed.rays[joint] += Vec2::new(rng.normal(), rng.normal()) * 0.5 / FOCAL_CELLS;
            observed.depths[joint] += 0.1 * rng.normal();
        }
        // A finger that lies anywhere.
        for joint in [2, 6, 7, 8] {
            observed.rays[joint] = Vec2::new(rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3));
            (observed.scores[joint], observed.spread_cells[joint]) = (0.02, 12.0);
        }
        let fitted = fit.fit(&observed, FOCAL_CELLS);
        sum_m += mean_error_m(&fit.points_m(&fitted), &fit.points_m(&pose));
    }
    assert!(sum_m / 50.0 < 0.025, "{} m", sum_m / 50.0);
}

#[test]
fn joints_of_no_hand_give_a_finite_pose_before_the_camera() {
    let fit = fit();
    for (spread, depth) in [(12.0, 0.0), (0.0, 9.0), (9.0, -9.0)] {
        let observed = JointObservation {
            rays: [Vec2::ZERO; JOINTS],
            depths: [depth; JOINTS],
            spread_cells: [spread; JOINTS],
            scores: [0.0; JOINTS],
            presence: 0.0,
        };
        let fitted = fit.fit(&observed, FOCAL_CELLS);
        assert!(fitted.position_m.is_finite(), "{fitted:?}");
        assert!((-FAR_M * 1.001..0.0).contains(&fitted.position_m.z), "{fitted:?}");
        assert!(fitted.articulation.iter().all(|value| value.abs() <= MAX_ARTICULATION));
        assert_eq!(fitted.angles, fitted.angles.clamped());
    }
}

#[test]
fn a_hand_that_is_hardly_seen_is_nearer_than_one_that_looks_as_large() {
    let fit = fit();
    for sample in 0..20 {
        let mut observed = observed(&fit, &pose(&fit, sample));
        observed.spread_cells = [SEEN_SPREAD_CELLS; JOINTS];
        observed.spread_cells[..10].fill(12.0);
        assert_eq!(observed.nearer(), 1.0);
        observed.spread_cells = [SEEN_SPREAD_CELLS; JOINTS];
        let seen_m = fit.fit(&observed, FOCAL_CELLS).position_m.length();
        observed.spread_cells = [4.0; JOINTS];
        let hardly_seen_m = fit.fit(&observed, FOCAL_CELLS).position_m.length();
        assert!((0.65..0.95).contains(&(hardly_seen_m / seen_m)), "{hardly_seen_m} m, {seen_m} m");
    }
}
