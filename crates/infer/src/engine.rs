//! A network that is ready to run.

use std::sync::Arc;
use std::time::{Duration, Instant};

use evpose_kernels::Level;
use evpose_kernels::blocked::{Scratch, ThreadPool, read_planes, write_planes};
use evpose_nn::graph::{Graph, NodeId};

use crate::InferError;
use crate::held::Buffer;
use crate::memory::Slot;
use crate::plan::{Planned, Planner};
use crate::precision::{CalibrationRanges, Precision};
use crate::step::{Place, Step};

/// How a network is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct EngineOptions {
    /// Threads, the caller's among them.
    pub threads: usize,
    /// The instructions to use.
    pub level: Level,
    /// How images and weights are kept.
    pub precision: Precision,
    /// Whether every layer is done by itself, and its values are there afterwards:
    /// [`Engine::observe`] needs that, and a table of layers may. It takes longer.
    pub is_layer_by_layer: bool,
}

impl Default for EngineOptions {
    /// One thread, the best instructions there are, 32 bits, layers together where that is faster.
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
    /// With so many threads.
    pub fn with_threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }

    /// With these instructions.
    pub fn with_level(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// With images and weights kept so.
    pub fn with_precision(self, precision: Precision) -> Self {
        Self { precision, ..self }
    }

    /// With every layer by itself.
    pub fn layer_by_layer(self) -> Self {
        Self { is_layer_by_layer: true, ..self }
    }
}

/// A layer of a plan, and what it takes.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Its path in the network, or what it does.
    pub name: String,
    /// How it is done.
    pub algorithm: &'static str,
    /// Channels, rows and columns of the output.
    pub output: [usize; 3],
    /// Products of the layer as defined, whatever the algorithm needs.
    pub macs: u64,
}

/// A compiled network with the memory and the threads that it runs with.
pub struct Engine {
    thread_pool: ThreadPool,
    level: Level,
    steps: Arc<[Planned]>,
    layers: Arc<[Layer]>,
    images: Vec<Buffer>,
    scratch: Scratch,
    input: (Slot, [f32; 2]),
    /// The node whose values these are.
    first: NodeId,
    outputs: Vec<Slot>,
    values: Vec<Vec<f32>>,
}

impl Engine {
    /// Compiles a network for images of `input` channels, rows and columns.
    ///
    /// # Errors
    /// [`InferError::Unsupported`] for a layer that there is no kernel for, [`InferError::Shape`]
    /// for images that a layer cannot take, [`InferError::Level`] for instructions that the
    /// processor does not have, [`InferError::NotCalibrated`] for 8 bits, which need
    /// [`compile_with`](Self::compile_with).
    pub fn compile(
        graph: &Graph,
        input: [usize; 3],
        options: EngineOptions,
    ) -> Result<Self, InferError> {
        Self::compile_with(graph, input, options, None)
    }

    /// As [`compile`](Self::compile), with what is known of the values that layers make.
    ///
    /// # Errors
    /// As there; [`InferError::NotCalibrated`] if nothing is known of a layer, or of another
    /// network.
    pub fn compile_with(
        graph: &Graph,
        input: [usize; 3],
        options: EngineOptions,
        ranges: Option<&CalibrationRanges>,
    ) -> Result<Self, InferError> {
        let EngineOptions { threads, level, precision, is_layer_by_layer } = options;
        if !Level::available().contains(&level) {
            return Err(InferError::Level { level: level.to_string() });
        }
        if let Some(ranges) = ranges {
            ranges.check(graph)?;
        }
        let mut planner = Planner::new(graph, input, level, precision, ranges)?;
        if !is_layer_by_layer {
            planner.chain();
        }
        let plan = planner.placed();
        let mut images = plan.memory.buffers();
        if let Some(planes) = plan.planes {
            images[plan.input.0] = Buffer::Planes(planes);
        }
        let blank = |slot: &Slot| {
            let size: usize = images[*slot].held().size().iter().product();
            vec![0.0; size]
        };
        let values = plan.outputs.iter().map(blank).collect();
        Ok(Self {
            thread_pool: ThreadPool::new(threads),
            level,
            images,
            steps: plan.steps.into(),
            layers: plan.layers.into(),
            scratch: Scratch::default(),
            input: plan.input,
            first: plan.first,
            outputs: plan.outputs,
            values,
        })
    }

    /// Another that runs beside this one, with memory and threads of its own and the same weights.
    #[must_use]
    pub fn another(&self) -> Self {
        Self {
            thread_pool: ThreadPool::new(self.thread_pool.threads()),
            level: self.level,
            steps: Arc::clone(&self.steps),
            layers: Arc::clone(&self.layers),
            images: self.images.clone(),
            scratch: Scratch::default(),
            input: self.input,
            first: self.first,
            outputs: self.outputs.clone(),
            values: self.values.clone(),
        }
    }

    /// What the network says of an image `[channels][height][width]`: each of its outputs in the
    /// same order, in the order of [`Graph::outputs`].
    ///
    /// # Panics
    /// If the image has another size than it was compiled for.
    pub fn run(&mut self, input: &[f32]) -> &[Vec<f32>] {
        self.read(input);
        for step in 0..self.steps.len() {
            self.step(step);
        }
        for (output, values) in self.outputs.iter().zip(&mut self.values) {
            write_planes(&self.thread_pool, self.images[*output].whole(), values);
        }
        &self.values
    }

    /// Runs an image and takes the values that layers make into `ranges`, which are of the same
    /// graph. Of an engine of 32 bits that [has every layer](EngineOptions::is_layer_by_layer).
    ///
    /// # Panics
    /// If the image has another size than it was compiled for, values are kept in fewer bits, or
    /// layers are done together.
    pub fn observe(&mut self, input: &[f32], ranges: &mut CalibrationRanges) {
        self.read(input);
        let ends = self.images[self.input.0].extremes();
        ranges.observe(self.first, ends);
        for step in 0..self.steps.len() {
            self.step(step);
            let Planned { node, output, step, .. } = &self.steps[step];
            assert!(!matches!(step, Step::Chain(_)), "an engine that has every layer");
            ranges.observe(*node, self.images[*output].extremes());
        }
    }

    /// As [`run`](Self::run), with the time that each layer took. Times are of one run: take many.
    ///
    /// # Panics
    /// If the image has another size than it was compiled for.
    pub fn run_timed(&mut self, input: &[f32]) -> Vec<Duration> {
        self.read(input);
        let count = self.steps.len();
        let timed = |step| {
            let begin = Instant::now();
            self.step(step);
            begin.elapsed()
        };
        (0..count).map(timed).collect()
    }

    /// The layers, in the order in which they run.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Threads that it runs with.
    pub fn threads(&self) -> usize {
        self.thread_pool.threads()
    }

    /// Bytes of all images on their way.
    pub fn image_bytes(&self) -> usize {
        self.images.iter().map(Buffer::bytes).sum()
    }

    fn read(&mut self, input: &[f32]) {
        let (slot, by) = self.input;
        match &mut self.images[slot] {
            Buffer::Planes(planes) => planes.read(&self.thread_pool, self.level, input, by),
            image => read_planes(&self.thread_pool, self.level, input, by, image.held_mut()),
        }
    }

    fn step(&mut self, step: usize) {
        let Planned { step, inputs, output, kept, .. } = &self.steps[step];
        // The output is never one of the inputs.
        let blank = Buffer::zeros([0; 3], 0, None);
        let mut image = std::mem::replace(&mut self.images[*output], blank);
        if let (Buffer::Packed(image), Some(storage)) = (&mut image, kept) {
            image.keep_as(*storage);
        }
        let inputs: Vec<&Buffer> = inputs.iter().map(|slot| &self.images[*slot]).collect();
        step.run(Place {
            thread_pool: &self.thread_pool,
            level: self.level,
            inputs: &inputs,
            output: &mut image,
            scratch: &mut self.scratch,
        });
        self.images[*output] = image;
    }
}
