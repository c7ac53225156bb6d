//! tract: pure Rust, built in.
//!
//! Optimised for the shape of the input. Matrix products are shared among threads, as its
//! documentation has it; the rest runs on one.

use std::hint::black_box;
use std::sync::Arc;

use anyhow::{Context, Result};
use tract_onnx::prelude::multithread::{Executor, multithread_tract_scope};
use tract_onnx::prelude::{
    Framework, InferenceModelExt, IntoRunnable, TValue, TVec, Tensor, TypedRunnableModel, onnx,
    tvec,
};

use super::{Job, Peer};

pub(super) struct Tract {
    settings: String,
    model: Arc<TypedRunnableModel>,
    executor: Executor,
    input: TValue,
}

impl Tract {
    pub(super) fn new(job: &Job<'_>) -> Result<Self> {
        let mut bytes = job.model;
        let model = onnx()
            .model_for_read(&mut bytes)
            .and_then(|model| model.into_optimized())
            .and_then(|model| model.into_runnable())
            .context("giving the network to tract")?;
        let executor = match job.threads {
            0 | 1 => Executor::SingleThread,
            threads => Executor::multithread(threads),
        };
        let [channels, height, width] = job.shape;
        let input = Tensor::from_shape(&[1, channels, height, width], job.image)?.into();
        let settings = format!("optimized model, matrix products on {} threads", job.threads);
        Ok(Self { settings, model, executor, input })
    }

    /// The outputs, as tract holds them.
    fn infer(&self) -> Result<TVec<TValue>> {
        let inputs = tvec![self.input.clone()];
        let model = &self.model;
        multithread_tract_scope(self.executor.clone(), || model.run(inputs))
    }
}

impl Peer for Tract {
    fn version(&self) -> &str {
        // What the program was built with.
        let entry = include_str!("../../../../../Cargo.lock").split_once("name = \"tract-onnx\"\n");
        entry.and_then(|(_, lines)| lines.split('"').nth(1)).unwrap_or_default()
    }

    fn settings(&self) -> &str {
        &self.settings
    }

    fn run(&mut self) -> Result<()> {
        black_box(self.infer()?);
        Ok(())
    }

    fn outputs(&mut self) -> Result<Vec<Vec<f32>>> {
        let values = |output: &TValue| Ok(output.try_as_plain_ram()?.as_slice::<f32>()?.to_vec());
        self.infer()?.iter().map(values).collect()
    }
}

#[cfg(test)]
mod tests {
    use evpose_cli::configs;
    use evpose_infer::onnx::{Interface, Message as _, model};
    use evpose_infer::{Engine, EngineOptions};
    use evpose_nn::Network;
    use evpose_task::hand::HandConfig;
    use tract_onnx::prelude::{DatumType, InferenceFact};

    use super::*;
    use crate::infer::against::max_difference;
    use crate::infer::networks;

    /// The file of `evpose export` leaves the number of inputs open.
    #[test]
    fn any_number_of_inputs_at_once_agrees_with_tract() {
        let changes = ["simulation.image_scale=0.5", "network.width=0.25"].map(str::to_owned);
        let config: HandConfig = configs::load("eventhands", &changes).unwrap();
        for name in Network::names() {
            let network = networks::network(&config, name, &burn::tensor::Device::flex()).unwrap();
            let (graph, shape) = (network.graph, network.input);
            let interface = Interface { input: "events".to_owned(), ..Interface::default() };
            let bytes = model(&graph, shape, Some(&interface)).unwrap().encode_to_vec();
            let mut engine = Engine::compile(&graph, shape, EngineOptions::default()).unwrap();
            let [channels, height, width] = shape;
            let size = channels * height * width;
            for count in [1, 3] {
                let images = (0..count * size).map(|k| ((37 * k) % 101) as f32 / 101.0);
                let images: Vec<f32> = images.collect();
                let dims = [count, channels, height, width];
                let fact = InferenceFact::dt_shape(DatumType::F32, dims);
                // Shapes in the file are those of any count, which tract takes for another than this one.
                let reader = onnx().with_ignore_value_info(true).with_ignore_output_shapes(true);
                let model = reader.model_for_read(&mut bytes.as_slice()).unwrap();
                let model = model.with_input_fact(0, fact).unwrap();
                let model = model.into_optimized().unwrap().into_runnable().unwrap();
                let input = Tensor::from_shape(&dims, &images).unwrap();
                let outputs = model.run(tvec![input.into()]).unwrap();
                let outputs: Vec<Vec<f32>> = outputs
                    .iter()
                    .map(|output| {
                        output.try_as_plain_ram().unwrap().as_slice::<f32>().unwrap().to_vec()
                    })
                    .collect();
                for (index, image) in images.chunks_exact(size).enumerate() {
                    let own = outputs.iter().map(|output| {
                        let length = output.len() / count;
                        output[index * length..][..length].to_vec()
                    });
                    let difference = max_difference(engine.run(image), &own.collect::<Vec<_>>());
                    assert!(difference < 1e-4, "{name}, {index} of {count}: {difference}");
                }
            }
        }
    }
}
