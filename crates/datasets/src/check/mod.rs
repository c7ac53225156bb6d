//! Labels that are wrong, or look as if they were.
//!
//! * [`check_labels`]: tracks into a [`CheckReport`]: lengths of limbs, left and right exchanged, joints
//!   outside of the image, missing, frozen or no numbers ([`Fault`]), each with its frame.
//! * [`tracks_of`]: annotations as [`Track`]s.
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
pub use report::{CheckReport, Fault, Finding, JointSummary, LimbSummary};
pub use track::{Track, TrackFrame, tracks_of};

/// Looks for labels that are wrong.
///
/// What is found is suspected, no more: a limb that points at the camera is short, and who stands still in
/// whole pixels is frozen.
pub fn check_labels(tracks: &[Track], options: &CheckOptions) -> CheckReport {
    let summary =
        |joint| JointSummary { joint, labelled: 0, missing: 0, outside: 0, not_finite: 0 };
    let mut joints: Vec<JointSummary> = JOINT_NAMES.into_iter().map(summary).collect();
    let mut found: Vec<(usize, usize, Vec<&'static str>, Fault)> = Vec::new();
    let torsos: Vec<_> = tracks.iter().map(|track| track.torsos(options)).collect();
    for (number, track) in tracks.iter().enumerate() {
        let mut find = |frame, joints, fault| found.push((number, frame, joints, fault));
        presence::check(track, &mut joints, &mut find);
        sides::check(track, &torsos[number], options, &mut find);
        frozen::check(track, &torsos[number], options, &mut find);
    }
    let (limbs, outliers) = bones::check(tracks, &torsos, options);
    found.extend(
        outliers
            .into_iter()
            .map(|(track, frame, ends, fault)| (track, frame, ends.to_vec(), fault)),
    );
    // Stable: within a frame, as the checks come.
    found.sort_by_key(|&(track, frame, ..)| (track, frame));
    let finding = |(number, index, joints, fault): (usize, usize, _, _)| {
        let (track, frame) = (&tracks[number], &tracks[number].frames[index]);
        let (name, t_s) = (frame.name.clone(), frame.t_s);
        Finding { track: track.name.clone(), frame: name, index, t_s, joints, fault }
    };
    CheckReport {
        tracks: tracks.len(),
        frames: tracks.iter().map(|track| track.frames.len()).sum(),
        joints,
        limbs,
        findings: found.into_iter().map(finding).collect(),
    }
}

#[cfg(test)]
mod tests;
