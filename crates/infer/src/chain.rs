//! Which steps of a plan are done together.

use std::ops::Range;

use evpose_kernels::blocked::Chain;

use crate::engine::Layer;
use crate::plan::{Planner, Work};
use crate::step::Step;

/// Bytes of an image that is better not written between two steps: a third of a second cache of 1
/// MiB.
const LARGE: usize = 350 << 10;

impl Planner<'_> {
    /// Puts steps together between which only large images lie that nobody else sees.
    pub(crate) fn chain(&mut self) {
        let mut from: Vec<Option<Work>> =
            std::mem::take(&mut self.work).into_iter().map(Some).collect();
        let mut first = 0;
        while first < from.len() {
            let mut end = first + 1;
            while end < from.len() && self.is_joined(&from, end) {
                end += 1;
            }
            let works: Vec<Work> = from[first..end].iter_mut().filter_map(Option::take).collect();
            self.work.push(self.joined(works));
            first = end;
        }
    }

    /// Whether the step at `next` goes with the one before it.
    fn is_joined(&self, all: &[Option<Work>], next: usize) -> bool {
        let (Some(one), Some(other)) = (&all[next - 1], &all[next]) else { return false };
        let value = &self.values[one.output];
        let uses = all.iter().flatten().flat_map(|work| &work.inputs);
        let is_seen_once = uses.filter(|input| **input == one.output).count() == 1
            && !self.graph.outputs.contains(&value.node);
        let [channels, height, width] = self.shapes[value.node];
        // Sums that take a residual are the last.
        let is_last = one.inputs.len() > 1;
        // Lanes that a convolution of planes leaves as they were only another convolution passes
        // over.
        let is_read =
            !matches!(one.step, Step::PlaneConv(..)) || matches!(other.step, Step::Conv(..));
        is_seen_once
            && !is_last
            && is_read
            && other.inputs[0] == one.output
            && value.kept.is_none()
            && one.step.is_link()
            && other.step.is_link()
            && channels * height * width * size_of::<f32>() >= LARGE
    }

    /// One step of several.
    fn joined(&self, mut works: Vec<Work>) -> Work {
        if works.len() == 1 {
            return works.remove(0);
        }
        let links = works.iter().filter_map(|work| work.step.link()).collect();
        let input = self.shapes[self.values[works[0].inputs[0]].node];
        let chain = Step::Chain(Chain::new(links, input, self.level));
        let layers = works.iter().map(|work| &work.layer);
        let macs = layers.clone().map(|layer| layer.macs).sum();
        let names: Vec<&str> = layers.map(|layer| layer.name.as_str()).collect();
        let name = named(&names);
        let mut inputs = vec![works[0].inputs[0]];
        let Some(last) = works.pop() else { unreachable!("there are several") };
        inputs.extend(last.inputs.get(1));
        let output = last.layer.output;
        let layer = Layer { name, algorithm: chain.algorithm(), output, macs };
        Work { step: chain, inputs, output: last.output, layer }
    }
}

/// The first and the last of some names, of which the last without what it has in common with the
/// first.
fn named(names: &[&str]) -> String {
    let (first, last) = (names[0], names[names.len() - 1]);
    let common: Range<usize> =
        0..first.bytes().zip(last.bytes()).take_while(|(one, other)| one == other).count();
    let dot = last[common].rfind('.').map_or(0, |dot| dot + 1);
    format!("{first} to {}", &last[dot..])
}
