//! The hand network with its loss: training and validation steps for Burn.

use burn::module::Module;
use burn::tensor::Tensor;
use burn_train::metric::{Adaptor, ItemLazy};
use burn_train::{InferenceStep, TrainOutput, TrainStep};
use evpose_nn::{HandLoss, HandLossParts, HandRegressor};

use crate::guard::Guard;
use crate::metric::{Field, LOSS, LoggedValue, Scalars};

/// Inputs and the poses at the ends of their windows.
#[derive(Debug, Clone)]
pub(crate) struct HandBatch {
    /// Representations, `[batch, 2, height, width]`.
    pub inputs: Tensor<4>,
    /// The outputs of a perfect network, `[batch, 12]` or `[batch, 15]`.
    pub poses: Tensor<2>,
    /// Optimiser step this batch is for, from 1.
    pub step: u64,
}

/// The logged values of a batch, read from the device already for the divergence check.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct HandScalars {
    /// Samples in the batch.
    pub batch_size: usize,
    /// The published loss L (not its logarithm), dimensionless.
    pub loss: f64,
    /// Root mean square error of the six articulation coefficients.
    pub articulation: f64,
    /// Root mean square error of the wrist position, in millimetres.
    pub translation_mm: f64,
    /// Root mean square error of the axis-angle vector, in degrees.
    pub rotation_deg: f64,
}

impl ItemLazy for HandScalars {
    fn sync(self) -> Result<Self, burn::tensor::ExecutionError> {
        Ok(self)
    }
}

impl Adaptor<HandScalars> for HandScalars {
    fn adapt(&self) -> HandScalars {
        *self
    }
}

impl Scalars for HandScalars {
    fn batch_size(&self) -> usize {
        self.batch_size
    }
}

/// The values logged per step.
pub(crate) const HAND_FIELDS: [Field<HandScalars>; 4] = [
    field(LOSS, "", |s| s.loss),
    field("articulation", "", |s| s.articulation),
    field("translation", "mm", |s| s.translation_mm),
    field("rotation", "deg", |s| s.rotation_deg),
];

/// The values that trainings of hands log for each batch, the loss first.
pub fn hand_values() -> Vec<LoggedValue> {
    HAND_FIELDS.iter().map(Field::logged).collect()
}

const fn field(
    name: &'static str,
    unit: &'static str,
    get: fn(&HandScalars) -> f64,
) -> Field<HandScalars> {
    Field { name, unit, higher_is_better: false, get }
}

/// The network with its loss.
#[derive(Module, Debug)]
pub(crate) struct HandLearner {
    pub(crate) network: HandRegressor,
    #[module(skip)]
    loss: HandLoss,
    #[module(skip)]
    guard: Guard,
}

impl HandLearner {
    pub(crate) fn new(network: HandRegressor, loss: HandLoss, guard: Guard) -> Self {
        Self { network, loss, guard }
    }

    fn measure(&self, batch: HandBatch) -> (HandLossParts, usize) {
        let [batch_size, ..] = batch.inputs.dims();
        (self.loss.forward(self.network.forward(batch.inputs), batch.poses), batch_size)
    }
}

fn scalars(parts: &HandLossParts, batch_size: usize) -> HandScalars {
    let read = |tensor: &Tensor<1>| f64::from(tensor.clone().into_scalar::<f32>());
    let rms = |mean_square: f64, components: f64| (components * mean_square).sqrt();
    HandScalars {
        batch_size,
        loss: read(&parts.total),
        articulation: rms(read(&parts.articulation), 1.0),
        translation_mm: 1e3 * rms(read(&parts.translation_m2), 3.0),
        rotation_deg: rms(read(&parts.rotation_rad2), 3.0).to_degrees(),
    }
}

impl TrainStep for HandLearner {
    type Input = HandBatch;
    type Output = HandScalars;

    fn step(&self, batch: HandBatch) -> TrainOutput<HandScalars> {
        let step = batch.step;
        let (parts, batch_size) = self.measure(batch);
        let measured = scalars(&parts, batch_size);
        self.guard.check(measured.loss, step);
        TrainOutput::new(self, parts.objective.backward(), measured)
    }
}

impl InferenceStep for HandLearner {
    type Input = HandBatch;
    type Output = HandScalars;

    fn step(&self, batch: HandBatch) -> HandScalars {
        let (parts, batch_size) = self.measure(batch);
        scalars(&parts, batch_size)
    }
}
