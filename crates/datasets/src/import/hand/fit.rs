//! Parameters of a hand from its labelled joints.
//!
//! # Model
//! Of the twelve parameters and, where wanted, the size of the hand, those are sought that
//! minimise Σ |joint − label|² / σ² + Σ articulation² / ρ². Joints on the image are as exact as
//! 0.3 % of its width and joints in space as 2 mm; the second sum settles what labels leave
//! open. On the image, the distance of the hand follows from its size.

use evpose_camera::ViewAdaptor;
use evpose_pose::rotation::{axis_angle_from_matrix, matrix_from_axis_angle};
use evpose_pose::{HandParams, HandSide};
use evpose_task::hand::HandView;
use glam::{Mat3, Vec2, Vec3};

use super::format::HandJoints;
use super::least_squares::minimise;
use super::starts::best_start;
use super::target::{Target, opencv};

/// Standard deviation of labels in space, in metres.
const SIGMA_M: f64 = 0.002;
/// Standard deviation of labels on the image, relative to its width.
const SIGMA_OF_WIDTH: f64 = 0.003;
/// Standard deviation of articulation coefficients, for labels in space and on the image.
const SIGMA_ARTICULATION: [f64; 2] = [5.0, 2.0];
/// Depth in metres before which no joint is projected.
const NEAR_M: f32 = 0.02;
/// Steps from the pose before.
const ITERATIONS: usize = 20;

/// Indices of the fitted values: coefficients, metres, radians, logarithm of the size.
pub(super) const VALUES: usize = 13;
/// Index of the first of the rotation.
const ROTATION: usize = 9;
/// Index of the logarithm of the size.
const SIZE: usize = 12;
/// Increments of numeric derivatives: points are of single precision.
const INCREMENTS: [f64; VALUES] =
    [1e-2, 1e-2, 1e-2, 1e-2, 1e-2, 1e-2, 2e-4, 2e-4, 2e-4, 2e-3, 2e-3, 2e-3, 1e-3];

/// Values that are fitted beside position and rotation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Freedom {
    /// None.
    Rigid,
    /// Rotation, translation and articulation.
    Articulated,
    /// Articulation and size.
    Sized,
}

/// Options of fitting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitOptions {
    /// Size of the hand relative to the neutral one.
    pub scale: f64,
    /// Mean residual in metres above which labels are reported.
    pub warn_m: f32,
    /// Mean residual relative to the width of the image above which labels are reported.
    pub warn_of_width: f32,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { scale: 1.0, warn_m: 0.01, warn_of_width: 0.01 }
    }
}

/// A fitted hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedHand {
    /// Parameters of the hand with the smallest error.
    pub params: HandParams,
    /// Mean distance of joints from their labels in pixels of the sensor.
    pub residual_px: f32,
    /// Mean distance in metres, of labels in space.
    pub residual_m: Option<f32>,
}

/// Fits hands to joints before a camera.
#[derive(Debug)]
pub struct HandFitter {
    view: HandView,
    adaptor: ViewAdaptor,
    side: HandSide,
    is_mirrored: bool,
    camera_from_world: Mat3,
    options: FitOptions,
}

/// A pose under way: parameters and size.
#[derive(Debug, Clone, Copy)]
pub(super) struct Guess {
    pub(super) params: HandParams,
    pub(super) scale: f64,
}

impl HandFitter {
    /// A fitter of hands of `side` before the camera of `adaptor`. With `is_mirrored`, labels are
    /// those of the other hand, whose mirror image is fitted.
    pub fn new(
        view: HandView,
        adaptor: ViewAdaptor,
        side: HandSide,
        is_mirrored: bool,
        options: FitOptions,
    ) -> Self {
        // The view maps points alone: the images of the axes are the columns of its rotation.
        let [zero, x, y, z] = view.camera_points(&[Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]);
        let camera_from_world = Mat3::from_cols(x - zero, y - zero, z - zero);
        Self { view, adaptor, side, is_mirrored, camera_from_world, options }
    }

    /// The same with hands of another size, relative to the neutral one.
    #[must_use]
    pub fn with_scale(self, scale: f64) -> Self {
        Self { options: FitOptions { scale, ..self.options }, ..self }
    }

    /// Fits a hand to labelled joints, from the pose before or, without one or where that does not
    /// lead to a small residual, from many. None if too few joints are labelled.
    pub fn fit(&self, joints: &HandJoints, before: Option<&HandParams>) -> Option<FittedHand> {
        let target = self.target(joints)?;
        let start = |params: &HandParams| Guess { params: *params, scale: self.options.scale };
        let near = before
            .map(|params| self.refine(&target, start(params), Freedom::Articulated, ITERATIONS).0)
            .map(|guess| self.fitted(&target, &guess));
        if let Some(near) = near.filter(|near| !self.is_poor(near)) {
            return Some(near);
        }
        let anew = best_start(self, &target, self.options.scale, Freedom::Articulated);
        let anew = self.fitted(&target, &anew);
        Some(near.filter(|near| near.residual_px <= anew.residual_px).unwrap_or(anew))
    }

    /// The size of a hand relative to the neutral one, from joints in space; none without such.
    pub fn fit_scale(&self, joints: &HandJoints) -> Option<f64> {
        let target = self.target(joints).filter(|target| matches!(target, Target::Space(_)))?;
        Some(best_start(self, &target, 1.0, Freedom::Sized).scale)
    }

    /// Whether the residual is so large that the labels should be looked at.
    pub fn is_poor(&self, fitted: &FittedHand) -> bool {
        match fitted.residual_m {
            Some(residual_m) => residual_m > self.options.warn_m,
            None => {
                let width_px = f32::from(self.adaptor.sensor().width);
                fitted.residual_px > self.options.warn_of_width * width_px
            }
        }
    }

    /// Labels in the frame of the fit; none if there are too few.
    fn target(&self, joints: &HandJoints) -> Option<Target> {
        Target::new(joints, &self.view, &self.adaptor, self.is_mirrored)
    }

    /// Joints in the frame of the camera: x right, y down, z forwards.
    pub(super) fn model_m(&self, guess: &Guess) -> [Vec3; 21] {
        let world_m = self.view.points_of(self.side, &guess.params, self.view.neutral()).world_m;
        let in_camera = self.view.camera_points(&world_m).map(opencv);
        let wrist = in_camera[0];
        in_camera.map(|at_m| wrist + (at_m - wrist) * guess.scale as f32)
    }

    /// The vector of the world of a vector in the frame of the camera.
    pub(super) fn world_from_camera(&self, vector_m: Vec3) -> Vec3 {
        self.camera_from_world.transpose() * opencv(vector_m)
    }

    /// Position in the view, in pixels, of a point in the frame of the camera.
    pub(super) fn view_px(&self, at_m: Vec3) -> Vec2 {
        let pinhole = &self.adaptor.view().pinhole;
        pinhole.principal_px + at_m.truncate() * (pinhole.focal_px / at_m.z.max(NEAR_M))
    }

    /// Minimises from a guess; the result and its cost.
    pub(super) fn refine(
        &self,
        target: &Target,
        guess: Guess,
        freedom: Freedom,
        iterations: usize,
    ) -> (Guess, f64) {
        // A turn from the guess, not an axis-angle vector, which jumps at half a turn.
        let base = matrix_from_axis_angle(guess.params.rotation);
        let unpack = |values: &[f64]| {
            let v = |k: usize| values[k] as f32;
            let turn = matrix_from_axis_angle(Vec3::new(v(9), v(10), v(11)));
            let params = HandParams {
                articulation: std::array::from_fn(v),
                translation_m: Vec3::new(v(6), v(7), v(8)),
                rotation: axis_angle_from_matrix(turn * base),
            };
            Guess { params, scale: values[SIZE].exp() }
        };
        let mut start = [0.0; VALUES];
        for (value, own) in start.iter_mut().zip(guess.params.to_array()).take(ROTATION) {
            *value = own.into();
        }
        // The logarithm keeps the size positive.
        start[SIZE] = guess.scale.ln();
        // An increment of 0 fixes a parameter.
        let mut increments = INCREMENTS;
        if freedom == Freedom::Rigid {
            increments[..6].fill(0.0);
        }
        if freedom != Freedom::Sized {
            increments[SIZE] = 0.0;
        }
        let mut residuals = |values: &[f64], out: &mut Vec<f64>| {
            self.residuals(target, &unpack(values), &values[..6], out);
        };
        let found = minimise(&mut residuals, &start, &increments, iterations);
        (unpack(&found.parameters), found.cost)
    }

    fn residuals(&self, target: &Target, guess: &Guess, articulation: &[f64], out: &mut Vec<f64>) {
        out.clear();
        // In standard deviations, so that labels and prior have the same unit.
        let model_m = self.model_m(guess);
        let sigma_articulation = match target {
            Target::Space(labels_m) => {
                for (model, label) in model_m.iter().zip(labels_m) {
                    let Some(label) = label else { continue };
                    let difference = (*model - *label).as_dvec3() / SIGMA_M;
                    out.extend(difference.to_array());
                }
                SIGMA_ARTICULATION[0]
            }
            Target::Image(labels_px) => {
                let sigma_px = SIGMA_OF_WIDTH * f64::from(self.adaptor.view().sensor.width);
                for (model, label) in model_m.iter().zip(labels_px) {
                    let Some(label) = label else { continue };
                    let difference = (self.view_px(*model) - *label).as_dvec2() / sigma_px;
                    out.extend(difference.to_array());
                }
                SIGMA_ARTICULATION[1]
            }
        };
        // The prior holds joints that no label reaches.
        out.extend(articulation.iter().map(|value| value / sigma_articulation));
    }

    /// The result with its residuals.
    fn fitted(&self, target: &Target, guess: &Guess) -> FittedHand {
        let model_m = self.model_m(guess);
        let mean = |distances: &mut dyn Iterator<Item = f32>| {
            let (sum, count) = distances.fold((0.0, 0), |(sum, count), d| (sum + d, count + 1));
            sum / count.max(1) as f32
        };
        let camera = &self.adaptor.calibration().camera;
        // The view has a focal length of its own; errors are in pixels of the sensor.
        let sensor_px_per_view_px =
            camera.focal_px.element_sum() as f32 / (2.0 * self.adaptor.view().pinhole.focal_px);
        let pairs = model_m.iter().enumerate();
        let (residual_px, residual_m) = match target {
            Target::Space(labels) => {
                let known = || pairs.clone().filter_map(|(k, model)| Some((*model, labels[k]?)));
                let px = &mut known().map(|(a, b)| self.view_px(a).distance(self.view_px(b)));
                (mean(px), Some(mean(&mut known().map(|(a, b)| a.distance(b)))))
            }
            Target::Image(labels) => {
                let known = pairs.filter_map(|(k, model)| Some((self.view_px(*model), labels[k]?)));
                (mean(&mut known.map(|(a, b)| a.distance(b))), None)
            }
        };
        let residual_px = residual_px * sensor_px_per_view_px;
        FittedHand { params: guess.params, residual_px, residual_m }
    }
}

#[cfg(test)]
mod tests;
