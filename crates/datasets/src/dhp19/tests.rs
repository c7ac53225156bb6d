//! Comparison with files in the published layouts and values of a separate program; see
//! `tests/golden/dhp19`.

use std::fs;
use std::path::{Path, PathBuf};

use evpose_core::Micros;
use evpose_pose::body::JOINT_NAMES;

use super::*;
use crate::DatasetError;

/// Removed as pixels that never stop, without support on separate cameras and on touching ones, and
/// as lamps.
const HOT: usize = 86;
const UNSUPPORTED: (usize, usize) = (354, 366);
const MASKED: usize = 65;
/// Of each camera: events, and the sums of times, columns, rows and ON events.
const PER_CAMERA: [(usize, i64, u64, u64, usize); CAMERAS] = [
    (164, 24_715_594, 35_059, 26_106, 91),
    (147, 21_362_629, 18_618, 23_389, 67),
    (76, 10_759_949, 6_371, 9_721, 36),
    (77, 10_562_724, 16_689, 10_556, 37),
];

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/dhp19").join(name)
}

/// The filters with a threshold of hot pixels that a short recording reaches.
fn filters(rule: NeighbourRule) -> Dhp19Filters {
    Dhp19Filters {
        hot_pixel_events: Some(20),
        background: Some(BackgroundFilter { rule, ..BackgroundFilter::default() }),
        are_lamps_masked: true,
    }
}

fn movement(filters: &Dhp19Filters) -> Movement {
    let path = golden("mov5.aedat");
    cut_movement(&path, &read_movie(&path, false).unwrap(), 12, filters).unwrap()
}

#[test]
fn a_movie_is_that_of_four_cameras() {
    let movie = read_movie(&golden("mov5.aedat"), false).unwrap();
    assert_eq!(movie.pulses, [1_055_020_000, 1_055_020_001, 1_055_280_000].map(Micros));
    assert_eq!(movie.cameras.iter().map(|camera| camera.len()).sum::<usize>(), 1100);
    assert!(movie.cameras.iter().all(|camera| camera.sensor() == SENSOR));
    // One of camera 1 and one of camera 2 lie outside.
    assert_eq!(movie.remarks.len(), 2, "{:?}", movie.remarks);
    assert!(movie.remarks[0].starts_with("camera 1: 1 events"), "{:?}", movie.remarks);
}

#[test]
fn movements_are_cut_and_filtered_as_the_published_programs_do_it() {
    let ours = movement(&filters(NeighbourRule::Published));
    let theirs = read_extracted(&golden("extracted.mat")).unwrap();
    assert_eq!(ours.cameras, theirs.cameras);
    assert_eq!(ours.span.window, theirs.span.window);
    assert_eq!((ours.span.origin, theirs.span.origin), (SpanOrigin::Pulses, SpanOrigin::Stated));
    let removed = Removed { hot: HOT, unsupported: UNSUPPORTED.1, masked: MASKED };
    assert_eq!((ours.removed, theirs.removed), (Some(removed), None));
}

#[test]
fn cameras_that_do_not_touch_are_filtered_as_numpy_does_it() {
    let ours = movement(&filters(NeighbourRule::PerCamera));
    let sums = ours.cameras.each_ref().map(|camera| {
        let t: i64 = camera.t().iter().map(|t| t.0).sum();
        let sum = |column: &[u16]| column.iter().map(|&v| u64::from(v)).sum::<u64>();
        let on = camera.polarity().iter().filter(|polarity| polarity.is_on()).count();
        (camera.len(), t, sum(camera.x()), sum(camera.y()), on)
    });
    assert_eq!(sums, PER_CAMERA);
    let removed = Removed { hot: HOT, unsupported: UNSUPPORTED.0, masked: MASKED };
    assert_eq!(ours.removed, Some(removed));
}

#[test]
fn joints_lie_on_the_images_where_numpy_projects_them() {
    let poses = read_vicon(&golden("S1_2_5.mat")).unwrap();
    assert_eq!(poses.len(), 12);
    let lost = |pose: &Pose| pose.iter().filter(|joint| joint.is_none()).count();
    assert_eq!(poses.iter().map(lost).sum::<usize>(), 2);
    let number = |name: &str| {
        let name = name.replace("hand", "wrist").replace("foot", "ankle");
        let name = match name.split_at(name.len() - 1) {
            (part, side @ ("L" | "R")) => format!("{part}_{}", side.to_lowercase()),
            _ => name,
        };
        JOINT_NAMES.iter().position(|joint| *joint == name).unwrap()
    };
    let table = fs::read_to_string(golden("projected.csv")).unwrap();
    let (mut on_image, mut off_image) = (0, 0);
    for line in table.lines().skip(1) {
        let [camera, pose, joint, u, v] = line.split(',').collect::<Vec<_>>().try_into().unwrap();
        let projection = Projection::of_camera(camera.parse().unwrap(), &golden("")).unwrap();
        let pose = &poses[pose.parse::<usize>().unwrap()];
        match (projection.project_pose(pose, PixelRule::Exact)[number(joint)], u.is_empty()) {
            (None, true) => off_image += 1,
            (Some(at), false) => {
                let want = [u, v].map(|number| number.parse::<f32>().unwrap());
                assert!(at.distance(want.into()) < 1e-4, "{line}: {at}");
                on_image += 1;
            }
            (found, _) => panic!("{line}: {found:?}"),
        }
    }
    assert_eq!((on_image, off_image), (189, 19));
}

#[test]
fn a_camera_sees_events_and_poses_on_one_clock() {
    let movement = movement(&Dhp19Filters::NONE);
    let poses = read_vicon(&golden("S1_2_5.mat")).unwrap();
    let projection = Projection::of_camera(2, &golden("")).unwrap();
    let name: Dhp19Name = "S1_2_5".parse().unwrap();
    let seen = movement.seen_by(name, 2, &projection, &poses, PixelRule::Truncated);
    assert_eq!((seen.name.as_str(), seen.bodies.len()), ("S1_2_5_ch2", 12));
    assert_eq!(seen.bodies[11].t, Micros(110_000));
    assert!(seen.events.t().iter().all(|t| (0..260_000).contains(&t.0)));
    assert!(seen.bodies.iter().flat_map(|b| b.points_px).flatten().all(|p| p == p.trunc()));
    // More poses than time.
    let many = [poses[0]; 40];
    let seen = movement.seen_by(name, 2, &projection, &many, PixelRule::Exact);
    assert_eq!(seen.bodies.len(), 27);
}

#[test]
fn what_is_wrong_is_named() {
    let path = golden("mov5.aedat");
    let mut movie = read_movie(&path, false).unwrap();
    movie.pulses = vec![Micros(0); 700];
    let failed = cut_movement(&path, &movie, 12, &Dhp19Filters::NONE).unwrap_err().to_string();
    assert!(failed.contains("mov5.aedat") && failed.contains("700 pulses"), "{failed}");

    // A file of one camera.
    let directory = tempfile::tempdir().unwrap();
    let other = directory.path().join("one.aedat");
    let bytes = fs::read(&path).unwrap();
    let chip = bytes.windows(5).position(|part| part == b"Multi").unwrap();
    let one = [&bytes[..chip], &bytes[chip + 5..]].concat();
    fs::write(&other, one).unwrap();
    let failed = read_movie(&other, false).unwrap_err().to_string();
    assert!(failed.contains("one.aedat") && failed.contains("four cameras"), "{failed}");

    // Cut within a record.
    fs::write(&other, &bytes[..bytes.len() - 3]).unwrap();
    assert!(matches!(read_movie(&other, false), Err(DatasetError::Recording(_))));
    let remarks = read_movie(&other, true).unwrap().remarks;
    assert!(remarks.iter().any(|remark| remark.contains("the rest is lost")), "{remarks:?}");

    // Files of each other's kind.
    let failed = read_vicon(&golden("extracted.mat")).unwrap_err().to_string();
    assert!(failed.contains("XYZPOS"), "{failed}");
    let failed = read_extracted(&golden("S1_2_5.mat")).unwrap_err().to_string();
    assert!(failed.contains("`out`"), "{failed}");
}
