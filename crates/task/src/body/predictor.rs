//! A network of bodies at work: images in, joints out.

use std::time::Instant;

use evpose_core::{Plane, SensorSize};
use evpose_infer::{CalibrationRanges, Engine, EngineOptions, Precision};
use evpose_pose::body::{BODY_JOINTS, BodyDecoder, BodyJoint, BodyMaps, BodyPoints};
use evpose_pose::metric::body::BodyPrediction;
use glam::Vec2;

use super::checkpoint::BodyCheckpoint;
use super::resample::{Interpolation, resize_grey};
use crate::TaskError;

/// Channels of the network's input, all the same.
const CHANNELS: usize = 3;
/// Pixels of the input for each cell of the maps.
const CELL_PX: usize = 4;

/// Finds joints on images.
pub struct BodyPredictor {
    engine: Engine,
    decoder: BodyDecoder,
    side_px: usize,
    interpolation: Interpolation,
    input: Vec<f32>,
}

/// How to look for joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPredictorOptions {
    /// Bits that the network computes in.
    pub precision: Precision,
    /// Threads of the network.
    pub threads: usize,
    /// Joints of a lower score are not found; that of the checkpoint if none.
    pub confidence: Option<f32>,
}

impl Default for BodyPredictorOptions {
    /// One thread, 32 bits, the confidence of the checkpoint.
    fn default() -> Self {
        Self { precision: Precision::F32, threads: 1, confidence: None }
    }
}

impl BodyPredictor {
    /// Compiles a network.
    ///
    /// # Errors
    /// If it cannot be compiled in the precision asked for; 8 bits need `ranges`.
    pub fn new(
        checkpoint: &BodyCheckpoint,
        options: BodyPredictorOptions,
        ranges: Option<&CalibrationRanges>,
    ) -> Result<Self, TaskError> {
        let image = &checkpoint.config.image;
        let side_px = image.side_px;
        let engine_options = EngineOptions::default()
            .with_threads(options.threads)
            .with_precision(options.precision);
        let shape = [CHANNELS, side_px, side_px];
        let graph = checkpoint.network.graph();
        let confidence = options.confidence.unwrap_or(checkpoint.config.decoding.confidence);
        let decoder = BodyDecoder::new([side_px / CELL_PX; 2], confidence)
            .softened_by(checkpoint.config.decoding.softening_cells);
        let is_published = checkpoint.config.targets.parity;
        Ok(Self {
            engine: Engine::compile_with(&graph, shape, engine_options, ranges)?,
            decoder: if is_published { decoder.as_published() } else { decoder },
            side_px,
            interpolation: image.interpolation,
            input: vec![0.0; CHANNELS * side_px * side_px],
        })
    }

    /// Another of the same network, for another thread.
    #[must_use]
    pub fn another(&self) -> Self {
        Self {
            engine: self.engine.another(),
            decoder: self.decoder.clone(),
            side_px: self.side_px,
            interpolation: self.interpolation,
            input: self.input.clone(),
        }
    }

    /// The network's input for an image, `[3][side][side]`: the resized image in each channel.
    pub fn input(&mut self, image: &Plane<u8>) -> &[f32] {
        let (first, others) = self.input.split_at_mut(self.side_px * self.side_px);
        resize_grey(image, self.interpolation, [self.side_px; 2], first);
        others.chunks_mut(first.len()).for_each(|channel| channel.copy_from_slice(first));
        &self.input
    }

    /// The joints of the person on an image.
    pub fn joints(&mut self, image: &Plane<u8>) -> Vec<BodyJoint> {
        self.input(image);
        match self.engine.run(&self.input) {
            [heatmaps, centers, regs, offsets] => {
                let maps = [heatmaps, centers, regs, offsets].map(Vec::as_slice);
                self.decoder.decode(&BodyMaps::from_array(maps))
            }
            // Graphs of bodies have four outputs.
            _ => Vec::new(),
        }
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

/// Joints relative to an image, on it.
pub fn joints_in_pixels(joints: &[BodyJoint], sensor: SensorSize) -> BodyPoints {
    in_pixels(joints, Vec2::new(f32::from(sensor.width), f32::from(sensor.height)))
}

fn in_pixels(joints: &[BodyJoint], size_px: Vec2) -> BodyPoints {
    let mut points = [None; BODY_JOINTS];
    for (point, joint) in points.iter_mut().zip(joints) {
        *point = joint.position.map(|at| at * size_px);
    }
    points
}
