//! First guesses of a hand's pose: many rotations, each brought to where the labels are.

use evpose_pose::HandParams;
use evpose_pose::rotation::axis_angle_from_matrix;
use glam::{Mat3, Vec2, Vec3};
use rayon::prelude::*;

use super::fit::{Freedom, Guess, HandFitter};
use super::target::Target;

/// Distance in metres at which a hand is projected to compare its size with that of the labels.
const TRIAL_DEPTH_M: f32 = 0.5;
/// Depths in metres between which hands are sought.
const DEPTHS_M: [f32; 2] = [0.08, 3.0];
/// Steps of the rotation and the position of each start.
const RIGID_ITERATIONS: usize = 15;
/// Starts whose articulation is fitted too.
const BEST: usize = 4;
/// Steps of these.
const ITERATIONS: usize = 60;

/// The best pose of those that are reached from many rotations.
pub(super) fn best_start(
    fitter: &HandFitter,
    target: &Target,
    scale: f64,
    freedom: Freedom,
) -> Guess {
    // Rigid first: from a wrong rotation, fingers would bend to fit.
    let rigid = |rotation: &Mat3| {
        let guess = placed(fitter, target, *rotation, scale);
        fitter.refine(target, guess, Freedom::Rigid, RIGID_ITERATIONS)
    };
    let mut guesses: Vec<(Guess, f64)> = cube_rotations().par_iter().map(rigid).collect();
    guesses.sort_by(|a, b| a.1.total_cmp(&b.1));
    guesses.truncate(BEST);
    let whole = |(guess, _): &(Guess, f64)| fitter.refine(target, *guess, freedom, ITERATIONS);
    let refined: Vec<(Guess, f64)> = guesses.par_iter().map(whole).collect();
    let best = refined.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    best.map_or(Guess { params: HandParams::default(), scale }, |(guess, _)| guess)
}

/// The neutral hand of a rotation with its labelled joints about where their labels are.
fn placed(fitter: &HandFitter, target: &Target, rotation: Mat3, scale: f64) -> Guess {
    let rotation = axis_angle_from_matrix(rotation);
    let mut guess = Guess { params: HandParams { rotation, ..HandParams::default() }, scale };
    let model_m = fitter.model_m(&guess);
    let center = match target {
        Target::Space(labels_m) => {
            let known = labels_m.iter().enumerate().filter_map(|(k, at)| Some((k, (*at)?)));
            let count = labels_m.iter().flatten().count() as f32;
            known.map(|(k, at)| at - model_m[k]).sum::<Vec3>() / count
        }
        Target::Image(labels_px) => {
            // In pixels there is no depth: the spread of the joints gives it.
            let known: Vec<(usize, Vec2)> =
                labels_px.iter().enumerate().filter_map(|(k, at)| Some((k, (*at)?))).collect();
            let mean_m = known.iter().map(|(k, _)| model_m[*k]).sum::<Vec3>() / known.len() as f32;
            let trial = Vec3::new(0.0, 0.0, TRIAL_DEPTH_M) - mean_m;
            let model_px: Vec<Vec2> =
                known.iter().map(|(k, _)| fitter.view_px(model_m[*k] + trial)).collect();
            let label_px: Vec<Vec2> = known.iter().map(|(_, at)| *at).collect();
            let [(model_center, model_spread), (center, spread)] =
                [moments(&model_px), moments(&label_px)];
            // Twice as large on the image is half as far.
            let depth_m = TRIAL_DEPTH_M * model_spread / spread.max(1e-3);
            let depth_m = depth_m.clamp(DEPTHS_M[0], DEPTHS_M[1]);
            // A pixel at the trial's depth is so many metres there.
            let origin_px = fitter.view_px(Vec3::Z);
            let m_per_px = 1.0 / (fitter.view_px(Vec3::new(1.0, 0.0, 1.0)).x - origin_px.x);
            let offset =
                (center - origin_px) * depth_m - (model_center - origin_px) * TRIAL_DEPTH_M;
            (offset * m_per_px).extend(depth_m) - mean_m
        }
    };
    guess.params.translation_m += fitter.world_from_camera(center);
    guess
}

/// Mean and root mean square distance from it.
fn moments(points: &[Vec2]) -> (Vec2, f32) {
    let count = points.len() as f32;
    let mean = points.iter().sum::<Vec2>() / count;
    let variance = points.iter().map(|at| at.distance_squared(mean)).sum::<f32>() / count;
    (mean, variance.sqrt())
}

/// The 24 rotations of a cube: every rotation is within 63 degrees of one of them.
fn cube_rotations() -> Vec<Mat3> {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let mut rotations = Vec::new();
    for x in axes {
        for y in axes.into_iter().filter(|y| y.dot(x) == 0.0) {
            // The cross product makes it a rotation; the other sign would be a reflection.
            rotations.push(Mat3::from_cols(x, y, x.cross(y)));
        }
    }
    rotations
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_24_different_rotations() {
        let rotations = cube_rotations();
        assert_eq!(rotations.len(), 24);
        for (k, a) in rotations.iter().enumerate() {
            assert!((a.determinant() - 1.0).abs() < 1e-6);
            assert!(rotations[..k].iter().all(|b| a != b));
        }
    }

    #[test]
    fn moments_are_mean_and_spread() {
        let (mean, spread) = moments(&[Vec2::new(1.0, 5.0), Vec2::new(3.0, 5.0)]);
        assert_eq!((mean, spread), (Vec2::new(2.0, 5.0), 1.0));
    }
}
