//! From the nodes of a graph to the steps of a plan: what is done, in which bits, and where.

use evpose_kernels::Level;
use evpose_kernels::blocked::Planes;
use evpose_nn::graph::{Activation, Graph, NodeId, Operation};

use crate::InferError;
use crate::engine::Layer;
use crate::fuse::{Fused, fused};
use crate::held::Kept;
use crate::memory::{Memory, Slot};
use crate::precision::{CalibrationRanges, Precision};
use crate::shapes::{Shape, shapes};
use crate::step::Step;

/// A step, and where its images are.
pub(crate) struct Planned {
    pub(crate) step: Step,
    pub(crate) inputs: Vec<Slot>,
    pub(crate) output: Slot,
    pub(crate) kept: Kept,
    /// The node whose values it makes.
    pub(crate) node: NodeId,
}

/// Steps in order, and the memory for their images.
pub(crate) struct Plan {
    pub(crate) steps: Vec<Planned>,
    pub(crate) layers: Vec<Layer>,
    pub(crate) memory: Memory,
    /// Where the image that the network is shown goes, and by what its values are multiplied and
    /// what is added on their way there.
    pub(crate) input: (Slot, [f32; 2]),
    /// The node whose values these are.
    pub(crate) first: NodeId,
    pub(crate) outputs: Vec<Slot>,
    /// That image, where it is taken in planes.
    pub(crate) planes: Option<Planes>,
}

/// An image on its way.
pub(crate) struct Value {
    pub(crate) node: NodeId,
    pub(crate) kept: Kept,
    /// Whether it is not in blocks of channels, as only what the network is shown can be.
    is_planes: bool,
    border: usize,
    /// The operation after which nobody needs it.
    last: usize,
}

/// A step, and which images it takes and makes.
pub(crate) struct Work {
    pub(crate) step: Step,
    pub(crate) inputs: Vec<usize>,
    pub(crate) output: usize,
    pub(crate) layer: Layer,
}

/// What is being planned.
pub(crate) struct Planner<'a> {
    pub(crate) graph: &'a Graph,
    pub(crate) shapes: Vec<Shape>,
    pub(crate) level: Level,
    precision: Precision,
    ranges: Option<&'a CalibrationRanges>,
    fused: Vec<Fused>,
    pub(crate) values: Vec<Value>,
    /// The values of every node, as kept by whoever made them and as others needed them.
    of_node: Vec<Vec<usize>>,
    pub(crate) work: Vec<Work>,
    /// The node at which the image that the network is shown is as its layers want it.
    first: NodeId,
}

impl<'a> Planner<'a> {
    /// Plans a network for images of `input` channels, rows and columns, layer by layer.
    ///
    /// # Errors
    /// Those of [`Engine::compile`](crate::Engine::compile).
    pub(crate) fn new(
        graph: &'a Graph,
        input: Shape,
        level: Level,
        precision: Precision,
        ranges: Option<&'a CalibrationRanges>,
    ) -> Result<Self, InferError> {
        let mut planner = Self {
            graph,
            shapes: shapes(graph, input)?,
            level,
            precision,
            ranges,
            fused: fused(graph),
            values: Vec::new(),
            of_node: vec![Vec::new(); graph.nodes.len()],
            work: Vec::new(),
            first: 0,
        };
        planner.first = planner.input();
        for id in 0..graph.nodes.len() {
            planner.node(id, planner.first)?;
        }
        Ok(planner)
    }

    /// The node at which the image that the network is shown is as its layers want it: the input,
    /// or a factor and an offset behind it that nobody else sees past.
    fn input(&self) -> NodeId {
        let nodes = self.graph.nodes.iter().enumerate();
        let users: Vec<_> = nodes.filter(|(_, node)| node.inputs.contains(&0)).collect();
        match users.as_slice() {
            [(id, node)]
                if matches!(node.operation, Operation::Affine { .. })
                    && !self.graph.outputs.contains(&0) =>
            {
                *id
            }
            _ => 0,
        }
    }

    /// Adds what is done at a node, if anything is.
    fn node(&mut self, id: NodeId, first: NodeId) -> Result<(), InferError> {
        if id == first {
            let is_planes = self.of_planes(id).is_some();
            let kept = if is_planes { None } else { self.kept(id)? };
            let value = self.value(id, kept);
            self.values[value].is_planes = is_planes;
            debug_assert_eq!(value, 0, "the input comes first");
            return Ok(());
        }
        if id < first {
            return Ok(());
        }
        let node = &self.graph.nodes[id];
        let (step, inputs) = match self.fused[id].clone() {
            Fused::Elsewhere => return Ok(()),
            Fused::Whole => self.whole(id)?,
            Fused::Sum { of, activation } => {
                let held = of.map(|id| self.any(id));
                let is_whole = held.iter().all(|value| self.values[*value].kept.is_none());
                let is_packed = !is_whole || self.kept(id)?.is_some();
                let step =
                    if is_packed { Step::PackedSum(activation) } else { Step::Sum(activation) };
                (step, held.to_vec())
            }
            Fused::Conv { conv, residual, activation } => {
                self.conv(id, conv, residual, activation)?
            }
        };
        let kept = match &step {
            // These keep images as they get them.
            Step::PackedMaxPool(_) | Step::PackedUpsample => self.values[inputs[0]].kept,
            step if step.writes_packed() => self.kept(id)?,
            _ => None,
        };
        debug_assert!(!node.name.is_empty(), "layers have names");
        let output = self.value(id, kept);
        self.push(step, inputs, output);
        Ok(())
    }

    /// The step of the only layer that takes the image that the network is shown, at `first`, in
    /// planes.
    fn of_planes(&self, first: NodeId) -> Option<Step> {
        let mut users =
            self.graph.nodes.iter().enumerate().filter(|(_, n)| n.inputs.contains(&first));
        let (Some((id, node)), None) = (users.next(), users.next()) else { return None };
        let end = self.fused.iter().find_map(|fused| match fused {
            Fused::Conv { conv, residual: None, activation } if *conv == id => Some(*activation),
            _ => None,
        });
        match &node.operation {
            Operation::Conv(conv) if !self.graph.outputs.contains(&first) => {
                Step::of_planes(conv, end?, self.level, self.precision == Precision::F32)
            }
            _ => None,
        }
    }

    fn push(&mut self, step: Step, inputs: Vec<usize>, output: usize) {
        let border = &mut self.values[inputs[0]].border;
        *border = (*border).max(step.border());
        let layer = self.layer(&step, &inputs, output);
        self.work.push(Work { step, inputs, output, layer });
    }

    fn value(&mut self, node: NodeId, kept: Kept) -> usize {
        self.values.push(Value { node, kept, is_planes: false, border: 0, last: 0 });
        self.of_node[node].push(self.values.len() - 1);
        self.values.len() - 1
    }

    /// How the values of a node should be kept.
    fn kept(&self, id: NodeId) -> Result<Kept, InferError> {
        let [_, height, width] = self.shapes[id];
        if height * width == 1 || self.graph.outputs.contains(&id) || !self.is_taken_packed(id) {
            return Ok(None);
        }
        self.storage(id)
    }

    /// How the values of a node are kept in fewer bits.
    fn storage(&self, id: NodeId) -> Result<Kept, InferError> {
        match (self.precision, self.ranges) {
            (Precision::F32, _) => Ok(None),
            (Precision::Bf16, _) => Ok(Some(evpose_kernels::blocked::Storage::Bf16)),
            (Precision::Int8, Some(ranges)) => Ok(Some(ranges.storage(id)?)),
            (Precision::Int8, None) => {
                Err(InferError::NotCalibrated { layer: self.graph.nodes[id].name.clone() })
            }
        }
    }

    /// Whether somebody takes the values of a node in fewer bits.
    fn is_taken_packed(&self, id: NodeId) -> bool {
        let takes = |(user, fused): (usize, &Fused)| match fused {
            Fused::Elsewhere => false,
            Fused::Whole => {
                let node = &self.graph.nodes[user];
                let may = matches!(
                    node.operation,
                    Operation::MaxPool { .. } | Operation::Upsample | Operation::Relu
                );
                may && node.inputs.contains(&id)
            }
            Fused::Sum { of, .. } => of.contains(&id),
            Fused::Conv { conv, .. } => self.graph.nodes[*conv].inputs.contains(&id),
        };
        self.fused.iter().enumerate().any(takes)
    }

    /// The values of a node, however they are kept.
    fn any(&self, id: NodeId) -> usize {
        self.of_node[id][0]
    }

    /// The values of a node in 32 bits, or in fewer.
    fn held(&mut self, id: NodeId, is_packed: bool) -> Result<usize, InferError> {
        let fits = |value: &&usize| self.values[**value].kept.is_some() == is_packed;
        if let Some(value) = self.of_node[id].iter().find(fits) {
            return Ok(*value);
        }
        let from = self.any(id);
        let kept = if is_packed { self.storage(id)? } else { None };
        let value = self.value(id, kept);
        self.push(Step::PackedSum(Activation::Identity), vec![from], value);
        Ok(value)
    }

    /// The step of a node that is done as it stands.
    fn whole(&mut self, id: NodeId) -> Result<(Step, Vec<usize>), InferError> {
        let node = &self.graph.nodes[id];
        let step = Step::of(node, self.level)?;
        let first = self.any(node.inputs[0]);
        let is_packed = self.values[first].kept.is_some();
        let step = match step {
            Step::MaxPool(pool) if is_packed => Step::PackedMaxPool(pool),
            Step::Upsample if is_packed => Step::PackedUpsample,
            Step::Sum(activation) if is_packed => Step::PackedSum(activation),
            step => {
                let inputs: Result<Vec<usize>, _> =
                    node.inputs.iter().map(|input| self.held(*input, false)).collect();
                return Ok((step, inputs?));
            }
        };
        // What is asked for is told in 32 bits, which only sums write.
        if self.graph.outputs.contains(&id) && !matches!(step, Step::PackedSum(_)) {
            let step = Step::of(node, self.level)?;
            return Ok((step, vec![self.held(node.inputs[0], false)?]));
        }
        Ok((step, vec![first]))
    }

    /// The step of a convolution and what came behind it.
    fn conv(
        &mut self,
        id: NodeId,
        conv: NodeId,
        residual: Option<NodeId>,
        activation: Activation,
    ) -> Result<(Step, Vec<usize>), InferError> {
        let node = &self.graph.nodes[conv];
        let Operation::Conv(layer) = &node.operation else {
            unreachable!("only convolutions take up others")
        };
        if self.values[self.any(node.inputs[0])].is_planes {
            let step = self.of_planes(node.inputs[0]);
            let step = step.unwrap_or_else(|| unreachable!("planes are for this layer"));
            return Ok((step, vec![self.any(node.inputs[0])]));
        }
        let [_, height, width] = self.shapes[id];
        let is_packed = self.precision != Precision::F32 && height * width > 1;
        let input = self.held(node.inputs[0], is_packed)?;
        let kept = self.values[input].kept;
        let step = Step::conv(
            &node.name,
            layer,
            self.shapes[id],
            residual.is_some(),
            activation,
            self.level,
            kept,
        )?;
        let residual = match residual {
            Some(id) if is_packed => Some(self.any(id)),
            Some(id) => Some(self.held(id, false)?),
            None => None,
        };
        Ok((step, [input].into_iter().chain(residual).collect()))
    }

    /// Gives every image its memory, which others have before and after it.
    pub(crate) fn placed(mut self) -> Plan {
        let (first, end) = (self.first, self.work.len());
        for (now, Work { inputs, output, .. }) in self.work.iter().enumerate() {
            inputs.iter().chain([output]).for_each(|value| self.values[*value].last = now);
        }
        // The input is written before every run.
        self.values[0].last = end;
        let of_outputs: Vec<usize> = self.graph.outputs.iter().map(|id| self.any(*id)).collect();
        of_outputs.iter().for_each(|value| self.values[*value].last = end);
        let mut memory = Memory::default();
        let mut slots = vec![0; self.values.len()];
        let take = |memory: &mut Memory, value: &Value| {
            memory.take(self.shapes[value.node], value.border, value.kept)
        };
        slots[0] = take(&mut memory, &self.values[0]);
        let (mut steps, mut layers) = (Vec::new(), Vec::new());
        for (now, Work { step, inputs, output, layer }) in self.work.into_iter().enumerate() {
            let Value { node, kept, .. } = self.values[output];
            slots[output] = take(&mut memory, &self.values[output]);
            layers.push(layer);
            let of_inputs = inputs.iter().map(|input| slots[*input]).collect();
            steps.push(Planned { step, inputs: of_inputs, output: slots[output], kept, node });
            let mut done = inputs;
            done.retain(|input| self.values[*input].last == now);
            done.dedup();
            done.into_iter().for_each(|input| memory.give(slots[input]));
        }
        let by = match self.graph.nodes[first].operation {
            Operation::Affine { factor, offset } => [factor, offset],
            _ => [1.0, 0.0],
        };
        let outputs = of_outputs.into_iter().map(|value| slots[value]).collect();
        let Value { node, is_planes, border, .. } = self.values[0];
        let planes = is_planes.then(|| Planes::zeros(self.shapes[node], border));
        Plan { steps, layers, memory, input: (slots[0], by), first, outputs, planes }
    }

    /// What is told of a step.
    fn layer(&self, step: &Step, inputs: &[usize], output: usize) -> Layer {
        let id = self.values[output].node;
        let output = self.shapes[id];
        let from = self.values[inputs[0]].node;
        // A convolution that took up what came behind it keeps its name.
        let named = (0..=id).rev().map(|id| &self.graph.nodes[id]).find(|node| {
            !step.is_conv()
                || node.inputs.first() == Some(&from)
                    && matches!(node.operation, Operation::Conv(_) | Operation::Linear(_))
        });
        let node = named.unwrap_or(&self.graph.nodes[id]);
        let pixels = (output[1] * output[2]) as u64;
        let macs = match &node.operation {
            Operation::Conv(conv) if step.is_conv() => conv.weight.len() as u64 * pixels,
            Operation::Linear(linear) if step.is_conv() => linear.weight.len() as u64,
            _ => 0,
        };
        Layer { name: node.name.clone(), algorithm: step.algorithm(), output, macs }
    }
}
