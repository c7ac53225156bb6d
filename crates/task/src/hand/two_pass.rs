//! Two passes of one network over a window: of the whole canonical view, and of a crop about the hand.

use evpose_core::{CounterRng, Micros, SensorSize};
use evpose_pose::{HandParams, HandPose, HandSide};
use evpose_sim::raster::Camera;
use glam::{Mat3, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::camera_turns::CameraTurnConfig;
use super::config::HandConfig;
use super::perspective_crop::PerspectiveCrop;
use super::view::HandView;
use crate::TaskError;

/// Maximum number of crops of a window.
const MAX_CROPS: usize = 8;
/// Crops that are tried beside a hand before there is none.
const BESIDE_TRIES: usize = 8;

/// Two passes of one network over every window: of the whole view, and of a perspective crop about
/// the hand that was found there, upright and enlarged. The view then has more pixels than the
/// network's image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TwoPassConfig {
    /// Size of the network's image, in pixels, of the view's proportions.
    pub size: SensorSize,
    /// A crop shows a hand as large as it is at this distance in the whole view, in metres.
    pub distance_m: f32,
    /// Maximum factor by which a crop is magnified.
    pub max_zoom: f32,
    /// Crops of a window, one after the other, each about the hand of the pass before.
    #[serde(skip_serializing_if = "is_one")]
    pub crops: usize,
    /// Microseconds of a recording after which the whole view is looked at once more. Until then, crops are about the
    /// hand that was found there; 0 looks at all.
    #[serde(skip_serializing_if = "is_zero_us")]
    pub view_every_us: i64,
    /// Share of the training windows that are whole views.
    pub first_pass_probability: f32,
    /// Share of the training windows of networks of joints that show what lies beside the hand.
    #[serde(skip_serializing_if = "is_zero")]
    pub empty_probability: f32,
    /// Errors of the first pass that the second is trained with.
    pub errors: CropErrors,
}

/// Largest errors of the crops that a network is trained with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CropErrors {
    /// Of the direction to the hand, relative to the vertical field of view of the crop.
    pub direction: f32,
    /// Of the zoom, in natural logarithm.
    pub zoom: f32,
    /// Of the direction of the hand in the image, in degrees.
    pub roll_deg: f32,
}

/// The view of a training sample of a network of joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrainingView {
    /// A part of the canonical view.
    pub crop: PerspectiveCrop,
    /// Whether tiles of the image change places, so that there is no hand in it.
    pub is_scrambled: bool,
}

impl Default for TwoPassConfig {
    fn default() -> Self {
        Self {
            size: SensorSize { width: 96, height: 72 },
            distance_m: 0.31,
            max_zoom: 4.0,
            crops: 1,
            view_every_us: 0,
            first_pass_probability: 0.4,
            empty_probability: 0.0,
            errors: CropErrors::default(),
        }
    }
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
fn is_zero(probability: &f32) -> bool {
    *probability == 0.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
fn is_zero_us(time_us: &i64) -> bool {
    *time_us == 0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
fn is_one(crops: &usize) -> bool {
    *crops == 1
}

impl Default for CropErrors {
    fn default() -> Self {
        Self { direction: 0.15, zoom: 0.35, roll_deg: 45.0 }
    }
}

impl TwoPassConfig {
    /// Whether all values make sense for a view of `view`.
    pub fn is_valid(&self, view: SensorSize) -> bool {
        let CropErrors { direction, zoom, roll_deg } = self.errors;
        // Sides are whole pixels, so that proportions may differ by 2 %.
        let across = u32::from(self.size.width) * u32::from(view.height);
        let same = across.abs_diff(u32::from(view.width) * u32::from(self.size.height));
        self.size.pixels() > 0
            && self.size.width <= view.width
            && 50 * same <= across
            && self.distance_m > 0.0
            && self.max_zoom >= 1.0
            && (1..=MAX_CROPS).contains(&self.crops)
            && (0..=TwoPass::MAX_VIEW_EVERY_US).contains(&self.view_every_us)
            && (0.0..=1.0).contains(&self.first_pass_probability)
            && (0.0..=1.0).contains(&self.empty_probability)
            && (0.0..=1.0).contains(&direction)
            && (0.0..=2.0).contains(&zoom)
            && (0.0..=180.0).contains(&roll_deg)
    }
}

/// Crops of the canonical view of a config.
#[derive(Debug)]
pub struct TwoPass {
    config: TwoPassConfig,
    turns: CameraTurnConfig,
    camera: Camera,
    view: HandView,
    side: HandSide,
}

impl TwoPass {
    /// Maximum of [`TwoPassConfig::view_every_us`]: a second, in which a hand goes anywhere.
    pub const MAX_VIEW_EVERY_US: i64 = 1_000_000;

    /// Those of a config; none if its network sees the whole view only, as it is.
    ///
    /// # Errors
    /// If the hand model cannot be read.
    pub fn new(config: &HandConfig) -> Result<Option<Self>, TaskError> {
        let Some(two_pass) = config.two_pass else { return Ok(None) };
        Ok(Some(Self {
            config: two_pass,
            turns: config.camera_turns,
            camera: config.simulation.camera(),
            view: HandView::new(config)?,
            side: config.simulation.hands.side(0),
        }))
    }

    /// Size of the network's image.
    pub fn size(&self) -> SensorSize {
        self.config.size
    }

    /// Crops of a window, one after the other.
    pub fn crops(&self) -> usize {
        self.config.crops
    }

    /// Time after which the whole view of a recording is looked at once more.
    pub fn view_every(&self) -> Micros {
        Micros(self.config.view_every_us)
    }

    /// Size of the view.
    pub fn view_size(&self) -> SensorSize {
        self.camera.sensor()
    }

    /// Crops of a view of another size, which shows the same.
    pub fn set_view_size(&mut self, size: SensorSize) {
        self.camera = self.camera.with_image(size);
    }

    /// The camera of the view.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The crop about the hand of a pose: about its joints, where it has some.
    pub fn about(&self, pose: &HandPose) -> PerspectiveCrop {
        match pose.joints {
            Some(joints) => self.about_points(&joints.camera_m),
            None => self.about_points(&self.points_m(&pose.params)),
        }
    }

    /// The crop about points in the frame of the camera.
    fn about_points(&self, points_m: &[Vec3; 21]) -> PerspectiveCrop {
        PerspectiveCrop::at(points_m, self.config.distance_m, self.config.max_zoom)
    }

    /// The points of the neutral hand of a pose, in the frame of the camera.
    fn points_m(&self, pose: &HandParams) -> [Vec3; 21] {
        self.view.camera_points(&self.view.points(self.side, pose, &[]).world_m)
    }

    /// The crop of training sample `sample` about the hand of its pose: a function of `seed` and its
    /// number alone.
    pub fn draw(&self, pose: &HandParams, seed: u64, sample: u64) -> PerspectiveCrop {
        self.draw_about(&self.points_m(pose), seed, sample)
    }

    /// As [`Self::draw`], about a hand whose evaluated points lie at `points_m` in the frame of the camera.
    pub fn draw_about(&self, points_m: &[Vec3; 21], seed: u64, sample: u64) -> PerspectiveCrop {
        let mut rng = CounterRng::new(seed, "perspective crops", sample);
        if rng.uniform(0.0, 1.0) < self.config.first_pass_probability {
            return PerspectiveCrop::new(self.turns.draw(seed, sample), 1.0);
        }
        let CropErrors { direction, zoom, roll_deg } = self.config.errors;
        let crop = self.about_points(points_m);
        let mut error = |largest: f32| largest * rng.uniform(-1.0, 1.0);
        // As likely too near as too far by the same factor; the whole view is a zoom of 1.
        let zoom = (crop.zoom() * error(zoom).exp()).max(1.0);
        let half_px = 0.5 * f32::from(self.view_size().height);
        let fov_rad = 2.0 * (half_px / (zoom * self.camera.pinhole().focal_px)).atan();
        // A direction is wrong by a share of what the crop sees, near or far.
        let (pan, tilt) = (fov_rad * error(direction), fov_rad * error(direction));
        let roll = error(roll_deg).to_radians();
        let error =
            Mat3::from_rotation_x(tilt) * Mat3::from_rotation_y(pan) * Mat3::from_rotation_z(roll);
        // The error is one of the frame of the crop, and so follows the turn to the hand.
        PerspectiveCrop::new(error * crop.turn(), zoom)
    }

    /// The view of training sample `sample` of a network of joints, of a hand at `points_m`: a function of `seed` and
    /// its number alone. With [`TwoPassConfig::empty_probability`] there is no hand in it: half of these lie beside
    /// the hand, in the others it is to be scrambled.
    pub fn draw_view(&self, points_m: &[Vec3; 21], seed: u64, sample: u64) -> TrainingView {
        let mut rng = CounterRng::new(seed, "crops without hands", sample);
        let about = || self.draw_about(points_m, seed, sample);
        if !rng.chance(self.config.empty_probability) {
            return TrainingView { crop: about(), is_scrambled: false };
        }
        let beside = rng.chance(0.5).then(|| self.draw_beside(points_m, &mut rng)).flatten();
        // A hand that fills the view leaves no place beside it.
        TrainingView { crop: beside.unwrap_or_else(about), is_scrambled: beside.is_none() }
    }

    /// A crop beside a hand at `points_m`, with none of it in the image, if there is place.
    fn draw_beside(&self, points_m: &[Vec3; 21], rng: &mut CounterRng) -> Option<PerspectiveCrop> {
        let about = self.about_points(points_m);
        // A whole view has no place beside the hand.
        let zoom = (about.zoom() * rng.uniform(-0.35f32, 0.35).exp()).max(2.0);
        let sensor = self.camera.sensor();
        let half_px = 0.5 * Vec2::new(sensor.width.into(), sensor.height.into());
        let half = half_px / (zoom * self.camera.pinhole().focal_px);
        for _ in 0..BESIDE_TRIES {
            let turned = |largest: f32, rng: &mut CounterRng| {
                (3.0 * largest * rng.uniform(-1.0, 1.0)).atan()
            };
            let (pan, tilt) = (turned(half.x, rng), turned(half.y, rng));
            let roll =
                Mat3::from_rotation_z(rng.uniform(-std::f32::consts::PI, std::f32::consts::PI));
            let turn =
                roll * Mat3::from_rotation_x(tilt) * Mat3::from_rotation_y(pan) * about.turn();
            let is_outside = |point_m: &Vec3| {
                let at_m = turn * *point_m;
                at_m.z >= 0.0 || (at_m.truncate() / -at_m.z).abs().cmpgt(half).any()
            };
            if points_m.iter().all(is_outside) {
                return Some(PerspectiveCrop::new(turn, zoom));
            }
        }
        None
    }

    /// Writes the network's image of a crop of the view's values, `[2][rows][columns]` both.
    pub fn fill(&self, crop: &PerspectiveCrop, values: &[f32], out: &mut [f32]) {
        crop.fill(&self.camera, values, self.config.size, out);
    }
}

#[cfg(test)]
mod tests {
    use burn::tensor::Device;
    use evpose_core::seed_for;
    use evpose_nn::{HandNetwork, HandRegressorConfig};
    use glam::Vec3;

    use crate::hand::{NetworkPredictor, Predictor};

    use super::*;

    fn config(first_pass_probability: f32) -> HandConfig {
        let two_pass = TwoPassConfig { first_pass_probability, ..TwoPassConfig::default() };
        let camera_turns = CameraTurnConfig { roll_deg: 180.0, tilt_deg: 8.0 };
        let network = HandRegressorConfig { width: 1.0 / 16.0, ..HandRegressorConfig::default() };
        HandConfig { two_pass: Some(two_pass), camera_turns, network, ..HandConfig::default() }
    }

    fn pose(config: &HandConfig, k: u64) -> HandParams {
        let mut rng = CounterRng::new(7, "poses of a test", k);
        let mut vector = |size: f32| Vec3::from_array([(); 3].map(|()| rng.uniform(-size, size)));
        HandParams {
            articulation: [0.3; 6],
            translation_m: config.simulation.camera.centre_m + vector(0.06),
            rotation: vector(1.5),
        }
    }

    /// The hand of a crop lies as far from the middle of the image as its errors allow, and
    /// is as large as they allow.
    #[test]
    fn crops_are_drawn_about_the_hand() {
        let config = config(0.0);
        let two_pass = TwoPass::new(&config).unwrap().unwrap();
        let focal_px = two_pass.camera().pinhole().focal_px;
        let height_px = f32::from(two_pass.view_size().height);
        let errors = config.two_pass.unwrap().errors;
        for k in 0..60 {
            let pose = pose(&config, k);
            let crop = two_pass.draw(&pose, 3, k);
            assert_eq!(crop, two_pass.draw(&pose, 3, k));
            let intended = two_pass.about(&pose.into());
            let larger = (crop.zoom() / intended.zoom()).ln().abs();
            assert!(larger <= errors.zoom + 1e-4 || crop.zoom() == 1.0, "sample {k}: {larger}");
            let seen = crop.crop_from_view(two_pass.camera(), &pose);
            let points = two_pass.view.points(two_pass.side, &seen, &[]);
            let points_m = two_pass.view.camera_points(&points.world_m);
            let low = points_m.iter().fold(Vec3::INFINITY, |low, point| low.min(*point));
            let high = points_m.iter().fold(Vec3::NEG_INFINITY, |high, point| high.max(*point));
            let middle = 0.5 * (low + high);
            // Of the box's middle, which turns with the hand, and of perspective: a third more.
            let off = (middle.truncate() / -middle.z).abs() * focal_px / height_px;
            assert!(off.max_element() < 1.35 * errors.direction + 0.05, "sample {k}: {off}");
        }
    }

    #[test]
    fn few_windows_show_no_hand_and_crops_beside_it_none_of_its_points() {
        let mut config = config(0.4);
        config.two_pass.as_mut().unwrap().empty_probability = 0.25;
        let two_pass = TwoPass::new(&config).unwrap().unwrap();
        let pinhole = two_pass.camera().pinhole();
        let view = two_pass.view_size();
        let (mut beside, mut scrambled) = (0, 0);
        for k in 0..200 {
            let points_m = two_pass.points_m(&pose(&config, k));
            let TrainingView { crop, is_scrambled } = two_pass.draw_view(&points_m, 3, k);
            assert_eq!(two_pass.draw_view(&points_m, 3, k), TrainingView { crop, is_scrambled });
            scrambled += usize::from(is_scrambled);
            if is_scrambled || crop == two_pass.draw_about(&points_m, 3, k) {
                continue;
            }
            beside += 1;
            for point_m in points_m {
                let at_m = crop.turn() * point_m;
                let longer = Vec3::new(crop.zoom() * at_m.x, crop.zoom() * at_m.y, at_m.z);
                let Some(at_px) = pinhole.image_from_camera(longer) else { continue };
                let size = Vec2::new(view.width.into(), view.height.into());
                let is_inside = at_px.cmpgt(Vec2::ZERO).all() && at_px.cmplt(size).all();
                assert!(!is_inside, "sample {k}: {at_px}");
            }
        }
        assert!((15..45).contains(&beside), "{beside} of 200");
        assert!((10..40).contains(&scrambled), "{scrambled} of 200");
    }

    #[test]
    fn first_passes_are_turned_whole_views() {
        let config = config(1.0);
        let two_pass = TwoPass::new(&config).unwrap().unwrap();
        for k in 0..10 {
            let crop = two_pass.draw(&pose(&config, k), 3, k);
            assert_eq!(crop, PerspectiveCrop::new(config.camera_turns.draw(3, k), 1.0));
        }
    }

    #[test]
    fn crops_of_a_finer_view_show_the_same() {
        let config = config(0.0);
        let mut two_pass = TwoPass::new(&config).unwrap().unwrap();
        let crop = two_pass.about(&pose(&config, 1).into());
        let mut seen = |view: SensorSize| {
            two_pass.set_view_size(view);
            let columns = usize::from(view.width);
            let ramp = (0..2 * view.pixels()).map(|i| (i % columns) as f32 / columns as f32);
            let mut image = vec![0.0; 2 * two_pass.size().pixels()];
            two_pass.fill(&crop, &ramp.collect::<Vec<_>>(), &mut image);
            image
        };
        let view = config.simulation.image_size();
        let [width, height] = [view.width, view.height].map(|side| 2 * side);
        let (usual, finer) = (seen(view), seen(SensorSize { width, height }));
        // Beyond the view nothing is seen; in it the largest value of what a pixel covers, to within a pixel and a
        // quarter of the view.
        let both = usual.iter().zip(&finer).filter(|(one, other)| **one > 0.0 && **other > 0.0);
        let apart: Vec<f32> = both.map(|(one, other)| (one - other).abs()).collect();
        let largest = apart.iter().copied().fold(0.0, f32::max);
        assert!(crop.zoom() > 1.2 && apart.len() > usual.len() / 2, "{}", apart.len());
        assert!(largest <= 1.3 / f32::from(view.width), "{largest}");
    }

    #[test]
    fn a_predictor_infers_the_hand_that_it_found_once_more_and_again() {
        let mut config = config(0.5);
        let device = Device::flex();
        let network =
            HandNetwork::init(&config.network, seed_for(1, "weights", 0), &device).unwrap();
        let two_pass = TwoPass::new(&config).unwrap().unwrap();
        let (view, size) = (two_pass.view_size(), two_pass.size());
        let values: Vec<f32> =
            (0..2 * view.pixels()).map(|i| ((i * 7919) % 97) as f32 / 97.0).collect();
        let sides = |size: SensorSize| (usize::from(size.height), usize::from(size.width));

        let plain = HandConfig { two_pass: None, ..config.clone() };
        let mut network_alone =
            NetworkPredictor::new(&plain, network.clone(), device.clone()).unwrap();
        let mut at = |crop: &PerspectiveCrop| {
            let mut image = vec![0.0; 2 * size.pixels()];
            two_pass.fill(crop, &values, &mut image);
            let pose = network_alone.predict(&image, sides(size)).unwrap()[0];
            crop.view_from_crop(two_pass.camera(), &pose.params)
        };
        let first = at(&PerspectiveCrop::WHOLE);
        let second = at(&two_pass.about(&first.into()));
        let third = at(&two_pass.about(&second.into()));

        // Two windows take the way of batches, and one alone that of single windows.
        let both = [values.clone(), values.clone()].concat();
        for (crops, last) in [(1, second), (2, third)] {
            config.two_pass.as_mut().unwrap().crops = crops;
            let mut predictor =
                NetworkPredictor::new(&config, network.clone(), device.clone()).unwrap();
            let poses = predictor.predict(&both, sides(view)).unwrap();
            assert!(poses.iter().all(|pose| pose.params == last) && poses.len() == 2);
        }

        // Of one recording, the second crop is about the hand of the first whole view until this is too old.
        config.two_pass.as_mut().unwrap().view_every_us = 5_000;
        let other = values.iter().rev().copied().collect::<Vec<f32>>();
        let inputs = [values, other].concat();
        let follow = |times: [i64; 2], at_once: bool| {
            let mut predictor =
                NetworkPredictor::new(&config, network.clone(), device.clone()).unwrap();
            let times = times.map(Micros);
            if at_once {
                return predictor.follow(&times, &inputs, sides(view)).unwrap();
            }
            let parts = times.chunks(1).zip(inputs.chunks(inputs.len() / 2));
            parts.flat_map(|(t, part)| predictor.follow(t, part, sides(view)).unwrap()).collect()
        };
        let alone = follow([0, 5_000], true);
        assert_eq!(
            alone,
            NetworkPredictor::new(&config, network.clone(), device.clone())
                .and_then(|mut predictor| predictor.predict(&inputs, sides(view)))
                .unwrap()
        );
        // Of other windows before, as those that warm an engine up, nothing is kept.
        let mut warm = NetworkPredictor::new(&config, network.clone(), device.clone()).unwrap();
        warm.predict(&inputs[inputs.len() / 2..], sides(view)).unwrap();
        assert_eq!(
            warm.follow(&[Micros(0)], &inputs[..inputs.len() / 2], sides(view)).unwrap(),
            [alone[0]]
        );
        for at_once in [true, false] {
            let followed = follow([0, 4_999], at_once);
            assert!(followed[0] == alone[0] && followed[1] != alone[1]);
            assert_eq!(followed, follow([0, 4_999], true));
        }
        assert!(first != second && second != third);
    }
}
