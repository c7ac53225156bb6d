use evpose_core::CounterRng;
use evpose_pose::body::{BodyPoints, number};
use glam::Vec2;

use super::*;

const FRAMES: usize = 200;
const RATE_HZ: f64 = 50.0;

/// Somebody who walks on the spot and waves, in pixels of 640 × 480: legs and arms swing past each
/// other.
fn walker(t_s: f64, seed: u64) -> BodyPoints {
    let t = t_s as f32;
    let phase = 5.0 * t + seed as f32;
    let at = |x: f32, y: f32| Some(Vec2::new(320.0 + 15.0 * (0.7 * t).sin() + x, 90.0 + y));
    let arm = |side: f32| {
        let angle = 0.6 * (phase * side).sin();
        let elbow = Vec2::new(side * 30.0 + 40.0 * angle.sin(), 30.0 + 40.0 * angle.cos());
        (elbow, elbow + 35.0 * Vec2::new((1.5 * angle).sin(), (1.5 * angle).cos()))
    };
    let leg = |side: f32| {
        let angle = 0.5 * (phase + if side > 0.0 { 0.0 } else { 3.1 }).sin();
        let knee = Vec2::new(side * 15.0 + 55.0 * angle.sin(), 120.0 + 55.0 * angle.cos());
        (knee, knee + 55.0 * Vec2::new((0.8 * angle).sin(), (0.8 * angle).cos()))
    };
    let ((elbow_l, wrist_l), (elbow_r, wrist_r)) = (arm(1.0), arm(-1.0));
    let ((knee_l, ankle_l), (knee_r, ankle_r)) = (leg(1.0), leg(-1.0));
    let mut joints = BodyPoints::default();
    for (joint, point) in [
        (number::HEAD, Vec2::new(0.0, 0.0)),
        (number::SHOULDER_L, Vec2::new(30.0, 30.0)),
        (number::SHOULDER_R, Vec2::new(-30.0, 30.0)),
        (number::ELBOW_L, elbow_l),
        (number::ELBOW_R, elbow_r),
        (number::WRIST_L, wrist_l),
        (number::WRIST_R, wrist_r),
        (number::HIP_L, Vec2::new(15.0, 120.0)),
        (number::HIP_R, Vec2::new(-15.0, 120.0)),
        (number::KNEE_L, knee_l),
        (number::KNEE_R, knee_r),
        (number::ANKLE_L, ankle_l),
        (number::ANKLE_R, ankle_r),
    ] {
        joints[joint] = at(point.x, point.y);
    }
    joints
}

fn track(seed: u64) -> LabelTrack {
    let frame = |index: usize| {
        let t_s = index as f64 / RATE_HZ;
        TrackFrame {
            name: format!("{seed}_{index:05}.png"),
            t_s: Some(t_s),
            joints: walker(t_s, seed),
        }
    };
    LabelTrack {
        name: format!("walk{seed}"),
        frames: (0..FRAMES).map(frame).collect(),
        image_size: Some(Vec2::new(640.0, 480.0)),
    }
}

fn check(tracks: &[LabelTrack]) -> Vec<LabelFinding> {
    check_labels(tracks, &CheckOptions::default()).findings
}

/// A track, a frame and a joint of three tracks, by chance; the frame not near either end.
fn draw(case: u64) -> (usize, usize, usize) {
    let mut rng = CounterRng::new(case, "fault", 0);
    (rng.below(3), 10 + rng.below(FRAMES - 90), rng.below(13))
}

fn tracks() -> Vec<LabelTrack> {
    (0..3).map(track).collect()
}

#[test]
fn clean_tracks_give_no_findings_and_the_lengths_that_they_have() {
    let report = check_labels(&tracks(), &CheckOptions::default());
    assert_eq!(report.findings, []);
    assert_eq!((report.tracks, report.frames), (3, 3 * FRAMES));
    let torso = Vec2::new(15.0, 120.0).distance(Vec2::new(-30.0, 30.0));
    let limb = |a, b| {
        let is_it = |limb: &&LimbSummary| limb.joints == [JOINT_NAMES[a], JOINT_NAMES[b]];
        report.limbs.iter().find(is_it).unwrap().clone()
    };
    for (a, b, length) in [
        (number::KNEE_L, number::ANKLE_L, 55.0),
        (number::ELBOW_R, number::WRIST_R, 35.0),
        (number::SHOULDER_R, number::SHOULDER_L, 60.0),
    ] {
        let limb = limb(a, b);
        assert!((limb.median - length / torso).abs() < 1e-5, "{limb:?}");
        assert!(limb.spread < 1e-5 && limb.outliers == 0, "{limb:?}");
    }
    assert!(report.joints.iter().all(|joint| joint.labelled == 3 * FRAMES && joint.missing == 0));
}

#[test]
fn joints_that_are_not_finite_or_not_on_the_image_are_reported_and_nothing_else() {
    for case in 0..20 {
        let (which, frame, joint) = draw(case);
        let mut tracks = tracks();
        tracks[which].frames[frame].joints[joint] = Some(Vec2::new(f32::NAN, 3.0));
        let findings = check(&tracks);
        assert_eq!(findings.len(), 1, "{findings:?}");
        assert_eq!((findings[0].index, findings[0].fault), (frame, LabelFault::NotFinite));
        assert_eq!(findings[0].track, tracks[which].name);
        assert_eq!(findings[0].joints, [JOINT_NAMES[joint]]);
        assert_eq!(findings[0].t_s, Some(frame as f64 / RATE_HZ));

        tracks[which].frames[frame].joints[joint] = Some(Vec2::new(641.0, 3.0));
        let findings = check(&tracks);
        assert_eq!(findings[0].fault, LabelFault::Outside { x: 641.0, y: 3.0 });
        assert_eq!((findings[0].index, findings[0].joints[0]), (frame, JOINT_NAMES[joint]));
    }
}

#[test]
fn missing_joints_are_found_in_tracks_and_only_counted_in_photographs() {
    for case in 0..10 {
        let (which, frame, joint) = draw(case);
        let mut tracks = tracks();
        for body in &mut tracks[which].frames[frame..frame + 7] {
            body.joints[joint] = None;
        }
        let findings = check(&tracks);
        assert_eq!(findings.len(), 1, "{findings:?}");
        assert_eq!(
            (findings[0].index, findings[0].fault),
            (frame, LabelFault::Missing { frames: 7 })
        );
        assert_eq!(findings[0].joints, [JOINT_NAMES[joint]]);
    }
    let mut photograph = track(0);
    photograph.frames.truncate(1);
    photograph.frames[0].joints[4] = None;
    let report = check_labels(&[photograph], &CheckOptions::default());
    assert_eq!((report.findings.len(), report.joints[4].missing), (0, 1));
}

#[test]
fn a_joint_at_a_wrong_place_makes_limbs_of_it_outliers() {
    for case in 0..20 {
        let (which, frame, joint) = draw(case);
        if joint == number::HEAD {
            // No limb leads to it.
            continue;
        }
        let mut tracks = tracks();
        let point = tracks[which].frames[frame].joints[joint].as_mut().unwrap();
        *point += Vec2::new(180.0, -20.0);
        let findings: Vec<_> = check(&tracks)
            .into_iter()
            .filter(|finding| matches!(finding.fault, LabelFault::BoneLength { .. }))
            .collect();
        assert!(!findings.is_empty(), "case {case}");
        for finding in findings {
            assert_eq!((finding.index, &finding.track), (frame, &tracks[which].name));
            assert!(finding.joints.contains(&JOINT_NAMES[joint]), "{finding:?}");
        }
    }
}

fn exchange(body: &mut BodyPoints, pairs: &[usize]) {
    for &left in pairs {
        body.swap(left, left + 1);
    }
}

#[test]
fn exchanged_sides_are_found_with_their_first_frame_and_length() {
    let whole = [1, 3, 5, 7, 9, 11];
    for (case, frames) in [(0, 1), (1, 2), (2, 5), (3, 30)] {
        let (which, frame, _) = draw(case);
        let mut tracks = tracks();
        for body in &mut tracks[which].frames[frame..frame + frames] {
            exchange(&mut body.joints, &whole);
        }
        let swaps: Vec<_> = check(&tracks)
            .into_iter()
            .filter(|finding| matches!(finding.fault, LabelFault::SwappedSides { .. }))
            .collect();
        // Shoulders are 60 pixels apart: they can always be distinguished.
        let of_shoulders: Vec<_> =
            swaps.iter().filter(|finding| finding.joints.contains(&"shoulder_l")).collect();
        assert_eq!(of_shoulders.len(), 1, "{swaps:?}");
        assert_eq!(of_shoulders[0].index, frame);
        assert_eq!(of_shoulders[0].fault, LabelFault::SwappedSides { frames });
        assert!(swaps.iter().all(|finding| finding.track == tracks[which].name));
    }
}

#[test]
fn on_photographs_a_body_whose_halves_face_opposite_ways_is_found() {
    let swapped_of = |pairs: &[usize]| {
        let photographs: Vec<_> = track(1)
            .frames
            .into_iter()
            .map(|mut frame| {
                exchange(&mut frame.joints, pairs);
                LabelTrack { name: frame.name.clone(), frames: vec![frame], image_size: None }
            })
            .collect();
        let mut findings = check(&photographs);
        findings.retain(|finding| matches!(finding.fault, LabelFault::SwappedSides { .. }));
        findings
    };
    assert_eq!(swapped_of(&[]), []);
    for half in [[1, 3, 5], [7, 9, 11]] {
        let findings = swapped_of(&half);
        assert_eq!(findings.len(), FRAMES);
        let trunk = ["shoulder_l", "shoulder_r", "hip_l", "hip_r"];
        assert!(findings.iter().all(|finding| finding.joints == trunk), "{findings:?}");
    }
    // From top to toe: somebody who is seen from behind.
    assert_eq!(swapped_of(&[1, 3, 5, 7, 9, 11]), []);
}

#[test]
fn joints_that_cross_are_not_exchanged() {
    // Ankles pass each other by 40 pixels a frame, a third of the torso.
    let mut track = track(0);
    for (index, frame) in track.frames.iter_mut().enumerate() {
        let x = 40.0 * (index as f32 - 4.5);
        if index < 10 {
            frame.joints[number::ANKLE_L] = Some(Vec2::new(320.0 + x, 400.0));
            frame.joints[number::ANKLE_R] = Some(Vec2::new(320.0 - x, 400.0));
        }
    }
    track.frames.truncate(10);
    let findings = check(&[track]);
    assert!(
        findings.iter().all(|finding| !matches!(finding.fault, LabelFault::SwappedSides { .. })),
        "{findings:?}"
    );
}

#[test]
fn frozen_joints_and_bodies_are_found() {
    for case in 0..10 {
        let (which, frame, joint) = draw(case);
        let mut tracks = tracks();
        let still = tracks[which].frames[frame].joints;
        // 60 frames are more than `frozen_frames`, 50.
        for body in &mut tracks[which].frames[frame..frame + 60] {
            body.joints[joint] = still[joint];
        }
        let findings = check(&tracks);
        let frozen: Vec<_> = findings
            .iter()
            .filter(|finding| matches!(finding.fault, LabelFault::FrozenJoint { .. }))
            .collect();
        assert_eq!(frozen.len(), 1, "{findings:?}");
        assert_eq!(
            (frozen[0].index, frozen[0].fault),
            (frame, LabelFault::FrozenJoint { frames: 60 })
        );
        assert_eq!(frozen[0].joints, [JOINT_NAMES[joint]]);

        for body in &mut tracks[which].frames[frame..frame + 60] {
            body.joints = still;
        }
        // The jump at the end of the frozen stretch may look like exchanged sides.
        let bodies: Vec<_> = check(&tracks)
            .into_iter()
            .filter(|finding| !matches!(finding.fault, LabelFault::SwappedSides { .. }))
            .collect();
        assert_eq!(bodies.len(), 1, "{bodies:?}");
        assert_eq!(
            (bodies[0].index, bodies[0].fault),
            (frame, LabelFault::FrozenBody { frames: 60 })
        );
    }
}

#[test]
fn times_that_go_back_are_found() {
    let mut tracks = tracks();
    tracks[1].frames[50].t_s = Some(0.5);
    let findings = check(&tracks);
    assert_eq!((findings.len(), findings[0].index), (1, 50));
    assert_eq!(findings[0].fault, LabelFault::TimeOrder { before_s: 0.98 });
}

#[test]
fn a_report_is_a_table_and_findings_by_kind() {
    let mut tracks = tracks();
    // Five more than a list shows.
    for frame in 20..35 {
        tracks[0].frames[frame].joints[number::WRIST_L] = Some(Vec2::new(-2.0, 300.0));
    }
    let report = check_labels(&tracks, &CheckOptions::default());
    let text = report.to_string();
    assert!(text.starts_with("600 frames of 3 tracks, "), "{text}");
    assert!(
        text.contains("outside of the image: 15\n  walk0 #20 (0_00020.png, 0.400 s) wrist_l: ")
    );
    assert!(text.contains("at (-2.0, 300.0)") && text.contains("… and 5 more"), "{text}");
    let json = serde_json::to_value(&report).unwrap();
    assert_eq!(json["findings"][0]["fault"]["kind"], "outside");
    assert_eq!(json["joints"][5]["outside"], 15);
}

#[test]
fn nothing_at_all_is_checked_too() {
    let empty = LabelTrack { name: "empty".to_owned(), frames: Vec::new(), image_size: None };
    let report = check_labels(&[empty], &CheckOptions::default());
    assert_eq!((report.frames, report.findings.len(), report.limbs.len()), (0, 0, 0));
    let nobody = TrackFrame { name: "0".to_owned(), t_s: None, joints: BodyPoints::default() };
    let track =
        LabelTrack { name: "nobody".to_owned(), frames: vec![nobody; 60], image_size: None };
    let report = check_labels(&[track], &CheckOptions::default());
    // Missing, all thirteen, and nothing frozen.
    assert_eq!(report.findings.len(), 13);
}
