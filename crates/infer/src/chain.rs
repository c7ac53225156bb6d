//! Selection of the steps that are fused into chains.

use std::ops::Range;

use evpose_kernels::blocked::Chain;

use crate::layer::Layer;
use crate::plan::{PlannedStep, Planner};
use crate::step::Step;

/// Smallest value, in bytes, that is better not written to memory between two steps: a third of an
/// L2 cache of 1 MiB.
const MIN_VALUE_BYTES: usize = 350 << 10;

impl Planner<'_> {
    /// Fuses consecutive steps if the values between them are large and have no other user.
    pub(crate) fn fuse_chains(&mut self) {
        // Taken out one by one, since a chain owns its steps.
        let mut from: Vec<Option<PlannedStep>> =
            std::mem::take(&mut self.steps).into_iter().map(Some).collect();
        let mut first = 0;
        while first < from.len() {
            let mut end = first + 1;
            while end < from.len() && self.is_fused_with_previous(&from, end) {
                end += 1;
            }
            let steps: Vec<PlannedStep> =
                from[first..end].iter_mut().filter_map(Option::take).collect();
            self.steps.push(self.fused_step(steps));
            first = end;
        }
    }

    /// Whether the step at `next` is fused with the one before it.
    fn is_fused_with_previous(&self, all: &[Option<PlannedStep>], next: usize) -> bool {
        let (Some(one), Some(other)) = (&all[next - 1], &all[next]) else { return false };
        // A chain keeps no value between its steps: nobody else may read it.
        let value = &self.values[one.output];
        let uses = all.iter().flatten().flat_map(|step| &step.inputs);
        let is_used_once = uses.filter(|input| **input == one.output).count() == 1
            && !self.graph.outputs.contains(&value.node);
        let [channels, height, width] = self.shapes[value.node];
        // A chain adds a residual in its last step only.
        let has_residual = one.inputs.len() > 1;
        // In a chain, a convolution of nchw writes nchw, which only a convolution reads.
        let has_layout =
            !matches!(one.step, Step::NchwConv(..)) || matches!(other.step, Step::Conv(..));
        is_used_once
            && !has_residual
            && has_layout
            && other.inputs[0] == one.output
            && value.storage.is_f32()
            && self.values[other.output].storage.is_f32()
            && one.step.is_link()
            && other.step.is_link()
            && channels * height * width * size_of::<f32>() >= MIN_VALUE_BYTES
    }

    /// One step that runs several.
    fn fused_step(&self, mut steps: Vec<PlannedStep>) -> PlannedStep {
        // A chain of one would cost bands and save nothing.
        if steps.len() == 1 {
            return steps.remove(0);
        }
        let links = steps.iter().filter_map(|step| step.step.link()).collect();
        let input = self.shapes[self.values[steps[0].inputs[0]].node];
        let chain = Step::Chain(Chain::new(links, input, self.level));
        let layers = steps.iter().map(|step| &step.layer);
        let macs = layers.clone().map(|layer| layer.macs).sum();
        let weights = layers.clone().map(|layer| layer.weights).sum();
        let names: Vec<&str> = layers.map(|layer| layer.name.as_str()).collect();
        let name = chain_name(&names);
        let mut inputs = vec![steps[0].inputs[0]];
        let Some(last) = steps.pop() else { unreachable!("there are several") };
        inputs.extend(last.inputs.get(1));
        let output = last.layer.output;
        // Values between the steps stay in the cache.
        let values = input.iter().product::<usize>() + output.iter().product::<usize>();
        let bytes = size_of::<f32>() as u64 * (weights + values as u64);
        let layer = Layer { name, algorithm: chain.algorithm(), output, macs, weights, bytes };
        PlannedStep { step: chain, inputs, output: last.output, layer }
    }
}

/// Name of a chain: the first and the last of its names, the last without the path that they share.
fn chain_name(names: &[&str]) -> String {
    let (first, last) = (names[0], names[names.len() - 1]);
    let common: Range<usize> =
        0..first.bytes().zip(last.bytes()).take_while(|(one, other)| one == other).count();
    let dot = last[common].rfind('.').map_or(0, |dot| dot + 1);
    format!("{first} to {}", &last[dot..])
}
