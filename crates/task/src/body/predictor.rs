//! A network of bodies at work: images in, joints out.

use std::time::Instant;

use evpose_core::Plane;
use evpose_infer::{CalibrationRanges, EngineOptions, Precision};
use evpose_pose::body::{BODY_JOINTS, BodyDecoder, BodyJoint, BodyPoints, score_of_joints};
use evpose_pose::metric::body::BodyPrediction;
use glam::{DAffine2, DVec2, Vec2};

use super::checkpoint::BodyCheckpoint;
use super::config::SecondPass;
use super::consensus::{SCALES, agreed, mapped, mirrored, resized};
use super::inference::BodyInference;
use super::resample::{Interpolation, sample};
use crate::TaskError;

/// Channels of the network's input, all the same.
const CHANNELS: usize = 3;
/// Pixels of the input for each cell of the maps.
const CELL_PX: usize = 4;
/// Side of a crop about the latest events, relative to that about the joints, up to which it is tried.
const SMALLER: f64 = 0.6;

/// Finds joints on images.
///
/// # Model
/// The network sees the whole image. With a second pass in the checkpoint's config it then sees a crop about the
/// joints that it found, so that small people are as large to it as others; without any joint
/// found, the first pass counts. Where the latest events are in a much smaller rectangle, as of somebody who
/// walks away from the trail that an EROS keeps, it also sees a crop about that one, and the pose of the higher
/// score counts. Where the config asks for a consensus, crops of other sizes and the mirror images of all
/// are seen as well, and each joint is where those of the highest total score lie together.
///
/// # Source
/// Crops about the person of the frame before are from MoveNet (Votel & Li, 2021). Here the crop
/// follows from the same image and the latest events, so that a pose depends on no earlier one.
pub struct BodyPredictor {
    inference: BodyInference,
    decoder: BodyDecoder,
    side_px: usize,
    interpolation: Interpolation,
    second_pass: Option<SecondPass>,
    /// `[images][3][side][side]`, at least one image.
    inputs: Vec<f32>,
}

/// How to look for joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPredictorOptions {
    /// Precision that the network computes in; f32 on devices other than the CPU.
    pub precision: Precision,
    /// Threads of the network, on the CPU.
    pub threads: usize,
    /// Joints of a lower score are not found; that of the checkpoint if none.
    pub confidence: Option<f32>,
    /// Whether a person is also inferred in crops of other sizes and in the mirror; as the checkpoint says
    /// if none.
    pub consensus: Option<bool>,
}

impl Default for BodyPredictorOptions {
    /// One thread, 32 bits, confidence and consensus of the checkpoint.
    fn default() -> Self {
        Self { precision: Precision::F32, threads: 1, confidence: None, consensus: None }
    }
}

impl BodyPredictor {
    /// Compiles a network for the CPU, or takes it on the device of its weights, where Burn computes
    /// it.
    ///
    /// # Errors
    /// If it cannot be compiled in the precision asked for; 8 bits need `ranges`. Devices other than
    /// the CPU compute in f32 only.
    pub fn new(
        checkpoint: &BodyCheckpoint,
        options: BodyPredictorOptions,
        ranges: Option<&CalibrationRanges>,
    ) -> Result<Self, TaskError> {
        let image = &checkpoint.config.image;
        let side_px = image.side_px;
        let inference = BodyInference::new(
            &checkpoint.network,
            [CHANNELS, side_px, side_px],
            EngineOptions::default().with_threads(options.threads),
            options.precision,
            ranges,
        )?;
        let confidence = options.confidence.unwrap_or(checkpoint.config.decoding.confidence);
        let decoder = BodyDecoder::new([side_px / CELL_PX; 2], confidence)
            .softened_by(checkpoint.config.decoding.softening_cells);
        let is_published = checkpoint.config.targets.parity;
        Ok(Self {
            inference,
            // A network that was trained on published targets expects the published rounding.
            decoder: if is_published { decoder.as_published() } else { decoder },
            side_px,
            interpolation: image.interpolation,
            second_pass: checkpoint.config.decoding.second_pass.map(|second| SecondPass {
                consensus: options.consensus.unwrap_or(second.consensus),
                ..second
            }),
            inputs: vec![0.0; CHANNELS * side_px * side_px],
        })
    }

    /// Another of the same network, for another thread.
    #[must_use]
    pub fn another(&self) -> Self {
        Self {
            inference: self.inference.another(),
            decoder: self.decoder.clone(),
            side_px: self.side_px,
            interpolation: self.interpolation,
            second_pass: self.second_pass,
            inputs: self.inputs.clone(),
        }
    }

    /// The network's input for an image, `[3][side][side]`: the resized image in each channel.
    pub fn input(&mut self, image: &Plane<u8>) -> &[f32] {
        self.fill_inputs(&[image]);
        &self.inputs
    }

    /// The input of the second pass for an image, of the same shape; that of the first without a
    /// second pass, or where the first found nothing.
    pub fn second_input(&mut self, image: &Plane<u8>) -> &[f32] {
        self.fill_inputs(&[image]);
        if let Some(second) = self.second_pass {
            let joints = self.infer();
            if let Some(crop) = joints.first().and_then(|joints| crop_about(joints, second)) {
                self.fill_input(0, image, crop);
            }
        }
        &self.inputs
    }

    /// Values of an input.
    fn size(&self) -> usize {
        CHANNELS * self.side_px * self.side_px
    }

    /// Fills as many inputs as there are images with all of each.
    fn fill_inputs(&mut self, images: &[&Plane<u8>]) {
        self.inputs.resize(images.len() * self.size(), 0.0);
        for (index, image) in images.iter().enumerate() {
            self.fill_input(index, image, DAffine2::IDENTITY);
        }
    }

    /// Fills an input with the part of an image that a map leads to.
    fn fill_input(&mut self, index: usize, image: &Plane<u8>, image_from_input: DAffine2) {
        let size = self.size();
        let input = &mut self.inputs[index * size..][..size];
        let (first, others) = input.split_at_mut(self.side_px * self.side_px);
        sample(image, image_from_input, self.interpolation, [self.side_px; 2], first);
        others.chunks_mut(first.len()).for_each(|channel| channel.copy_from_slice(first));
    }

    /// Infers `batch` images of nothing: the first inference on a GPU compiles its kernels, which
    /// takes seconds.
    pub fn warm_up(&mut self, batch: usize) {
        let image = Plane::filled(1, 1, 0);
        self.joints_of(&vec![&image; batch.max(1)], &[]);
    }

    /// The joints of the person on an image.
    pub fn joints(&mut self, image: &Plane<u8>) -> Vec<BodyJoint> {
        self.joints_of(&[image], &[]).pop().unwrap_or_default()
    }

    /// The joints of the person on each of several images, which a GPU infers together. `extents` are the corners
    /// of the rectangle of the latest events of each image, relative to it, where they are known.
    pub fn joints_of(
        &mut self,
        images: &[&Plane<u8>],
        extents: &[Option<[Vec2; 2]>],
    ) -> Vec<Vec<BodyJoint>> {
        self.fill_inputs(images);
        let mut joints = self.infer();
        let Some(second) = self.second_pass else { return joints };
        let mut crops: Vec<Option<DAffine2>> =
            joints.iter().map(|joints| crop_about(joints, second)).collect();
        self.infer_crops(images, &crops, false, &mut joints);
        // Before the consensus, which looks around the crop that has won.
        self.infer_recent(images, extents, second, (&mut crops, &mut joints));
        if second.consensus {
            self.infer_again(images, &crops, &mut joints);
        }
        // Until here, joints are relative to the crop that they were detected in.
        for (joints, crop) in joints.iter_mut().zip(&crops) {
            if let Some(crop) = crop {
                *joints = mapped(joints, crop);
            }
        }
        joints
    }

    /// Infers the images that have a crop once more, as they are or in the mirror, and replaces their
    /// joints by those in it.
    fn infer_crops(
        &mut self,
        images: &[&Plane<u8>],
        crops: &[Option<DAffine2>],
        is_mirrored: bool,
        joints: &mut [Vec<BodyJoint>],
    ) {
        let cropped = crops.iter().enumerate().filter_map(|(k, crop)| Some((k, (*crop)?)));
        let cropped: Vec<(usize, DAffine2)> = cropped.collect();
        if cropped.is_empty() {
            return;
        }
        // Inputs without a crop are inferred in vain: another count would be compiled first, for seconds.
        let count = if self.inference.compiles_by_count() { images.len() } else { cropped.len() };
        self.inputs.resize(count * self.size(), 0.0);
        for (input, (index, crop)) in cropped.iter().enumerate() {
            self.fill_input(input, images[*index], *crop);
        }
        if is_mirrored {
            self.inputs.chunks_exact_mut(self.side_px).for_each(<[f32]>::reverse);
        }
        for ((index, _), found) in cropped.into_iter().zip(self.infer()) {
            joints[index] = if is_mirrored { mirrored(&found) } else { found };
        }
    }

    /// Infers the crops of the last pass in other sizes and in the mirror, and replaces their joints by
    /// those that most of them agree on. An image without a crop is also seen in the mirror.
    fn infer_again(
        &mut self,
        images: &[&Plane<u8>],
        crops: &[Option<DAffine2>],
        joints: &mut [Vec<BodyJoint>],
    ) {
        let mut inferences: Vec<Vec<Vec<BodyJoint>>> =
            joints.iter().map(|own| vec![own.clone()]).collect();
        for (scale, is_mirrored) in
            SCALES.iter().flat_map(|scale| [(*scale, false), (*scale, true)])
        {
            // Known from the last pass.
            if scale == 1.0 && !is_mirrored {
                continue;
            }
            let of = |crop: &Option<DAffine2>| match crop {
                Some(crop) => Some(resized(crop, scale)),
                None => (scale == 1.0).then_some(DAffine2::IDENTITY),
            };
            let scaled: Vec<Option<DAffine2>> = crops.iter().map(of).collect();
            let mut found = vec![Vec::new(); images.len()];
            self.infer_crops(images, &scaled, is_mirrored, &mut found);
            for (index, scaled) in scaled.iter().enumerate() {
                let Some(scaled) = scaled else { continue };
                // All inferences of an image are compared in the coordinates of its own crop.
                let crop_from_image = crops[index].unwrap_or(DAffine2::IDENTITY).inverse();
                inferences[index].push(mapped(&found[index], &(crop_from_image * *scaled)));
            }
        }
        for (joints, inferences) in joints.iter_mut().zip(&inferences) {
            *joints = agreed(inferences);
        }
    }

    /// Infers crops about the latest events where these are much smaller than those inferred, and takes them
    /// where their pose has the higher score.
    fn infer_recent(
        &mut self,
        images: &[&Plane<u8>],
        extents: &[Option<[Vec2; 2]>],
        second: SecondPass,
        (crops, joints): (&mut [Option<DAffine2>], &mut [Vec<BodyJoint>]),
    ) {
        let side = |crop: &DAffine2| crop.matrix2.x_axis.x;
        let mut recent = vec![None; images.len()];
        for (index, (recent, corners)) in recent.iter_mut().zip(extents).enumerate() {
            // Without joints there is nobody, as small as the events may be.
            let is_somebody = joints[index].iter().any(|joint| joint.position.is_some());
            let widest = SMALLER * crops[index].as_ref().map_or(1.0, side);
            let crop = corners.and_then(|corners| crop_around(corners, second));
            *recent = crop.filter(|crop| is_somebody && side(crop) <= widest);
        }
        if recent.iter().all(Option::is_none) {
            return;
        }
        let mut found = joints.to_vec();
        self.infer_crops(images, &recent, false, &mut found);
        for (index, (recent, found)) in recent.into_iter().zip(found).enumerate() {
            let Some(recent) = recent else { continue };
            if score_of_joints(&found) > score_of_joints(&joints[index]) {
                (crops[index], joints[index]) = (Some(recent), found);
            }
        }
    }

    /// The joints in each of the network's inputs.
    fn infer(&mut self) -> Vec<Vec<BodyJoint>> {
        let shape = [CHANNELS, self.side_px, self.side_px];
        let mut joints = Vec::with_capacity(self.inputs.len() / self.size());
        let Self { inference, decoder, inputs, .. } = self;
        inference.for_each(inputs, shape, |maps| joints.push(decoder.decode(maps)));
        joints
    }

    /// The same in pixels of the image, and how long it took.
    pub fn predict(&mut self, t_s: f64, image: &Plane<u8>) -> BodyPrediction {
        let begin = Instant::now();
        let joints = self.joints(image);
        let joints_px = in_pixels(&joints, Vec2::new(image.width() as f32, image.height() as f32));
        BodyPrediction { t_s, delay_s: begin.elapsed().as_secs_f64(), joints_px }
    }
}

impl std::fmt::Debug for BodyPredictor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BodyPredictor").field("side_px", &self.side_px).finish_non_exhaustive()
    }
}

/// The map from a crop about joints to the image, both from 0 to 1; none without joints, or if the
/// crop is the image.
fn crop_about(joints: &[BodyJoint], second: SecondPass) -> Option<DAffine2> {
    let found = joints.iter().filter_map(|joint| joint.position);
    let (low, high) =
        found.map(|at| (at, at)).reduce(|(low, high), (at, _)| (low.min(at), high.max(at)))?;
    crop_around([low, high], second)
}

/// The same about a rectangle.
fn crop_around([low, high]: [Vec2; 2], second: SecondPass) -> Option<DAffine2> {
    let side = ((high - low).max_element() * second.side).max(second.min_side);
    if side >= 1.0 {
        return None;
    }
    // Within the image: there is nothing beyond it.
    let start = (0.5 * (low + high) - 0.5 * side).clamp(Vec2::ZERO, Vec2::splat(1.0 - side));
    let side = DVec2::splat(f64::from(side));
    Some(DAffine2::from_scale_angle_translation(side, 0.0, start.as_dvec2()))
}

/// Joints relative to an image, on it.
fn in_pixels(joints: &[BodyJoint], size_px: Vec2) -> BodyPoints {
    let mut points = [None; BODY_JOINTS];
    for (point, joint) in points.iter_mut().zip(joints) {
        *point = joint.position.map(|at| at * size_px);
    }
    points
}

#[cfg(test)]
mod tests {
    use burn::tensor::Device;

    use super::*;
    use crate::body::BodyConfig;

    #[test]
    fn images_that_are_inferred_together_have_the_joints_of_each_alone() {
        let mut config = BodyConfig::default();
        (config.image.side_px, config.network.width) = (32, 0.25);
        config.decoding.second_pass =
            Some(SecondPass { side: 1.2, min_side: 0.1, consensus: true });
        // Random weights score low, and joints that are not detected would not be compared.
        config.decoding.confidence = 0.0;
        let network = config.network.init(3, &Device::flex()).expect("a network");
        let checkpoint = BodyCheckpoint { config, network, mean_pose: None, data: None };
        let options = BodyPredictorOptions::default();
        let mut predictor = BodyPredictor::new(&checkpoint, options, None).expect("compiles");
        let images: Vec<Plane<u8>> = (1..5_u8)
            .map(|k| {
                let grey = |i: usize| (i * usize::from(k) * 37 % 251) as u8;
                Plane::from_vec(48, 36, (0..48 * 36).map(grey).collect()).expect("a plane")
            })
            .collect();
        let images: Vec<&Plane<u8>> = images.iter().collect();
        let small = |x: f32| Some([Vec2::new(x, 0.2), Vec2::new(x + 0.1, 0.3)]);
        let extents = [small(0.1), None, small(0.5), Some([Vec2::ZERO, Vec2::ONE])];
        let together = predictor.joints_of(&images, &extents);
        let alone: Vec<_> = (0..4)
            .map(|k| predictor.joints_of(&images[k..=k], &extents[k..=k]).remove(0))
            .collect();
        assert_eq!(alone, together);
        let without = predictor.joints_of(&images, &[]);
        assert_eq!((&without[1], &without[3]), (&together[1], &together[3]));
        let options = BodyPredictorOptions { consensus: Some(false), ..options };
        let mut twice = BodyPredictor::new(&checkpoint, options, None).expect("compiles");
        assert_ne!(twice.joints_of(&images, &[]), without);
        let differs = [0, 2].map(|k| without[k] != together[k]);
        assert!(differs.contains(&true) && score_of_joints(&together[0]) > 0.0, "{differs:?}");
    }

    fn detected(places: &[[f32; 2]]) -> Vec<BodyJoint> {
        places.iter().map(|at| BodyJoint { position: Some((*at).into()), score: 0.5 }).collect()
    }

    #[test]
    fn a_crop_is_about_the_joints_and_within_the_image() {
        let second = SecondPass { side: 1.5, min_side: 0.2, consensus: false };
        let corners = |joints: &[BodyJoint]| {
            crop_about(joints, second)
                .map(|crop| [DVec2::ZERO, DVec2::ONE].map(|at| crop.transform_point2(at).as_vec2()))
        };
        let near = |a: Option<[Vec2; 2]>, b: [[f32; 2]; 2]| {
            assert!(
                a.is_some_and(|a| a.into_iter().zip(b).all(|(a, b)| a.distance(b.into()) < 1e-6)),
                "{a:?} for {b:?}"
            );
        };
        near(corners(&detected(&[[0.4, 0.3], [0.6, 0.7]])), [[0.2, 0.2], [0.8, 0.8]]);
        near(corners(&detected(&[[0.0, 0.3], [0.2, 0.7]])), [[0.0, 0.2], [0.6, 0.8]]);
        near(corners(&detected(&[[0.5, 0.5]])), [[0.4, 0.4], [0.6, 0.6]]);
        assert_eq!(corners(&detected(&[[0.1, 0.1], [0.2, 0.8]])), None, "as large as the image");
        assert_eq!(corners(&[BodyJoint { position: None, score: 0.0 }]), None);
    }
}
