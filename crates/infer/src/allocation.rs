//! Allocation: from planned steps on values to allocated steps on buffers.

use evpose_kernels::blocked::NchwImage;
use evpose_nn::graph::{NodeId, Operation};

use crate::buffer::StorageType;
use crate::layer::Layer;
use crate::memory::{BufferAllocator, Slot};
use crate::plan::{PlannedStep, Planner, Value};
use crate::step::Step;

/// A step with the buffers of its inputs and output.
pub(crate) struct AllocatedStep {
    pub(crate) step: Step,
    pub(crate) inputs: Vec<Slot>,
    pub(crate) output: Slot,
    pub(crate) storage: StorageType,
    /// Node whose values the step computes.
    pub(crate) node: NodeId,
}

/// An executable plan: steps in order and their buffers.
pub(crate) struct Plan {
    pub(crate) steps: Vec<AllocatedStep>,
    pub(crate) layers: Vec<Layer>,
    pub(crate) memory: BufferAllocator,
    /// Buffer of the input, with the scale and shift that are applied to the image on the way
    /// there.
    pub(crate) input: (Slot, [f32; 2]),
    /// Node whose values are in that buffer.
    pub(crate) first: NodeId,
    pub(crate) outputs: Vec<Slot>,
    /// The buffer of the input if its layout is nchw.
    pub(crate) nchw_input: Option<NchwImage>,
}

impl Planner<'_> {
    /// Gives every value a buffer, which it shares with values before and after its lifetime.
    pub(crate) fn allocated(mut self) -> Plan {
        let (first, end) = (self.first, self.steps.len());
        for (now, PlannedStep { inputs, output, .. }) in self.steps.iter().enumerate() {
            inputs.iter().chain([output]).for_each(|value| self.values[*value].last_use = now);
        }
        // The input is written before every run, and outputs are read after it: both live
        // throughout.
        self.values[0].last_use = end;
        let output_values: Vec<usize> =
            self.graph.outputs.iter().map(|id| self.primary_value(*id)).collect();
        output_values.iter().for_each(|value| self.values[*value].last_use = end);
        let mut memory = BufferAllocator::default();
        let mut slots = vec![0; self.values.len()];
        let allocate = |memory: &mut BufferAllocator, value: &Value| {
            memory.allocate(self.shapes[value.node], value.border, value.storage)
        };
        slots[0] = allocate(&mut memory, &self.values[0]);
        let (mut steps, mut layers) = (Vec::new(), Vec::new());
        for (now, planned) in self.steps.into_iter().enumerate() {
            let PlannedStep { step, inputs, output, layer } = planned;
            let Value { node, storage, .. } = self.values[output];
            // Before the inputs are released: a step never writes to one of its inputs.
            slots[output] = allocate(&mut memory, &self.values[output]);
            layers.push(layer);
            let input_slots = inputs.iter().map(|input| slots[*input]).collect();
            let output = slots[output];
            steps.push(AllocatedStep { step, inputs: input_slots, output, storage, node });
            // A sum of a value with itself would release its buffer twice, hence without repeats.
            let mut dead = Vec::with_capacity(inputs.len());
            for input in inputs {
                if self.values[input].last_use == now && !dead.contains(&input) {
                    dead.push(input);
                }
            }
            dead.into_iter().for_each(|input| memory.release(slots[input]));
        }
        let affine = match self.graph.nodes[first].operation {
            Operation::Affine { factor, offset } => [factor, offset],
            _ => [1.0, 0.0],
        };
        let outputs = output_values.into_iter().map(|value| slots[value]).collect();
        let Value { node, is_nchw, border, .. } = self.values[0];
        let nchw_input = is_nchw.then(|| NchwImage::zeros(self.shapes[node], border));
        Plan { steps, layers, memory, input: (slots[0], affine), first, outputs, nchw_input }
    }
}
