//! Hands that are fitted to their own joints, exact, disturbed and in part.

use evpose_core::CounterRng;
use glam::Quat;

use super::*;
use crate::BodyModel;

/// Cells to one unit of a ray: of a crop as the configs make them.
const FOCAL_CELLS: f32 = 60.0;

fn fit() -> HandFit {
    let model = BodyModel::procedural_arm();
    HandFit::new(HandSkeleton::new(&model, &model.shaped(&[])))
}

fn pose(sample: u64) -> FittedPose {
    let mut rng = CounterRng::new(9, "fitted hands", sample);
    let axis = Vec3::from_array([(); 3].map(|()| rng.uniform(-1.8, 1.8)));
    FittedPose {
        articulation: [(); 6].map(|()| rng.uniform(-1.5, 1.5)),
        rotation: Mat3::from_quat(Quat::from_scaled_axis(axis)),
        position_m: Vec3::new(
            rng.uniform(-0.08, 0.08),
            rng.uniform(-0.08, 0.08),
            rng.uniform(-0.6, -0.3),
        ),
    }
}

fn points_m(fit: &HandFit, pose: &FittedPose) -> [Vec3; JOINTS] {
    let local_m = fit.skeleton.points(&pose.articulation);
    local_m.map(|point_m| pose.rotation * point_m + pose.position_m)
}

fn observed(fit: &HandFit, pose: &FittedPose) -> JointObservation {
    let at_m = points_m(fit, pose);
    JointObservation {
        rays: at_m.map(|at| at.truncate() / -at.z),
        depths: at_m.map(|at| (pose.position_m.z - at.z) / fit.palm_m()),
        scores: [1.0; JOINTS],
        presence: 1.0,
    }
}

fn mean_error_m(a: &[Vec3; JOINTS], b: &[Vec3; JOINTS]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).sum::<f32>() / JOINTS as f32
}

#[test]
fn exact_joints_give_the_hand_they_are_of() {
    let (fit, count) = (fit(), 100);
    let (mut error_m, mut of_shape_m, mut of_coefficients) = (0.0, 0.0, 0.0);
    for sample in 0..count {
        let pose = pose(sample);
        let fitted = fit.fit(&observed(&fit, &pose), FOCAL_CELLS);
        let [found, want] = [fitted, pose].map(|pose| points_m(&fit, &pose));
        error_m += mean_error_m(&found, &want);
        let from_wrist = |points_m: [Vec3; JOINTS]| points_m.map(|point_m| point_m - points_m[0]);
        of_shape_m += mean_error_m(&from_wrist(found), &from_wrist(want));
        let pairs = pose.articulation.iter().zip(fitted.articulation);
        of_coefficients += pairs.map(|(a, b)| (a - b).abs()).sum::<f32>() / 6.0;
    }
    // The prior pulls towards the mean hand, and the distance is what joints say least about.
    let of = |sum: f32| sum / count as f32;
    assert!(of(error_m) < 0.003, "{} m", of(error_m));
    assert!(of(of_shape_m) < 0.001, "{} m", of(of_shape_m));
    assert!(of(of_coefficients) < 0.06, "{}", of(of_coefficients));
}

#[test]
fn errors_of_half_a_cell_stay_millimetres_and_joints_that_score_nothing_do_not_count() {
    let fit = fit();
    let mut sum_m = 0.0;
    for sample in 0..50 {
        let pose = pose(sample);
        let mut rng = CounterRng::new(2, "errors of joints", sample);
        let mut observed = observed(&fit, &pose);
        for joint in 0..JOINTS {
            observed.rays[joint] += Vec2::new(rng.normal(), rng.normal()) * 0.5 / FOCAL_CELLS;
            observed.depths[joint] += 0.1 * rng.normal();
        }
        // A finger that lies anywhere.
        for joint in [2, 6, 7, 8] {
            observed.rays[joint] = Vec2::new(rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3));
            observed.scores[joint] = 0.02;
        }
        let fitted = fit.fit(&observed, FOCAL_CELLS);
        sum_m += mean_error_m(&points_m(&fit, &fitted), &points_m(&fit, &pose));
    }
    assert!(sum_m / 50.0 < 0.02, "{} m", sum_m / 50.0);
}

#[test]
fn joints_of_no_hand_give_a_finite_pose_before_the_camera() {
    let fit = fit();
    for (scores, depth) in [([0.0; JOINTS], 0.0), ([1.0; JOINTS], 9.0), ([0.01; JOINTS], -9.0)] {
        let observed = JointObservation {
            rays: [Vec2::ZERO; JOINTS],
            depths: [depth; JOINTS],
            scores,
            presence: 0.0,
        };
        let fitted = fit.fit(&observed, FOCAL_CELLS);
        assert!(fitted.position_m.is_finite(), "{fitted:?}");
        assert!((-FAR_M * 1.001..0.0).contains(&fitted.position_m.z), "{fitted:?}");
        assert!(fitted.articulation.iter().all(|value| value.abs() <= MAX_ARTICULATION));
    }
}
