//! Properties of the scenes: range, still and moving parts, and how well frames follow them.

use gapbench_pixel::camera::record;
use gapbench_pixel::event::{HEIGHT, WIDTH};
use gapbench_pixel::{Circuit, SCENE_KINDS, Scene, SceneKind, Seeds};

const PIXELS: usize = WIDTH * HEIGHT;

fn scenes() -> impl Iterator<Item = (SceneKind, Scene)> {
    SCENE_KINDS.into_iter().flat_map(|kind| (0..3).map(move |seed| (kind, Scene::new(kind, seed))))
}

#[test]
fn luminance_stays_between_the_darkest_level_under_the_shade_and_white() {
    for (kind, scene) in scenes() {
        let frames: Vec<f32> = (0..10).flat_map(|k| scene.frame(k, 10.0)).collect();
        let (low, high) = frames
            .iter()
            .fold((f32::MAX, 0.0_f32), |(low, high), &light| (low.min(light), high.max(light)));
        assert!(low > 0.0166 && high < 1.0001, "{kind:?}: {low} to {high}");
        assert!(low < 0.05 && high > 0.7, "{kind:?} has no dark or no bright part");
    }
}

#[test]
fn every_scene_has_still_pixels_of_eight_levels_and_moving_ones_of_both_polarities() {
    for (kind, scene) in scenes() {
        let frames: Vec<Vec<f32>> = (0..40).map(|k| scene.frame(k, 40.0)).collect();
        let still: Vec<f32> = (0..PIXELS)
            .filter(|&i| frames.iter().all(|frame| (frame[i] - frames[0][i]).abs() < 1e-7))
            .map(|i| frames[0][i])
            .collect();
        for level in 0..8 {
            let light = 0.02_f32.powf(level as f32 / 7.0);
            let count = still.iter().filter(|&&i| (i / light - 1.0).abs() < 0.01).count();
            assert!(count > 20, "{kind:?} has {count} still pixels of {light}");
        }
        let recording = record(&Circuit::ideal(), &scene, Seeds { camera: 0, run: 0 });
        let on = recording.events.iter().filter(|event| event.on).count();
        let share = on as f64 / recording.events.len() as f64;
        assert!(recording.events.len() > 10_000, "{kind:?}: {}", recording.events.len());
        assert!((0.3..0.7).contains(&share), "{kind:?}: {share} of the events are ON");
    }
}

#[test]
fn frames_at_1_khz_interpolated_linearly_follow_the_scene() {
    let (mut worst, mut square, mut count) = (0.0_f64, 0.0, 0.0);
    for (_, scene) in scenes() {
        for pixel in (0..PIXELS).step_by(23) {
            let (x, y) = ((pixel % WIDTH) as f64, (pixel / WIDTH) as f64);
            for k in (0..1000).step_by(3) {
                let light = |t_ms: f64| scene.luminance(x, y, t_ms * 1e-3);
                let t_ms = f64::from(k);
                let straight = 0.5 * (light(t_ms) + light(t_ms + 1.0));
                let error = (straight / light(t_ms + 0.5)).ln();
                worst = worst.max(error.abs());
                square += error * error;
                count += 1.0;
            }
        }
    }
    let rms = (square / count).sqrt();
    assert!(worst < 0.035, "off by {worst} in ln I");
    assert!(rms < 0.0007, "off by {rms} r.m.s. in ln I");
}

#[test]
fn a_scene_is_its_kind_and_seed() {
    for kind in SCENE_KINDS {
        let frame = |seed| Scene::new(kind, seed).frame(123, 1000.0);
        assert_eq!(frame(5), frame(5));
        assert_ne!(frame(5), frame(6));
    }
}
