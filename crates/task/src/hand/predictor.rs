//! Predictors of hands: from representations of windows to poses.

use burn::tensor::{Device, Tensor, TensorData};
use evpose_core::{Micros, SensorSize};
use evpose_infer::{CalibrationRanges, Engine, EngineOptions, Precision};
use evpose_nn::graph::Graph;
use evpose_nn::{HandNetwork, RotationOutput};
use evpose_pose::{HandParams, HandPose};
use rayon::prelude::*;

use super::config::HandConfig;
use super::joint_decoder::JointDecoder;
use super::perspective_crop::PerspectiveCrop;
use super::two_pass::TwoPass;
use crate::TaskError;

/// A predictor of poses: a network, or a constant.
pub trait Predictor: Send {
    /// Poses of `inputs`, which holds representations of `[2, height, width]`, one after another;
    /// `image_size` is `(height, width)`.
    ///
    /// # Errors
    /// If the computation fails or yields something that is not a number.
    fn predict(
        &mut self,
        inputs: &[f32],
        image_size: (usize, usize),
    ) -> Result<Vec<HandPose>, TaskError>;

    /// As [`Self::predict`], of the windows of one recording that end at `times`, after those of the calls before.
    ///
    /// # Errors
    /// As [`Self::predict`].
    fn follow(
        &mut self,
        times: &[Micros],
        inputs: &[f32],
        image_size: (usize, usize),
    ) -> Result<Vec<HandPose>, TaskError> {
        assert_eq!(inputs.len(), times.len() * 2 * image_size.0 * image_size.1);
        self.predict(inputs, image_size)
    }
}

impl<P: Predictor + ?Sized> Predictor for &mut P {
    fn predict(
        &mut self,
        inputs: &[f32],
        image_size: (usize, usize),
    ) -> Result<Vec<HandPose>, TaskError> {
        (**self).predict(inputs, image_size)
    }

    fn follow(
        &mut self,
        times: &[Micros],
        inputs: &[f32],
        image_size: (usize, usize),
    ) -> Result<Vec<HandPose>, TaskError> {
        (**self).follow(times, inputs, image_size)
    }
}

/// A network: on the CPU compiled, on other devices by Burn. With [`TwoPass`], it infers the whole view and then crops.
pub struct NetworkPredictor {
    backend: Backend,
    decoder: PoseDecoder,
    two_pass: Option<TwoPass>,
    /// The last hand that was found in a whole view, and the time of that.
    in_whole_view: Option<(Micros, HandPose)>,
}

/// Makes poses of a network's outputs.
enum PoseDecoder {
    Regression(RotationOutput),
    Joints(Box<JointDecoder>),
}

impl PoseDecoder {
    fn new(config: &HandConfig, network: &HandNetwork) -> Result<Self, TaskError> {
        Ok(match network {
            HandNetwork::Regressor(network) => Self::Regression(network.config().rotation),
            HandNetwork::Joints(_) => Self::Joints(Box::new(JointDecoder::new(config)?)),
        })
    }
}

enum Backend {
    Compiled(Box<Compiled>),
    Burn { network: Box<HandNetwork>, device: Device },
}

impl NetworkPredictor {
    /// Predicts with `network` of an experiment, which must live on `device`.
    ///
    /// # Errors
    /// If the hand model that crops are found with cannot be read.
    pub fn new(
        config: &HandConfig,
        network: HandNetwork,
        device: Device,
    ) -> Result<Self, TaskError> {
        if device == Device::flex() {
            return Self::compiled(config, &network, Precision::F32, None);
        }
        Self::with_burn(config, network, device)
    }

    /// Predicts with our engine in `precision`; int8 needs the calibrated ranges of the layers, see
    /// [`QuantizationRanges`](crate::QuantizationRanges).
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn compiled(
        config: &HandConfig,
        network: &HandNetwork,
        precision: Precision,
        ranges: Option<CalibrationRanges>,
    ) -> Result<Self, TaskError> {
        let compiled = Compiled::new(network.graph(), precision, ranges);
        let decoder = PoseDecoder::new(config, network)?;
        let two_pass = TwoPass::new(config)?;
        let backend = Backend::Compiled(Box::new(compiled));
        Ok(Self { backend, decoder, two_pass, in_whole_view: None })
    }

    /// Predicts with Burn's own arithmetic on every device.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_burn(
        config: &HandConfig,
        network: HandNetwork,
        device: Device,
    ) -> Result<Self, TaskError> {
        let decoder = PoseDecoder::new(config, &network)?;
        let two_pass = TwoPass::new(config)?;
        let backend = Backend::Burn { network: Box::new(network), device };
        Ok(Self { backend, decoder, two_pass, in_whole_view: None })
    }

    /// The network's poses in the view of images of one size, which show `crops` of it.
    fn infer(
        &mut self,
        inputs: &[f32],
        (height, width): (usize, usize),
        crops: &[PerspectiveCrop],
        two_pass: Option<&TwoPass>,
    ) -> Result<Vec<HandPose>, TaskError> {
        let values = match &mut self.backend {
            Backend::Compiled(compiled) => compiled.values(inputs, [2, height, width])?,
            Backend::Burn { network, device } => {
                let shape = [inputs.len() / (2 * height * width), 2, height, width];
                let data = TensorData::new(inputs.to_vec(), shape);
                let output = network.forward(Tensor::<4>::from_data(data, &*device));
                output.into_data().iter().collect()
            }
        };
        // Poses of hands have no score, so that nothing else would reveal a diverged network.
        if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            return Err(TaskError::NotFinite { value: *value });
        }
        Ok(match &self.decoder {
            PoseDecoder::Regression(rotation) => {
                let poses = rotation.poses(&values);
                let Some(two_pass) = two_pass else {
                    return Ok(poses.into_iter().map(HandPose::from).collect());
                };
                let in_view = |(pose, crop): (&HandParams, &PerspectiveCrop)| {
                    crop.view_from_crop(two_pass.camera(), pose).into()
                };
                poses.iter().zip(crops).map(in_view).collect()
            }
            PoseDecoder::Joints(decoder) => {
                let size = SensorSize { width: width as u16, height: height as u16 };
                let rows = values.par_chunks_exact((values.len() / crops.len().max(1)).max(1));
                rows.zip(crops).map(|(row, crop)| decoder.pose(row, size, crop)).collect()
            }
        })
    }

    /// The network's own inputs for those of [`Predictor::predict`]: of two passes, those of the first.
    pub fn first_inputs(&self, inputs: &[f32]) -> Vec<f32> {
        let Some(two_pass) = &self.two_pass else { return inputs.to_vec() };
        let count = inputs.len() / (2 * two_pass.view_size().pixels());
        crops(two_pass, inputs, &vec![PerspectiveCrop::WHOLE; count])
    }

    /// For each window, the hand of the last whole view that was looked at: its own, if the one before is older than
    /// the config allows.
    fn hands_of_views(
        &mut self,
        two_pass: &TwoPass,
        times: &[Micros],
        inputs: &[f32],
    ) -> Result<Vec<HandPose>, TaskError> {
        let mut last = self.in_whole_view.map(|(t, _)| t);
        let is_old = |t: Micros, last: Micros| !(last..last + two_pass.view_every()).contains(&t);
        let is_due: Vec<bool> = times
            .iter()
            .map(|&t| {
                let is_due = last.is_none_or(|last| is_old(t, last));
                last = last.filter(|_| !is_due).or(Some(t));
                is_due
            })
            .collect();
        let views = inputs.chunks_exact(2 * two_pass.view_size().pixels());
        let views: Vec<&[f32]> =
            views.zip(&is_due).filter(|(_, is_due)| **is_due).map(|(view, _)| view).collect();
        let whole = vec![PerspectiveCrop::WHOLE; views.len()];
        let mut hands = self.infer_crops(two_pass, &views.concat(), &whole)?.into_iter();
        let of_windows = times.iter().zip(is_due).filter_map(|(&t, is_due)| {
            if is_due {
                self.in_whole_view = hands.next().map(|hand| (t, hand));
            }
            self.in_whole_view.map(|(_, hand)| hand)
        });
        Ok(of_windows.collect())
    }

    /// The poses of `crops`, one of each of the views in `inputs`, in those views.
    fn infer_crops(
        &mut self,
        two_pass: &TwoPass,
        inputs: &[f32],
        each: &[PerspectiveCrop],
    ) -> Result<Vec<HandPose>, TaskError> {
        let size = two_pass.size();
        let seen = crops(two_pass, inputs, each);
        self.infer(&seen, (size.height.into(), size.width.into()), each, Some(two_pass))
    }
}

impl Predictor for NetworkPredictor {
    fn predict(
        &mut self,
        inputs: &[f32],
        image_size: (usize, usize),
    ) -> Result<Vec<HandPose>, TaskError> {
        // Windows of no recording: all whole views are looked at.
        let apart = |k: usize| Micros(k as i64 * TwoPass::MAX_VIEW_EVERY_US);
        let times: Vec<Micros> =
            (0..inputs.len() / (2 * image_size.0 * image_size.1)).map(apart).collect();
        self.in_whole_view = None;
        let poses = self.follow(&times, inputs, image_size);
        // Nor are their hands those of a recording that comes later.
        self.in_whole_view = None;
        poses
    }

    fn follow(
        &mut self,
        times: &[Micros],
        inputs: &[f32],
        image_size: (usize, usize),
    ) -> Result<Vec<HandPose>, TaskError> {
        // Taken out while the network runs, which borrows the predictor as a whole.
        let Some(mut two_pass) = self.two_pass.take() else {
            let whole = vec![PerspectiveCrop::WHOLE; times.len()];
            return self.infer(inputs, image_size, &whole, None);
        };
        // Cameras of many pixels have a finer view.
        let (height, width) = (image_size.0 as u16, image_size.1 as u16);
        two_pass.set_view_size(SensorSize { width, height });
        let mut poses = self.hands_of_views(&two_pass, times, inputs);
        for _ in 0..two_pass.crops() {
            poses = poses.and_then(|before| {
                let about: Vec<PerspectiveCrop> =
                    before.iter().map(|pose| two_pass.about(pose)).collect();
                self.infer_crops(&two_pass, inputs, &about)
            });
        }
        self.two_pass = Some(two_pass);
        poses
    }
}

/// The images of `crops`, one of each of the views in `inputs`.
fn crops(two_pass: &TwoPass, inputs: &[f32], each: &[PerspectiveCrop]) -> Vec<f32> {
    let image = 2 * two_pass.size().pixels();
    let mut seen = vec![0.0; image * each.len()];
    let views = inputs.par_chunks_exact(2 * two_pass.view_size().pixels());
    seen.par_chunks_exact_mut(image)
        .zip(views)
        .zip(each)
        .for_each(|((out, view), crop)| two_pass.fill(crop, view, out));
    seen
}

/// A network compiled for images of one size.
struct Compiled {
    graph: Graph,
    precision: Precision,
    ranges: Option<CalibrationRanges>,
    shape: [usize; 3],
    /// An engine with all threads, for single windows.
    single: Option<Engine>,
    /// An engine of one thread for each thread, for batches.
    parallel: Vec<Engine>,
}

impl Compiled {
    fn new(graph: Graph, precision: Precision, ranges: Option<CalibrationRanges>) -> Self {
        Self { graph, precision, ranges, shape: [0; 3], single: None, parallel: Vec::new() }
    }

    /// The outputs for windows of a shape, one after another; the same bits on any number of
    /// threads.
    fn values(&mut self, windows: &[f32], shape: [usize; 3]) -> Result<Vec<f32>, TaskError> {
        // An engine is compiled for images of one size.
        if shape != self.shape {
            (self.shape, self.single) = (shape, None);
            self.parallel.clear();
        }
        let size: usize = shape.iter().product();
        let threads = rayon::current_num_threads();
        let compile = |threads| {
            let options = EngineOptions::default();
            let options = options.with_threads(threads).with_precision(self.precision);
            let ranges = self.ranges.as_ref();
            Engine::compile_with(&self.graph, shape, options, ranges).map_err(TaskError::from)
        };
        // A window alone is split over the threads; of several, each thread computes whole ones and waits for
        // no other.
        if windows.len() == size {
            let engine = match self.single.take() {
                Some(engine) => engine,
                None => compile(threads)?,
            };
            return Ok(self.single.insert(engine).run(windows).concat());
        }
        let count = windows.len() / size;
        let parts = threads.clamp(1, count.max(1));
        while self.parallel.len() < parts {
            let engine = match self.parallel.first() {
                Some(engine) => engine.another(),
                None => compile(1)?,
            };
            self.parallel.push(engine);
        }
        let part = count.div_ceil(parts).max(1) * size;
        let values: Vec<Vec<f32>> = self
            .parallel
            .par_iter_mut()
            .zip(windows.par_chunks(part))
            .map(|(engine, windows)| {
                windows.chunks(size).flat_map(|window| engine.run(window).concat()).collect()
            })
            .collect();
        Ok(values.concat())
    }
}

/// A constant pose, the baseline of evaluations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstantPose(pub HandParams);

impl Predictor for ConstantPose {
    fn predict(
        &mut self,
        inputs: &[f32],
        (height, width): (usize, usize),
    ) -> Result<Vec<HandPose>, TaskError> {
        Ok(vec![self.0.into(); inputs.len() / (2 * height * width)])
    }
}
