//! A hand of one vertex a joint, built in memory.

use std::f32::consts::FRAC_PI_2;

use proptest::prelude::*;

use super::*;
use crate::{BodyPose, PosedBody};

/// Position of joint `k` of [`JOINTS`] on a right hand, fingers along -z, its back up.
fn place(k: usize) -> Vec3 {
    match k {
        0 => Vec3::ZERO,
        1..=4 => Vec3::new(-0.04, -0.01, -0.02 * k as f32),
        _ => {
            let (finger, phalanx) = ((k - 5) / 5, (k - 5) % 5);
            Vec3::new(0.02 * finger as f32 - 0.03, 0.0, -0.03 - 0.03 * phalanx as f32)
        }
    }
}

/// The file, without the joints named in `lacking`.
fn glb(lacking: &[&str]) -> Vec<u8> {
    let joints: Vec<usize> = (0..25).filter(|&k| !lacking.contains(&JOINTS[k].0)).collect();
    let n = joints.len();
    let mut blob = Vec::new();
    let mut floats = |values: &[f32]| values.iter().for_each(|v| blob.extend(v.to_le_bytes()));
    for &k in &joints {
        floats(&Mat4::from_translation(-place(k)).to_cols_array());
    }
    for &k in &joints {
        floats(&place(k).to_array());
    }
    for _ in 0..n {
        floats(&[1.0, 0.0, 0.0, 0.0]);
    }
    for k in 0..n {
        blob.extend([k as u8, 0, 0, 0]);
    }
    blob.extend([0, 1, 2, 3, 4, 5, 0, 0]);
    let mut at = 0;
    let mut view = |length: usize| {
        let text = format!(r#"{{"buffer":0,"byteOffset":{at},"byteLength":{length}}}"#);
        at += length;
        text
    };
    let views = [64 * n, 12 * n, 16 * n, 4 * n, 6].map(&mut view).join(",");
    let nodes: Vec<String> =
        joints.iter().map(|&k| format!(r#"{{"name":"{}"}}"#, JOINTS[k].0)).collect();
    let indices: Vec<String> = (0..n).map(|k| k.to_string()).collect();
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{}}}],"bufferViews":[{views}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":{n},"type":"MAT4"}},
{{"bufferView":1,"componentType":5126,"count":{n},"type":"VEC3","min":[-1,-1,-1],"max":[1,1,1]}},
{{"bufferView":2,"componentType":5126,"count":{n},"type":"VEC4"}},
{{"bufferView":3,"componentType":5121,"count":{n},"type":"VEC4"}},
{{"bufferView":4,"componentType":5121,"count":6,"type":"SCALAR"}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":1,"WEIGHTS_0":2,"JOINTS_0":3}},"indices":4}}]}}],
"skins":[{{"inverseBindMatrices":0,"joints":[{}]}}],
"nodes":[{},{{"mesh":0,"skin":0}}]}}"#,
        blob.len(),
        indices.join(","),
        nodes.join(",")
    );
    while json.len() % 4 != 0 {
        json.push(' ');
    }
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend(((28 + json.len() + blob.len()) as u32).to_le_bytes());
    out.extend((json.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(json.bytes());
    out.extend((blob.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(blob);
    out
}

fn read(bytes: &[u8]) -> Result<ModelFile, ModelFileError> {
    ModelFile::from_bytes(Path::new("HAND"), bytes.to_vec())
}

#[test]
fn a_hand_is_turned_as_the_published_ones_and_keeps_its_lengths() {
    let file = read(&glb(&[])).unwrap();
    assert_eq!(file.kind, ModelKind::Jointed(HandSide::Right));
    let joints_m = &file.model.joint_offsets_m;
    assert_eq!(joints_m.len(), 16);
    // The middle finger starts on x; -z became -x, -x became +z.
    let middle = place(11);
    let forward = Vec3::new(middle.x, 0.0, middle.z).normalize();
    assert!(joints_m[4].distance(Vec3::new(-middle.length(), 0.0, 0.0)) < 1e-6, "{}", joints_m[4]);
    assert!((joints_m[1] - joints_m[7]).z > 0.0);
    assert!((joints_m[6].x + place(13).dot(forward)).abs() < 1e-6);
    // Every vertex lies at the joint of its number; these are the tips.
    assert_eq!(file.model.fingertips, [4, 9, 14, 19, 24]);
}

#[test]
fn turning_a_knuckle_carries_its_finger_by_the_skin() {
    let model = read(&glb(&[])).unwrap().model;
    let shaped = model.shaped(&[]);
    let mut pose = BodyPose::rest(&model);
    pose.joints[1] = Vec3::new(0.0, 0.0, FRAC_PI_2);
    let mut out = PosedBody::default();
    model.pose(&shaped, &pose, &mut out);
    let from_knuckle = shaped.vertices_m[9] - shaped.joints_m[1];
    let turned = Vec3::new(-from_knuckle.y, from_knuckle.x, from_knuckle.z);
    assert!(out.vertices_m[9].distance(shaped.joints_m[1] + turned) < 1e-6);
    assert_eq!(out.vertices_m[14], shaped.vertices_m[14]);
}

#[test]
fn joints_that_a_file_lacks_are_named() {
    let file = read(&glb(&["index-finger-tip", "ring-finger-metacarpal"])).unwrap();
    assert_eq!(file.missing[3..], ["index-finger-tip", "ring-finger-metacarpal"]);
    let error = read(&glb(&["thumb-phalanx-distal"])).unwrap_err().to_string();
    assert!(error.contains("without the WebXR joints thumb-phalanx-distal"), "{error}");
}

#[test]
fn every_prefix_is_refused() {
    let whole = glb(&[]);
    for end in 0..whole.len() {
        assert!(read(&whole[..end]).is_err(), "{end}");
    }
}

proptest! {
    #[test]
    fn changed_bytes_never_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), 1u8..), 1..6),
    ) {
        let mut bytes = glb(&[]);
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] ^= value;
        }
        let _ = read(&bytes);
    }
}
