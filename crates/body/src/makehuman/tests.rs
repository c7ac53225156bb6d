//! A made-up person in the published layout: a tetrahedron around each joint, in MakeHuman's unit.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;

use super::*;
use crate::{BodyPose, PosedBody};

/// Half the size of what is around a joint, in MakeHuman's unit.
const HALF: f32 = 0.1;
/// How far arms are lowered in the rest pose of the files, in radians.
const LOWERED: f32 = 0.8;

/// The joints of the files: the procedural ones with lowered arms.
fn resting() -> [Vec3; JOINTS] {
    let mut joints_m = rest_joints();
    for (shoulder, hand, side) in [(16, LEFT_HAND, -1.0), (17, RIGHT_HAND, 1.0)] {
        let (root_m, turn) = (joints_m[shoulder], Mat3::from_rotation_z(side * LOWERED));
        let fingers = hand..hand + 15;
        for joint in [shoulder + 2, shoulder + 4].into_iter().chain(fingers) {
            joints_m[joint] = root_m + turn * (joints_m[joint] - root_m);
        }
    }
    // Files have the joint of the head as far above the one that is used as that is above the neck.
    joints_m[15] += joints_m[15] - joints_m[12];
    joints_m
}

fn tip(joints_m: &[Vec3; JOINTS], joint: usize) -> Vec3 {
    2.0 * joints_m[joint] - joints_m[joint - 1]
}

/// Writes the files: group `body` of tetrahedra around the joints, and cubes of the same vertices.
fn write(folder: &Path) {
    let joints_m = resting();
    let ends = (0..10).map(|digit| (JOINTS + digit, tip(&joints_m, BODY_JOINTS + 3 * digit + 2)));
    let places: Vec<(usize, Vec3)> = joints_m.into_iter().enumerate().chain(ends).collect();
    let (mut vertices, mut faces) = (String::new(), String::from("g body\n"));
    let mut cubes = String::new();
    for (place, at_m) in places {
        let corners = [Vec3::ONE, Vec3::new(1.0, -1.0, -1.0), Vec3::new(-1.0, 1.0, -1.0)];
        for corner in corners.into_iter().chain([Vec3::new(-1.0, -1.0, 1.0)]) {
            let Vec3 { x, y, z } = at_m / UNIT_M + corner * HALF;
            writeln!(vertices, "v {x} {y} {z}").expect("written");
        }
        let [a, b, c, d] = [1, 2, 3, 4].map(|k| 4 * place + k);
        let tetrahedron = format!("f {a} {b} {c}\nf {a} {c} {d}\nf {a} {d} {b}\nf {b} {d} {c}\n");
        if place < JOINTS {
            faces += &tetrahedron;
        }
        cubes += &format!("g joint-{place}\n{tetrahedron}");
    }
    fs::create_dir_all(folder.join("3dobjs")).expect("created");
    fs::write(folder.join("3dobjs/base.obj"), vertices + &faces + &cubes).expect("written");

    let cube =
        |place| serde_json::json!({ "strategy": "CUBE", "cube_name": format!("joint-{place}") });
    let (mut rig, mut weights) = (serde_json::Map::new(), serde_json::Map::new());
    for joint in 0..JOINTS {
        let is_last = joint >= BODY_JOINTS && (joint - BODY_JOINTS) % 3 == 2;
        let tail = if is_last { JOINTS + (joint - BODY_JOINTS) / 3 } else { joint };
        let bone = serde_json::json!({ "head": cube(joint), "tail": cube(tail), "roll": 0.0 });
        rig.insert(rig::bone_of(joint), bone);
        let own: Vec<_> = (4 * joint..4 * joint + 4).map(|v| serde_json::json!([v, 1.0])).collect();
        weights.insert(rig::bone_of(joint), own.into());
    }
    let standard = folder.join("rigs/standard");
    fs::create_dir_all(&standard).expect("created");
    let rig = serde_json::Value::Object(rig).to_string();
    fs::write(standard.join("rig.game_engine.json"), rig).expect("written");
    let weights = serde_json::json!({ "license": "CC0", "weights": weights }).to_string();
    fs::write(standard.join("weights.game_engine.json"), weights).expect("written");

    // Tall people are longer below the knees, men wider at the hips; babies are passed over.
    let macros = folder.join("targets/macrodetails/height");
    fs::create_dir_all(&macros).expect("created");
    let lower = [4, 5, 7, 8, 10, 11].map(|joint| moved(joint, "0 -1.5 0"));
    let lower = lower[2..].concat();
    for sex in ["male", "female"] {
        let name = format!("{sex}-young-averagemuscle-averageweight-maxheight.target.gz");
        let file = fs::File::create(macros.join(name)).expect("created");
        let mut packed = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
        packed.write_all(lower.as_bytes()).expect("written");
        packed.finish().expect("written");
    }
    let above = folder.join("targets/macrodetails");
    let wide = format!("# basemesh hm08\n{}{}", moved(1, ".2 0 0"), moved(2, "-.2 0 0"));
    for age in ["young", "old", "baby"] {
        let name = format!("universal-male-{age}-averagemuscle-averageweight.target");
        fs::write(above.join(name), &wide).expect("written");
    }
}

/// Lines that move all that is around a joint.
fn moved(joint: usize, by: &str) -> String {
    (4 * joint..4 * joint + 4).map(|vertex| format!("{vertex} {by}\n")).collect()
}

fn person() -> (tempfile::TempDir, MakeHuman) {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path());
    let person = MakeHuman::read(folder.path()).expect("read");
    (folder, person)
}

#[test]
fn lowered_arms_are_raised_to_the_t_pose() {
    let (_folder, MakeHuman { model, outfits }) = person();
    let joints_m = model.shaped(&[]).joints_m;
    // Trunk, arms and hands; the mean shape has wider hips than the base mesh.
    // Directions are exact; the turn of least angle leaves a twist of a few degrees.
    for (joint, want_m) in rest_joints().into_iter().enumerate().skip(12) {
        let is_exact = joint < BODY_JOINTS || [LEFT_HAND + 3, RIGHT_HAND + 3].contains(&joint);
        let within_m = if is_exact { 1e-4 } else { 3e-3 };
        let apart_m = joints_m[joint].distance(want_m);
        assert!(apart_m < within_m, "{joint}: {} {want_m}", joints_m[joint]);
    }
    let (along, want) = (joints_m[4] - joints_m[1], rest_joints()[4] - rest_joints()[1]);
    assert!(along.normalize().distance(want.normalize()) < 1e-5, "{along}");
    // What is around the wrist has turned with it, and stayed around it.
    let around = &model.shaped(&[]).vertices_m[4 * 20..4 * 21];
    let middle_m = around.iter().sum::<Vec3>() / 4.0;
    assert!(middle_m.distance(joints_m[20]) < 1e-4);
    let want = Mat3::from_rotation_z(LOWERED) * Vec3::ONE * HALF * UNIT_M;
    let (found, turned) = (around[0] - middle_m, (around[0] - middle_m).angle_between(want));
    assert!((found.x - want.x).abs() < 1e-4 && turned < 0.07, "{found} {turned}");
    assert_eq!(outfits[0].len(), 4 * JOINTS);
    assert_eq!(outfits[0], outfits[3], "there are no helpers in this mesh");
}

#[test]
fn targets_count_as_their_words_say() {
    let (_folder, MakeHuman { model, .. }) = person();
    assert_eq!(model.shape_directions_m.len(), 4, "two of height, two of men; no babies");
    let hips_m = |betas: &[f32]| {
        let joints_m = model.shaped(betas).joints_m;
        (joints_m[1].x - joints_m[2].x, joints_m[4].y - joints_m[7].y)
    };
    let rest = rest_joints();
    let (width_m, shank_m) = (rest[1].x - rest[2].x, rest[4].y - rest[7].y);
    // A young woman: neither; a young man: 2 cm on either side.
    let young = -2.0 / 3.0;
    let close = |a: (f32, f32), b: (f32, f32)| (a.0 - b.0).abs() + (a.1 - b.1).abs() < 1e-4;
    assert!(close(hips_m(&[-2.0, young]), (width_m, shank_m)), "{:?}", hips_m(&[-2.0, young]));
    assert!(close(hips_m(&[2.0, young]), (width_m + 0.04, shank_m)));
    // Between young and old both targets of men count in part, and all of them together.
    assert!(close(hips_m(&[2.0, 0.7]), (width_m + 0.04, shank_m)));
    // Half of the way between the middle and the outermost target of height, of any sex.
    for sex in [-2.0, 0.1, 2.0] {
        let (_, found_m) = hips_m(&[sex, young, 0.0, 0.0, 2.0]);
        assert!((found_m - shank_m - 0.5 * 0.15).abs() < 1e-4, "{found_m}");
    }
    // With much weight, a target of average weight does not count.
    assert!(close(hips_m(&[2.0, young, 0.0, 2.0]), (width_m, shank_m)));
}

#[test]
fn a_pose_moves_joints_as_those_of_the_procedural_body() {
    let (_folder, MakeHuman { model, .. }) = person();
    let mut pose = BodyPose::rest(&model);
    pose.joints[16] = Vec3::new(0.0, 0.0, -1.3);
    pose.joints[18] = Vec3::new(0.0, -1.0, 0.0);
    let joints = |model: &BodyModel, betas: &[f32]| {
        let mut posed = PosedBody::default();
        model.pose_joints(&model.shaped(betas), &pose, &mut posed);
        posed.joints
    };
    let procedural = BodyModel::procedural_arm();
    let (own, want) = (joints(&model, &[-2.0]), joints(&procedural, &[]));
    for joint in [13, 16, 18, 20, 25, 28] {
        let apart = own[joint].translation.distance(want[joint].translation);
        // Joints of the procedural arm are sums of vertices.
        assert!(apart < 5e-3, "{joint}: {apart}");
    }
}

#[test]
fn faults_are_found_with_their_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let message = |folder: &Path| MakeHuman::read(folder).expect_err("refused").to_string();
    assert!(message(folder.path()).contains("base.obj"));
    write(folder.path());
    let target = "universal-male-old-averagemuscle-averageweight.target";
    let target = folder.path().join("targets/macrodetails").join(target);
    for row in ["100000 0 0 0", "1 0 0", "1 0 nan 0", "x"] {
        fs::write(&target, format!("# basemesh hm08\n{row}\n")).expect("written");
        assert!(message(folder.path()).contains("line 2"), "{row}");
    }
    fs::remove_file(&target).expect("removed");
    let weights = folder.path().join("rigs/standard/weights.game_engine.json");
    fs::write(&weights, r#"{ "weights": { "pelvis": [[0, 1.0]] } }"#).expect("written");
    assert!(message(folder.path()).contains("weights of vertex 1"));
    fs::write(folder.path().join("rigs/standard/rig.game_engine.json"), "{}").expect("written");
    assert!(message(folder.path()).contains("no bone `pelvis`"));
}
