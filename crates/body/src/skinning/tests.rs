//! Closed forms of posing, on the procedural arm.

use std::f32::consts::FRAC_PI_2;
use std::sync::LazyLock;

use evpose_core::CounterRng;
use evpose_pose::rotation::{geodesic_rad, matrix_from_axis_angle};
use proptest::prelude::*;

use super::*;
use crate::motion::{Target, Variant};
use crate::skeleton::{RIGHT_HAND, RIGHT_WRIST};

static MODEL: LazyLock<BodyModel> = LazyLock::new(BodyModel::procedural_arm);
static SHAPED: LazyLock<ShapedBody> = LazyLock::new(|| MODEL.shaped(&[]));

fn posed(pose: &BodyPose) -> PosedBody {
    let mut out = PosedBody::default();
    MODEL.pose(&SHAPED, pose, &mut out);
    out
}

fn random_pose(seed: u64) -> BodyPose {
    let target = Target::draw(Variant::Code, &mut CounterRng::new(seed, "pose", 0));
    BodyPose::from_generator(&MODEL, &target.parameters, target.translation_m)
}

#[test]
fn at_rest_nothing_moves() {
    let body = posed(&BodyPose::rest(&MODEL));
    for (posed, rest) in body.vertices_m.iter().zip(&SHAPED.vertices_m) {
        assert!(posed.distance(*rest) < 1e-6);
    }
    for (posed, rest) in body.normals.iter().zip(&SHAPED.normals) {
        assert!(posed.distance(*rest) < 1e-5);
    }
    for (joint, rest) in body.joints.iter().zip(&SHAPED.joints_m) {
        assert!(Vec3::from(joint.translation).distance(*rest) < 1e-6);
    }
}

#[test]
fn turning_the_wrist_turns_the_finger_tips_about_it() {
    let mut pose = BodyPose::rest(&MODEL);
    pose.joints[RIGHT_WRIST] = Vec3::new(0.0, 0.0, FRAC_PI_2);
    pose.translation_m = Vec3::new(0.1, -0.2, 0.3);
    let body = posed(&pose);
    let wrist_m = SHAPED.joints_m[RIGHT_WRIST];
    for tip in MODEL.fingertips {
        let from_wrist = SHAPED.vertices_m[tip as usize] - wrist_m;
        // A quarter turn about z sends (x, y) to (-y, x).
        let turned = Vec3::new(-from_wrist.y, from_wrist.x, from_wrist.z);
        let want = wrist_m + turned + pose.translation_m;
        assert!(body.vertices_m[tip as usize].distance(want) < 1e-6);
    }
}

#[test]
fn turning_a_knuckle_moves_its_finger_only() {
    let mut pose = BodyPose::rest(&MODEL);
    pose.joints[RIGHT_HAND] = Vec3::new(0.0, 0.0, 1.0);
    let (rest, body) = (posed(&BodyPose::rest(&MODEL)), posed(&pose));
    let moved = MODEL
        .fingertips
        .map(|tip| rest.vertices_m[tip as usize].distance(body.vertices_m[tip as usize]) > 1e-3);
    assert_eq!(moved, [false, true, false, false, false], "thumb, index, middle, ring, pinky");
}

#[test]
fn normals_stay_unit_and_near_those_of_the_posed_surface() {
    let body = posed(&random_pose(3));
    let exact = area_weighted_normals(&body.vertices_m, &MODEL.faces);
    let cosines: Vec<f32> = body.normals.iter().zip(&exact).map(|(a, b)| a.dot(*b)).collect();
    assert!(body.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
    let close = cosines.iter().filter(|cosine| **cosine > 0.9).count();
    assert!(close as f32 > 0.97 * cosines.len() as f32, "{close} of {}", cosines.len());
}

#[test]
fn evaluation_points_come_in_the_published_order() {
    let body = posed(&random_pose(4));
    let points = body.evaluation_points(&MODEL);
    let joint = |j: usize| Vec3::from(body.joints[j].translation);
    assert_eq!(points[0], joint(21));
    assert_eq!(points[2], body.vertices_m[MODEL.fingertips[1] as usize]);
    // Point 9 is the knuckle of the middle finger, joint 40.
    assert_eq!(points[9], joint(40));
    assert_eq!(points[20], joint(51));
}

#[test]
fn pose_correctives_displace_the_rest_pose() {
    let mut model = BodyModel::procedural_arm();
    // One direction moves vertex 0 along z with entry (1, 0) of R - I of joint 1: sin of its turn
    // about z.
    model.pose_directions_m = vec![vec![Vec3::ZERO; model.template_m.len()]; 9 * 51];
    model.pose_directions_m[3][0] = Vec3::new(0.0, 0.0, 0.01);
    let mut pose = BodyPose::rest(&model);
    pose.joints[1] = Vec3::new(0.0, 0.0, FRAC_PI_2);
    let mut out = PosedBody::default();
    model.pose(&SHAPED, &pose, &mut out);
    // Joint 1 is a hip and moves no vertex by itself.
    let displaced = out.vertices_m[0] - SHAPED.vertices_m[0];
    assert!(displaced.distance(Vec3::new(0.0, 0.0, 0.01)) < 1e-6, "{displaced}");
    assert!(out.vertices_m[1].distance(SHAPED.vertices_m[1]) < 1e-6);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn a_placed_hand_has_the_parameters_it_was_placed_with(
        articulation in prop::array::uniform6(-2.0f32..2.0),
        translation in prop::array::uniform3(-1.0f32..1.0),
        axis in prop::array::uniform3(-1.0f32..1.0),
        angle in 0.0f32..3.1,
    ) {
        let Some(axis) = Vec3::from(axis).try_normalize() else { return Ok(()) };
        let params = HandParams {
            articulation,
            translation_m: translation.into(),
            rotation: axis * angle,
        };
        let mut body = PosedBody::default();
        MODEL.pose_hand(&SHAPED, &params, &mut body);
        let read = body.hand_params(&MODEL, articulation);
        prop_assert!(read.translation_m.distance(params.translation_m) < 1e-6);
        prop_assert!(read.rotation.distance(params.rotation) < 1e-3, "{}", read.rotation);
        prop_assert_eq!(read.articulation, articulation);
    }

    /// Labels and playback agree: the hand of a posed body, placed by its own parameters, is there.
    #[test]
    fn placing_a_hand_by_its_label_returns_the_hand(seed in 0u64..1000) {
        let target = Target::draw(Variant::Code, &mut CounterRng::new(seed, "pose", 0));
        let pose = BodyPose::from_generator(&MODEL, &target.parameters, target.translation_m);
        let body = posed(&pose);
        let params = body.hand_params(&MODEL, target.articulation());
        let mut placed = PosedBody::default();
        MODEL.pose_hand(&SHAPED, &params, &mut placed);
        for (a, b) in body.evaluation_points(&MODEL).iter().zip(placed.evaluation_points(&MODEL)) {
            prop_assert!(a.distance(b) < 1e-5, "{a} {b}");
        }
        // Without a surface, too.
        for (a, b) in MODEL.hand_points(&SHAPED, &params).iter().zip(placed.evaluation_points(&MODEL)) {
            prop_assert!(a.distance(b) < 1e-5, "{a} {b}");
        }
    }

    #[test]
    fn the_rotation_label_is_that_of_the_chain(seed in 0u64..1000) {
        let pose = random_pose(seed);
        let chain = [0, 3, 6, 9, 14, 17, 19, 21];
        let rotation = chain.iter().fold(Mat3::IDENTITY, |product, &joint| {
            product * matrix_from_axis_angle(pose.joints[joint])
        });
        let label = posed(&pose).hand_params(&MODEL, [0.0; 6]).rotation;
        let want = evpose_pose::rotation::axis_angle_from_matrix(rotation);
        prop_assert!(label.length() <= std::f32::consts::PI + 1e-5);
        prop_assert!(geodesic_rad(label, want) < 1e-3);
    }
}

#[test]
fn vertices_and_normals_are_those_of_a_plain_sum_over_joints() {
    let pose = random_pose(9);
    let body = posed(&pose);
    let transforms = body.joints.iter().zip(&SHAPED.joints_m);
    let world_from_rest: Vec<Affine3A> =
        transforms.map(|(joint, &rest_m)| *joint * Affine3A::from_translation(-rest_m)).collect();
    for (vertex, skin) in MODEL.skin.iter().enumerate() {
        let (mut moved_m, mut normal) = (Vec3::ZERO, Vec3::ZERO);
        for (joint, weight) in skin.iter() {
            let transform = &world_from_rest[joint];
            moved_m += weight * transform.transform_point3(SHAPED.vertices_m[vertex]);
            normal += weight * transform.transform_vector3(SHAPED.normals[vertex]);
        }
        assert!(body.vertices_m[vertex].distance(moved_m) < 1e-6, "{vertex}");
        assert!(body.normals[vertex].distance(normal.normalize()) < 1e-5, "{vertex}");
    }
}
