//! COCO's keypoints into images of persons.

#![allow(clippy::unwrap_used, reason = "tests")]

use evpose_datasets::coco::convert;
use evpose_datasets::read_annotations;
use evpose_datasets::stills::{SkipReason, StillOptions, StillStyle};
use evpose_pose::body::{Visibility, number};
use glam::Vec2;
use serde_json::{Value, json};

/// Places of COCO's 17 keypoints of a person who faces the camera, `x` to the right: nose, eyes,
/// ears, then shoulders to ankles in pairs, left first.
const PLACES: [[i32; 2]; 17] = [
    [32, 10],
    [34, 8],
    [30, 8],
    [36, 9],
    [28, 9],
    [42, 20],
    [22, 20],
    [50, 32],
    [14, 32],
    [54, 44],
    [10, 44],
    [38, 42],
    [26, 42],
    [40, 56],
    [24, 56],
    [42, 70],
    [22, 70],
];

/// An annotation of the person, `dx` pixels to the right, with the visibility of each keypoint.
fn person(image: i64, dx: i32, visibility: impl Fn(usize) -> i32) -> Value {
    let triple = |(k, [x, y]): (usize, &[i32; 2])| match visibility(k) {
        0 => [0, 0, 0],
        seen => [x + dx, *y, seen],
    };
    let keypoints: Vec<i32> = PLACES.iter().enumerate().flat_map(triple).collect();
    json!({"image_id": image, "category_id": 1, "iscrowd": 0, "keypoints": keypoints})
}

#[test]
fn persons_are_cut_out_with_the_middle_of_the_face_as_head() {
    let directory = tempfile::tempdir().unwrap();
    let images = directory.path().join("train2017");
    std::fs::create_dir(&images).unwrap();
    for name in ["000000000007.jpg", "000000000009.jpg"] {
        image::GrayImage::from_pixel(100, 80, image::Luma([90])).save(images.join(name)).unwrap();
    }
    let file = directory.path().join("person_keypoints_train2017.json");
    let mut crowd = person(7, 0, |_| 2);
    crowd["iscrowd"] = json!(1);
    let mut tiny = person(7, 0, |_| 2);
    let small = PLACES.iter().flat_map(|[x, y]| [x / 2, y / 2, 2]);
    tiny["keypoints"] = small.collect();
    let content = json!({
        "images": [
            {"id": 7, "file_name": "000000000007.jpg", "width": 100, "height": 80},
            {"id": 8, "file_name": "000000000008.jpg"},
            {"id": 9, "file_name": "000000000009.jpg"},
        ],
        "annotations": [
            // No left ear, a left ankle that cannot be seen, no right wrist.
            person(7, 0, |k| match k { 3 | 10 => 0, 15 => 1, _ => 2 }),
            person(7, 30, |_| 2),
            crowd,
            // Nose and shoulders.
            person(7, 0, |k| if matches!(k, 0 | 5 | 6) { 2 } else { 0 }),
            person(7, 0, |_| 0),
            tiny,
            person(8, 0, |_| 2),
        ],
    });
    std::fs::write(&file, content.to_string()).unwrap();
    let output = directory.path().join("out");
    let options =
        StillOptions { style: StillStyle::Grey, ..StillOptions::new(file, images, &output) };
    let converted = convert(&options, &|_, _| {}).unwrap();
    let skipped: Vec<_> =
        converted.skipped.iter().map(|s| (s.image.as_str(), s.person, s.reason)).collect();
    assert_eq!(
        skipped,
        [
            ("000000000007.jpg", Some(2), SkipReason::Crowd),
            ("000000000007.jpg", Some(3), SkipReason::FewJoints),
            ("000000000007.jpg", Some(4), SkipReason::NoPoints),
            ("000000000007.jpg", Some(5), SkipReason::Small),
            ("000000000008.jpg", None, SkipReason::NoImage),
            ("000000000009.jpg", None, SkipReason::NoPersons),
        ]
    );
    let annotations = read_annotations(&output.join("poses.json")).unwrap();
    let names: Vec<_> = annotations.iter().map(|annotation| annotation.image.as_str()).collect();
    assert_eq!(names, ["000000000007_0.png", "000000000007_1.png"]);
    let label = &annotations[0].label;
    // Points from (14, 8) to (54, 70): half a side is 51, the middle (34, 39).
    let (start, side) = (Vec2::new(-17.0, -12.0), 102.0);
    let at = |joint: usize| label.keypoints[joint].position * side + start;
    // The mean of nose, both eyes and the right ear.
    assert!(at(number::HEAD).abs_diff_eq(Vec2::new(31.0, 8.75), 1e-4), "{}", at(number::HEAD));
    assert!(at(number::ELBOW_L).abs_diff_eq(Vec2::new(50.0, 32.0), 1e-4));
    assert_eq!(label.keypoints[number::WRIST_R].visibility, Visibility::Unlabelled);
    assert_eq!(label.keypoints[number::ANKLE_L].visibility, Visibility::Hidden);
    assert_eq!(label.keypoints[number::HEAD].visibility, Visibility::Visible);
    // The one beside, shoulders of somebody else, and the tiny one.
    assert_eq!(label.other_keypoints[number::SHOULDER_L].len(), 3);
    assert_eq!(converted.labelled["wrist_r"], 1);
}
