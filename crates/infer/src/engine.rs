//! A network that is ready to run.

use std::sync::Arc;
use std::time::{Duration, Instant};

use evpose_kernels::Level;
use evpose_kernels::blocked::{Image, Scratch, Team};
use evpose_nn::graph::{Graph, Node, Operation};

use crate::InferError;
use crate::fuse::{Fused, fused};
use crate::memory::{Memory, Slot};
use crate::shapes::{Shape, shapes};
use crate::step::{Place, Step};

/// How a network is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct EngineOptions {
    /// Threads, the caller's among them.
    pub threads: usize,
    /// The instructions to use.
    pub level: Level,
}

impl Default for EngineOptions {
    /// One thread, the best instructions there are.
    fn default() -> Self {
        Self { threads: 1, level: Level::best() }
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
    pub products: u64,
}

/// A compiled network with the memory and the threads that it runs with.
pub struct Engine {
    team: Team,
    level: Level,
    steps: Arc<[Planned]>,
    layers: Arc<[Layer]>,
    images: Vec<Image>,
    scratch: Scratch,
    input: Slot,
    outputs: Vec<Slot>,
    values: Vec<Vec<f32>>,
}

/// A step, and where its images are.
struct Planned {
    step: Step,
    inputs: Vec<Slot>,
    output: Slot,
}

impl Engine {
    /// Compiles a network for images of `input` channels, rows and columns.
    ///
    /// # Errors
    /// [`InferError::Unsupported`] for a layer that there is no kernel for, [`InferError::Shape`] for
    /// images that a layer cannot take, [`InferError::Level`] for instructions that the processor does
    /// not have.
    pub fn compile(
        graph: &Graph,
        input: [usize; 3],
        options: EngineOptions,
    ) -> Result<Self, InferError> {
        let EngineOptions { threads, level } = options;
        if !Level::available().contains(&level) {
            return Err(InferError::Level { level: level.to_string() });
        }
        let shapes = shapes(graph, input)?;
        let work = work(graph, &shapes, level)?;
        let plan = plan(graph, &shapes, work);
        let blank = |id: &usize| vec![0.0; shapes[*id].iter().product()];
        let values = graph.outputs.iter().map(blank).collect();
        Ok(Self {
            team: Team::new(threads),
            level,
            images: plan.memory.images(),
            steps: plan.steps.into(),
            layers: plan.layers.into(),
            scratch: Scratch::default(),
            input: plan.input,
            outputs: plan.outputs,
            values,
        })
    }

    /// Another that runs beside this one, with memory and threads of its own and the same weights.
    #[must_use]
    pub fn another(&self) -> Self {
        Self {
            team: Team::new(self.team.threads()),
            level: self.level,
            steps: Arc::clone(&self.steps),
            layers: Arc::clone(&self.layers),
            images: self.images.clone(),
            scratch: Scratch::default(),
            input: self.input,
            outputs: self.outputs.clone(),
            values: self.values.clone(),
        }
    }

    /// What the network says of an image `[channels][height][width]`: each of its outputs in the same
    /// order, in the order of [`Graph::outputs`].
    ///
    /// # Panics
    /// If the image has another size than it was compiled for.
    pub fn run(&mut self, input: &[f32]) -> &[Vec<f32>] {
        self.images[self.input].read_planes(input);
        for step in 0..self.steps.len() {
            self.step(step);
        }
        for (output, values) in self.outputs.iter().zip(&mut self.values) {
            self.images[*output].write_planes(values);
        }
        &self.values
    }

    /// As [`run`](Self::run), with the time that each layer took. Times are of one run: take many.
    ///
    /// # Panics
    /// If the image has another size than it was compiled for.
    pub fn run_timed(&mut self, input: &[f32]) -> Vec<Duration> {
        self.images[self.input].read_planes(input);
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
        self.team.threads()
    }

    /// Bytes of all images on their way.
    pub fn image_bytes(&self) -> usize {
        self.images.iter().map(Image::bytes).sum()
    }

    fn step(&mut self, step: usize) {
        let Planned { step, inputs, output } = &self.steps[step];
        // The output is never one of the inputs.
        let blank = Image::zeros(0, 0, 0, 0);
        let mut image = std::mem::replace(&mut self.images[*output], blank);
        let inputs: Vec<&Image> = inputs.iter().map(|slot| &self.images[*slot]).collect();
        step.run(Place {
            team: &self.team,
            level: self.level,
            inputs: &inputs,
            output: &mut image,
            scratch: &mut self.scratch,
        });
        self.images[*output] = image;
    }
}

/// A step of a node, and which nodes it takes.
type Work = Option<(Step, Vec<usize>)>;

/// What is done at every node; nothing where another does it.
fn work(graph: &Graph, shapes: &[Shape], level: Level) -> Result<Vec<Work>, InferError> {
    let of = |(id, fused): (usize, Fused)| {
        let node = &graph.nodes[id];
        Ok(match fused {
            Fused::Elsewhere => None,
            Fused::Whole if node.operation == Operation::Input => None,
            Fused::Whole => Some((Step::of(node, level)?, node.inputs.clone())),
            Fused::Sum { of, activation } => Some((Step::Sum(activation), of.to_vec())),
            Fused::Conv { conv, residual, activation } => {
                let Node { name, operation, inputs, .. } = &graph.nodes[conv];
                let Operation::Conv(layer) = operation else { return Ok(None) };
                let has_residual = residual.is_some();
                let step = Step::conv(name, layer, shapes[id], has_residual, activation, level)?;
                Some((step, inputs.iter().copied().chain(residual).collect()))
            }
        })
    };
    fused(graph).into_iter().enumerate().map(of).collect()
}

struct Plan {
    steps: Vec<Planned>,
    layers: Vec<Layer>,
    memory: Memory,
    input: Slot,
    outputs: Vec<Slot>,
}

/// Gives every image its memory, which others have before and after it.
fn plan(graph: &Graph, shapes: &[Shape], work: Vec<Work>) -> Plan {
    let count = graph.nodes.len();
    let (mut borders, mut last) = (vec![0; count], (0..count).collect::<Vec<_>>());
    for (id, (step, inputs)) in
        work.iter().enumerate().filter_map(|(id, work)| work.as_ref().map(|work| (id, work)))
    {
        borders[inputs[0]] = borders[inputs[0]].max(step.border());
        inputs.iter().for_each(|input| last[*input] = last[*input].max(id));
    }
    graph.outputs.iter().for_each(|output| last[*output] = count);
    let mut memory = Memory::default();
    let mut slots = vec![0; count];
    slots[0] = memory.take(shapes[0], borders[0]);
    // The input is written before every run.
    last[0] = count;
    let (mut steps, mut layers) = (Vec::new(), Vec::new());
    for (id, work) in work.into_iter().enumerate() {
        let Some((step, inputs)) = work else { continue };
        slots[id] = memory.take(shapes[id], borders[id]);
        layers.push(layer(graph, id, &step, &inputs, shapes));
        let output = slots[id];
        steps.push(Planned { step, inputs: inputs.iter().map(|id| slots[*id]).collect(), output });
        let mut done: Vec<usize> = inputs.into_iter().filter(|input| last[*input] == id).collect();
        done.dedup();
        done.into_iter().for_each(|input| memory.give(slots[input]));
    }
    let outputs = graph.outputs.iter().map(|output| slots[*output]).collect();
    Plan { steps, layers, memory, input: slots[0], outputs }
}

fn layer(graph: &Graph, id: usize, step: &Step, inputs: &[usize], shapes: &[Shape]) -> Layer {
    let output = shapes[id];
    // A convolution that took up what came behind it keeps its name.
    let named = (0..=id).rev().map(|id| &graph.nodes[id]).find(|node| {
        let is_conv = matches!(step, Step::Conv(..) | Step::Winograd(..) | Step::Depthwise(..));
        !is_conv
            || node.inputs.first() == inputs.first()
                && matches!(node.operation, Operation::Conv(_) | Operation::Linear(_))
    });
    let node = named.unwrap_or(&graph.nodes[id]);
    let pixels = (output[1] * output[2]) as u64;
    let products = match &node.operation {
        Operation::Conv(conv) => conv.weight.len() as u64 * pixels,
        Operation::Linear(linear) => linear.weight.len() as u64,
        _ => 0,
    };
    Layer { name: node.name.clone(), algorithm: step.algorithm(), output, products }
}
