//! Compiled networks.

use std::sync::Arc;
use std::time::{Duration, Instant};

use evpose_kernels::Level;
use evpose_kernels::blocked::{Scratch, ThreadPool, reorder_from_nchw, reorder_to_nchw};
use evpose_nn::graph::{Graph, NodeId};

use crate::InferError;
use crate::allocation::AllocatedStep;
use crate::buffer::{Buffer, StorageType};
use crate::layer::Layer;
use crate::memory::Slot;
use crate::plan::Planner;
use crate::precision::{CalibrationRanges, Precision};
use crate::step::{Step, StepContext};

/// Options of compiling a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct EngineOptions {
    /// Number of threads, the caller's included.
    pub threads: usize,
    /// Instruction set of the kernels.
    pub level: Level,
    /// Precision of weights and of the values between layers.
    pub precision: Precision,
    /// Whether every layer runs as a step of its own, not fused into a chain, so that its values
    /// are in a buffer afterwards. [`Engine::observe`] needs that; tables of times per layer may.
    /// It is slower.
    pub is_layer_by_layer: bool,
}

impl Default for EngineOptions {
    /// One thread, the best instruction set of this processor, f32, chains of fused layers.
    fn default() -> Self {
        Self {
            threads: 1,
            level: Level::best(),
            precision: Precision::F32,
            is_layer_by_layer: false,
        }
    }
}

impl EngineOptions {
    /// Sets the number of threads.
    pub fn with_threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }

    /// Sets the instruction set.
    pub fn with_level(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// Sets the precision.
    pub fn with_precision(self, precision: Precision) -> Self {
        Self { precision, ..self }
    }

    /// Disables chains: see [`is_layer_by_layer`](Self::is_layer_by_layer).
    pub fn layer_by_layer(self) -> Self {
        Self { is_layer_by_layer: true, ..self }
    }
}

/// A compiled network with its buffers and threads.
pub struct Engine {
    thread_pool: ThreadPool,
    level: Level,
    steps: Arc<[AllocatedStep]>,
    layers: Arc<[Layer]>,
    buffers: Vec<Buffer>,
    scratch: Scratch,
    input: (Slot, [f32; 2]),
    /// Node whose values are in the input buffer.
    first: NodeId,
    outputs: Vec<Slot>,
    values: Vec<Vec<f32>>,
}

impl Engine {
    /// Compiles a network for images of `input` channels, height and width.
    ///
    /// # Errors
    /// [`InferError::Unsupported`] for a layer without a kernel, [`InferError::Shape`] for a size
    /// that a layer cannot take, [`InferError::Level`] for an instruction set that the processor
    /// does not have, [`InferError::NotCalibrated`] for int8, which needs
    /// [`compile_with`](Self::compile_with).
    pub fn compile(
        graph: &Graph,
        input: [usize; 3],
        options: EngineOptions,
    ) -> Result<Self, InferError> {
        Self::compile_with(graph, input, options, None)
    }

    /// [`compile`](Self::compile) with the calibration ranges that int8 needs.
    ///
    /// # Errors
    /// As [`compile`](Self::compile); [`InferError::NotCalibrated`] if the range of a layer is
    /// missing, or the ranges are those of another network.
    pub fn compile_with(
        graph: &Graph,
        input: [usize; 3],
        options: EngineOptions,
        ranges: Option<&CalibrationRanges>,
    ) -> Result<Self, InferError> {
        let EngineOptions { threads, level, precision, is_layer_by_layer } = options;
        // A level that the processor lacks would end in an illegal instruction.
        if !Level::available().contains(&level) {
            return Err(InferError::Level { level: level.to_string() });
        }
        // Ranges of another network would quantise without any sign of it.
        if let Some(ranges) = ranges {
            ranges.check(graph)?;
        }
        let mut planner = Planner::new(graph, input, level, precision, ranges)?;
        if !is_layer_by_layer {
            planner.fuse_chains();
        }
        let plan = planner.allocated();
        let mut buffers = plan.memory.buffers();
        if let Some(image) = plan.nchw_input {
            buffers[plan.input.0] = Buffer::Nchw(image);
        }
        let blank = |slot: &Slot| {
            let size: usize = buffers[*slot].view().size().iter().product();
            vec![0.0; size]
        };
        let values = plan.outputs.iter().map(blank).collect();
        Ok(Self {
            thread_pool: ThreadPool::new(threads),
            level,
            buffers,
            steps: plan.steps.into(),
            layers: plan.layers.into(),
            scratch: Scratch::default(),
            input: plan.input,
            first: plan.first,
            outputs: plan.outputs,
            values,
        })
    }

    /// A second engine with buffers and threads of its own, which shares the weights.
    #[must_use]
    pub fn another(&self) -> Self {
        Self {
            thread_pool: ThreadPool::new(self.thread_pool.threads()),
            level: self.level,
            steps: Arc::clone(&self.steps),
            layers: Arc::clone(&self.layers),
            buffers: self.buffers.clone(),
            scratch: Scratch::default(),
            input: self.input,
            first: self.first,
            outputs: self.outputs.clone(),
            values: self.values.clone(),
        }
    }

    /// Runs the network on an image `[channels][height][width]` and returns its outputs, in the
    /// order of [`Graph::outputs`], each `[channels][height][width]`.
    ///
    /// # Panics
    /// If the image has another size than the network was compiled for.
    pub fn run(&mut self, input: &[f32]) -> &[Vec<f32>] {
        self.copy_input(input);
        for step in 0..self.steps.len() {
            self.run_step(step);
        }
        for (output, values) in self.outputs.iter().zip(&mut self.values) {
            reorder_to_nchw(&self.thread_pool, self.buffers[*output].f32(), values);
        }
        &self.values
    }

    /// Runs the network on an image and extends `ranges`, which are of the same graph, by the
    /// values of every layer (calibration). The engine must be f32 and [layer by
    /// layer](EngineOptions::is_layer_by_layer).
    ///
    /// # Panics
    /// If the image has another size than the network was compiled for, or the engine is not f32
    /// and layer by layer.
    pub fn observe(&mut self, input: &[f32], ranges: &mut CalibrationRanges) {
        self.copy_input(input);
        // The input is no step's output, but int8 needs its range as well.
        let range = self.buffers[self.input.0].min_max();
        ranges.observe(self.first, range);
        for step in 0..self.steps.len() {
            self.run_step(step);
            let AllocatedStep { node, output, step, .. } = &self.steps[step];
            assert!(!matches!(step, Step::Chain(_)), "an engine that runs layer by layer");
            ranges.observe(*node, self.buffers[*output].min_max());
        }
    }

    /// Runs the network on an image and returns the time of each layer. Times of a single run are
    /// noisy: repeat it.
    ///
    /// # Panics
    /// If the image has another size than the network was compiled for.
    pub fn run_timed(&mut self, input: &[f32]) -> Vec<Duration> {
        self.copy_input(input);
        let count = self.steps.len();
        let timed = |step| {
            let begin = Instant::now();
            self.run_step(step);
            begin.elapsed()
        };
        (0..count).map(timed).collect()
    }

    /// Layers in the order in which they run.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// The instruction set that the network was compiled for, such as `avx512`; `avx512 and amx`
    /// if tiles of AMX compute some of its layers.
    pub fn instructions(&self) -> String {
        let uses_amx = self.steps.iter().any(|step| step.step.uses_amx());
        let amx = if uses_amx { " and amx" } else { "" };
        format!("{}{amx}", self.level)
    }

    /// Number of threads, the caller's included.
    pub fn threads(&self) -> usize {
        self.thread_pool.threads()
    }

    /// Copies an image to the buffer of the input.
    fn copy_input(&mut self, input: &[f32]) {
        // An affine map of the input is applied while it is copied, which saves a pass over it.
        let (slot, affine) = self.input;
        match &mut self.buffers[slot] {
            Buffer::Nchw(image) => image.copy_from(&self.thread_pool, self.level, input, affine),
            buffer => {
                reorder_from_nchw(&self.thread_pool, self.level, input, affine, buffer.view_mut());
            }
        }
    }

    fn run_step(&mut self, step: usize) {
        let AllocatedStep { step, inputs, output, storage, .. } = &self.steps[step];
        // Taken out for the borrow checker; an output is never one of its inputs.
        let blank = Buffer::zeros([0; 3], 0, StorageType::F32);
        let mut image = std::mem::replace(&mut self.buffers[*output], blank);
        // Values of another element type may have been in this buffer before.
        if let (Buffer::LowPrecision(image), StorageType::LowPrecision(element_type)) =
            (&mut image, storage)
        {
            image.reinterpret_as(*element_type);
        }
        let inputs: Vec<&Buffer> = inputs.iter().map(|slot| &self.buffers[*slot]).collect();
        step.run(StepContext {
            thread_pool: &self.thread_pool,
            level: self.level,
            inputs: &inputs,
            output: &mut image,
            scratch: &mut self.scratch,
        });
        self.buffers[*output] = image;
    }
}
