//! Errors of the joints of bodies.
//!
//! # Model
//! Each joint has its own [`BodyPck`], mean distance in pixels (MPJPE) and [`RootMeanSquare`]; the
//! values of a body are the means over the joints that have one, so that a joint that is rarely
//! labelled weighs as much as another.
//!
//! # Source
//! hpe-core's `PCK`, `MPJPE` and `RMSE`. There a joint without labels makes the mean not a number.

use glam::DVec2;

use super::track::Pose;
use super::{BodyPck, RootMeanSquare};
use crate::body::BODY_JOINTS;
use evpose_core::stats::bootstrap::Totals;

/// Errors of one joint.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct JointErrors {
    /// Errors relative to the size of the body; a joint that was not found is wrong.
    pub pck: BodyPck,
    /// Distances in pixels.
    pub distance_px: Totals,
    /// Squares of the same errors.
    pub squares: RootMeanSquare,
    /// How often the joint was labelled.
    pub labelled: u64,
    /// How often it was labelled and not found: distances know nothing of those.
    pub missing: u64,
    /// How often it was labelled on a body of unknown size: the PCK knows nothing of those.
    pub unmeasured: u64,
    /// How often it was not labelled: not in view, in recordings of simulations.
    pub unlabelled: u64,
    /// How often it was not labelled and found nevertheless.
    pub spurious: u64,
}

impl JointErrors {
    fn push(&mut self, predicted: Option<DVec2>, truth: DVec2, size_px: Option<f64>) {
        self.labelled += 1;
        let distance_px = predicted.map(|predicted| predicted.distance(truth));
        match (predicted, distance_px) {
            (Some(predicted), Some(distance_px)) => {
                self.distance_px.push(distance_px);
                self.squares.push(predicted, truth);
            }
            _ => self.missing += 1,
        }
        // Thresholds are shares of the size: without one, no error is correct or wrong.
        match size_px.filter(|size_px| *size_px > 0.0) {
            // A missing joint is farther away than any threshold.
            Some(size_px) => self.pck.push(distance_px.unwrap_or(f64::INFINITY), size_px),
            None => self.unmeasured += 1,
        }
    }

    /// See [`MissingJoints::Published`](super::MissingJoints::Published).
    fn push_published(&mut self, predicted: DVec2, truth: DVec2, size_px: f64) {
        let distance_px = predicted.distance(truth);
        // As published: the column alone decides whether there is a label.
        if truth.x != -1.0 {
            self.labelled += 1;
            self.pck.push(distance_px, size_px);
        }
        if truth.cmpgt(DVec2::ZERO).all() && predicted.cmpne(DVec2::ZERO).all() {
            self.distance_px.push(distance_px);
        }
        self.squares.push(predicted, truth);
    }

    fn merge(&mut self, other: &Self) {
        self.pck.merge(&other.pck);
        self.distance_px = [self.distance_px, other.distance_px].into_iter().sum();
        self.squares.merge(&other.squares);
        self.labelled += other.labelled;
        self.missing += other.missing;
        self.unmeasured += other.unmeasured;
        self.unlabelled += other.unlabelled;
        self.spurious += other.spurious;
    }
}

/// Errors of all joints, at any number of instants. They add up over sequences.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BodyErrors {
    /// One per joint, in the order of networks.
    pub joints: [JointErrors; BODY_JOINTS],
    /// How many instants were compared.
    pub instants: u64,
}

impl BodyErrors {
    /// Adds an instant.
    pub(super) fn push(&mut self, predicted: &Pose, truth: &Pose) {
        self.instants += 1;
        for ((errors, predicted), at) in
            self.joints.iter_mut().zip(predicted.joints).zip(truth.joints)
        {
            match at {
                Some(at) => errors.push(predicted, at, truth.size),
                None => {
                    errors.unlabelled += 1;
                    errors.spurious += u64::from(predicted.is_some());
                }
            }
        }
    }

    /// Adds an instant as the published program does; missing joints have their published
    /// stand-ins.
    pub(super) fn push_published(&mut self, predicted: &Pose, truth: &Pose) {
        self.instants += 1;
        for ((errors, predicted), at) in
            self.joints.iter_mut().zip(predicted.joints).zip(truth.joints)
        {
            if let (Some(predicted), Some(at), Some(size_px)) = (predicted, at, truth.size) {
                errors.push_published(predicted, at, size_px);
            }
        }
    }

    /// Adds the errors of another sequence.
    pub fn merge(&mut self, other: &Self) {
        for (errors, more) in self.joints.iter_mut().zip(&other.joints) {
            errors.merge(more);
        }
        self.instants += other.instants;
    }

    /// The share of correct joints at a threshold in percent of the body's size.
    pub fn pck(&self, percent: usize) -> Option<f64> {
        self.mean(|joint| joint.pck.correct(percent).mean())
    }

    /// The same at 1 %, 2 %, …, 100 %, or none where nothing was measured.
    pub fn curve(&self) -> Vec<f64> {
        (1..=super::BODY_THRESHOLDS).filter_map(|percent| self.pck(percent)).collect()
    }

    /// The area under the curve.
    pub fn auc(&self) -> Option<f64> {
        self.mean(|joint| joint.pck.area().mean())
    }

    /// The mean distance, in pixels.
    pub fn mpjpe_px(&self) -> Option<f64> {
        self.mean(|joint| joint.distance_px.mean())
    }

    /// The root mean square error, in pixels.
    pub fn rmse_px(&self) -> Option<f64> {
        self.mean(|joint| joint.squares.length())
    }

    /// The root mean square error, in percent of the position.
    pub fn rmse_percent(&self) -> Option<f64> {
        self.mean(|joint| joint.squares.percent())
    }

    /// Any number of all joints together, for intervals of means and ratios in which joints weigh
    /// as often as they are labelled.
    pub fn pooled(&self, number: impl Fn(&JointErrors) -> Totals) -> Totals {
        self.joints.iter().map(number).sum()
    }

    fn mean(&self, value: impl Fn(&JointErrors) -> Option<f64>) -> Option<f64> {
        mean_over_joints(self.joints.iter().map(value))
    }
}

/// The mean of the values there are.
pub(super) fn mean_over_joints(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let mut mean = Totals::default();
    values.flatten().for_each(|value| mean.push(value));
    mean.mean()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(at: impl Fn(usize) -> Option<DVec2>, size: Option<f64>) -> Pose {
        Pose { joints: std::array::from_fn(at), size }
    }

    /// Joints in a row whose errors are 3, 4, 5 times their number.
    fn instant(size: Option<f64>) -> (Pose, Pose) {
        let at = |k: usize| DVec2::new(100.0 + 10.0 * k as f64, 50.0);
        let error = |k: usize| DVec2::new(3.0, 4.0) * k as f64;
        (pose(|k| Some(at(k) + error(k)), size), pose(|k| Some(at(k)), size))
    }

    #[test]
    fn errors_are_counted_joint_by_joint_and_averaged() {
        let (predicted, truth) = instant(Some(100.0));
        let mut errors = BodyErrors::default();
        errors.push(&predicted, &truth);
        for (k, joint) in errors.joints.iter().enumerate() {
            assert!((joint.distance_px.mean().unwrap() - 5.0 * k as f64).abs() < 1e-12);
        }
        assert!((errors.mpjpe_px().unwrap() - 30.0).abs() < 1e-12);
        // 5 k of 100 px: 0 to 8 are within 40 %.
        assert_eq!(errors.pck(40), Some(9.0 / 13.0));
        assert_eq!(errors.curve()[39], 9.0 / 13.0);
        let mean = errors.curve().iter().sum::<f64>() / 100.0;
        assert!((errors.auc().unwrap() - mean).abs() < 1e-12);
        assert!((errors.rmse_px().unwrap() - 30.0).abs() < 1e-12);
    }

    #[test]
    fn a_joint_that_is_not_found_is_wrong_and_counted() {
        let (mut predicted, truth) = instant(Some(100.0));
        predicted.joints[0] = None;
        let mut errors = BodyErrors::default();
        errors.push(&predicted, &truth);
        assert_eq!((errors.joints[0].missing, errors.joints[0].labelled), (1, 1));
        assert_eq!((errors.pck(40), errors.pck(100)), (Some(8.0 / 13.0), Some(12.0 / 13.0)));
        // The mean of 12 joints.
        assert!((errors.mpjpe_px().unwrap() - 32.5).abs() < 1e-12);
    }

    #[test]
    fn joints_without_label_or_size_are_not_evaluated() {
        let (predicted, mut truth) = instant(Some(100.0));
        truth.joints[12] = None;
        let mut errors = BodyErrors::default();
        errors.push(&predicted, &truth);
        assert_eq!((errors.joints[12].labelled, errors.pck(40)), (0, Some(9.0 / 12.0)));
        for size in [None, Some(0.0)] {
            let (predicted, truth) = instant(size);
            let mut errors = BodyErrors::default();
            errors.push(&predicted, &truth);
            assert_eq!((errors.joints[3].unmeasured, errors.pck(40)), (1, None));
            assert!(errors.mpjpe_px().is_some() && errors.curve().is_empty());
        }
    }

    #[test]
    fn the_published_program_evaluates_stand_ins_of_missing_joints() {
        let (mut predicted, mut truth) = instant(Some(100.0));
        predicted.joints[1] = Some(DVec2::new(-640.0, -480.0));
        predicted.joints[2] = Some(DVec2::new(0.0, 50.0));
        truth.joints[3] = Some(DVec2::NEG_ONE);
        let mut errors = BodyErrors::default();
        errors.push_published(&predicted, &truth);
        let counts = |k: usize| {
            let joint = &errors.joints[k];
            (joint.pck.len(), joint.distance_px.count, joint.squares.count)
        };
        assert_eq!([1, 2, 3, 4].map(counts), [(1, 1, 1), (1, 0, 1), (0, 0, 1), (1, 1, 1)]);
        assert!(errors.joints[1].distance_px.mean().unwrap() > 700.0);
    }

    #[test]
    fn sequences_add_up() {
        let (mut predicted, mut truth) = instant(Some(100.0));
        (predicted.joints[0], truth.joints[1]) = (None, None);
        // One joint is missing, one found where there is none; then a body of unknown size.
        let instants = [(predicted, truth), instant(None)];
        let of = |times: usize| {
            let mut errors = BodyErrors::default();
            for (predicted, truth) in instants.repeat(times) {
                errors.push(&predicted, &truth);
            }
            errors
        };
        let mut merged = of(1);
        merged.merge(&of(2));
        assert_eq!(merged, of(3));
        let counts = |of: fn(&JointErrors) -> u64| merged.joints.iter().map(of).sum::<u64>();
        assert_eq!((counts(|j| j.missing), counts(|j| j.spurious)), (3, 3));
        assert_eq!((counts(|j| j.unlabelled), counts(|j| j.unmeasured)), (3, 39));
        // Of the 13 joints of one instant, one is missing and one is not labelled.
        assert_eq!(merged.pooled(|joint| joint.distance_px).count, 3 * (11 + 13));
    }
}
