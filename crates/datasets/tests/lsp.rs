//! Leeds Sports Pose into images of persons.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::path::Path;

use evpose_datasets::lsp::convert;
use evpose_datasets::stills::{Converted, SkipReason, StillOptions, StillStyle};
use evpose_datasets::{Annotation, read_annotations};
use evpose_pose::body::{Visibility, number};
use glam::Vec2;
use tempfile::TempDir;

/// Corner and sides of the first person's window: points from (10, 4) to (54, 70).
const WINDOW: [Vec2; 2] = [Vec2::new(-23.0, -18.0), Vec2::new(110.0, 110.0)];

/// A folder with photographs of these names, and options that write beside them.
fn set(file: &str, names: &[&str]) -> (TempDir, StillOptions) {
    let directory = tempfile::tempdir().unwrap();
    let photographs = directory.path().join("images");
    std::fs::create_dir(&photographs).unwrap();
    for name in names {
        image::GrayImage::from_pixel(64, 80, image::Luma([90]))
            .save(photographs.join(name))
            .unwrap();
    }
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/lsp").join(file);
    let output = directory.path().join("out");
    let options =
        StillOptions { style: StillStyle::Grey, ..StillOptions::new(golden, photographs, output) };
    (directory, options)
}

fn converted(options: &StillOptions) -> (Converted, Vec<Annotation>) {
    let converted = convert(options, &|_, _| {}).unwrap();
    (converted, read_annotations(&options.output.join("poses.json")).unwrap())
}

fn extended() -> (TempDir, StillOptions) {
    let names = ["im00001.jpg", "im00002.jpg", "im00003.jpg", "im00004.jpg", "im00006.jpg"];
    set("extended.mat", &names)
}

/// A joint in pixels of the photograph.
fn at_px(annotation: &Annotation, joint: usize) -> Option<Vec2> {
    let keypoint = annotation.label.keypoints[joint];
    keypoint.is_labelled().then(|| keypoint.position * WINDOW[1] + WINDOW[0])
}

#[test]
fn fourteen_points_become_thirteen_joints() {
    let (_directory, options) = extended();
    let (_, annotations) = converted(&options);
    let person = &annotations[0];
    let close = |joint, x, y| {
        let at = at_px(person, joint).unwrap();
        assert!(at.abs_diff_eq(Vec2::new(x, y), 1e-4), "{joint} {at}");
    };
    close(number::WRIST_L, 54.0, 44.0);
    close(number::WRIST_R, 10.0, 44.0);
    close(number::SHOULDER_L, 42.0, 20.0);
    close(number::KNEE_L, 40.0, 56.0);
    close(number::ANKLE_R, 22.0, 70.0);
    // Between neck and top.
    close(number::HEAD, 32.0, 10.0);
    assert!(person.label.keypoints.iter().all(|joint| joint.visibility == Visibility::Visible));
}

#[test]
fn a_head_without_neck_is_between_shoulders_and_top() {
    let (_directory, options) = extended();
    let (converted, annotations) = converted(&options);
    let person = &annotations[1];
    assert_eq!(person.label.keypoints[number::ANKLE_R].visibility, Visibility::Unlabelled);
    // Without the ankle of the right side, points are as far apart as with it.
    let head = at_px(person, number::HEAD).unwrap() + Vec2::new(3.0, 2.0);
    assert!(head.abs_diff_eq(Vec2::new(35.0, 12.4), 1e-4), "{head}");
    assert_eq!((converted.labelled["ankle_r"], converted.labelled["head"]), (1, 2));
}

#[test]
fn persons_with_exchanged_sides_or_few_joints_are_left_out_and_counted() {
    let (_directory, options) = extended();
    let (converted, annotations) = converted(&options);
    let images: Vec<_> = annotations.iter().map(|annotation| annotation.image.as_str()).collect();
    assert_eq!(images, ["im00001_0.png", "im00002_0.png"]);
    let skipped: Vec<_> = converted.skipped.iter().map(|s| (s.image.as_str(), s.reason)).collect();
    assert_eq!(
        skipped,
        [
            ("im00003.jpg", SkipReason::SidesExchanged),
            ("im00004.jpg", SkipReason::FewJoints),
            ("im00005.jpg", SkipReason::NoImage),
            ("im00006.jpg", SkipReason::SidesExchanged),
        ]
    );
    let report = std::fs::read_to_string(options.output.join("conversion.json")).unwrap();
    assert!(report.contains("sides_exchanged") && report.contains("\"ankle_r\": 1"), "{report}");
}

#[test]
fn the_original_set_is_known_by_its_shape() {
    let (_directory, options) = set("original.mat", &["im0001.jpg", "im0002.jpg"]);
    let (converted, annotations) = converted(&options);
    assert_eq!((converted.persons, converted.images), (2, 2));
    assert_eq!(annotations[0].image, "im0001_0.png");
    let hidden = |annotation: &Annotation| {
        let keypoints = annotation.label.keypoints.iter().enumerate();
        let hidden = keypoints.filter(|(_, at)| at.visibility == Visibility::Hidden);
        hidden.map(|(joint, _)| joint).collect::<Vec<_>>()
    };
    assert_eq!(hidden(&annotations[0]), [number::WRIST_R, number::ANKLE_R]);
    assert!(hidden(&annotations[1]).is_empty());
    assert!(
        at_px(&annotations[0], number::ANKLE_R).unwrap().abs_diff_eq(Vec2::new(22.0, 70.0), 1e-4)
    );
}

#[test]
fn another_table_is_an_error_with_its_shape() {
    let (_directory, options) = set("turned.mat", &["im00001.jpg"]);
    let message = convert(&options, &|_, _| {}).unwrap_err().to_string();
    assert!(message.contains("joints: 14×2×3: it is 14×3×N or 3×14×N"), "{message}");
}
