//! Limbs at rest, which an EROS forgets, and single events of noise, which it keeps.

use evpose_core::CounterRng;
use evpose_pose::body::BodyLabel;
use evpose_task::body::BodyAugmentation;
use glam::Vec2;

use super::geometry::bounding_box;

/// Shoulder, elbow, wrist and hip, knee, ankle of either side.
const ARMS: [[usize; 3]; 2] = [[1, 3, 5], [2, 4, 6]];
const LEGS: [[usize; 3]; 2] = [[7, 9, 11], [8, 10, 12]];
/// Shares of the drawn cases: both legs, all limbs, else each limb by chance.
const BOTH_LEGS: f32 = 0.5;
const ALL_LIMBS: f32 = 0.15;
/// Probability of each limb in the other cases.
const ALONE: f32 = 0.4;
/// How far a limb is known: 0 is its first joint, 1 the middle one, 2 its end.
const KNOWN: [f32; 2] = [0.0, 1.5];
/// A foot or a hand, in lengths of the limb's last part.
const END: f32 = 0.35;

/// Limbs that left no trace. Lengths are relative to the view.
#[derive(Debug, Clone)]
pub(super) struct Rest {
    segments: Vec<[Vec2; 2]>,
    radius: f32,
    rng: CounterRng,
}

/// Draws limbs that rest; none without labelled limbs.
pub(super) fn draw_rest(
    augmentation: &BodyAugmentation,
    mut rng: CounterRng,
    label: &BodyLabel,
) -> Option<Rest> {
    if !rng.chance(augmentation.rest_probability) {
        return None;
    }
    let (low, high) = bounding_box(label)?;
    let width = rng.uniform(augmentation.rest_width[0], augmentation.rest_width[1]);
    let known = rng.uniform(KNOWN[0], KNOWN[1]);
    let case = rng.unit();
    let mut segments = Vec::new();
    for (limb, is_leg) in
        LEGS.map(|leg| (leg, true)).into_iter().chain(ARMS.map(|arm| (arm, false)))
    {
        // Draws come for every limb, whether or not it rests.
        let alone = rng.chance(ALONE);
        let known_alone = rng.uniform(KNOWN[0], KNOWN[1]);
        // Who stands rests with both legs, to the same height.
        let (rests, known) = match case {
            case if case < BOTH_LEGS => (is_leg, known),
            case if case < BOTH_LEGS + ALL_LIMBS => (true, known),
            _ => (alone, known_alone),
        };
        if rests {
            segments.extend(parts_beyond(label, limb, known));
        }
    }
    // The width is a share of the body, whose size on the image differs.
    let radius = width * (high - low).max_element();
    (!segments.is_empty()).then_some(Rest { segments, radius, rng })
}

/// The parts of a limb from `known` on, hand or foot included; those with an unlabelled end are
/// left out.
fn parts_beyond(label: &BodyLabel, limb: [usize; 3], known: f32) -> Vec<[Vec2; 2]> {
    let at = |joint: usize| {
        let keypoint = label.keypoints.get(joint).filter(|keypoint| keypoint.is_labelled());
        keypoint.map(|keypoint| keypoint.position)
    };
    let mut parts = Vec::new();
    for (part, ends) in limb.windows(2).enumerate() {
        let (Some(from), Some(to)) = (at(ends[0]), at(ends[1])) else { continue };
        // `known` counts parts: 1.5 is the middle of the second.
        let share = known - part as f32;
        if share < 1.0 {
            let is_last = part + 2 == limb.len();
            let end = if is_last { to + END * (to - from) } else { to };
            parts.push([from.lerp(to, share.max(0.0)), end]);
        }
    }
    parts
}

impl Rest {
    /// Gives the pixels about the limbs values of other pixels of the image, which has `side`
    /// columns: the noise of the place remains.
    pub(super) fn erase(&self, image: &mut [f32], side: usize) {
        // A copy of the generator: the same view always erases the same way.
        let mut rng = self.rng.clone();
        let n = image.len();
        for pixel in 0..n {
            let at =
                Vec2::new((pixel % side) as f32 + 0.5, (pixel / side) as f32 + 0.5) / side as f32;
            if self.segments.iter().any(|ends| distance(at, ends) < self.radius) {
                image[pixel] = image[rng.below(n)];
            }
        }
    }
}

/// The distance of a point from a segment.
fn distance(at: Vec2, [from, to]: &[Vec2; 2]) -> f32 {
    let along = *to - *from;
    let share = (at - *from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
    at.distance(*from + share.clamp(0.0, 1.0) * along)
}

/// Lights a share of the pixels, each up to `most`, as events of noise do in an EROS.
pub(super) fn add_speckle(image: &mut [f32], rng: &mut CounterRng, share: f32, most: f32) {
    for grey in image {
        if rng.chance(share) {
            *grey = grey.max(rng.unit() * most);
        }
    }
}

#[cfg(test)]
mod tests {
    use evpose_pose::body::{Keypoint, Visibility};

    use super::*;

    fn standing() -> BodyLabel {
        let places = [
            (0.5, 0.1),
            (0.6, 0.25),
            (0.4, 0.25),
            (0.62, 0.4),
            (0.38, 0.4),
            (0.62, 0.5),
            (0.38, 0.5),
            (0.55, 0.5),
            (0.45, 0.5),
            (0.55, 0.7),
            (0.45, 0.7),
            (0.55, 0.9),
            (0.45, 0.9),
        ];
        let keypoint =
            |(x, y)| Keypoint { position: Vec2::new(x, y), visibility: Visibility::Visible };
        BodyLabel { keypoints: places.map(keypoint).to_vec(), ..BodyLabel::default() }
    }

    #[test]
    fn a_limb_ends_at_its_hand_or_foot_and_begins_where_it_is_no_longer_known() {
        let parts = parts_beyond(&standing(), LEGS[0], 0.5);
        let y: Vec<f32> = parts.iter().flatten().map(|at| at.y).collect();
        for (y, expected) in y.iter().zip([0.6, 0.7, 0.7, 0.97]) {
            assert!((y - expected).abs() < 1e-6, "{y} {expected}");
        }
        assert_eq!((parts.len(), parts_beyond(&standing(), LEGS[0], 1.2).len()), (2, 1));
        let mut cut = standing();
        cut.keypoints[11] = Keypoint::default();
        assert_eq!(parts_beyond(&cut, LEGS[0], 0.0).len(), 1);
    }

    #[test]
    fn what_rests_takes_values_of_the_image_and_all_else_stays() {
        let augmentation =
            BodyAugmentation { rest_probability: 1.0, ..BodyAugmentation::default() };
        let mut erased = [0usize; 2];
        for sample in 0..200 {
            let rng = CounterRng::new(4, "rest", sample);
            let Some(rest) = draw_rest(&augmentation, rng, &standing()) else { continue };
            let mut image = vec![10.0; 64 * 64];
            let ankle = 57 * 64 + 35;
            let head = 6 * 64 + 32;
            (image[ankle], image[head]) = (200.0, 100.0);
            rest.erase(&mut image, 64);
            assert!(image.iter().all(|grey| [10.0, 100.0, 200.0].contains(grey)));
            assert_eq!(image[head], 100.0);
            erased[usize::from(image[ankle] == 10.0)] += 1;
        }
        // Both legs, all limbs, or this one in two of five.
        assert!((110..190).contains(&erased[1]), "{erased:?}");
    }

    #[test]
    fn speckle_lights_its_share_of_pixels() {
        let mut image = vec![20.0; 10_000];
        add_speckle(&mut image, &mut CounterRng::new(1, "speckle", 0), 0.2, 200.0);
        let lit = image.iter().filter(|&&grey| grey > 20.0).count();
        // A tenth of the greys is below what was there; four standard deviations.
        assert!(lit.abs_diff(1800) < 160, "{lit}");
        assert!(image.iter().all(|grey| (20.0..=200.0).contains(grey)));
    }
}
