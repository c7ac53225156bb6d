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
