//! Left hands, and models that end at the wrist.

use evpose_body::skeleton::{RIGHT_HAND, RIGHT_WRIST, parents};
use evpose_body::{BodyModel, SkinWeights};
use evpose_core::Plane;
use evpose_pose::HandSide;
use evpose_sim::config::{CameraPoseConfig, Hands};
use evpose_sim::raster::Camera;
use evpose_sim::{SequenceInfo, Simulation, SimulationConfig, record_all};
use glam::{Vec2, Vec3};

fn small(hands: Hands) -> SimulationConfig {
    SimulationConfig {
        sequences: 2,
        seconds: 0.2,
        image_scale: 0.5,
        hands,
        ..SimulationConfig::default()
    }
}

#[test]
fn a_left_hand_is_seen_where_a_mirror_shows_the_right_one() {
    let [mut right, mut left] = [Hands::Right, Hands::Left]
        .map(|hands| Simulation::new(&small(hands), 3).unwrap().sequence(0).unwrap());
    let camera = *right.camera();
    let width = f32::from(camera.sensor().width);
    let (mut alike, mut seen) = (0, 0);
    for _ in 0..100 {
        let (a, b) = (right.advance().unwrap(), left.advance().unwrap());
        assert_eq!(a.label.articulation, b.label.articulation);
        for (p, q) in a.points_m.iter().zip(b.points_m) {
            let (Some(p), Some(q)) = (camera.image_from_world(*p), camera.image_from_world(q))
            else {
                panic!("a hand behind the camera");
            };
            assert!((q.x - (width - p.x)).abs() < 1e-2 && (q.y - p.y).abs() < 1e-2, "{p} {q}");
            // Points of the skeleton lie behind the skin of the hand, whose light is the same.
            let (x, y) = (p.x.floor(), p.y.floor());
            if (0.0..width).contains(&x) && (0.0..f32::from(camera.sensor().height)).contains(&y) {
                let (x, y) = (x as usize, y as usize);
                let twin = width as usize - 1 - x;
                seen += 1;
                let difference = (a.luminance.at(x, y) - b.luminance.at(twin, y)).abs();
                alike += usize::from(difference < 0.01);
            }
        }
    }
    // At its border, rounding decides between the hand and the background, which is not mirrored.
    assert!(seen > 500 && alike * 100 > seen * 95, "{alike} of {seen}");
}

#[test]
fn parameters_of_a_hand_reproduce_its_points() {
    for (hands, side) in [(Hands::Right, HandSide::Right), (Hands::Left, HandSide::Left)] {
        let simulation = Simulation::new(&small(hands), 4).unwrap();
        let mut sequence = simulation.sequence(0).unwrap();
        for _ in 0..50 {
            let step = sequence.advance().unwrap();
            let actor = simulation.actor();
            let shaped = actor.body().shaped(&step.episode.betas);
            let points_m = actor.points_of(side, &step.label, &shaped);
            for (got, want) in points_m.iter().zip(step.points_m) {
                assert!(got.distance(want) < 1e-4, "{got} for {want}");
            }
        }
    }
}

/// A black hand before bright backgrounds, seen by a camera that stands elsewhere.
fn black_and_displaced(hands: Hands) -> SimulationConfig {
    let mut config = small(hands);
    config.camera_pose =
        CameraPoseConfig { roll_deg: 35.0, orbit_deg: [40.0, -20.0], distance: 1.15 };
    config.lights.gain = 0.0;
    config.backgrounds.offset = 1.0;
    config.skin.texels = 64;
    config
}

/// Share of the points whose pixel, or one beside it, is of the black hand; of those on the image.
fn share_on_the_hand(image: &Plane<f32>, camera: &Camera, points_m: &[Vec3]) -> [usize; 2] {
    let on_image = points_m.iter().filter_map(|point_m| {
        let at: Vec2 = camera.image_from_world(*point_m).unwrap().floor();
        let inside = |at: f32, side: u16| (1.0..f32::from(side) - 1.0).contains(&at);
        let size = camera.sensor();
        (inside(at.x, size.width) && inside(at.y, size.height)).then_some(at)
    });
    on_image.fold([0, 0], |[dark, seen], at| {
        let (x, y) = (at.x as usize, at.y as usize);
        let is_dark = (y - 1..y + 2).any(|y| (x - 1..x + 2).any(|x| *image.at(x, y) < 1e-3));
        [dark + usize::from(is_dark), seen + 1]
    })
}

#[test]
fn labels_before_a_displaced_camera_lie_on_the_hand_that_it_sees() {
    for (hands, side) in [(Hands::Right, HandSide::Right), (Hands::Left, HandSide::Left)] {
        let config = black_and_displaced(hands);
        let simulation = Simulation::new(&config, 8).unwrap();
        let mut sequence = simulation.sequence(0).unwrap();
        let (actor, camera) = (simulation.actor(), config.camera());
        let [mut simulated, mut drawn] = [[0, 0]; 2];
        for frame in 0..150 {
            let step = sequence.advance().unwrap();
            if frame % 30 > 0 {
                continue;
            }
            let shaped = actor.body().shaped(&step.episode.betas);
            let points_m = actor.points_of(side, &step.label, &shaped);
            for (got, want) in points_m.iter().zip(step.points_m) {
                assert!(got.distance(want) < 1e-4, "{side:?}: {got} for {want}");
            }
            let count = |total: &mut [usize; 2], image: &Plane<f32>| {
                let [dark, seen] = share_on_the_hand(image, &camera, &points_m);
                *total = [total[0] + dark, total[1] + seen];
            };
            count(&mut simulated, step.luminance);
            let (label, betas) = (step.label, step.episode.betas.clone());
            let light = simulation.light_of(side, &[label], &betas, 0).unwrap();
            count(&mut drawn, &light[0]);
        }
        for [dark, seen] in [simulated, drawn] {
            assert!(seen > 60 && dark * 100 >= seen * 98, "{side:?}: {dark} of {seen}");
        }
    }
}

#[test]
fn a_run_of_both_hands_says_which_is_which() {
    let directory = tempfile::tempdir().unwrap();
    let simulation = Simulation::new(&small(Hands::Both), 5).unwrap();
    record_all(&simulation, directory.path(), &|_| {}).unwrap();
    let hand =
        |stem: &str| SequenceInfo::beside(&directory.path().join(stem)).unwrap().unwrap().hand;
    assert_eq!((hand("0000"), hand("0001")), (HandSide::Right, HandSide::Left));
}

/// The procedural arm as a model of 16 joints: all before the hand moves with the wrist.
fn hand_only() -> BodyModel {
    let arm = BodyModel::procedural_arm();
    let own = |joint: usize| joint.saturating_sub(RIGHT_HAND - 1);
    let kept: Vec<usize> = std::iter::once(RIGHT_WRIST).chain(RIGHT_HAND..52).collect();
    let rest = arm.shaped(&[]);
    let mut hand = arm.right_hand.clone();
    hand.first_joint = 1;
    BodyModel {
        joint_regressor: vec![Vec::new(); kept.len()],
        joint_offsets_m: kept.iter().map(|&joint| rest.joints_m[joint]).collect(),
        parents: kept
            .iter()
            .map(|&joint| parents()[joint].filter(|_| joint != RIGHT_WRIST).map(own))
            .collect(),
        skin: arm
            .skin
            .iter()
            .map(|skin| SkinWeights { joints: skin.joints.map(|j| own(j.into()) as u8), ..*skin })
            .collect(),
        right_hand: hand,
        left_hand: None,
        wrist: 0,
        ..arm
    }
}

#[test]
fn a_model_that_ends_at_the_wrist_is_moved_by_the_procedural_arm() {
    let config = SimulationConfig { shape_range: 0.0, ..small(Hands::Right) };
    let mut whole = Simulation::new(&config, 6).unwrap().sequence(0).unwrap();
    let hand = Simulation::with_body(&config, 6, hand_only()).unwrap();
    let mut hand = hand.sequence(0).unwrap();
    for _ in 0..50 {
        let (a, b) = (whole.advance().unwrap(), hand.advance().unwrap());
        assert!((a.label.translation_m - b.label.translation_m).length() < 1e-5);
        for (a, b) in a.points_m.iter().zip(b.points_m) {
            assert!(a.distance(b) < 1e-4, "{a} for {b}");
        }
        assert!(b.points_m.iter().all(|p: &Vec3| p.is_finite()));
    }
}
