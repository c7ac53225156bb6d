//! ONNX files, run by tract.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Error, Result, anyhow, bail, ensure};
use tract_onnx::prelude::{
    DatumType, Framework, InferenceFact, InferenceModel, InferenceModelExt, IntoRunnable,
    SymbolValues, Tensor, TractResult, TypedRunnableModel, onnx, tvec,
};
use tract_onnx::tract_hir::infer::{DimFact, Factoid as _};

const CHANNELS: usize = 3;

/// A network with one image as its input, ready to run.
pub(crate) struct OnnxModel {
    path: PathBuf,
    model: Arc<TypedRunnableModel>,
    input: InputShape,
    element: DatumType,
    output_shapes: Vec<Vec<usize>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct InputShape {
    height_px: usize,
    width_px: usize,
    /// `[1, height, width, 3]`, as TensorFlow has it; else `[1, 3, height, width]`.
    is_channels_last: bool,
}

impl OnnxModel {
    /// Opens a file; width and height that it leaves open are those of `open_px`.
    pub(crate) fn open(path: &Path, open_px: [usize; 2]) -> Result<Self> {
        let name = path.display();
        // The runtime's own message says neither which file nor why.
        let metadata = std::fs::metadata(path).map_err(|error| anyhow!("{name}: {error}"))?;
        if metadata.is_dir() {
            return Err(anyhow!("{name}: {}", std::io::ErrorKind::IsADirectory));
        }
        let unreadable = |error| anyhow!("{name}: no ONNX network that tract runs: {error:#}");
        let model = onnx().model_for_path(path).map_err(unreadable)?;
        let (input, element) = input_of(&model, open_px).map_err(|shape| {
            anyhow!(
                "{name}: its input is {shape}; one image of three channels is needed, \
                 [1, 3, height, width] or [1, height, width, 3]"
            )
        })?;
        let (model, output_shapes) = compile(model, input, element).map_err(unreadable)?;
        Ok(Self { path: path.to_owned(), model, input, element, output_shapes })
    }

    /// Width and height of the input, in pixels.
    pub(crate) fn input_px(&self) -> [usize; 2] {
        [self.input.width_px, self.input.height_px]
    }

    pub(crate) fn output_shapes(&self) -> &[Vec<usize>] {
        &self.output_shapes
    }

    pub(crate) fn other_outputs(&self, system: &'static str, needed: &'static str) -> Error {
        let shapes: Vec<String> =
            self.output_shapes.iter().map(|shape| format!("{shape:?}")).collect();
        let (path, shapes) = (self.path.display(), shapes.join(", "));
        anyhow!("{path}: no network of {system}: its outputs are {shapes}; needed: {needed}")
    }

    /// The outputs for a grey image, row by row, the same in each channel.
    pub(crate) fn run(&self, grey: &[f32]) -> Result<Vec<Vec<f32>>> {
        let run = || -> TractResult<Vec<Vec<f32>>> {
            // Some files compute in half precision.
            let input = self.input.tensor(grey)?.cast_to_dt(self.element)?.into_owned();
            let outputs = self.model.run(tvec![input.into()])?;
            let values = outputs.iter().map(|output| {
                let output = output.cast_to::<f32>()?;
                Ok(output.try_as_plain_ram()?.as_slice::<f32>()?.to_vec())
            });
            values.collect()
        };
        run().map_err(|error| anyhow!("{}: running it: {error:#}", self.path.display()))
    }
}

impl InputShape {
    fn dims(self) -> [usize; 4] {
        let Self { height_px, width_px, is_channels_last } = self;
        if is_channels_last {
            [1, height_px, width_px, CHANNELS]
        } else {
            [1, CHANNELS, height_px, width_px]
        }
    }

    fn tensor(self, grey: &[f32]) -> TractResult<Tensor> {
        let values: Vec<f32> = if self.is_channels_last {
            grey.iter().flat_map(|value| [*value; CHANNELS]).collect()
        } else {
            grey.repeat(CHANNELS)
        };
        Tensor::from_shape(&self.dims(), &values)
    }
}

/// Shape and element type of a model's input; the error is the input in words if it is no image.
fn input_of(
    model: &InferenceModel,
    [open_width, open_height]: [usize; 2],
) -> Result<(InputShape, DatumType)> {
    // One image goes in: models of more are not known here.
    let inputs = model.input_outlets()?;
    ensure!(inputs.len() == 1, "{} tensors", inputs.len());
    let fact = model.input_fact(0)?;
    let dims: Vec<Option<usize>> = fact.shape.dims().map(size_of).collect();
    let (height, width, is_channels_last) = match dims[..] {
        // An open batch size is taken as 1.
        [None | Some(1), Some(CHANNELS), height, width] => (height, width, false),
        [None | Some(1), height, width, Some(CHANNELS)] => (height, width, true),
        _ => {
            let dims: Vec<String> = dims
                .iter()
                .map(|dim| dim.map_or_else(|| "?".to_owned(), |size| size.to_string()))
                .collect();
            bail!("[{}]", dims.join(", "));
        }
    };
    let input = InputShape {
        height_px: height.unwrap_or(open_height),
        width_px: width.unwrap_or(open_width),
        is_channels_last,
    };
    Ok((input, fact.datum_type.concretize().unwrap_or(DatumType::F32)))
}

/// A dimension's size; none if it is left open.
fn size_of(dim: &DimFact) -> Option<usize> {
    dim.concretize().and_then(|size| size.to_i64().ok()).and_then(|size| size.try_into().ok())
}

/// A model for this input, and the shapes of its outputs.
fn compile(
    model: InferenceModel,
    input: InputShape,
    element: DatumType,
) -> TractResult<(Arc<TypedRunnableModel>, Vec<Vec<usize>>)> {
    let fact = InferenceFact::dt_shape(element, input.dims());
    let mut model = model.with_input_fact(0, fact)?;
    // Shapes that the file states are for the size that it leaves open.
    let outputs = model.output_outlets()?.len();
    for output in 0..outputs {
        model = model.with_output_fact(output, InferenceFact::default())?;
    }
    let model = model.into_optimized()?;
    let shape = |output: usize| -> TractResult<Vec<usize>> {
        let shape = &model.output_fact(output)?.shape;
        Ok(shape.eval_to_usize(&SymbolValues::default())?.to_vec())
    };
    let shapes = (0..outputs).map(shape).collect::<TractResult<_>>()?;
    Ok((model.into_runnable()?, shapes))
}
