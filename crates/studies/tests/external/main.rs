//! Networks from small ONNX files, from a grey image to joints.
#![cfg(feature = "onnx")]
#![allow(clippy::unwrap_used, reason = "tests")]

mod onnx;

use std::path::{Path, PathBuf};

use evpose_core::Plane;
use evpose_pose::body::{BodyJoint, OpenPoseModel, number};
use evpose_studies::external::{ImageNetwork, MoveNet, OpenPose};
use glam::Vec2;
use onnx::{Maps, movenet, openpose};

fn written(directory: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = directory.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

fn near(joint: BodyJoint, at: Vec2) {
    let position = joint.position.unwrap_or(Vec2::MAX);
    assert!(position.distance(at) < 0.02, "{position}, not {at}");
}

#[test]
fn keypoints_of_movenet_are_read_off_the_letterboxed_image() {
    let directory = tempfile::tempdir().unwrap();
    // The network reads its outputs off pixels of the input: those of column 8, rows 2 and 3.
    let path = written(directory.path(), "movenet.onnx", &movenet(16, true));
    let network = MoveNet::open(&path).unwrap();
    assert_eq!(network.description(), "MoveNet, 16x16 px");
    // 32 x 24 pixels: a row of the image is half a row of the input, below two black ones.
    let mut image = Plane::filled(32, 24, 0);
    for (y, row) in image.data_mut().chunks_mut(32).enumerate() {
        row.fill(if y < 2 { 102 } else { 153 });
    }
    let joints = network.joints(&image).unwrap();
    // Greys 102 and 153 are 0.4 and 0.6: x = 0.6, y = 0.4 of the input, score 0.6.
    for joint in joints {
        near(joint, Vec2::new(0.6, (0.4 * 16.0 - 2.0) / 12.0));
        assert!((joint.score - 0.6).abs() < 1e-3, "{}", joint.score);
    }
    // Floats, and the image as it is.
    let path = written(directory.path(), "floats.onnx", &movenet(16, false));
    assert_eq!(MoveNet::open(&path).unwrap().joints(&image).unwrap(), joints);
}

#[test]
fn people_of_openpose_are_put_together_whatever_the_layout_of_the_maps() {
    let directory = tempfile::tempdir().unwrap();
    let image = Plane::filled(128, 96, 128);
    let layouts = [Maps::Apart, Maps::Together, Maps::Stages, Maps::ChannelsLast];
    for model in OpenPoseModel::ALL {
        for layout in layouts {
            let name = format!("{}-{layout:?}.onnx", model.name());
            let path = written(directory.path(), &name, &openpose(model, layout, 0.5));
            let network = OpenPose::open(&path).unwrap();
            let parts = model.parts();
            assert_eq!(network.description(), format!("OpenPose, {parts} parts, 128x96 px"));
            let joints = network.joints(&image).unwrap();
            // Cells are 8 pixels of 128 x 96; files::onnx says where parts are.
            near(joints[number::SHOULDER_R], Vec2::new(4.5 / 16.0, 4.5 / 12.0));
            near(joints[number::SHOULDER_L], Vec2::new(12.5 / 16.0, 4.5 / 12.0));
            near(joints[number::HEAD], Vec2::new(8.5 / 16.0, 1.5 / 12.0));
            assert!(joints[number::KNEE_L].position.is_none(), "{name}");
        }
    }
}

#[test]
fn greys_of_openpose_are_centred() {
    let directory = tempfile::tempdir().unwrap();
    // Heatmaps fall by the mean of the input, so that people are there in front of mid-grey only.
    let path =
        written(directory.path(), "grey.onnx", &openpose(OpenPoseModel::Coco18, Maps::Apart, 0.5));
    let network = OpenPose::open(&path).unwrap();
    let score = |grey: u8| network.joints(&Plane::filled(128, 96, grey)).unwrap()[1].score;
    let [dark, middle, bright] = [score(0), score(128), score(255)];
    // The peak is 0.5 - input: 1.0, 0.5 and about 0 for greys of 0, 128 and 255.
    assert!(
        bright < 0.05 && middle > 0.4 && (dark - middle - 0.5).abs() < 0.1,
        "{dark} {middle} {bright}"
    );
}

#[test]
fn a_size_that_the_file_leaves_open_is_that_of_the_system() {
    let directory = tempfile::tempdir().unwrap();
    let bytes = onnx::openpose_of_any_size();
    let path = written(directory.path(), "open.onnx", &bytes);
    let network = OpenPose::open(&path).unwrap();
    assert_eq!(network.description(), "OpenPose, 18 parts, 496x368 px");
    assert!(network.joints(&Plane::filled(40, 30, 9)).unwrap()[1].position.is_none());
}

#[test]
fn files_of_something_else_are_refused_by_name() {
    let directory = tempfile::tempdir().unwrap();
    let message = |error: Option<anyhow::Error>| error.unwrap().to_string();
    let missing = directory.path().join("nothing.onnx");
    let error = message(MoveNet::open(&missing).err());
    assert!(error.contains("nothing.onnx"), "{error}");
    let text = written(directory.path(), "text.onnx", b"no network at all");
    let error = message(OpenPose::open(&text).err());
    assert!(error.contains("text.onnx: no ONNX network"), "{error}");
    let other = written(directory.path(), "other.onnx", &movenet(16, false));
    let error = message(OpenPose::open(&other).err());
    assert!(error.contains("[1, 1, 17, 3]") && error.contains("BODY_25"), "{error}");
    let maps = openpose(OpenPoseModel::Coco18, Maps::Apart, 0.5);
    let other = written(directory.path(), "maps.onnx", &maps);
    let error = message(MoveNet::open(&other).err());
    assert!(error.contains("[1, 19, 12, 16], [1, 38, 12, 16]"), "{error}");
    let grey = written(directory.path(), "grey.onnx", &onnx::of_grey_images());
    let error = message(MoveNet::open(&grey).err());
    assert!(error.contains("[1, 1, 16, 16]; one image of three channels"), "{error}");
}
