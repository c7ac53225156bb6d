//! The forward model beside that of the Python package `smplx`.
//!
//! # Source
//! Values of smplx 0.1.28 with PyTorch in double precision, `MANO` and `SMPLH` with
//! `use_pca=True, num_pca_comps=6, flat_hand_mean=False`, on the synthetic models of
//! [`super::synthetic`] (the same integer hash in NumPy) and with the coefficients of [`posed`];
//! points are the joints, then the vertices at the finger tips.

use glam::Vec3;

use super::synthetic::stream;
use super::*;
use crate::{BodyPose, HandBasis, PosedBody};

/// Points of the hand, in metres.
const HAND: [(usize, [f32; 3]); 9] = [
    (0, [0.2655475, 0.7241552, -0.4870692]),
    (1, [0.2546927, 0.7806092, -0.5432126]),
    (8, [0.2426619, 0.702856, -0.5841772]),
    (15, [0.204159, 0.7077265, -0.5347196]),
    (16, [0.071047, 0.9488473, -0.6260822]),
    (17, [0.1819912, 0.8906323, -0.6240276]),
    (18, [0.1703611, 1.0121871, -0.6250845]),
    (19, [0.1408634, 0.8335943, -0.5691258]),
    (20, [0.1628225, 0.9004012, -0.660284]),
];
/// Points of the body, in metres.
const BODY: [(usize, [f32; 3]); 9] = [
    (0, [0.21958, 0.769183, -0.5175947]),
    (1, [0.2346803, 0.8117762, -0.4952225]),
    (26, [0.1902753, 0.7282526, -0.5013235]),
    (51, [0.1356552, 0.7560999, -0.5767337]),
    (52, [0.1331257, 0.8556344, -0.6976966]),
    (53, [0.1670901, 0.9291297, -0.8464783]),
    (54, [0.2217475, 1.0322951, -0.6436677]),
    (55, [0.0745161, 0.8095732, -0.8582398]),
    (56, [0.135398, 0.7822724, -0.5916179]),
];
/// Metres.
const TOLERANCE_M: f32 = 1e-5;

fn values(salt: u32, count: usize, scale: f64) -> Vec<f32> {
    stream(salt, count, scale).into_iter().map(|value| value as f32).collect()
}

/// The model in a random shape and pose.
fn posed(model: &BodyModel) -> PosedBody {
    let mut pose = BodyPose::rest(model);
    pose.translation_m = Vec3::from_slice(&values(21, 3, 2.0));
    let turn = |basis: &HandBasis, salt: u32, pose: &mut BodyPose| {
        pose.set_hand(basis, &values(salt, 6, 4.0));
    };
    if let Some(left) = &model.left_hand {
        for (joint, angles) in pose.joints[1..].iter_mut().zip(values(25, 63, 2.0).chunks(3)) {
            *joint = Vec3::from_slice(angles);
        }
        turn(left, 24, &mut pose);
    }
    turn(&model.right_hand, 23, &mut pose);
    pose.joints[0] = Vec3::from_slice(&values(22, 3, 3.0));
    let mut out = PosedBody::default();
    model.pose(&model.shaped(&values(20, 10, 4.0)), &pose, &mut out);
    out
}

fn assert_points(file: &ModelFile, golden: &[(usize, [f32; 3])], count: usize) {
    let points = posed(&file.model).output_points(&file.model);
    assert_eq!(points.len(), count);
    for &(point, want) in golden {
        let off_m = points[point].distance(want.into());
        assert!(off_m < TOLERANCE_M, "point {point}: {} instead of {want:?}", points[point]);
    }
}

#[test]
fn a_hand_is_where_the_published_package_puts_it() {
    assert_points(&read(pkl(&hand(-1.0))).unwrap(), &HAND, 21);
}

#[test]
fn a_body_is_where_the_published_package_puts_it() {
    assert_points(&read(npz(&body())).unwrap(), &BODY, 57);
}

#[test]
fn a_hand_follows_the_twelve_parameters() {
    let model = read(npz(&hand(-1.0))).unwrap().model;
    let params = evpose_pose::HandParams {
        articulation: [0.3, -0.8, 0.1, 0.9, -0.2, 0.4],
        translation_m: Vec3::new(0.1, -0.2, 0.7),
        rotation: Vec3::new(0.4, 1.1, -0.6),
    };
    let shaped = model.shaped(&[]);
    let mut placed = PosedBody::default();
    model.pose_hand(&shaped, &params, &mut placed);
    // The same by turning the root: the package's orientation, and its translation less the wrist.
    let mut pose = BodyPose::of_hand(&model, &params.articulation);
    pose.joints[0] = params.rotation;
    pose.translation_m = params.translation_m - shaped.joints_m[0];
    let mut turned = PosedBody::default();
    model.pose(&shaped, &pose, &mut turned);
    for (a, b) in placed.vertices_m.iter().zip(&turned.vertices_m) {
        assert!(a.distance(*b) < 1e-6, "{a} {b}");
    }
    assert_eq!(placed.evaluation_points(&model)[0], params.translation_m);
    // Of the surface, the fingertips alone, with their correctives.
    for (a, b) in model.hand_points(&shaped, &params).iter().zip(placed.evaluation_points(&model)) {
        assert!(a.distance(b) < 1e-6, "{a} {b}");
    }
}

#[test]
fn every_weight_of_a_vertex_moves_it() {
    let model = read(npz(&hand(-1.0))).unwrap().model;
    assert!(!model.further_weights.is_empty());
    for vertex in 0..778 {
        let four: f32 = model.skin[vertex].iter().map(|(_, weight)| weight).sum();
        let further = model.further_weights.iter().filter(|more| more.vertex as usize == vertex);
        let sum = four + further.map(|more| more.weight).sum::<f32>();
        assert!((sum - 1.0).abs() < 1e-6, "{vertex}: {sum}");
    }
}
