//! Planning: from the nodes of a graph to steps on values with storage types.

use evpose_kernels::Level;
use evpose_kernels::blocked::LowPrecisionType;
use evpose_nn::graph::{Activation, ConvLayer, Graph, NodeId, Operation};

use crate::InferError;
use crate::buffer::StorageType;
use crate::fuse::{FusedOp, fuse};
use crate::layer::Layer;
use crate::precision::{CalibrationRanges, Precision};
use crate::shapes::{Shape, infer_shapes};
use crate::step::Step;

/// Index of a value in [`Planner::values`].
pub(crate) type ValueId = usize;

/// A value: the output of a node in one storage type. A node whose users need different types has
/// several.
pub(crate) struct Value {
    pub(crate) node: NodeId,
    pub(crate) storage: StorageType,
    /// Whether its layout is nchw, which only the input of the network has.
    pub(crate) is_nchw: bool,
    /// Zero border that its users need.
    pub(crate) border: usize,
    /// Index of the last step that reads it.
    pub(crate) last_use: usize,
}

/// A step with the values that it reads and writes.
pub(crate) struct PlannedStep {
    pub(crate) step: Step,
    pub(crate) inputs: Vec<ValueId>,
    pub(crate) output: ValueId,
    pub(crate) layer: Layer,
}

/// A plan in the making.
pub(crate) struct Planner<'a> {
    pub(crate) graph: &'a Graph,
    pub(crate) shapes: Vec<Shape>,
    pub(crate) level: Level,
    precision: Precision,
    ranges: Option<&'a CalibrationRanges>,
    /// Operation of each node after fusion.
    fused: Vec<FusedOp>,
    pub(crate) values: Vec<Value>,
    /// The values of each node: the one that its step writes, then conversions.
    values_of_node: Vec<Vec<ValueId>>,
    pub(crate) steps: Vec<PlannedStep>,
    /// The node whose values the input buffer holds: see [`input_node`](Self::input_node).
    pub(crate) first: NodeId,
}

impl<'a> Planner<'a> {
    /// Plans a network for images of `input` channels, height and width, one step per layer.
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
            shapes: infer_shapes(graph, input)?,
            level,
            precision,
            ranges,
            fused: fuse(graph),
            values: Vec::new(),
            values_of_node: vec![Vec::new(); graph.nodes.len()],
            steps: Vec::new(),
            first: 0,
        };
        planner.first = planner.input_node();
        for id in 0..graph.nodes.len() {
            planner.plan_node(id, planner.first)?;
        }
        Ok(planner)
    }

    /// The node whose values the input buffer holds: the input, or the affine operation that is its
    /// only user, which is then applied while the image is copied.
    fn input_node(&self) -> NodeId {
        // Another user, or an output, needs the image as it was before the operation.
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

    /// Adds the step of a node, if it has one.
    fn plan_node(&mut self, id: NodeId, first: NodeId) -> Result<(), InferError> {
        if id == first {
            let is_nchw = self.nchw_conv(id).is_some();
            let storage = if is_nchw { StorageType::F32 } else { self.preferred_storage(id)? };
            let value = self.add_value(id, storage);
            self.values[value].is_nchw = is_nchw;
            // The allocation relies on it.
            assert_eq!(value, 0, "the input comes first");
            return Ok(());
        }
        if id < first {
            return Ok(());
        }
        let node = &self.graph.nodes[id];
        let (step, inputs) = match self.fused[id].clone() {
            FusedOp::Absorbed => return Ok(()),
            FusedOp::Unfused => self.unfused_step(id)?,
            FusedOp::Add { inputs, activation } => {
                let inputs = inputs.map(|id| self.primary_value(id));
                let is_f32 = inputs.iter().all(|value| self.values[*value].storage.is_f32());
                // Only the kernel of low precision reads mixed storage types.
                let is_low_precision = !is_f32 || !self.preferred_storage(id)?.is_f32();
                let step = if is_low_precision {
                    Step::LowPrecisionAdd(activation)
                } else {
                    Step::Add(activation)
                };
                (step, inputs.to_vec())
            }
            FusedOp::Conv { conv, residual, activation } => {
                self.conv_step(id, conv, residual, activation)?
            }
        };
        let storage = match &step {
            // Their kernels do not convert.
            Step::LowPrecisionMaxPool(_) | Step::LowPrecisionUpsample => {
                self.values[inputs[0]].storage
            }
            step if step.writes_low_precision() => self.preferred_storage(id)?,
            _ => StorageType::F32,
        };
        assert!(!node.name.is_empty(), "layers have names");
        let output = self.add_value(id, storage);
        self.push_step(step, inputs, output);
        Ok(())
    }

    /// Step of the layer that reads the input, at node `first`, in nchw; none if another layer
    /// reads it or the layer cannot.
    fn nchw_conv(&self, first: NodeId) -> Option<Step> {
        let mut users =
            self.graph.nodes.iter().enumerate().filter(|(_, n)| n.inputs.contains(&first));
        // Another user would need the input in nChw16c as well.
        let (Some((id, node)), None) = (users.next(), users.next()) else { return None };
        let activation = self.fused.iter().find_map(|fused| match fused {
            FusedOp::Conv { conv, residual: None, activation } if *conv == id => Some(*activation),
            _ => None,
        });
        match &node.operation {
            Operation::Conv(conv) if !self.graph.outputs.contains(&first) => {
                Step::nchw_conv(conv, activation?, self.level, self.precision == Precision::F32)
            }
            _ => None,
        }
    }

    /// Adds a step, and widens the border of its input to what it needs.
    fn push_step(&mut self, step: Step, inputs: Vec<ValueId>, output: ValueId) {
        let border = &mut self.values[inputs[0]].border;
        *border = (*border).max(step.border());
        let layer = self.layer(&step, &inputs, output);
        self.steps.push(PlannedStep { step, inputs, output, layer });
    }

    fn add_value(&mut self, node: NodeId, storage: StorageType) -> ValueId {
        self.values.push(Value { node, storage, is_nchw: false, border: 0, last_use: 0 });
        self.values_of_node[node].push(self.values.len() - 1);
        self.values.len() - 1
    }

    /// Storage type in which the step of a node should write: of low precision if a user reads
    /// that. Vectors and outputs are f32.
    fn preferred_storage(&self, id: NodeId) -> Result<StorageType, InferError> {
        let [_, height, width] = self.shapes[id];
        if height * width == 1
            || self.graph.outputs.contains(&id)
            || !self.is_used_in_low_precision(id)
        {
            return Ok(StorageType::F32);
        }
        self.storage_at_precision(id)
    }

    fn storage_at_precision(&self, id: NodeId) -> Result<StorageType, InferError> {
        match (self.precision, self.ranges) {
            (Precision::F32, _) => Ok(StorageType::F32),
            (Precision::Bf16, _) => Ok(StorageType::LowPrecision(LowPrecisionType::Bf16)),
            (Precision::Int8, Some(ranges)) => {
                Ok(StorageType::LowPrecision(ranges.low_precision_type(id)?))
            }
            (Precision::Int8, None) => {
                Err(InferError::NotCalibrated { layer: self.graph.nodes[id].name.clone() })
            }
        }
    }

    /// Whether a user of a node reads low precision.
    fn is_used_in_low_precision(&self, id: NodeId) -> bool {
        let takes = |(user, fused): (usize, &FusedOp)| match fused {
            // The step that absorbed it has its inputs.
            FusedOp::Absorbed => false,
            FusedOp::Unfused => {
                let node = &self.graph.nodes[user];
                let has_kernel = matches!(
                    node.operation,
                    Operation::MaxPool { .. } | Operation::Upsample | Operation::Relu
                );
                has_kernel && node.inputs.contains(&id)
            }
            FusedOp::Add { inputs, .. } => inputs.contains(&id),
            FusedOp::Conv { conv, .. } => {
                let node = &self.graph.nodes[*conv];
                matches!(&node.operation, Operation::Conv(layer) if self.reads_low_precision(layer))
                    && node.inputs.contains(&id)
            }
        };
        self.fused.iter().enumerate().any(takes)
    }

    /// Whether a convolution is one of low precision. Depthwise ones of bf16 read f32, of which nothing has to be
    /// converted at each tap.
    fn reads_low_precision(&self, layer: &ConvLayer) -> bool {
        match self.precision {
            Precision::F32 => false,
            Precision::Bf16 => layer.groups == 1,
            Precision::Int8 => true,
        }
    }

    /// The value that the step of a node writes.
    pub(crate) fn primary_value(&self, id: NodeId) -> ValueId {
        self.values_of_node[id][0]
    }

    /// The value of a node in f32 or in low precision; adds a conversion if there is none.
    fn value_as(&mut self, id: NodeId, is_low_precision: bool) -> Result<ValueId, InferError> {
        let fits = |value: &&ValueId| self.values[**value].storage.is_f32() != is_low_precision;
        if let Some(value) = self.values_of_node[id].iter().find(fits) {
            return Ok(*value);
        }
        let from = self.primary_value(id);
        let storage =
            if is_low_precision { self.storage_at_precision(id)? } else { StorageType::F32 };
        let value = self.add_value(id, storage);
        // A sum of one operand without an activation is a conversion between storage types.
        self.push_step(Step::LowPrecisionAdd(Activation::Identity), vec![from], value);
        Ok(value)
    }

    /// Step and inputs of a node without fusion.
    fn unfused_step(&mut self, id: NodeId) -> Result<(Step, Vec<ValueId>), InferError> {
        let node = &self.graph.nodes[id];
        let step = Step::from_node(node, self.level)?;
        let first = self.primary_value(node.inputs[0]);
        let is_low_precision = !self.values[first].storage.is_f32();
        let step = match step {
            Step::MaxPool(pool) if is_low_precision => Step::LowPrecisionMaxPool(pool),
            Step::Upsample if is_low_precision => Step::LowPrecisionUpsample,
            Step::Add(activation) if is_low_precision => Step::LowPrecisionAdd(activation),
            step => {
                let inputs: Result<Vec<ValueId>, _> =
                    node.inputs.iter().map(|input| self.value_as(*input, false)).collect();
                return Ok((step, inputs?));
            }
        };
        // Outputs are f32, and the kernels of low precision cannot write that, except for the sum.
        if self.graph.outputs.contains(&id) && !matches!(step, Step::LowPrecisionAdd(_)) {
            let step = Step::from_node(node, self.level)?;
            return Ok((step, vec![self.value_as(node.inputs[0], false)?]));
        }
        Ok((step, vec![first]))
    }

    /// Step and inputs of a convolution `conv` with its epilogue, whose last node is `id`.
    fn conv_step(
        &mut self,
        id: NodeId,
        conv: NodeId,
        residual: Option<NodeId>,
        activation: Activation,
    ) -> Result<(Step, Vec<ValueId>), InferError> {
        let node = &self.graph.nodes[conv];
        let Operation::Conv(layer) = &node.operation else {
            unreachable!("only convolutions absorb others")
        };
        if self.values[self.primary_value(node.inputs[0])].is_nchw {
            let step = self.nchw_conv(node.inputs[0]);
            let step =
                step.unwrap_or_else(|| unreachable!("the nchw layout was chosen for this layer"));
            return Ok((step, vec![self.primary_value(node.inputs[0])]));
        }
        let [_, height, width] = self.shapes[id];
        // Kernels of low precision are those of square windows that keep the size.
        let [_, _, kernel, across] = layer.shape;
        let is_square = kernel == across && kernel % 2 == 1 && layer.padding == [kernel / 2; 4];
        let is_low_precision = height * width > 1 && is_square && self.reads_low_precision(layer);
        let input = self.value_as(node.inputs[0], is_low_precision)?;
        let storage = self.values[input].storage;
        let step = Step::conv(
            &node.name,
            layer,
            self.shapes[id],
            residual.is_some(),
            activation,
            self.level,
            storage,
        )?;
        // Kernels of low precision read a residual of any storage type, those of f32 only f32.
        let residual = match residual {
            Some(id) if is_low_precision => Some(self.primary_value(id)),
            Some(id) => Some(self.value_as(id, false)?),
            None => None,
        };
        Ok((step, [input].into_iter().chain(residual).collect()))
    }

    /// Description of a step.
    fn layer(&self, step: &Step, inputs: &[ValueId], output: ValueId) -> Layer {
        let id = self.values[output].node;
        let output = self.shapes[id];
        let from = self.values[inputs[0]].node;
        // A convolution with an epilogue has the name of the convolution, not of the last node.
        let named = (0..=id).rev().map(|id| &self.graph.nodes[id]).find(|node| {
            !step.is_conv()
                || node.inputs.first() == Some(&from)
                    && matches!(node.operation, Operation::Conv(_) | Operation::Linear(_))
        });
        let node = named.unwrap_or(&self.graph.nodes[id]);
        let pixels = (output[1] * output[2]) as u64;
        let (weight, bias) = match &node.operation {
            Operation::Conv(conv) if step.is_conv() => (conv.weight.len(), conv.bias.len()),
            Operation::Linear(linear) if step.is_conv() => (linear.weight.len(), linear.bias.len()),
            _ => (0, 0),
        };
        // A fully connected layer has one pixel: each of its weights counts once.
        let (macs, weights) = (weight as u64 * pixels, (weight + bias) as u64);
        let values = inputs.iter().map(|input| self.values[*input].node).chain([id]);
        let values: usize = values.map(|id| self.shapes[id].iter().product::<usize>()).sum();
        let bytes = size_of::<f32>() as u64 * (weights + values as u64);
        Layer { name: node.name.clone(), algorithm: step.algorithm(), output, macs, weights, bytes }
    }
}
