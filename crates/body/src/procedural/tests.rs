//! Properties of the procedural arm.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use proptest::prelude::*;

use super::*;
use crate::{BodyPose, PosedBody};

static MODEL: LazyLock<BodyModel> = LazyLock::new(BodyModel::procedural_arm);

/// Posed hands with these articulation coefficients; the rest of the body in the T-pose.
fn posed(coefficients: &[f32]) -> PosedBody {
    let model = &*MODEL;
    let mut pose = BodyPose::rest(model);
    pose.set_hand(&model.right_hand, coefficients);
    let mut out = PosedBody::default();
    model.pose(&model.shaped(&[]), &pose, &mut out);
    out
}

fn volume_m3(vertices_m: &[Vec3], faces: &[[u32; 3]]) -> f32 {
    let corners = faces.iter().map(|face| face.map(|i| vertices_m[i as usize]));
    corners.map(|[a, b, c]| a.cross(b).dot(c)).sum::<f32>() / 6.0
}

#[test]
fn the_surface_is_one_closed_sphere_of_the_promised_size() {
    let model = &*MODEL;
    let mut faces_of_edge = BTreeMap::new();
    for face in &model.faces {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            // Each direction once: neighbouring faces agree on what is outside.
            *faces_of_edge.entry((a, b)).or_insert(0) += 1;
        }
    }
    assert!(
        faces_of_edge.iter().all(|(&(a, b), &n)| n == 1 && faces_of_edge.contains_key(&(b, a)))
    );
    let (vertices, edges) = (model.template_m.len(), faces_of_edge.len() / 2);
    assert_eq!(vertices + model.faces.len() - edges, 2, "Euler characteristic of a sphere");
    assert!((1_500..=3_000).contains(&vertices), "{vertices}");

    // One piece: everything is reached from the first vertex.
    let mut reached = vec![false; vertices];
    let mut frontier = vec![0u32];
    while let Some(vertex) = frontier.pop() {
        if !std::mem::replace(&mut reached[vertex as usize], true) {
            let around = faces_of_edge.range((vertex, 0)..=(vertex, u32::MAX));
            frontier.extend(around.map(|(&(_, next), _)| next));
        }
    }
    assert!(reached.iter().all(|&r| r));
}

#[test]
fn the_surface_faces_outwards_and_has_the_volume_of_an_arm() {
    let model = &*MODEL;
    let litres = 1e3 * volume_m3(&model.template_m, &model.faces);
    assert!((2.0..4.5).contains(&litres), "{litres}");
    let shaped = model.shaped(&[]);
    let anatomy = Anatomy::new(&digits::digits());
    let inside: usize = shaped
        .vertices_m
        .iter()
        .zip(&shaped.normals)
        .filter(|(vertex, normal)| {
            anatomy.distance(**vertex + **normal * 5e-4) <= anatomy.distance(**vertex)
        })
        .count();
    assert_eq!(inside, 0, "normals that do not lead away");
}

#[test]
fn the_hand_has_human_measures() {
    let model = &*MODEL;
    let joints_m = model.shaped(&[]).joints_m;
    let [thumb, index, middle, ring, pinky] =
        model.fingertips.map(|i| model.template_m[i as usize]);
    let length_mm = |a: Vec3, b: Vec3| 1e3 * a.distance(b);
    assert!((180.0..192.0).contains(&length_mm(joints_m[RIGHT_WRIST], middle)));
    // Tip to knuckle: middle, ring, index, pinky, from the longest.
    let fingers = [(middle, 40), (ring, 46), (index, 37), (pinky, 43)];
    let lengths = fingers.map(|(tip, knuckle)| length_mm(joints_m[knuckle], tip));
    assert!(lengths.is_sorted_by(|a, b| a > b), "{lengths:?}");
    assert!((95.0..112.0).contains(&length_mm(joints_m[49], thumb)));
    // Palm down, fingers away from the body, thumb forward.
    assert!(middle.x < joints_m[RIGHT_WRIST].x - 0.17);
    assert!(thumb.z > index.z && index.z > middle.z && middle.z > ring.z && ring.z > pinky.z);
    assert!(thumb.y < middle.y);
}

#[test]
fn joints_at_rest_are_the_rest_joints() {
    let model = &*MODEL;
    let want = frame::rest_joints(&digits::digits());
    for (joint, (got, want)) in model.shaped(&[]).joints_m.iter().zip(want).enumerate() {
        assert!(got.distance(want) < 1e-5, "{joint}: {got} {want}");
    }
}

#[test]
fn skin_weights_are_shares_of_neighbouring_bones() {
    let model = &*MODEL;
    for (skin, vertex_m) in model.skin.iter().zip(&model.template_m) {
        assert!((skin.weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
        assert!(skin.weights.is_sorted_by(|a, b| a >= b));
        let fingers: Vec<usize> = skin
            .iter()
            .filter(|&(joint, weight)| joint >= RIGHT_HAND && weight > 0.02)
            .map(|(joint, _)| (joint - RIGHT_HAND) / 3)
            .collect();
        // Beyond the webs, a vertex has one digit.
        if vertex_m.x < frame::WRIST_M.x - 0.115 {
            assert!(fingers.iter().all(|&finger| finger == fingers[0]), "{vertex_m} {skin:?}");
        }
    }
}

#[test]
fn closing_the_hand_moves_the_tips_towards_the_palm() {
    let model = &*MODEL;
    let (open, closed) = (posed(&[-1.0]), posed(&[1.0]));
    for tip in &model.fingertips[1..] {
        let [from, to] = [&open, &closed].map(|body| body.vertices_m[*tip as usize]);
        assert!(to.y < from.y - 0.03, "{from} {to}");
        assert!(to.x > from.x + 0.02, "{from} {to}");
    }
}

#[test]
fn opposition_brings_the_thumb_under_the_palm() {
    let model = &*MODEL;
    let thumb = model.fingertips[0] as usize;
    let [from, to] = [-2.0, 2.0].map(|c| posed(&[0.0, 0.0, c]).vertices_m[thumb]);
    assert!(to.z < from.z - 0.03 && to.y < from.y, "{from} {to}");
}

#[test]
fn rows_of_the_basis_are_orthogonal_and_mirrored_for_the_left_hand() {
    let model = &*MODEL;
    let rows = &model.right_hand.components;
    for (i, a) in rows.iter().enumerate() {
        for (j, b) in rows.iter().enumerate() {
            let cosine = a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>()
                / (a.iter().map(|v| v * v).sum::<f32>() * b.iter().map(|v| v * v).sum::<f32>())
                    .sqrt();
            assert!((cosine - f32::from(u8::from(i == j))).abs() < 1e-5, "{i} {j} {cosine}");
        }
    }
    // Mirroring a rotation is conjugation with the reflection x -> -x.
    let left = model.left_hand.as_ref().expect("two hands");
    let [right, left] = [&model.right_hand, left].map(|hand| hand.rotation(4, &[1.0, -0.5]));
    let point = Vec3::new(0.3, -0.2, 0.5);
    let mirror = |p: Vec3| Vec3::new(-p.x, p.y, p.z);
    let turn = evpose_pose::rotation::matrix_from_axis_angle;
    assert!((turn(left) * mirror(point)).distance(mirror(turn(right) * point)) < 1e-6);
}

#[test]
fn two_builds_are_the_same() {
    let [a, b] = [(); 2].map(|()| BodyModel::procedural_arm());
    assert_eq!(a.template_m, b.template_m);
    assert_eq!((a.faces, a.skin, a.uvs), (b.faces, b.skin, b.uvs));
    assert_eq!(a.shape_directions_m, b.shape_directions_m);
}

#[test]
fn texture_coordinates_follow_the_layout() {
    use crate::texture_layout as layout;
    let model = &*MODEL;
    assert!(model.uvs.iter().all(|uv| uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all()));
    for tip in model.fingertips {
        assert!(
            model.uvs[tip as usize].x > layout::U_NAIL[1] - 0.03,
            "{}",
            model.uvs[tip as usize]
        );
    }
    let palm = frame::hand_point([55.0, -14.0, 0.0]);
    let nearest = (0..model.uvs.len()).min_by(|&a, &b| {
        model.template_m[a].distance(palm).total_cmp(&model.template_m[b].distance(palm))
    });
    let uv = nearest.map_or(Vec2::ZERO, |vertex| model.uvs[vertex]);
    assert!(uv.x > layout::U_WRIST && uv.x < layout::U_KNUCKLE && uv.y > 0.7, "{uv}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn every_person_in_the_range_is_plausible(betas in prop::collection::vec(-2.0f32..2.0, 10)) {
        let model = &*MODEL;
        let shaped = model.shaped(&betas);
        for (k, (vertex, mean)) in shaped.vertices_m.iter().zip(&model.template_m).enumerate() {
            prop_assert!(vertex.distance(*mean) < 0.06, "{k}");
        }
        let hand_mm = 1e3 * shaped.joints_m[RIGHT_WRIST]
            .distance(shaped.vertices_m[model.fingertips[2] as usize]);
        prop_assert!((145.0..230.0).contains(&hand_mm), "{hand_mm}");
        prop_assert!(volume_m3(&shaped.vertices_m, &model.faces) > 1e-3);
        // The arm still hangs on the same shoulder girdle.
        prop_assert!(shaped.joints_m[RIGHT_SHOULDER].distance(frame::SHOULDER_M) < 0.01);
    }
}
