//! Errors of joints in the world, in millimetres.
//!
//! # Model
//! MPJPE: the mean distance between predicted and true joints, without any alignment; a mean over
//! joints of each joint's mean over the instants at which it was found, and beside it the share of
//! joints that were not found.

use evpose_core::stats::bootstrap::{BootstrapConfig, Totals, mean_interval};
use evpose_core::stats::interval::Interval;
use serde::{Deserialize, Serialize};

use crate::body::{BODY_JOINTS, JOINT_NAMES, WorldJoints};

/// Errors of one sequence.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SpatialErrors {
    /// Distances in millimetres, joint by joint.
    pub distances_mm: [Totals; BODY_JOINTS],
    /// Number of instants at which a true joint was not found, joint by joint.
    pub missing: [u64; BODY_JOINTS],
}

impl SpatialErrors {
    /// Adds the joints of an instant, both in metres; joints without truth do not count.
    pub fn push(&mut self, predicted: &WorldJoints, truth: &WorldJoints) {
        for joint in 0..BODY_JOINTS {
            let Some(truth_m) = truth[joint] else { continue };
            match predicted[joint] {
                Some(at_m) => self.distances_mm[joint].push(1e3 * at_m.distance(truth_m)),
                None => self.missing[joint] += 1,
            }
        }
    }
}

/// Errors over all sequences.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpatialSummary {
    /// Number of sequences.
    pub sequences: usize,
    /// Mean per joint position error in millimetres, with its interval over sequences.
    pub mpjpe_mm: Option<Interval>,
    /// Share of the true joints that were not found.
    pub missing: f64,
    /// Joint by joint.
    pub joints: Vec<SpatialJoint>,
}

/// Errors of a joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpatialJoint {
    /// Name of the joint.
    pub joint: String,
    /// Mean distance in millimetres; none if it was never found.
    pub error_mm: Option<f64>,
    /// Share of the instants at which it was not found.
    pub missing: f64,
}

impl SpatialSummary {
    /// The summary of sequences.
    pub fn new(sequences: &[SpatialErrors], config: &BootstrapConfig) -> Self {
        // Every joint counts alike: a sequence is the mean over joints of its means.
        let of_sequence = |errors: &SpatialErrors| {
            let mut totals = Totals::default();
            errors.distances_mm.iter().filter_map(|joint| joint.mean()).for_each(|mean| {
                totals.push(mean);
            });
            totals
        };
        // Without any joint the share is 0, not NaN.
        let share = |missing: u64, count: u64| missing as f64 / (missing + count).max(1) as f64;
        let joint = |k: usize| {
            let (mut all, mut missing) = (Totals::default(), 0);
            for errors in sequences {
                all.sum += errors.distances_mm[k].sum;
                all.count += errors.distances_mm[k].count;
                missing += errors.missing[k];
            }
            (all, missing)
        };
        let all: Vec<(Totals, u64)> = (0..BODY_JOINTS).map(joint).collect();
        let (found, missing) = all.iter().fold((0, 0), |(found, lost), (totals, missing)| {
            (found + totals.count, lost + missing)
        });
        // Intervals are over sequences: within one, errors depend on each other.
        let totals: Vec<Totals> = sequences.iter().map(of_sequence).collect();
        Self {
            sequences: sequences.len(),
            mpjpe_mm: mean_interval(&totals, config),
            missing: share(missing, found),
            joints: all
                .iter()
                .zip(JOINT_NAMES)
                .map(|((totals, missing), name)| SpatialJoint {
                    joint: name.to_owned(),
                    error_mm: totals.mean(),
                    missing: share(*missing, totals.count),
                })
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn distances_are_averaged_over_joints_and_missing_ones_counted() {
        let truth: WorldJoints = [Some(DVec3::ZERO); BODY_JOINTS];
        let mut predicted: WorldJoints = [Some(DVec3::new(0.03, 0.0, 0.04)); BODY_JOINTS];
        predicted[0] = Some(DVec3::new(0.0, 0.18, 0.0));
        let mut errors = SpatialErrors::default();
        errors.push(&predicted, &truth);
        predicted[0] = None;
        errors.push(&predicted, &truth);
        let mut unlabelled = truth;
        unlabelled[5] = None;
        errors.push(&truth, &unlabelled);
        let summary = SpatialSummary::new(&[errors], &BootstrapConfig::default());
        // The head is 180 mm, then 0 mm off; joint 5 has two instants, the others three.
        let want = (90.0 + 50.0 + 11.0 * 100.0 / 3.0) / 13.0;
        let estimate = summary.mpjpe_mm.unwrap().estimate;
        assert!((estimate - want).abs() < 1e-9, "{estimate} for {want}");
        assert!((summary.missing - 1.0 / 38.0).abs() < 1e-12, "{}", summary.missing);
        assert_eq!(summary.joints[0].error_mm, Some(90.0));
        assert!((summary.joints[0].missing - 1.0 / 3.0).abs() < 1e-12);
    }
}
