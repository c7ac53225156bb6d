//! Lengths of limbs.
//!
//! # Model
//! A limb's length in torsos is compared with the median over all tracks. Limbs get shorter in an
//! image as they turn towards the camera, so that the spread is wide and what is found is mostly
//! too long.

use evpose_pose::body::{JOINT_NAMES, LIMBS};

use super::track::median;
use super::{CheckOptions, LabelFault, LabelTrack, LimbSummary};

/// From the median of differences to the standard deviation, for normal ones.
const DEVIATION_OF_MEDIAN: f32 = 1.4826;
/// Minimal count of lengths that decides about outliers.
const MIN_LENGTHS: usize = 8;

/// An outlier: track, frame, joints and what is wrong.
pub(super) type Outlier = (usize, usize, [&'static str; 2], LabelFault);

/// Lengths of all limbs that are known somewhere, and all outliers.
pub(super) fn check(
    tracks: &[LabelTrack],
    torsos: &[Vec<Option<f32>>],
    options: &CheckOptions,
) -> (Vec<LimbSummary>, Vec<Outlier>) {
    let mut summaries = Vec::new();
    let mut outliers = Vec::new();
    for limb in LIMBS {
        let mut lengths = Vec::new();
        for (number, track) in tracks.iter().enumerate() {
            for (frame, torso) in torsos[number].iter().enumerate() {
                let ends = limb.map(|joint| track.joint(frame, joint));
                // In torsos, so that people near the camera are no outliers.
                if let ([Some(a), Some(b)], Some(torso)) = (ends, torso) {
                    lengths.push((number, frame, a.distance(b) / torso));
                }
            }
        }
        let Some(middle) = median(lengths.iter().map(|length| length.2).collect()) else {
            continue;
        };
        // Medians, so that outliers do not widen the limit that is to detect them.
        let differences = lengths.iter().map(|length| (length.2 - middle).abs()).collect();
        let spread = DEVIATION_OF_MEDIAN * median(differences).unwrap_or(0.0);
        // Of lengths that hardly vary any would be an outlier: the spread has a minimum.
        let limit = options.outlier_spreads * spread.max(options.min_spread * middle);
        let joints = limb.map(|joint| JOINT_NAMES[joint]);
        let before = outliers.len();
        // A few lengths say nothing about their spread.
        if lengths.len() >= MIN_LENGTHS {
            for &(track, frame, length) in &lengths {
                if (length - middle).abs() > limit {
                    let fault = LabelFault::BoneLength { length, median: middle, spread };
                    outliers.push((track, frame, joints, fault));
                }
            }
        }
        let (frames, outliers) = (lengths.len(), outliers.len() - before);
        summaries.push(LimbSummary { joints, frames, median: middle, spread, outliers });
    }
    (summaries, outliers)
}
