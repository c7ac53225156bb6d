//! Properties of the procedural human.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use super::*;
use crate::{BodyPose, PosedBody};

static MODEL: LazyLock<BodyModel> = LazyLock::new(BodyModel::procedural_human);

#[test]
fn the_surface_is_one_closed_sphere() {
    let model = &*MODEL;
    let mut edges = BTreeMap::new();
    for face in &model.faces {
        for k in 0..3 {
            *edges.entry((face[k], face[(k + 1) % 3])).or_insert(0) += 1;
        }
    }
    assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges.contains_key(&(b, a))));
    let vertices = model.template_m.len();
    assert_eq!(
        vertices + model.faces.len() - edges.len() / 2,
        2,
        "Euler characteristic of a sphere"
    );
    assert!((3_000..=8_000).contains(&vertices), "{vertices}");
}

#[test]
fn it_is_an_adult() {
    let model = &*MODEL;
    let corners = model.faces.iter().map(|face| face.map(|i| model.template_m[i as usize]));
    let volume_m3 = corners.map(|[a, b, c]| a.cross(b).dot(c)).sum::<f32>() / 6.0;
    // 60 to 85 kg at the density of water.
    assert!((0.060..=0.085).contains(&volume_m3), "{volume_m3}");
    let heights = model.template_m.iter().map(|vertex_m| vertex_m.y);
    let (low, high) = heights.fold((f32::MAX, f32::MIN), |(l, h), y| (l.min(y), h.max(y)));
    assert!((1.70..=1.80).contains(&(high - low)), "{}", high - low);
}

#[test]
fn every_vertex_is_held_by_bones_near_it_and_both_sides_are_alike() {
    let model = &*MODEL;
    for (skin, vertex_m) in model.skin.iter().zip(&model.template_m) {
        let sum: f32 = skin.iter().map(|(_, weight)| weight).sum();
        assert!((sum - 1.0).abs() < 1e-5);
        let (strongest, _) = skin.iter().next().expect("held");
        let joint_m = model.joint_offsets_m[strongest];
        assert!(joint_m.distance(*vertex_m) < 0.45, "{vertex_m}: {strongest}");
    }
    let mass = |side: f32| model.template_m.iter().filter(|v| v.x * side > 0.02).count() as f32;
    assert!((mass(1.0) / mass(-1.0) - 1.0).abs() < 0.05);
}

#[test]
fn shapes_move_joints_with_the_surface_around_them() {
    let model = &*MODEL;
    for shape in 0..model.shape_directions_m.len() {
        let mut betas = vec![0.0; model.shape_directions_m.len()];
        betas[shape] = 2.0;
        let (mean, shaped) = (model.shaped(&[]), model.shaped(&betas));
        for joint in [4, 5, 18, 19, 20, 21] {
            let at_m = mean.joints_m[joint];
            let near =
                (0..model.template_m.len()).filter(|&v| model.template_m[v].distance(at_m) < 0.07);
            let moved: Vec<Vec3> =
                near.map(|v| shaped.vertices_m[v] - mean.vertices_m[v]).collect();
            let surface_m = moved.iter().sum::<Vec3>() / moved.len() as f32;
            let joint_m = shaped.joints_m[joint] - at_m;
            assert!(surface_m.distance(joint_m) < 0.015, "{shape}, {joint}: {surface_m} {joint_m}");
        }
    }
}

#[test]
fn a_bent_arm_keeps_its_volume() {
    let model = &*MODEL;
    let volume = |pose: &BodyPose| {
        let mut posed = PosedBody::default();
        model.pose(&model.shaped(&[]), pose, &mut posed);
        let corners = model.faces.iter().map(|face| face.map(|i| posed.vertices_m[i as usize]));
        corners.map(|[a, b, c]| a.cross(b).dot(c)).sum::<f32>() / 6.0
    };
    let rest = BodyPose::rest(model);
    let mut bent = rest.clone();
    bent.joints[18] = Vec3::new(0.0, -1.6, 0.0);
    bent.joints[16] = Vec3::new(0.0, 0.0, -1.2);
    bent.joints[4] = Vec3::new(1.4, 0.0, 0.0);
    let ratio = volume(&bent) / volume(&rest);
    assert!((0.95..1.05).contains(&ratio), "{ratio}");
}
