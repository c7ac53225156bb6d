//! ONNX Runtime, of the user's library.
//!
//! All optimisations of the graph, as many threads inside an operator as ours has, one operator at
//! a time. Threads spin as they do by default.
//!
//! # Source
//! <https://onnxruntime.ai/docs/performance/tune-performance/threading.html>,
//! <https://onnxruntime.ai/docs/performance/model-optimizations/graph-optimizations.html>

use std::hint::black_box;
use std::path::Path;
use std::sync::OnceLock;

use anyhow::{Context, Result, anyhow};
use ort::environment::Environment;
use ort::session::Session;
use ort::session::builder::GraphOptimizationLevel;
use ort::value::Tensor;

use super::{Job, Peer, library};

/// The user's library.
const LIBRARY: &str = "ORT_DYLIB_PATH";

pub(super) struct OnnxRuntime {
    version: String,
    settings: String,
    session: Session,
    input: Tensor<f32>,
}

impl OnnxRuntime {
    #[allow(clippy::result_large_err, reason = "the builder's error is of `ort`")]
    pub(super) fn new(job: &Job<'_>) -> Result<Self> {
        let path = library(LIBRARY).unwrap_or_else(|| "libonnxruntime.so".into());
        let session = Session::builder(environment(&path)?)?
            .with_optimization_level(GraphOptimizationLevel::All)
            .and_then(|builder| builder.with_intra_threads(job.threads))
            // As programs of one stream set it: one inference at a time, on all threads.
            .and_then(|builder| builder.with_inter_threads(1))
            .and_then(|builder| builder.with_parallel_execution(false))
            .map_err(|error| anyhow!("setting ONNX Runtime up: {error}"))?
            .commit_from_memory(job.model)
            .context("giving the network to ONNX Runtime")?;
        let [channels, height, width] = job.shape;
        // The image is copied here once: no copy may be part of a timed run.
        let input = Tensor::from_array(([1, channels, height, width], job.image.to_vec()))?;
        let settings = format!(
            "all graph optimizations, intra-op threads {}, inter-op threads 1, sequential, spinning",
            job.threads
        );
        let version = format!("{} ({})", file_name(&path), ort::info());
        Ok(Self { version, settings, session, input })
    }
}

/// The one environment of this process, which lasts as long as it does.
fn environment(path: &Path) -> Result<&'static Environment> {
    static ENVIRONMENT: OnceLock<Environment> = OnceLock::new();
    if let Some(environment) = ENVIRONMENT.get() {
        return Ok(environment);
    }
    let advice = || {
        format!(
            "loading ONNX Runtime from {}: name its library in ${LIBRARY}; \
             docs/guide/bench-infer.md says where to get it",
            path.display()
        )
    };
    let environment = ort::init_from(path).with_context(advice)?.build()?;
    // A second thread may have been faster; the first environment stays.
    Ok(ENVIRONMENT.get_or_init(|| environment))
}

/// The name of a library's file, which says its version; links do not.
fn file_name(path: &Path) -> String {
    let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

impl Peer for OnnxRuntime {
    fn version(&self) -> &str {
        &self.version
    }

    fn settings(&self) -> &str {
        &self.settings
    }

    fn run(&mut self) -> Result<()> {
        black_box(self.session.run(ort::inputs![&self.input])?);
        Ok(())
    }

    fn outputs(&mut self) -> Result<Vec<Vec<f32>>> {
        let outputs = self.session.run(ort::inputs![&self.input])?;
        outputs.values().map(|output| Ok(output.try_extract_tensor::<f32>()?.1.to_vec())).collect()
    }
}
