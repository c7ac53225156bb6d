//! OpenVINO on the CPU, of the user's library.
//!
//! Set for latency, one stream, as many threads as ours has. Without a hint it computes in bf16
//! where the processor has instructions for it; with one, in f32.
//!
//! # Source
//! <https://docs.openvino.ai/2026/openvino-workflow/running-inference/optimize-inference/high-level-performance-hints.html>,
//! <https://docs.openvino.ai/2026/openvino-workflow/running-inference/inference-devices-and-modes/cpu-device.html>

use anyhow::{Context, Result, anyhow};
use openvino::{
    CompiledModel, Core, DeviceType, ElementType, InferRequest, PropertyKey, RwPropertyKey, Shape,
    Tensor,
};

use super::{Job, Peer, library};

/// The user's library.
const LIBRARY: &str = "OPENVINO_DYLIB_PATH";
/// Maximum difference of outputs in bf16, which has eight significant bits.
const DEFAULT_TOLERANCE: f64 = 0.1;

pub(super) struct OpenVino {
    version: String,
    settings: String,
    is_f32: bool,
    outputs: usize,
    request: InferRequest,
    // Dropped after the request that needs them.
    _model: CompiledModel,
    _core: Core,
}

impl OpenVino {
    pub(super) fn new(job: &Job<'_>, is_f32: bool) -> Result<Self> {
        if let Some(path) = library(LIBRARY) {
            openvino_sys::library::load_from(path).map_err(|error| anyhow!(error))
        } else {
            openvino_sys::library::load().map_err(|error| anyhow!(error))
        }
        .with_context(|| {
            format!(
                "loading OpenVINO: name its library libopenvino_c in ${LIBRARY}; \
                 docs/guide/bench-infer.md says where to get it"
            )
        })?;
        let mut core = Core::new()?;
        let threads = job.threads.to_string();
        let mut properties = vec![
            // As latency is measured here: one inference at a time.
            (RwPropertyKey::HintPerformanceMode, "LATENCY"),
            (RwPropertyKey::InferenceNumThreads, threads.as_str()),
            (RwPropertyKey::NumStreams, "1"),
        ];
        if is_f32 {
            properties.push((RwPropertyKey::HintInferencePrecision, "f32"));
        }
        core.set_properties(&DeviceType::CPU, properties)?;
        let model = core.read_model_from_buffer(job.model, None)?;
        let mut model = core.compile_model(&model, DeviceType::CPU)?;
        let mut request = model.create_infer_request()?;
        let [channels, height, width] = job.shape.map(|side| side as i64);
        let shape = Shape::new(&[1, channels, height, width])?;
        let mut input = Tensor::new(ElementType::F32, &shape)?;
        input.get_data_mut::<f32>()?.copy_from_slice(job.image);
        request.set_input_tensor(&input)?;
        Ok(Self {
            version: openvino::version().build_number,
            settings: settings(&model)?,
            is_f32,
            outputs: model.get_output_size()?,
            request,
            // Kept as long as the request that was made of them.
            _model: model,
            _core: core,
        })
    }
}

fn settings(model: &CompiledModel) -> Result<String> {
    let keys = [
        RwPropertyKey::HintPerformanceMode,
        RwPropertyKey::InferenceNumThreads,
        RwPropertyKey::NumStreams,
        RwPropertyKey::HintInferencePrecision,
        RwPropertyKey::HintEnableCpuPinning,
    ];
    // The plugin may overrule what it was asked for: what it reports is what was timed.
    let values = keys.map(|key| -> Result<String> {
        let value = model.get_property(&PropertyKey::Rw(key.clone()))?;
        Ok(format!("{} {value}", key.as_ref()))
    });
    Ok(values.into_iter().collect::<Result<Vec<_>>>()?.join(", "))
}

impl Peer for OpenVino {
    fn version(&self) -> &str {
        &self.version
    }

    fn settings(&self) -> &str {
        &self.settings
    }

    fn tolerance(&self, tolerance: f64) -> f64 {
        if self.is_f32 { tolerance } else { tolerance.max(DEFAULT_TOLERANCE) }
    }

    fn run(&mut self) -> Result<()> {
        Ok(self.request.infer()?)
    }

    fn outputs(&mut self) -> Result<Vec<Vec<f32>>> {
        self.run()?;
        let values =
            |index| Ok(self.request.get_output_tensor_by_index(index)?.get_data::<f32>()?.to_vec());
        (0..self.outputs).map(values).collect()
    }
}
