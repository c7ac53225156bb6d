//! Properties of all activities.

use std::sync::LazyLock;

use evpose_core::CounterRng;
use glam::Vec3;

use super::*;
use crate::{BodyModel, PosedBody, ShapedBody};

static HUMAN: LazyLock<(BodyModel, ShapedBody)> = LazyLock::new(|| {
    let model = BodyModel::procedural_human();
    let shaped = model.shaped(&[]);
    (model, shaped)
});

fn joints(figure: &Figure) -> Vec<Vec3> {
    let mut posed = PosedBody::default();
    figure.pose(&HUMAN.0, &HUMAN.1, &mut posed);
    posed.joints.iter().map(|joint| Vec3::from(joint.translation)).collect()
}

#[test]
fn names_are_one_of_a_kind_and_found() {
    for activity in activities() {
        let found = activity_by_name(activity.name).expect("registered");
        assert_eq!(found.about, activity.about);
        assert_eq!(activities().filter(|other| other.name == activity.name).count(), 1);
    }
}

#[test]
fn what_is_mixed_is_of_training_activities_alone() {
    let sources = mixed::sources();
    assert_eq!(sources.len(), TRAINING_ACTIVITIES.len() - 1, "all but itself");
    for held_out in HELD_OUT_ACTIVITIES {
        assert!(sources.iter().all(|source| source.name != held_out.name), "{}", held_out.name);
    }
}

#[test]
fn every_motion_is_continuous_keeps_its_feet_on_the_floor_and_stays_in_its_place() {
    for activity in activities() {
        for index in 0..6 {
            let mut rng = CounterRng::new(3, activity.name, index);
            let still = if index % 2 == 0 { 0.0 } else { 0.4 };
            let performance = Performance::draw(activity, &mut rng, 8.0, still);
            let mut before: Option<Vec<Vec3>> = None;
            for step in 0..4_000 {
                let t_s = step as f32 * 2e-3;
                let figure = performance.at(t_s);
                let now = joints(&figure);
                assert!(now.iter().all(|joint| joint.is_finite()), "{}: {t_s}", activity.name);
                let lowest = [7, 8, 10, 11].map(|foot| now[foot].y).into_iter().fold(9.0, f32::min);
                let off = lowest - figure.rise_m;
                assert!((0.0..0.12).contains(&off), "{} {t_s}: {off}", activity.name);
                assert!(now[0].x.abs() < 2.5 && now[0].z.abs() < 2.5, "{}", activity.name);
                if let Some(before) = before {
                    let fastest = now.iter().zip(&before).take(22).map(|(a, b)| a.distance(*b));
                    let fastest_m_s = fastest.fold(0.0, f32::max) / 2e-3;
                    assert!(fastest_m_s < 14.0, "{} at {t_s}: {fastest_m_s} m/s", activity.name);
                }
                before = Some(now);
            }
        }
    }
}

#[test]
fn somebody_who_rests_hardly_moves_and_goes_on_where_they_stopped() {
    let activity = activity_by_name("boxing").expect("registered");
    let performance = Performance::draw(activity, &mut CounterRng::new(1, "still", 0), 20.0, 0.5);
    let speed = |t_s: f32| {
        let (a, b) = (joints(&performance.at(t_s)), joints(&performance.at(t_s + 0.02)));
        a.iter().zip(&b).take(22).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max) / 0.02
    };
    let still = (0..1_000).filter(|step| speed(0.02 * *step as f32) < 0.06).count();
    assert!((200..700).contains(&still), "{still}");
}

#[test]
fn figures_do_what_their_words_say() {
    let mut figure = Figure::default();
    figure.arms[0] = Arm { flexion: std::f32::consts::FRAC_PI_2, ..Arm::default() };
    figure.arms[1] = Arm { abduction: std::f32::consts::FRAC_PI_2, ..Arm::default() };
    figure.legs[0] = Leg { flexion: 1.0, knee: 1.0, ..Leg::default() };
    let joints = joints(&figure);
    let along = |from: usize, to: usize| (joints[to] - joints[from]).normalize();
    assert!(along(16, 18).z > 0.95, "forwards: {}", along(16, 18));
    assert!(along(17, 19).x < -0.95, "to the right: {}", along(17, 19));
    assert!(along(1, 4).z > 0.7 && along(4, 7).y < -0.95, "{} {}", along(1, 4), along(4, 7));
    let bent = Figure { arms: [Arm { elbow: 1.5, ..Arm::default() }; 2], ..Figure::default() };
    let bent = self::joints(&bent);
    assert!((bent[20] - bent[18]).normalize().z > 0.9 && (bent[21] - bent[19]).normalize().z > 0.9);
    assert!((bent[7].x - 0.09).abs() < 0.02, "the left foot is on the left");
}
