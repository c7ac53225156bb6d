//! Augmented views of samples.

use evpose_core::{CounterRng, Plane};
use evpose_pose::body::BodyLabel;
use glam::DAffine2;

use super::geometry;
use super::label::{is_inside, moved, unlabelled};
use super::light::{Square, add_noise, blank, relight};
use super::rest::{Rest, add_speckle, draw_rest};
use evpose_task::body::BodyAugmentation;
use evpose_task::body::{Interpolation, sample};

/// The brightest event of noise is at least as bright, of 255.
const DIMMEST_SPECKLE: f32 = 40.0;

/// An augmentation of one image and its label: drawn at random by [`BodyAugmentation`], or
/// [`plain`](Self::plain).
#[derive(Debug, Clone)]
pub struct BodyView {
    label: BodyLabel,
    view_from_image: DAffine2,
    interpolation: Interpolation,
    light: Option<[f32; 2]>,
    noise: Option<(CounterRng, f32)>,
    blank: Option<Square>,
    rest: Option<Rest>,
    speckle: Option<(CounterRng, [f32; 2])>,
}

/// Draws the view of sample `sample`: a pure function of its index, of `seed` and of its label.
pub(in crate::body) fn draw(
    augmentation: &BodyAugmentation,
    seed: u64,
    sample: u64,
    label: &BodyLabel,
) -> BodyView {
    // Geometry and grey values have streams of their own: either can change without the other.
    let mut places = CounterRng::new(seed, "body augmentation", sample);
    let mut greys = CounterRng::new(seed, "body augmentation greys", sample);
    let interpolation = match augmentation.interpolation.len() {
        0 => Interpolation::Linear,
        n => augmentation.interpolation[places.below(n)],
    };
    // No map, if the drawn one loses too many joints.
    let mut view = BodyView::plain(label, interpolation);
    let is_mirrored = places.chance(augmentation.mirror_probability);
    let mut people = CounterRng::new(seed, "body augmentation people", sample);
    let map = geometry::draw_person_crop(augmentation, &mut people, label)
        .or_else(|| geometry::draw_map(augmentation, &mut places, label));
    if is_mirrored || map.is_some() {
        let mirror = if is_mirrored { geometry::mirror() } else { DAffine2::IDENTITY };
        let view_from_image = map.unwrap_or(DAffine2::IDENTITY) * mirror;
        let seen = moved(label, view_from_image, is_mirrored);
        let (before, after) = (unlabelled(label), unlabelled(&seen));
        // Joints that the image lacks anyway are no loss of the view.
        if after <= before + augmentation.max_lost && after <= augmentation.max_unlabelled {
            view = BodyView { label: seen, view_from_image, ..view };
        }
    }
    let [contrast, brightness] = [augmentation.contrast, augmentation.brightness]
        .map(|[low, high]| greys.uniform(low, high));
    view.light = greys.chance(augmentation.light_probability).then_some([contrast, brightness]);
    if greys.chance(augmentation.noise_probability) {
        let rng = CounterRng::new(seed, "body augmentation noise", sample);
        view.noise = Some((rng, augmentation.noise_grey));
    }
    if greys.chance(augmentation.blank_probability) {
        // In the view, where a joint may lie elsewhere than in the image.
        view.blank = draw_square(augmentation, &mut greys, &view.label);
    }
    let rests = CounterRng::new(seed, "body augmentation rest", sample);
    view.rest = draw_rest(augmentation, rests, &view.label);
    let mut speckles = CounterRng::new(seed, "body augmentation speckle", sample);
    if speckles.chance(augmentation.speckle_probability) {
        let [low, high] = augmentation.speckle;
        let share_and_grey =
            [speckles.uniform(low, high), speckles.uniform(DIMMEST_SPECKLE, 255.0)];
        view.speckle = Some((speckles, share_and_grey));
    }
    view
}

/// Draws a square on a joint; none without joints.
fn draw_square(
    augmentation: &BodyAugmentation,
    rng: &mut CounterRng,
    label: &BodyLabel,
) -> Option<Square> {
    let is_seen = |at: &glam::Vec2| is_inside(*at);
    let labelled = label.keypoints.iter().filter(|keypoint| keypoint.is_labelled());
    let seen: Vec<_> = labelled.map(|keypoint| keypoint.position).filter(is_seen).collect();
    let half_side = rng.uniform(augmentation.blank[0], augmentation.blank[1]);
    let grey = rng.below(1 << u8::BITS) as u8;
    (!seen.is_empty()).then(|| Square { middle: seen[rng.below(seen.len())], half_side, grey })
}

impl BodyView {
    /// The view without augmentation, for validation.
    pub fn plain(label: &BodyLabel, interpolation: Interpolation) -> Self {
        Self {
            label: label.clone(),
            view_from_image: DAffine2::IDENTITY,
            interpolation,
            light: None,
            noise: None,
            blank: None,
            rest: None,
            speckle: None,
        }
    }

    /// The label of the view.
    pub fn label(&self) -> &BodyLabel {
        &self.label
    }

    /// The map from the image to the view; coordinates from 0 to 1 along either side.
    pub fn view_from_image(&self) -> DAffine2 {
        self.view_from_image
    }

    /// Renders the view of an image: `side` rows of as many grey values, 0 to 255, one channel of
    /// the network's input.
    ///
    /// # Panics
    /// If `out` is of another size.
    pub fn render(&self, image: &Plane<u8>, side: usize, out: &mut [f32]) {
        sample(image, self.view_from_image.inverse(), self.interpolation, [side; 2], out);
        // Rest and speckle are of events, light and noise of the whole image; a blank covers it.
        if let Some(rest) = &self.rest {
            rest.erase(out, side);
        }
        // A copy, so that a view renders alike each time.
        if let Some((rng, [share, most])) = &self.speckle {
            add_speckle(out, &mut rng.clone(), *share, *most);
        }
        if let Some([contrast, brightness]) = self.light {
            relight(out, contrast, brightness);
        }
        if let Some((rng, most)) = &self.noise {
            add_noise(out, &mut rng.clone(), *most);
        }
        if let Some(square) = &self.blank {
            blank(out, side, square);
        }
    }
}

#[cfg(test)]
mod tests;
