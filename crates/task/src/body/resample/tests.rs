//! Images as OpenCV and SciPy sample them, and what no sampling may do.

use proptest::prelude::*;

use super::*;

const WIDTH: usize = 37;
const HEIGHT: usize = 23;

/// The fraction of `43758.5453 sin(12.9898 i + 78.233 stream)`.
fn hashed(count: usize, stream: usize) -> impl Iterator<Item = f64> {
    let value = move |i: usize| (12.9898 * i as f64 + 78.233 * stream as f64).sin() * 43758.5453;
    (0..count).map(move |i| value(i) - value(i).floor())
}

fn image() -> Plane<u8> {
    let greys = hashed(WIDTH * HEIGHT, 1).map(|u| (u.powi(3) * 256.0) as u8).collect();
    Plane::from_vec(WIDTH, HEIGHT, greys).unwrap()
}

fn weighted_sum(image: &[f32]) -> f64 {
    image.iter().zip(hashed(image.len(), 50)).map(|(grey, u)| f64::from(*grey) * u).sum()
}

fn size(width: usize, height: usize, interpolation: Interpolation) -> Vec<f32> {
    let mut out = vec![f32::NAN; width * height];
    resize_grey(&image(), interpolation, [width, height], &mut out);
    out
}

/// Made with OpenCV 5.0: `resize` of the image as `float32` (nearest: `INTER_NEAREST_EXACT`),
/// clipped to 0 to 255, multiplied by hashed values (stream 50) and summed.
#[test]
fn images_are_resized_as_by_opencv() {
    use Interpolation::{Area, Cubic, Lanczos4, Linear, Nearest};
    for (width, height, interpolation, expected) in [
        (13, 11, Nearest, 5719.67764),
        (13, 11, Linear, 5823.44932),
        (13, 11, Area, 5112.02188),
        (13, 11, Cubic, 6104.15643),
        (13, 11, Lanczos4, 6266.26786),
        (48, 40, Nearest, 64867.3528),
        (48, 40, Linear, 64274.656),
        (48, 40, Area, 64422.5398),
        (48, 40, Cubic, 65614.8955),
        (48, 40, Lanczos4, 66529.1077),
    ] {
        let sum = weighted_sum(&size(width, height, interpolation));
        assert!((sum - expected).abs() < 1e-5 * expected, "{interpolation:?} {width}: {sum}");
    }
}

/// Rotated by 17 degrees, a little smaller and moved.
fn turned(interpolation: Interpolation) -> Vec<f32> {
    let linear = glam::DMat2::from_angle(17f64.to_radians()) * 0.9;
    let start = DVec2::splat(0.5) - linear * DVec2::new(0.45, 0.55);
    let map = DAffine2::from_mat2_translation(linear, start);
    let mut out = vec![f32::NAN; 21 * 19];
    sample(&image(), map, interpolation, [21, 19], &mut out);
    out
}

/// Made with SciPy 1.17: `map_coordinates` of order 1 and mode `nearest` at the same places, and
/// NumPy's `floor`; black outside of the image.
#[test]
fn images_are_turned_as_by_scipy() {
    for (interpolation, expected) in
        [(Interpolation::Linear, 13257.8865), (Interpolation::Nearest, 13499.571)]
    {
        let sum = weighted_sum(&turned(interpolation));
        assert!((sum - expected).abs() < 1e-5 * expected, "{interpolation:?}: {sum}");
    }
}

#[test]
fn in_its_own_size_an_image_is_itself() {
    let image = image();
    for interpolation in Interpolation::ALL {
        let out = size(WIDTH, HEIGHT, interpolation);
        let greys = image.data().iter().map(|&grey| f32::from(grey));
        let most = out.iter().zip(greys).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(most < 1e-3, "{interpolation:?}: {most}");
    }
}

#[test]
fn upright_images_are_the_same_pixel_by_pixel() {
    // A negative scale is a mirror, which is upright as well.
    let map =
        DAffine2::from_scale_angle_translation(DVec2::new(-1.3, 0.7), 0.0, DVec2::new(1.2, 0.1));
    let pixels = DVec2::new(WIDTH as f64, HEIGHT as f64);
    let map = DAffine2::from_scale_angle_translation(pixels / 16.0, 0.0, DVec2::ZERO)
        * DAffine2::from_scale_angle_translation(DVec2::ONE, 0.0, DVec2::ZERO)
        * DAffine2::from_mat2_translation(map.matrix2, map.translation * 16.0);
    for interpolation in Interpolation::ALL {
        let [mut upright, mut turned] = [vec![0.0; 256], vec![0.0; 256]];
        sample_upright(&image(), map, interpolation, 16, &mut upright);
        sample_turned(&image(), map, interpolation, 16, &mut turned);
        for (a, b) in upright.iter().zip(&turned) {
            assert!((a - b).abs() < 1e-3, "{interpolation:?}: {a} {b}");
        }
    }
}

#[test]
fn an_image_without_pixels_is_black_and_nothing_is_asked_of_no_pixels() {
    let mut out = [9.0; 6];
    resize_grey(&Plane::filled(0, 5, 0), Interpolation::Linear, [3, 2], &mut out);
    assert_eq!(out, [0.0; 6]);
    resize_grey(&image(), Interpolation::Area, [0, 0], &mut []);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn what_is_one_grey_stays_it_inside_and_is_black_outside(
        angle in -3.2..3.2f64, scale in 0.1..3.0f64, x in -1.0..1f64, y in -1.0..1f64,
    ) {
        let grey = Plane::filled(31, 17, 200);
        let map = DAffine2::from_scale_angle_translation(
            DVec2::splat(scale), angle, DVec2::new(x, y),
        );
        for interpolation in Interpolation::ALL {
            let mut out = vec![f32::NAN; 8 * 8];
            sample(&grey, map, interpolation, [8, 8], &mut out);
            for (i, value) in out.into_iter().enumerate() {
                let at = DVec2::new((i % 8) as f64 + 0.5, (i / 8) as f64 + 0.5) / 8.0;
                let at = map.transform_point2(at);
                // The mean over a pixel needs it whole.
                let slack = if interpolation == Interpolation::Area { scale / 4.0 } else { 1e-9 };
                let inward = at.min(DVec2::ONE - at).min_element();
                if inward > slack {
                    prop_assert!((value - 200.0).abs() < 1e-2, "{:?} {}", interpolation, at);
                } else if inward < -slack {
                    prop_assert_eq!(value, 0.0);
                }
            }
        }
    }
}
