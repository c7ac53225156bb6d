//! Labels that are wrong, or look as if they were.
//!
//! * [`check_labels`]: tracks into a [`CheckReport`]: lengths of limbs, left and right exchanged,
//!   joints outside of the image, missing, frozen or not finite ([`LabelFault`]), each with its frame.
//! * [`tracks_of`]: annotations as [`LabelTrack`]s.
//! * [`CheckOptions`]: when a label is suspected.

mod bones;
mod frozen;
mod options;
mod presence;
mod report;
mod sides;
mod track;

use evpose_pose::body::JOINT_NAMES;

pub use options::CheckOptions;
pub use report::{CheckReport, JointSummary, LabelFault, LabelFinding, LimbSummary};
pub use track::{LabelTrack, TrackFrame, tracks_of};

/// Looks for labels that are wrong.
///
/// Findings are suspicions: a limb that points at the camera is short, and a person who stands
/// still in whole pixels is frozen.
pub fn check_labels(tracks: &[LabelTrack], options: &CheckOptions) -> CheckReport {
    let summary =
        |joint| JointSummary { joint, labelled: 0, missing: 0, outside: 0, not_finite: 0 };
    let mut joints: Vec<JointSummary> = JOINT_NAMES.into_iter().map(summary).collect();
    let mut findings: Vec<(usize, usize, Vec<&'static str>, LabelFault)> = Vec::new();
    // Sizes of torsos are the unit of the checks: they are measured once.
    let torsos: Vec<_> = tracks.iter().map(|track| track.torsos(options)).collect();
    for (index, track) in tracks.iter().enumerate() {
        let mut report = |frame, joints, fault| findings.push((index, frame, joints, fault));
        presence::check(track, &mut joints, &mut report);
        sides::check(track, &torsos[index], options, &mut report);
        frozen::check(track, &torsos[index], options, &mut report);
    }
    // Limbs are compared over all tracks, as people share proportions.
    let (limbs, outliers) = bones::check(tracks, &torsos, options);
    findings.extend(
        outliers
            .into_iter()
            .map(|(track, frame, ends, fault)| (track, frame, ends.to_vec(), fault)),
    );
    // Stable: within a frame, as the checks come.
    findings.sort_by_key(|&(track, frame, ..)| (track, frame));
    let finding = |(track, index, joints, fault): (usize, usize, _, _)| {
        let (track, frame) = (&tracks[track], &tracks[track].frames[index]);
        let (name, t_s) = (frame.name.clone(), frame.t_s);
        LabelFinding { track: track.name.clone(), frame: name, index, t_s, joints, fault }
    };
    CheckReport {
        tracks: tracks.len(),
        frames: tracks.iter().map(|track| track.frames.len()).sum(),
        joints,
        limbs,
        findings: findings.into_iter().map(finding).collect(),
    }
}

#[cfg(test)]
mod tests;
