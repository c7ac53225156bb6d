//! Geometric augmentation: affine maps from image to view, coordinates from 0 to 1 along either
//! side.

use evpose_core::CounterRng;
use evpose_pose::body::BodyLabel;
use glam::{DAffine2, DMat2, DVec2, Vec2};

use evpose_task::body::BodyAugmentation;

/// Targets of the three points that define a skew.
///
/// # Source
/// The published code: pixels of 192, one of them below the image.
const SKEWED: [DVec2; 3] = [
    DVec2::new(10.0 / 192.0, 100.0 / 192.0),
    DVec2::new(200.0 / 192.0, 50.0 / 192.0),
    DVec2::new(100.0 / 192.0, 250.0 / 192.0),
];
/// The joints of other persons that prevent a shift, as published: heads and left elbows.
const SHIFT_BLOCKERS: [usize; 2] = [0, 3];
/// The smallest area ratio of a skew, and the inverse of the largest: nearly collinear points
/// determine no map.
const MIN_AREA_RATIO: f64 = 0.1;

/// The horizontal flip.
pub(super) fn mirror() -> DAffine2 {
    DAffine2::from_cols(DVec2::NEG_X, DVec2::Y, DVec2::X)
}

/// The smallest side of a crop about a person, relative to the image.
const MIN_PERSON_CROP: f32 = 0.2;

/// Draws the map of a crop about the person; none if that is not to be done, or nobody is in view.
///
/// The crop is a square in relative coordinates. The person is wholly in it where it is larger than
/// the bounding box, anywhere; where it is smaller, it is about the middle of the box.
pub(super) fn draw_person_crop(
    augmentation: &BodyAugmentation,
    rng: &mut CounterRng,
    label: &BodyLabel,
) -> Option<DAffine2> {
    if !rng.chance(augmentation.person_crop_probability) {
        return None;
    }
    let (low, high) = bounding_box(label)?;
    let extent = (high - low).max_element();
    let side = (extent * uniform(rng, augmentation.person_crop) as f32).max(MIN_PERSON_CROP);
    let slack = (Vec2::splat(side) - (high - low)).max(Vec2::ZERO);
    let shift = Vec2::from([0, 1].map(|_| rng.uniform(-0.5, 0.5))) * slack;
    let start = (0.5 * (low + high) + shift - 0.5 * side).as_dvec2();
    let scale = 1.0 / f64::from(side);
    Some(DAffine2::from_scale_angle_translation(DVec2::splat(scale), 0.0, -start * scale))
}

pub(super) fn bounding_box(label: &BodyLabel) -> Option<(Vec2, Vec2)> {
    let labelled = label.keypoints.iter().filter(|keypoint| keypoint.is_labelled());
    labelled
        .map(|keypoint| (keypoint.position, keypoint.position))
        .reduce(|(low, high), (at, _)| (low.min(at), high.max(at)))
}

/// Draws one of the five maps; none if nothing is to be done.
pub(super) fn draw_map(
    augmentation: &BodyAugmentation,
    rng: &mut CounterRng,
    label: &BodyLabel,
) -> Option<DAffine2> {
    // With other people in view, crops stay central, without skew or shift.
    let is_alone = label.other_centers.is_empty();
    // Above 0: what never happens is never chosen.
    let mut rest = rng.unit();
    let mut is_chosen = |probability: f32| {
        let is_chosen = rest <= probability;
        rest -= probability;
        is_chosen
    };
    if is_chosen(augmentation.pad_probability) {
        Some(pad(uniform(rng, augmentation.pad)))
    } else if is_chosen(augmentation.crop_probability) {
        let cut = uniform(rng, augmentation.crop);
        let start = [0, 1].map(|_| uniform(rng, augmentation.crop_start) * cut);
        Some(crop(cut, if is_alone { DVec2::from(start) } else { DVec2::splat(cut) }))
    } else if is_chosen(augmentation.affine_probability) {
        let from =
            SKEWED.map(|to| to + DVec2::from([0, 1].map(|_| uniform(rng, augmentation.affine))));
        skew(from).filter(|_| is_alone)
    } else if is_chosen(augmentation.rotate_probability) {
        Some(rotation(uniform(rng, augmentation.rotate_deg)))
    } else if is_chosen(augmentation.shift_probability) {
        let most = uniform(rng, augmentation.shift);
        let by = [0, 1].map(|_| {
            let by = most * uniform(rng, [0.5, 1.0]);
            if rng.chance(0.5) { -by } else { by }
        });
        let others = |joint: usize| label.other_keypoints.get(joint).map_or(0, Vec::len);
        let is_alone = is_alone && SHIFT_BLOCKERS.into_iter().all(|joint| others(joint) == 0);
        is_alone.then(|| DAffine2::from_translation(by.into()))
    } else {
        None
    }
}

fn uniform(rng: &mut CounterRng, [low, high]: [f32; 2]) -> f64 {
    f64::from(rng.uniform(low, high))
}

/// The whole image inside of a border.
fn pad(border: f64) -> DAffine2 {
    let scale = 1.0 / (1.0 + 2.0 * border);
    DAffine2::from_scale_angle_translation(DVec2::splat(scale), 0.0, DVec2::splat(border * scale))
}

/// A part from `start` on, `cut` smaller at each side on average.
fn crop(cut: f64, start: DVec2) -> DAffine2 {
    let scale = 1.0 / (1.0 - 2.0 * cut);
    DAffine2::from_scale_angle_translation(DVec2::splat(scale), 0.0, -start * scale)
}

/// The map from three points to the targets of a skew; none if they are nearly collinear.
fn skew(from: [DVec2; 3]) -> Option<DAffine2> {
    let sides = |[a, b, c]: [DVec2; 3]| DMat2::from_cols(b - a, c - a);
    let (before, after) = (sides(from), sides(SKEWED));
    let area = after.determinant() / before.determinant();
    // A negative ratio is outside as well: a mirror image would exchange left and right.
    if !(MIN_AREA_RATIO..=1.0 / MIN_AREA_RATIO).contains(&area) {
        return None;
    }
    let linear = after * before.inverse();
    Some(DAffine2::from_mat2_translation(linear, SKEWED[0] - linear * from[0]))
}

/// The rotation about the centre of the image.
fn rotation(degrees: f64) -> DAffine2 {
    let middle = DAffine2::from_translation(DVec2::splat(0.5));
    middle * DAffine2::from_angle(degrees.to_radians()) * middle.inverse()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: DVec2, b: DVec2) {
        assert!(a.distance(b) < 1e-12, "{a} {b}");
    }

    #[test]
    fn maps_move_points_as_they_should() {
        close(mirror().transform_point2(DVec2::new(0.2, 0.7)), DVec2::new(0.8, 0.7));
        // A tenth on each side: the image is 10 twelfths of what is seen.
        close(pad(0.1).transform_point2(DVec2::new(0.0, 1.0)), DVec2::new(1.0 / 12.0, 11.0 / 12.0));
        let part = crop(0.25, DVec2::new(0.2, 0.4));
        close(part.transform_point2(DVec2::new(0.2, 0.9)), DVec2::new(0.0, 1.0));
        close(rotation(90.0).transform_point2(DVec2::new(1.0, 0.5)), DVec2::new(0.5, 1.0));
        let from = SKEWED.map(|at| at - DVec2::new(0.1, 0.2) * at.x);
        let skewed = skew(from).unwrap();
        from.into_iter().zip(SKEWED).for_each(|(a, b)| close(skewed.transform_point2(a), b));
        let [a, b, _] = SKEWED;
        assert_eq!(skew([a, b, a + 1.001 * (b - a)]), None, "on a line");
        assert_eq!(skew([b, a, SKEWED[2]]), None, "turned over");
    }

    #[test]
    fn a_person_is_wholly_in_a_crop_about_them_wherever_they_stand() {
        use evpose_pose::body::{Keypoint, Visibility};
        let keypoint = |x: f32, y: f32| Keypoint {
            position: Vec2::new(x, y),
            visibility: Visibility::Visible,
        };
        let keypoints = vec![keypoint(0.05, 0.6), keypoint(0.2, 0.9), Keypoint::default()];
        let label = BodyLabel { keypoints, ..BodyLabel::default() };
        let augmentation = BodyAugmentation {
            person_crop_probability: 1.0,
            person_crop: [1.1, 2.2],
            ..BodyAugmentation::none()
        };
        let mut sides = Vec::new();
        for sample in 0..500 {
            let mut rng = CounterRng::new(3, "crops", sample);
            let map = draw_person_crop(&augmentation, &mut rng, &label).unwrap();
            for at in [DVec2::new(0.05, 0.6), DVec2::new(0.2, 0.9)] {
                let seen = map.transform_point2(at);
                assert!(seen.cmpge(DVec2::splat(-1e-9)).all() && seen.cmple(DVec2::ONE).all());
            }
            sides.push(1.0 / map.matrix2.x_axis.x / 0.3);
        }
        // Relative to the longer side of the box, uniform.
        let mean = sides.iter().sum::<f64>() / sides.len() as f64;
        assert!(sides.iter().all(|side| (1.1..=2.2).contains(side)), "{sides:?}");
        assert!((mean - 1.65).abs() < 0.06, "{mean}");
        let nobody = BodyLabel::default();
        let mut rng = CounterRng::new(3, "crops", 0);
        assert_eq!(draw_person_crop(&augmentation, &mut rng, &nobody), None);
    }

    #[test]
    fn each_map_is_drawn_as_often_as_it_should() {
        let augmentation = BodyAugmentation::default();
        let (alone, n) = (BodyLabel::default(), 20_000);
        let crowd = BodyLabel { other_centers: vec![Vec2::ZERO], ..alone.clone() };
        let count = |label: &BodyLabel, is: fn(&DAffine2) -> bool| {
            let draw = |i| draw_map(&augmentation, &mut CounterRng::new(5, "maps", i), label);
            (0..n).filter_map(draw).filter(is).count() as f64 / n as f64
        };
        let near = |share: f64, expected: f64| {
            // Four standard deviations.
            let slack = 4.0 * (expected * (1.0 - expected) / n as f64).sqrt();
            assert!((share - expected).abs() <= slack, "{share} for {expected}");
        };
        near(
            count(&alone, |map| map.matrix2.determinant() < 0.9 && map.matrix2.y_axis.x == 0.0),
            0.1,
        );
        near(
            count(&alone, |map| map.matrix2.determinant() > 1.5 && map.matrix2.y_axis.x == 0.0),
            0.4,
        );
        near(count(&alone, |map| map.matrix2 == DMat2::IDENTITY), 0.1);
        near(count(&alone, |map| map.matrix2.y_axis.x != 0.0), 0.15);
        near(count(&crowd, |map| map.matrix2.y_axis.x != 0.0), 0.045);
        near(count(&crowd, |map| map.matrix2 == DMat2::IDENTITY), 0.0);
        near(count(&crowd, |map| map.matrix2.determinant() > 1.5), 0.4);
    }
}
