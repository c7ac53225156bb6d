//! Labels follow their images, and what varies does so as it should.

use evpose_pose::body::{Keypoint, Visibility};
use glam::{DVec2, Vec2};
use proptest::prelude::*;

use super::*;

const WIDTH: usize = 346;
const HEIGHT: usize = 260;

fn label(points: impl IntoIterator<Item = Vec2>) -> BodyLabel {
    let keypoint = |position| Keypoint { position, visibility: Visibility::Visible };
    BodyLabel {
        keypoints: points.into_iter().map(keypoint).collect(),
        center: Vec2::splat(0.5),
        ..BodyLabel::default()
    }
}

/// Thirteen places in the image.
fn body(seed: u64) -> BodyLabel {
    let mut rng = CounterRng::new(seed, "test body", 0);
    label(std::array::from_fn::<_, 13, _>(|_| {
        Vec2::new(rng.uniform(0.2, 0.8), rng.uniform(0.2, 0.8))
    }))
}

/// Black but for a round spot on a joint.
fn spot(at: Vec2) -> Plane<u8> {
    let mut image = Plane::filled(WIDTH, HEIGHT, 0);
    let at = at.as_dvec2() * DVec2::new(WIDTH as f64, HEIGHT as f64);
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            let d = at.distance_squared(DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
            *image.at_mut(x, y) = (255.0 * (-d / 18.0).exp()) as u8;
        }
    }
    image
}

/// Places change, greys do not.
fn places_only() -> BodyAugmentation {
    BodyAugmentation {
        light_probability: 0.0,
        noise_probability: 0.0,
        blank_probability: 0.0,
        ..BodyAugmentation::default()
    }
}

fn render(view: &BodyView, image: &Plane<u8>, side: usize) -> Vec<f32> {
    let mut out = vec![f32::NAN; side * side];
    view.render(image, side, &mut out);
    out
}

/// The middle of what is bright, from 0 to 1.
fn middle(image: &[f32], side: usize) -> Vec2 {
    let (mut sum, mut at) = (0.0, DVec2::ZERO);
    for (i, &grey) in image.iter().enumerate() {
        sum += f64::from(grey);
        at += f64::from(grey) * DVec2::new((i % side) as f64 + 0.5, (i / side) as f64 + 0.5);
    }
    (at / sum / side as f64).as_vec2()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn joints_are_where_the_image_shows_them(
        seed in 0..1000u64,
        sample in 0..1000u64,
        joint in 0..13usize,
    ) {
        let body = body(seed);
        for interpolation in Interpolation::ALL {
            let interpolation = vec![interpolation];
            let augmentation = BodyAugmentation { interpolation, ..places_only() };
            let view = draw(&augmentation, seed, sample, &body);
            // In a mirror, another joint is where this one was.
            let from = body.keypoints[joint].position;
            let to = view.view_from_image().transform_point2(from.as_dvec2()).as_vec2();
            let seen = view.label().keypoints.iter().find(|seen| seen.position.distance(to) < 1e-6);
            let seen = seen.unwrap();
            let inward = to.min(Vec2::ONE - to).min_element();
            prop_assert_eq!(seen.is_labelled(), inward >= 0.0);
            if inward > 0.1 {
                let found = middle(&render(&view, &spot(from), 128), 128);
                // A third of a pixel: as much as sampling without the mean over pixels misses. The
                // nearest pixel may lie half of one away, in phase all over the image where steps are
                // whole pixels.
                let map = view.view_from_image().matrix2;
                let half_px = DVec2::new(
                    map.x_axis.length() / WIDTH as f64,
                    map.y_axis.length() / HEIGHT as f64,
                ) * 64.0;
                let largest = match view.interpolation {
                    Interpolation::Nearest => half_px.length().max(0.34),
                    _ => 0.34,
                };
                let distance = f64::from(found.distance(to)) * 128.0;
                prop_assert!(distance < largest, "{} for {}", found, to);
            }
        }
    }

    #[test]
    fn what_varies_depends_on_seed_and_sample_only(seed in 0..1000u64, sample in 0..1000u64) {
        let (body, image) = (body(1), spot(Vec2::splat(0.4)));
        let seen = |seed, sample| {
            let view = draw(&BodyAugmentation::published(), seed, sample, &body);
            (view.label().clone(), render(&view, &image, 32))
        };
        prop_assert_eq!(seen(seed, sample), seen(seed, sample));
    }

    #[test]
    fn bodies_are_not_lost(seed in 0..1000u64, sample in 0..1000u64) {
        // All over the image: some joints leave it often.
        let mut rng = CounterRng::new(seed, "test body", 1);
        let mut body = label((0..13).map(|_| Vec2::new(rng.unit(), rng.unit())));
        for joint in 0..rng.below(8) {
            body.keypoints[joint].visibility = Visibility::Unlabelled;
        }
        let before = unlabelled(&body);
        let view = draw(&places_only(), seed, sample, &body);
        let after = unlabelled(view.label());
        prop_assert!(after <= before + 3);
        if after > 5 {
            prop_assert_eq!(view.label(), &body);
            prop_assert_eq!(view.view_from_image(), DAffine2::IDENTITY);
        }
    }
}

#[test]
fn a_crop_that_loses_four_joints_is_given_up_and_one_that_loses_three_is_not() {
    let crop = BodyAugmentation {
        crop_probability: 1.0,
        pad_probability: 0.0,
        affine_probability: 0.0,
        rotate_probability: 0.0,
        shift_probability: 0.0,
        mirror_probability: 1.0,
        ..places_only()
    };
    crop.validate(13).unwrap();
    let body = |outside: usize| {
        let at = |joint| Vec2::splat(if joint < outside { 0.01 } else { 0.5 });
        label((0..13).map(at))
    };
    let lost = draw(&crop, 0, 0, &body(3));
    assert_eq!(unlabelled(lost.label()), 3);
    let kept = draw(&crop, 0, 0, &body(4));
    assert_eq!((kept.label(), kept.view_from_image()), (&body(4), DAffine2::IDENTITY));
}

#[test]
fn two_mirrors_show_the_image_itself() {
    let mirror = BodyAugmentation { mirror_probability: 1.0, ..BodyAugmentation::none() };
    let body = body(3);
    let greys: Vec<u8> = (0..48 * 48).map(|i| (i * 37 % 251) as u8).collect();
    let image = Plane::from_vec(48, 48, greys.clone()).unwrap();
    let once = draw(&mirror, 0, 0, &body);
    let seen = render(&once, &image, 48).iter().map(|&grey| grey as u8).collect();
    let seen = Plane::from_vec(48, 48, seen).unwrap();
    assert_eq!((seen.at(0, 5), seen.at(47, 5)), (image.at(47, 5), image.at(0, 5)));
    let twice = draw(&mirror, 0, 1, once.label());
    let again: Vec<u8> = render(&twice, &seen, 48).iter().map(|&grey| grey as u8).collect();
    assert_eq!(again, greys);
    for (a, b) in twice.label().keypoints.iter().zip(&body.keypoints) {
        assert!(a.position.distance(b.position) < 1e-6);
    }
}

#[test]
fn nothing_varies_without_augmentation() {
    let (body, image) = (body(4), spot(Vec2::splat(0.3)));
    let plain = render(&BodyView::plain(&body, Interpolation::Linear), &image, 64);
    for sample in 0..50 {
        let view = draw(&BodyAugmentation::none(), 9, sample, &body);
        assert_eq!((view.label(), render(&view, &image, 64)), (&body, plain.clone()));
    }
}

#[test]
fn greys_vary_as_often_as_they_should() {
    let (augmentation, body, n) = (BodyAugmentation::published(), body(4), 4000);
    let views: Vec<BodyView> = (0..n).map(|sample| draw(&augmentation, 2, sample, &body)).collect();
    let share =
        |is: fn(&BodyView) -> bool| views.iter().filter(|view| is(view)).count() as f64 / n as f64;
    // Four standard deviations of a half are 0.032.
    assert!((share(|view| view.light.is_some()) - 0.4).abs() < 0.032);
    assert!((share(|view| view.noise.is_some()) - 0.4).abs() < 0.032);
    assert!((share(|view| view.blank.is_some()) - 0.3).abs() < 0.032);
    let mirror = BodyAugmentation { mirror_probability: 0.5, ..BodyAugmentation::none() };
    let mirrored =
        (0..n).filter(|&sample| draw(&mirror, 2, sample, &body).label() != &body).count();
    assert!((mirrored as f64 / n as f64 - 0.5).abs() < 0.032);
    for interpolation in Interpolation::ALL {
        let of_it = views.iter().filter(|view| view.interpolation == interpolation).count();
        assert!(of_it.abs_diff(800) < 130, "{interpolation:?}");
    }
}

#[test]
fn a_square_lies_on_a_joint() {
    let square = BodyAugmentation { blank_probability: 1.0, ..BodyAugmentation::none() };
    let (body, black) = (body(6), Plane::filled(20, 20, 0));
    let mut hidden = 0;
    for sample in 0..100 {
        let out = render(&draw(&square, 1, sample, &body), &black, 192);
        let filled = out.iter().filter(|&&grey| grey > 0.0).count();
        if filled > 0 {
            assert!([6, 8, 10, 12].iter().any(|side| side * side == filled), "{filled}");
            let at = middle(&out, 192);
            assert!(body.keypoints.iter().any(|joint| joint.position.distance(at) < 1.0 / 192.0));
            hidden += 1;
        }
    }
    assert!(hidden > 90, "but for those that are black");
    let nobody = BodyLabel::default();
    let out = render(&draw(&square, 1, 0, &nobody), &black, 32);
    assert_eq!(out, [0.0; 32 * 32]);
}
