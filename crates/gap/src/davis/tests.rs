use super::*;

const SIZE: SensorSize = SensorSize { width: 4, height: 2 };

/// A shot around a time, exposed for so long, of the same code everywhere.
fn shot(middle_us: i64, exposure_us: i64, code: u16) -> Shot {
    let start = Micros(middle_us - exposure_us / 2);
    Shot { start, end: start + Micros(exposure_us), codes: vec![code; SIZE.pixels()] }
}

/// Another code in the first pixel, and all others at rest.
fn moving(middle_us: i64, exposure_us: i64, code: u16) -> Shot {
    let mut shot = shot(middle_us, exposure_us, 90);
    shot.codes[0] = code;
    shot
}

fn shots(all: Vec<Shot>) -> Shots {
    Shots::new(SIZE, Response::Linear, 255, all).unwrap()
}

/// Light of the first pixel at a time.
fn light_at(scene: &LightSequence, t_ms: usize) -> f64 {
    f64::from(scene.planes()[t_ms].data()[0])
}

#[test]
fn frames_are_at_the_middle_of_their_exposures() {
    let codes = [(0, 51), (40_000, 51), (80_000, 204)];
    let all = codes.map(|(middle_us, code)| moving(middle_us, 8_000, code));
    let scene = shots(all.to_vec()).scene().unwrap();
    assert_eq!((scene.duration(), scene.fps(), scene.size()), (Micros(80_000), 1_000.0, SIZE));
    assert!((light_at(&scene, 10) - 0.2).abs() < 0.003);
    assert!((light_at(&scene, 80) - 0.8).abs() < 0.003);
    // Half way between, a logarithm is half way: 0.4 is as far from 0.2 as 0.8 from it.
    assert!((light_at(&scene, 60) - 0.4).abs() < 0.005, "{}", light_at(&scene, 60));
}

#[test]
fn frames_out_of_order_are_refused() {
    for all in [vec![shot(0, 10, 1)], vec![shot(50, 10, 1), shot(0, 10, 1)]] {
        assert!(Shots::new(SIZE, Response::Linear, 255, all).is_err());
    }
}

#[test]
fn longer_exposures_are_not_more_light() {
    let all = vec![shot(0, 4_000, 50), shot(30_000, 4_000, 50), shot(60_000, 8_000, 100)];
    let scene = shots(all).scene().unwrap();
    for t_ms in [0, 30, 45, 60] {
        assert!((light_at(&scene, t_ms) - 50.0 / 255.0).abs() < 0.003, "{t_ms}");
    }
}

#[test]
fn steps_of_the_codes_are_no_motion() {
    let codes = [80, 81, 80, 80, 81, 80, 81, 81];
    let all = codes.iter().enumerate().map(|(k, code)| shot(30_000 * k as i64, 5_000, *code));
    let scene = shots(all.collect()).scene().unwrap();
    let light: Vec<f64> = (0..=210).map(|t_ms| light_at(&scene, t_ms)).collect();
    let (min, max) =
        (light.iter().copied().fold(9.0, f64::min), light.iter().copied().fold(0.0, f64::max));
    assert!((max / min).ln() < 1.0 / 80.0, "{min} {max}");
}

#[test]
fn pixels_whose_light_is_not_known_are_not_compared() {
    let mut all: Vec<Shot> = (0..6).map(|k| shot(30_000 * k, 5_000, 90)).collect();
    all[3].codes[1] = 255;
    all[4].codes[2] = 2;
    let scene = shots(all).scene().unwrap();
    let masked: Vec<usize> = (0..SIZE.pixels()).filter(|pixel| scene.masked()[*pixel]).collect();
    assert_eq!(masked, [1, 2]);
    let black = shots((0..6).map(|k| shot(30_000 * k, 5_000, 0)).collect());
    assert!(matches!(black.scene(), Err(GapError::Scene(_))));
}

#[test]
fn noise_of_frames_is_that_of_pixels_at_rest() {
    let noisy = |k: i64| {
        let mut shot = shot(30_000 * k, 5_000, 120);
        for (pixel, code) in shot.codes.iter_mut().enumerate() {
            let noise = evpose_core::StageNoise::new(1, "test", k as u64).normal(pixel, 0);
            *code = (120.0 + 3.0 * noise).round() as u16;
        }
        shot
    };
    let noise = shots((0..200).map(noisy).collect()).noise;
    assert!((2.4..3.4).contains(&noise), "{noise}");
    assert_eq!(shots((0..9).map(|k| shot(30_000 * k, 5_000, 9)).collect()).noise, 0.0);
}

#[test]
fn a_twin_has_the_same_frames_of_another_light() {
    let codes = [60, 60, 70, 120, 120, 60, 60, 60, 90];
    let all = codes.iter().enumerate().map(|(k, code)| moving(30_000 * k as i64, 5_000, *code));
    let shots = shots(all.collect());
    let scene = shots.scene().unwrap();
    let twin = shots.twin(0, 1).unwrap();
    assert_eq!((twin.duration(), twin.masked()), (scene.duration(), scene.masked()));
    // Every second frame is used, a step of a code apart at the most, with another black.
    for k in [0, 2, 4, 6, 8] {
        let (own, other) = (light_at(&scene, 30 * k), light_at(&twin, 30 * k));
        assert!((own - other).abs() < 3.0 / 255.0, "{k}: {own} {other}");
    }
    // The light of the others is drawn at random.
    let apart = |k: &usize| (light_at(&scene, 30 * k) - light_at(&twin, 30 * k)).abs();
    assert!([1, 3, 5, 7].iter().map(apart).any(|apart| apart > 5.0 / 255.0));
    let again = shots.twin(0, 1).unwrap();
    assert!(twin.planes().iter().zip(again.planes()).all(|(a, b)| a.data() == b.data()));
}
